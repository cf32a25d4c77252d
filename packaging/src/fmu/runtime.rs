//! The shared libraries of both FMUs before anything is baked into them.

use std::collections::BTreeMap;
use std::path::Path;

use crate::platform::Platform;

/// Shared libraries of one model by platform.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Runtimes(pub BTreeMap<Platform, Vec<u8>>);

impl Runtimes {
    /// The detector's library for this machine, part of this command.
    pub fn detector() -> Self {
        Self::host(include_bytes!(env!("STEERGUARD_DETECTOR_RUNTIME")))
    }

    /// The reference vehicle's library for this machine, part of this command.
    pub fn plant() -> Self {
        Self::host(include_bytes!(env!("STEERGUARD_PLANT_RUNTIME")))
    }

    fn host(bytes: &[u8]) -> Self {
        Self(Platform::HOST.map(|platform| (platform, bytes.to_vec())).into_iter().collect())
    }

    /// Adds or replaces the library of a platform by the file at `path`.
    ///
    /// # Errors
    /// What reading the file says.
    pub fn add(&mut self, platform: Platform, path: &Path) -> std::io::Result<()> {
        self.0.insert(platform, std::fs::read(path)?);
        Ok(())
    }
}
