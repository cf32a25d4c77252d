//! Recorded drives through the packaged detector: what it would have said.
//!
//! # Conventions
//! - The detector's FMU runs at the design's period on samples of the drive (`steerguard_drives`); the
//!   angle at the road wheel is that of the steering sensor over the design's steering ratio. Offset and bias
//!   are parameters of the FMU, which start at the design's.
//! - Times count from the drive's first sample. A gap restarts the detector, whose own time begins anew.
//! - A fault f is *injected* as `u.delta = recorded - f`: the wheels of the recording stand where they stand,
//!   so that the actual angle less the commanded one is f. All runs of a drive go on together, so that its
//!   file is read once.
//! - Without a torque column the torque is that of the speed's course (`torque.rs`).

mod detector;
mod error;
pub mod fault;
mod figure;
mod preparation;
pub mod recording;
pub mod report;
mod run;
pub mod tally;
mod torque;
mod trace;

pub use detector::Bench;
pub use error::ReplayError;
pub use run::{OpenDrive, Outputs, drive};
