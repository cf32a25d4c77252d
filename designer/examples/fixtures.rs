//! Designs anew the design files that tests read, from the specifications beside them:
//!
//! ```text
//! cargo run --release -p steerguard-designer --example fixtures [NAME...]
//! ```
//!
//! Without names, all of them. `git diff --stat` then shows which have changed.

use std::error::Error;
use std::fs;

use steerguard_designer::{Spec, design};

#[path = "../tests/common/fixtures.rs"]
mod fixtures;

fn main() -> Result<(), Box<dyn Error>> {
    let names: Vec<String> = std::env::args().skip(1).collect();
    for fixture in fixtures::all() {
        if !names.is_empty() && !names.iter().any(|name| name == fixture.name) {
            continue;
        }
        let spec = Spec::from_toml(&fs::read_to_string(&fixture.specification)?)?;
        let text = design(&spec, &mut |_| {})?.to_json()?;
        let changed = fs::read_to_string(&fixture.design).ok().as_ref() != Some(&text);
        fs::write(&fixture.design, text)?;
        let changed = if changed { "changed" } else { "as it was" };
        println!("{}: {changed}", fixture.design.display());
    }
    Ok(())
}
