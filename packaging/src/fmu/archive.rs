//! FMU and SSP archives, byte for byte reproducible.
//!
//! # Conventions
//! - `modelDescription.xml` or `SystemStructure.ssd` first, the other entries sorted by name with forward slashes.
//! - Every entry is deflated, dated 1980-01-01, readable by all; nothing depends on the machine.
//! - Sizes stand in the local headers: no data descriptors, which some importers cannot read.

use std::collections::BTreeMap;
use std::io::{Cursor, Write};

use zip::result::ZipError;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, System, ZipWriter};

/// The content of an FMU or SSP: entry names and bytes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Archive {
    first_name: &'static str,
    first: Vec<u8>,
    entries: BTreeMap<String, Vec<u8>>,
}

impl Archive {
    /// An FMU with nothing but its description.
    pub fn new(model_description: impl Into<Vec<u8>>) -> Self {
        Self::beginning_with("modelDescription.xml", model_description.into())
    }

    /// A system with nothing but its structure.
    pub fn system(structure: impl Into<Vec<u8>>) -> Self {
        Self::beginning_with("SystemStructure.ssd", structure.into())
    }

    fn beginning_with(first_name: &'static str, first: Vec<u8>) -> Self {
        Self { first_name, first, entries: BTreeMap::new() }
    }

    /// Adds or replaces an entry; `name` is relative, with forward slashes.
    pub fn insert(&mut self, name: impl Into<String>, bytes: impl Into<Vec<u8>>) {
        self.entries.insert(name.into(), bytes.into());
    }

    /// The bytes of the file.
    ///
    /// # Errors
    /// [`ZipError`] if an entry does not fit the format.
    pub fn to_bytes(&self) -> Result<Vec<u8>, ZipError> {
        let options = SimpleFileOptions::default()
            .compression_method(CompressionMethod::Deflated)
            .compression_level(Some(9))
            .last_modified_time(DateTime::DEFAULT)
            .system(System::Unix)
            .unix_permissions(0o644);
        let mut writer = ZipWriter::new(Cursor::new(Vec::new()));
        let first = (self.first_name, &self.first);
        let others = self.entries.iter().map(|(name, bytes)| (name.as_str(), bytes));
        for (name, bytes) in std::iter::once(first).chain(others) {
            writer.start_file(name, options)?;
            writer.write_all(bytes)?;
        }
        Ok(writer.finish()?.into_inner())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn entries_are_sorted_plain_and_without_data_descriptors() {
        let mut archive = Archive::new("<x/>");
        archive.insert("resources/b.txt", "b");
        archive.insert("binaries/a.so", vec![7; 70_000]);
        let bytes = archive.to_bytes().unwrap();
        assert_eq!(bytes, archive.clone().to_bytes().unwrap());

        let mut zip = zip::ZipArchive::new(Cursor::new(&bytes)).unwrap();
        let names: Vec<_> = zip.file_names().map(|name| name.unwrap().into_owned()).collect();
        assert_eq!(names, ["modelDescription.xml", "binaries/a.so", "resources/b.txt"]);
        for index in 0..zip.len() {
            let entry = zip.by_index_raw(index).unwrap();
            assert_eq!(entry.compression(), CompressionMethod::Deflated);
            assert_eq!(entry.last_modified(), Some(DateTime::DEFAULT));
            assert_eq!(entry.unix_mode(), Some(0o100_644));
            let header = entry.header_start() as usize;
            let flags = u16::from_le_bytes([bytes[header + 6], bytes[header + 7]]);
            assert_eq!(flags & 0b1000, 0, "data descriptor");
        }
    }
}
