//! The core knows no version of FMI: what does has its place in a layer such as `fmu/fmi2`.

#![allow(clippy::unwrap_used)]

use std::fs;
use std::path::Path;

#[test]
fn no_source_names_a_version_of_fmi() {
    let package = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut sources = 0;
    for entry in fs::read_dir(package.join("src")).unwrap() {
        let path = entry.unwrap().path();
        assert!(path.is_file(), "{} would go unread", path.display());
        let source = fs::read_to_string(&path).unwrap().to_lowercase();
        for version in ["fmi1", "fmi2", "fmi3", "fmi 1", "fmi 2", "fmi 3"] {
            assert!(!source.contains(version), "{} names {version}", path.display());
        }
        sources += 1;
    }
    assert!(sources > 0);
    let manifest = fs::read_to_string(package.join("Cargo.toml")).unwrap();
    assert!(!manifest.contains("steerguard-fmi"), "the core depends on the layer of a version");
}
