//! Files as tables: names of columns, and rows of numbers.

mod binary;
mod bounded;
mod dialect;
mod row;
mod text;

use std::fs::File;
use std::io::{Read as _, Seek as _};
use std::path::Path;

use crate::error::{Cause, DriveError};
use binary::Binary;
pub(crate) use row::{Header, RowError};
use text::Text;

/// An open file.
pub(crate) enum Table {
    /// CSV.
    Text(Box<Text>),
    /// Parquet.
    Binary(Box<Binary>),
}

/// What files of other formats begin with.
const OTHERS: [(&[u8], &str); 7] = [
    (b"MDF ", "an MDF file"),
    (b"UnFinMF", "an unfinished MDF file"),
    (b"MATLAB 5.0", "a MAT file"),
    (b"\x89HDF", "an HDF5 file (MAT 7.3 is one)"),
    (b"PK\x03\x04", "a ZIP archive"),
    (b"\x1f\x8b", "a gzip file"),
    (b"\x28\xb5\x2f\xfd", "a zstd file"),
];

impl Table {
    /// Opens the file at `path`, by its content. Delimiter and decimal mark count for text.
    pub fn open(
        path: &Path,
        delimiter: Option<u8>,
        decimal_mark: Option<u8>,
    ) -> Result<Self, DriveError> {
        let failed = |cause| DriveError::of(path, None, cause);
        let open = || -> Result<Self, Cause> {
            let mut file = File::open(path)?;
            let metadata = file.metadata()?;
            if metadata.is_dir() {
                return Err(Cause::NoFile("a folder"));
            } else if !metadata.is_file() {
                return Err(Cause::NoFile("a pipe or a device"));
            }
            let mut begin = Vec::new();
            file.by_ref().take(16).read_to_end(&mut begin)?;
            file.rewind()?;
            if begin.is_empty() {
                return Err(Cause::Empty);
            }
            if begin.starts_with(b"PAR1") {
                return Ok(Self::Binary(Box::new(Binary::new(file)?)));
            }
            let other = OTHERS.iter().find(|(magic, _)| begin.starts_with(magic));
            match other {
                Some((_, what)) => Err(Cause::Format(what)),
                None => Ok(Self::Text(Box::new(Text::new(file, delimiter, decimal_mark)?))),
            }
        };
        open().map_err(failed)
    }

    /// What is said of the columns.
    pub fn headers(&self) -> &[Header] {
        match self {
            Self::Text(text) => &text.headers,
            Self::Binary(binary) => &binary.headers,
        }
    }

    /// Says how the file is read, where that was found out.
    pub fn reading(&self) -> String {
        match self {
            Self::Text(text) => text.reading(),
            Self::Binary(_) => "Parquet".into(),
        }
    }

    /// Selects the columns whose cells [`Self::next`] gives.
    pub fn select(&mut self, columns: &[usize]) {
        match self {
            Self::Text(text) => text.select(columns),
            Self::Binary(binary) => binary.select(columns),
        }
    }

    /// Reads the next row into `cells`, one for each selected column, NaN for none, and says its line;
    /// `None` at the end.
    pub fn next(&mut self, cells: &mut [f64]) -> Result<Option<u64>, RowError> {
        match self {
            Self::Text(text) => text.next(cells),
            Self::Binary(binary) => binary.next(cells),
        }
    }
}
