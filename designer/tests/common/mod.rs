//! What several tests share.

use steerguard_designer::Spec;
use toml::{Table, Value};

/// The paper's case with what `text` changes: where the defaults differ from the paper, the paper's.
pub fn papers_but(text: &str) -> Spec {
    let mut papers = Table::try_from(Spec::paper()).unwrap();
    overlay(&mut papers, text.parse().unwrap());
    Spec::from_toml(&toml::to_string(&papers).unwrap()).unwrap()
}

fn overlay(below: &mut Table, above: Table) {
    for (key, value) in above {
        match (below.get_mut(&key), value) {
            (Some(Value::Table(below)), Value::Table(above)) => overlay(below, above),
            (_, value) => {
                below.insert(key, value);
            }
        }
    }
}
