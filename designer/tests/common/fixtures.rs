//! Design files that tests read, and the specifications that they are made of.

#![allow(dead_code, reason = "not every test needs both")]

use std::path::{Path, PathBuf};

/// A design file and its specification.
pub struct Fixture {
    pub name: &'static str,
    pub specification: PathBuf,
    pub design: PathBuf,
}

/// All of them: `paper.json` of the example, the others of what stands beside them.
pub fn all() -> Vec<Fixture> {
    let designer = Path::new(env!("CARGO_MANIFEST_DIR"));
    let folder = designer.join("verify/tests/fixtures");
    let paper = designer.join("../examples/paper.toml");
    let of = |name: &'static str| Fixture {
        name,
        specification: match name {
            "paper" => paper.clone(),
            other => folder.join(format!("{other}.toml")),
        },
        design: folder.join(format!("{name}.json")),
    };
    ["paper", "gap", "noise", "guaranteed"].map(of).into()
}
