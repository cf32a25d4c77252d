//! FMUs from memory.

use steerguard::importer::Fmu;

/// Opens an FMU given as its bytes.
pub fn open(bytes: &[u8]) -> Fmu {
    let file = tempfile::NamedTempFile::new().unwrap();
    std::fs::write(file.path(), bytes).unwrap();
    Fmu::open(file.path()).unwrap()
}
