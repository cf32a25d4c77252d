//! Recorded drives: from files as loggers write them to samples on a grid.
//!
//! ```text
//! file -> Reader: rows in SI, columns by told or guessed names -> Resampler: samples of one period
//! ```
//!
//! # Conventions
//! - SI, axes ISO 8855: yaw rate, steering and lateral acceleration are positive to the left. Whoever has
//!   other axes turns a column by a minus in its mapping.
//! - The steering is what its sensor shows, at the hand wheel or the road wheel: neither ratio nor offset is
//!   applied here, a table from hand wheel to road wheel ([`SteeringTable`]) is.
//! - Times are those of the file, s; of stamps of date and clock since the midnight before the first. A signal that comes late by its delay belongs to the time before that.
//! - What is guessed of a file is said ([`Chosen`]); what looks wrong is an error with its line, or a
//!   [`Finding`].
//! - Files are streamed: memory does not grow with them.

mod choose;
mod columns;
mod error;
mod findings;
mod names;
mod reader;
mod resample;
mod sample;
mod signal;
mod stamp;
mod steering;
mod table;
mod unit;

pub use choose::{Choice, Chosen};
pub use columns::{Column, ColumnError, Columns};
pub use error::{Cause, DriveError};
pub use findings::Finding;
pub use reader::{Layout, Reader, Row};
pub use resample::{Resampled, Resampler, Spacing, pieces};
pub use sample::{Piece, Sample};
pub use signal::{Signal, Wanted};
pub use stamp::StampForm;
pub use steering::{SteeringTable, SteeringTableError};
pub use unit::{Quantity, Unit};
