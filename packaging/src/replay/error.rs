//! Why a replay has no result.

use steerguard_drives::DriveError;

use crate::drive::exchange::NotFinite;
use crate::drive::figure::PlotError;
use crate::importer::{CallError, ImportError};
use crate::output::OutputError;

/// Why a replay has no result.
#[derive(Debug, thiserror::Error)]
pub enum ReplayError {
    /// A drive cannot be read.
    #[error(transparent)]
    Drive(#[from] DriveError),
    /// The detector lacks a variable.
    #[error(transparent)]
    Import(#[from] ImportError),
    /// The detector refused a call or failed.
    #[error(transparent)]
    Call(#[from] CallError),
    /// The detector gave what is no number.
    #[error(transparent)]
    NotFinite(#[from] NotFinite),
    /// A sample could not be written as CSV.
    #[error("cannot write CSV: {0}")]
    Csv(#[from] csv::Error),
    /// The plot could not be drawn.
    #[error(transparent)]
    Plot(#[from] PlotError),
    /// A file could not be written.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// The summary could not be written as JSON.
    #[error("cannot write JSON: {0}")]
    Json(#[from] serde_json::Error),
}
