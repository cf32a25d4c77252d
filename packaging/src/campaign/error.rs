//! Why a campaign has no result.

use std::path::{Path, PathBuf};

use parquet::errors::ParquetError;

use crate::drive::cosimulation::CosimulationError;
use crate::output::OutputError;

/// Why a campaign has no result.
#[derive(Debug, thiserror::Error)]
pub enum CampaignError {
    /// A drive ended early.
    #[error("drive {index}: {source}")]
    Drive {
        /// Which drive.
        index: u64,
        /// Why.
        source: Box<CosimulationError>,
    },
    /// The folder is in use for another campaign.
    #[error("`{}` holds another campaign{differences}", folder.display())]
    OtherCampaign {
        /// The folder.
        folder: PathBuf,
        /// What differs, a line each.
        differences: String,
    },
    /// What the folder says of its campaign cannot be read.
    #[error("`{}` is damaged: it holds no campaign", path.display())]
    Damaged {
        /// The file.
        path: PathBuf,
    },
    /// A block cannot be used.
    #[error("block `{}`: {reason}", path.display())]
    Block {
        /// Its file.
        path: PathBuf,
        /// Why not.
        reason: String,
    },
    /// A file could not be read.
    #[error("cannot read `{}`: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// JSON could not be made.
    #[error("cannot write JSON: {0}")]
    Json(#[from] serde_json::Error),
    /// The table could not be made.
    #[error("cannot make the table of results: {0}")]
    Table(#[from] ParquetError),
    /// A file could not be written.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// The system gives no threads.
    #[error("cannot start workers: {0}")]
    Workers(#[from] rayon::ThreadPoolBuildError),
}

impl CampaignError {
    pub(super) fn drive(index: u64) -> impl FnOnce(CosimulationError) -> Self {
        move |source| Self::Drive { index, source: Box::new(source) }
    }

    pub(super) fn read(path: &Path) -> impl FnOnce(std::io::Error) -> Self + '_ {
        |source| Self::Read { path: path.to_owned(), source }
    }
}
