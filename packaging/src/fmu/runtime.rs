//! The shared libraries of all FMUs before anything is baked into them.

use std::collections::BTreeMap;

use crate::platform::Platform;

/// Shared libraries of one model by platform.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Runtimes(pub BTreeMap<Platform, Vec<u8>>);

impl Runtimes {
    /// The detector's library for this machine, part of this command.
    pub fn detector() -> Self {
        Self::host(include_bytes!(env!("STEERGUARD_DETECTOR_RUNTIME")))
    }

    /// The detector's library of FMI 3.0 for this machine, part of this command.
    pub fn detector_fmi3() -> Self {
        Self::host(include_bytes!(env!("STEERGUARD_DETECTOR_FMI3_RUNTIME")))
    }

    /// The reference vehicle's library for this machine, part of this command.
    pub fn plant() -> Self {
        Self::host(include_bytes!(env!("STEERGUARD_PLANT_RUNTIME")))
    }

    fn host(bytes: &[u8]) -> Self {
        Self(Platform::HOST.map(|platform| (platform, bytes.to_vec())).into_iter().collect())
    }
}

/// Whether a library is for FMI 3.0, by the name of a function that it exports then.
pub fn is_for_fmi3(library: &[u8]) -> bool {
    const NAME: &[u8] = b"fmi3GetVersion";
    library.windows(NAME.len()).any(|bytes| bytes == NAME)
}
