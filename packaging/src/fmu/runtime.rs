//! The shared libraries of both FMUs before anything is baked into them.

use std::collections::BTreeMap;
use std::path::Path;

use crate::platform::Platform;

/// What is built into this command: a platform, and the libraries of detector and reference vehicle.
type Embedded = (Platform, &'static [u8], &'static [u8]);

// EMBEDDED, written by the build script.
include!(env!("STEERGUARD_EMBEDDED"));

/// Shared libraries of one model by platform.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Runtimes(pub BTreeMap<Platform, Vec<u8>>);

impl Runtimes {
    /// The detector's libraries that are part of this command.
    pub fn detector() -> Self {
        Self(EMBEDDED.iter().map(|(platform, bytes, _)| (*platform, bytes.to_vec())).collect())
    }

    /// The reference vehicle's libraries that are part of this command.
    pub fn plant() -> Self {
        Self(EMBEDDED.iter().map(|(platform, _, bytes)| (*platform, bytes.to_vec())).collect())
    }

    /// Adds or replaces the library of a platform by the file at `path`.
    ///
    /// # Errors
    /// What reading the file says.
    pub fn add(&mut self, platform: Platform, path: &Path) -> std::io::Result<()> {
        self.0.insert(platform, std::fs::read(path)?);
        Ok(())
    }

    /// These libraries alone; `platforms` empty means all.
    ///
    /// # Errors
    /// The first platform that there is no library for.
    pub fn only(mut self, platforms: &[Platform]) -> Result<Self, Platform> {
        if let Some(missing) = platforms.iter().find(|platform| !self.0.contains_key(platform)) {
            return Err(*missing);
        }
        self.0.retain(|platform, _| platforms.is_empty() || platforms.contains(platform));
        Ok(self)
    }

    /// Names of the platforms, for people.
    pub fn listed(&self) -> String {
        self.0.keys().map(|platform| platform.folder()).collect::<Vec<_>>().join(", ")
    }
}
