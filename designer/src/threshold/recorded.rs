//! What J reaches over recorded fault-free drives, which count beside the simulated ones.
//!
//! # Conventions
//! - A drive is what its sensors showed: zeros are not subtracted, the angle is that of the road wheel.
//! - The statistic is that of the kind of threshold: of kind "calibrated" J less the start-up term, of kind
//!   "adaptive" the ratio of an uncertain vehicle's, which a real car is (`calibration.rs`).

use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use steerguard_detector::{Configuration, ConfigurationError, Detector, Input, Measurement};

use crate::threshold::calibration::{Largest, Population};

/// A recorded drive at the sampling period.
#[derive(Clone, Debug, PartialEq)]
pub struct RecordedDrive {
    /// Its file, as the specification names it.
    pub file: String,
    /// SHA-256 of the file's bytes, in hexadecimal.
    pub sha256: String,
    /// Its samples.
    pub samples: Vec<RecordedSample>,
}

/// A sample of a recorded drive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RecordedSample {
    /// Whether it is the first one of a piece: the detector starts anew.
    pub starts: bool,
    /// What the sensors show.
    pub y: Measurement,
    /// What is commanded.
    pub u: Input,
}

/// What a recorded drive gave.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Recorded {
    /// The file, as the specification names it.
    pub file: String,
    /// SHA-256 of its bytes, in hexadecimal.
    pub sha256: String,
    /// Its samples.
    pub samples: u64,
    /// Share of them at which the detector monitored.
    pub monitored: f64,
    /// Largest statistic at a monitored sample.
    pub level: f64,
    /// Likewise of the second test, where it runs.
    pub second: Option<f64>,
}

/// The largest of recorded drives; none of none.
pub fn largest(recorded: &[Recorded]) -> Option<&Recorded> {
    recorded.iter().max_by(|a, b| a.level.total_cmp(&b.level))
}

/// Why a recorded drive does not count.
#[derive(Debug, thiserror::Error)]
pub enum RecordedError {
    /// Nothing to take a level from.
    #[error(
        "evaluation.calibration.drives: the detector monitored no sample of `{file}` past its start-up: \
         its speed never stayed in operating_range.v_x_m_per_s, or the car left the other ranges; leave \
         the drive out, or see with `steerguard replay` what the detector makes of it"
    )]
    NotMonitored {
        /// The drive.
        file: String,
    },
    /// The detector refuses its configuration.
    #[error(transparent)]
    Configuration(#[from] ConfigurationError),
}

/// Takes `drives` through the detector with `configuration`, on all processors.
///
/// # Errors
/// [`RecordedError`].
pub fn levels(
    configuration: &Configuration,
    drives: &[RecordedDrive],
    population: Population,
) -> Result<Vec<Recorded>, RecordedError> {
    let detector = Detector::new(configuration)?;
    drives.par_iter().map(|drive| level(configuration, &detector, drive, population)).collect()
}

fn level(
    configuration: &Configuration,
    fresh: &Detector,
    drive: &RecordedDrive,
    population: Population,
) -> Result<Recorded, RecordedError> {
    let mut largest = Largest::default();
    let mut detector = *fresh;
    for RecordedSample { starts, y, u } in &drive.samples {
        if *starts {
            detector = *fresh;
        }
        detector.sample(*y, *u);
        largest.add(&detector, &configuration.evaluation, population);
    }
    let samples = drive.samples.len() as u64;
    // Within the start-up J may stay below the term that covers it.
    let level = largest.level.filter(|level| *level > 0.0);
    Ok(Recorded {
        file: drive.file.clone(),
        sha256: drive.sha256.clone(),
        samples,
        monitored: largest.monitored as f64 / samples as f64,
        level: level.ok_or_else(|| RecordedError::NotMonitored { file: drive.file.clone() })?,
        second: largest.second.filter(|_| configuration.estimator.is_some()),
    })
}
