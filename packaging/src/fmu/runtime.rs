//! The shared libraries of all FMUs before anything is baked into them.

use std::collections::BTreeMap;

use crate::platform::Platform;

/// What is built into this command: a platform, and the libraries of the detector in FMI 2.0, in FMI 3.0, and
/// of the reference vehicle.
type Embedded = (Platform, &'static [u8], &'static [u8], &'static [u8]);

// EMBEDDED, written by the build script.
include!(env!("STEERGUARD_EMBEDDED"));

/// Shared libraries of one model by platform.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Runtimes(pub BTreeMap<Platform, Vec<u8>>);

impl Runtimes {
    /// The detector's libraries that are part of this command.
    pub fn detector() -> Self {
        Self::embedded(|(_, fmi2, _, _)| fmi2)
    }

    /// The detector's libraries of FMI 3.0 that are part of this command.
    pub fn detector_fmi3() -> Self {
        Self::embedded(|(_, _, fmi3, _)| fmi3)
    }

    /// The reference vehicle's libraries that are part of this command.
    pub fn plant() -> Self {
        Self::embedded(|(_, _, _, plant)| plant)
    }

    fn embedded(library: fn(&Embedded) -> &'static [u8]) -> Self {
        Self(EMBEDDED.iter().map(|of| (of.0, library(of).to_vec())).collect())
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

/// Whether a library is for FMI 3.0, by the name of a function that it exports then.
pub fn is_for_fmi3(library: &[u8]) -> bool {
    const NAME: &[u8] = b"fmi3GetVersion";
    library.windows(NAME.len()).any(|bytes| bytes == NAME)
}
