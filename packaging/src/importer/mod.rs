//! An importer of FMI 2.0 Co-Simulation FMUs: unpack, read the description, load, step.
//!
//! # Conventions
//! - The library is code that the user chose to run, but the archive and its description are input:
//!   sizes are bounded and names checked before anything is loaded.
//! - Variables are asked for by name and type once; values then travel by value reference.

mod instance;
mod library;
mod log;
mod unpack;

use std::path::Path;
use std::sync::Arc;
use std::{fmt, fs};

use steerguard_model_description::xml::{self, Description, ReadError};

pub use instance::{CallError, Instance};
pub use log::LogMessage;
pub use unpack::UnpackError;
pub(crate) use unpack::{MAX_ENTRIES, MAX_UNPACKED_BYTES};

use crate::output::temporary::TemporaryFolder;
use crate::platform::Platform;
use library::Library;

/// An FMU that cannot be used.
#[derive(Debug, thiserror::Error)]
#[error("`{fmu}`: {cause}")]
pub struct ImportError {
    /// Path of the FMU.
    pub fmu: String,
    /// What is wrong with it.
    pub cause: Box<ImportCause>,
}

/// What can be wrong with an FMU.
#[derive(Debug, thiserror::Error)]
pub enum ImportCause {
    /// The archive cannot be unpacked.
    #[error("{0}")]
    Unpack(#[from] UnpackError),
    /// There is no description that can be read.
    #[error("modelDescription.xml: {0}")]
    NoDescription(std::io::Error),
    /// The description is not one of FMI 2.0 Co-Simulation.
    #[error(transparent)]
    Description(#[from] ReadError),
    /// FMUs do not run on this machine, or this one does not.
    #[error("no `{0}` in it: the FMU does not run on this machine")]
    Platform(String),
    /// The library cannot be loaded.
    #[error("its library cannot be loaded: {0}")]
    Load(#[from] libloading::Error),
    /// A variable is missing or of another type.
    #[error("no variable `{name}` of type {kind}")]
    Variable {
        /// Name looked for.
        name: String,
        /// Type looked for.
        kind: Type,
    },
}

/// Types of variables.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Type {
    /// fmi2Real.
    Real,
    /// fmi2Boolean.
    Boolean,
    /// fmi2Integer.
    Integer,
    /// fmi2Integer with named values.
    Enumeration,
    /// fmi2String.
    String,
}

impl fmt::Display for Type {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Debug::fmt(self, f)
    }
}

/// An FMU, unpacked and loaded.
pub struct Fmu {
    name: String,
    /// Folder of the unpacked archive as a `file:` URI, with `resources` appended.
    resource_location: String,
    description: Description,
    library: Arc<Library>,
}

impl Fmu {
    /// Unpacks and loads the FMU at `path`.
    ///
    /// # Errors
    /// [`ImportError`].
    pub fn open(path: &Path) -> Result<Self, ImportError> {
        let name = path.display().to_string();
        Self::load(path, name.clone())
            .map_err(|cause| ImportError { fmu: name, cause: Box::new(cause) })
    }

    fn load(path: &Path, name: String) -> Result<Self, ImportCause> {
        let folder = TemporaryFolder::new().map_err(UnpackError::Io)?;
        unpack::unpack(path, folder.path())?;
        let text = fs::read_to_string(folder.path().join("modelDescription.xml"))
            .map_err(ImportCause::NoDescription)?;
        let description = xml::read(&text)?;

        let identifier = &description.co_simulation.model_identifier;
        let entry = Platform::HOST.map(|platform| platform.library_path(identifier));
        let entry = entry.unwrap_or_else(|| format!("binaries/*/{identifier}"));
        let file = folder.path().join(&entry);
        if !unpack::is_safe(&entry) || !file.is_file() {
            return Err(ImportCause::Platform(entry));
        }
        let resource_location = file_uri(&folder.path().join("resources"));
        let library = Arc::new(Library::load(&file, folder)?);
        Ok(Self { name, resource_location, description, library })
    }

    /// Its description.
    pub fn description(&self) -> &Description {
        &self.description
    }

    /// Communication step that the FMU proposes, s.
    pub fn step_size_s(&self) -> Option<f64> {
        self.description.default_experiment.step_size
    }

    /// Names of its variables.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.description.variables.iter().map(|variable| variable.name.as_str())
    }

    /// Value reference of a variable.
    ///
    /// # Errors
    /// [`ImportCause::Variable`] if there is none of this name and type.
    pub fn variable(&self, name: &str, kind: Type) -> Result<u32, ImportError> {
        self.description
            .variables
            .iter()
            .find(|variable| variable.name == name && variable.kind == kind.to_string())
            .map(|variable| variable.value_reference)
            .ok_or_else(|| ImportError {
                fmu: self.name.clone(),
                cause: Box::new(ImportCause::Variable { name: name.to_owned(), kind }),
            })
    }

    /// Value references of Real variables.
    ///
    /// # Errors
    /// As [`Self::variable`].
    pub fn reals<const N: usize>(&self, names: [&str; N]) -> Result<[u32; N], ImportError> {
        let mut references = [0; N];
        for (reference, name) in references.iter_mut().zip(names) {
            *reference = self.variable(name, Type::Real)?;
        }
        Ok(references)
    }

    /// A new instance.
    ///
    /// # Errors
    /// [`CallError`] if the FMU gives none, with what it logged.
    pub fn instantiate(&self, name: &str) -> Result<Instance, CallError> {
        self.instantiate_with_guid(name, &self.description.guid)
    }

    /// A new instance, asked for under another GUID than the description's: an FMU has to refuse.
    ///
    /// # Errors
    /// [`CallError`] if the FMU gives none, with what it logged.
    pub fn instantiate_with_guid(&self, name: &str, guid: &str) -> Result<Instance, CallError> {
        Instance::new(self.library.clone(), name, guid, &self.resource_location)
    }
}

/// `path` as a `file:` URI.
fn file_uri(path: &Path) -> String {
    let mut uri = String::from("file://");
    let text = path.to_string_lossy().replace('\\', "/");
    if !text.starts_with('/') {
        uri.push('/');
    }
    for byte in text.bytes() {
        match byte {
            b'a'..=b'z' | b'A'..=b'Z' | b'0'..=b'9' | b'/' | b'-' | b'_' | b'.' | b'~' | b':' => {
                uri.push(char::from(byte));
            }
            _ => uri.push_str(&format!("%{byte:02X}")),
        }
    }
    uri
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn uris_escape_what_they_must() {
        assert_eq!(file_uri(Path::new("/a b/ü")), "file:///a%20b/%C3%BC");
        assert_eq!(file_uri(Path::new("C:\\x")), "file:///C:/x");
    }
}
