//! The packaged FMUs, found by the environment variable that `tests/run` sets.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use std::path::{Path, PathBuf};

use fmi::fmi2::import::Fmi2Import;
use steerguard_designer::Design;
use steerguard_detector::Detector;

/// A file among the packaged fixtures.
pub fn fixture(name: &str) -> PathBuf {
    let folder = std::env::var_os("STEERGUARD_FIXTURES")
        .expect("STEERGUARD_FIXTURES names the folder of the packaged FMUs; tests/run sets it");
    Path::new(&folder).join(name)
}

/// The FMU of a model, unpacked and described by the foreign importer.
#[allow(dead_code, reason = "not every test file needs it")]
pub fn import(model: &str) -> Fmi2Import {
    let path = fixture(&format!("{model}.fmu"));
    fmi::import::from_path(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// The detector that the design file describes, without an FMU around it.
#[allow(dead_code, reason = "not every test file needs it")]
pub fn plain_detector() -> Detector {
    let text = std::fs::read_to_string(fixture("design.json")).unwrap();
    let design = Design::from_json(&text).unwrap();
    Detector::new(&design.configuration()).unwrap()
}
