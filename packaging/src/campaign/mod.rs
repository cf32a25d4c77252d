//! Campaigns: many random drives through the packaged FMUs, and what they show.
//!
//! # Conventions
//! - Drive i is a pure function of settings, design and i, down to the last bit, on any machine: random
//!   numbers by counter, sine and cosine of `libm`, and FMUs that use nothing else. So results do not
//!   depend on the number of workers, on interruptions, or on who drove which part.
//! - Drives are grouped in blocks of [`folder::BLOCK`]; a block is the unit of work and of storage.

pub mod drive;
pub mod drive_record;
mod error;
pub mod folder;
pub mod names;
pub mod outcome;
mod record;
pub mod report;
pub mod settings;
pub mod signals;
pub mod simulation;
pub mod statistics;
pub mod table;
pub mod worst;

use std::ops::Range;

use rayon::ThreadPoolBuilder;
use rayon::iter::{IndexedParallelIterator, IntoParallelRefIterator, ParallelIterator};
use serde::Serialize;

use crate::digest::sha256;
use drive::Drive;
use drive_record::DriveRecord;
pub use error::CampaignError;
use folder::Folder;
use settings::Settings;
use simulation::TestBench;
use table::Row;

/// Value of the key `format` of `campaign.json`.
const FORMAT: &str = "steerguard-campaign/1";

/// Everything that the results of a campaign depend on: the content of `campaign.json`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Manifest {
    /// Format and version of the folder.
    pub format: &'static str,
    /// Version of this command.
    pub version: &'static str,
    /// SHA-256 of the detector's FMU.
    pub detector: String,
    /// SHA-256 of the plant's FMU.
    pub plant: String,
    /// Hash of the design.
    pub design: String,
    /// What is driven.
    #[serde(flatten)]
    pub settings: Settings,
}

impl Manifest {
    /// The manifest of a campaign on FMUs with these bytes.
    pub fn new(settings: Settings, design: String, detector: &[u8], plant: &[u8]) -> Self {
        Self {
            format: FORMAT,
            version: env!("CARGO_PKG_VERSION"),
            detector: sha256(detector),
            plant: sha256(plant),
            design,
            settings,
        }
    }
}

/// The K-th of N parts of a campaign, K from 1: consecutive blocks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    /// K, from 1 to N.
    pub number: u64,
    /// N.
    pub of: u64,
}

impl Shard {
    /// The whole campaign.
    pub const WHOLE: Self = Self { number: 1, of: 1 };

    /// The blocks of the part among `blocks` blocks.
    pub fn blocks(self, blocks: u64) -> Range<u64> {
        let end = |k: u64| (u128::from(blocks) * u128::from(k) / u128::from(self.of)) as u64;
        end(self.number - 1)..end(self.number)
    }

    /// The drives of the part among `drives` drives.
    pub fn drives(self, drives: u64) -> Range<u64> {
        let blocks = self.blocks(drives.div_ceil(folder::BLOCK));
        drives.min(blocks.start * folder::BLOCK)..drives.min(blocks.end * folder::BLOCK)
    }
}

/// Drives one drive and returns its row.
///
/// # Errors
/// [`CampaignError::Drive`].
pub fn row(bench: &TestBench, settings: &Settings, index: u64) -> Result<Row, CampaignError> {
    let drive = Drive::draw(settings, &bench.subject, index);
    let outcome = bench.run(&drive, |_| ()).map_err(CampaignError::drive(index))?;
    Ok(Row { drive: DriveRecord::from(&drive), outcome })
}

/// Drives and writes `blocks` on `jobs` workers; `progress` hears the number of drives done.
///
/// # Errors
/// The first [`CampaignError`]; blocks written before stay.
pub fn run(
    bench: &TestBench,
    settings: &Settings,
    folder: &Folder,
    blocks: &[u64],
    jobs: usize,
    progress: impl Fn(u64) + Sync,
) -> Result<(), CampaignError> {
    let drive_block = |&block: &u64| {
        let rows = folder.drives_of(block).map(|index| {
            let row = row(bench, settings, index);
            progress(1);
            row
        });
        folder.write_block(block, rows.collect::<Result<_, _>>()?)
    };
    let workers = ThreadPoolBuilder::new().num_threads(jobs).build()?;
    // One block at a time for each worker, so that none runs out of work before the others.
    workers.install(|| blocks.par_iter().with_max_len(1).try_for_each(drive_block))
}
