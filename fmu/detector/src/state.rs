//! How the detector's condition appears as an item of `state`.

use steerguard_detector::Monitor;
use steerguard_model_description::detector::DetectorState;

/// The item of `state` while a condition holds.
pub const fn state(monitor: Monitor) -> DetectorState {
    match monitor {
        Monitor::Starting => DetectorState::Starting,
        Monitor::Monitoring => DetectorState::Monitoring,
        Monitor::OutOfRange => DetectorState::OutOfRange,
        Monitor::InvalidInput => DetectorState::InvalidInput,
    }
}
