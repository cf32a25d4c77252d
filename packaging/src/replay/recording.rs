//! Recorded fault-free drives for the calibration of a threshold, sampled as `replay` samples them.

use std::path::Path;

use steerguard_designer::Spec;
use steerguard_designer::threshold::recorded::{RecordedDrive, RecordedSample};
use steerguard_detector::{Input, Measurement};
use steerguard_drives::{Cause, Columns, DriveError, Reader, Resampler, Spacing};

use super::run::{WANTED, columns, warnings};
use super::torque::Torques;
use crate::digest::sha256_of_file;

/// A drive, and how it was read.
#[derive(Clone, Debug, PartialEq)]
pub struct Recording {
    /// Its samples.
    pub drive: RecordedDrive,
    /// Its format and columns, told or guessed.
    pub reading: Vec<String>,
    /// What was not taken, what is missing, and what looks wrong with the signals.
    pub warnings: Vec<String>,
}

/// Reads the drive that `spec` calls `name` from the file at `path`; none with more than `most` samples.
///
/// # Errors
/// [`DriveError`].
pub fn read(
    path: &Path,
    name: &str,
    columns_told: &Columns,
    spec: &Spec,
    most: usize,
) -> Result<Option<Recording>, DriveError> {
    let mut reader = Reader::open(path, columns_told, WANTED)?;
    let layout = reader.layout();
    let period_s = spec.sampling.period_s;
    let spacing = Spacing::of_period(period_s);
    let resampled = Resampler::new(reader.by_ref(), layout, spacing);
    let (mut samples, mut without_torque) = (Vec::new(), 0);
    for driven in Torques::new(resampled, spec.vehicle, period_s) {
        let driven = driven?;
        if samples.len() == most {
            return Ok(None);
        }
        let sample = driven.resampled.sample;
        without_torque += u64::from(sample.drive_torque_n_m.is_none());
        samples.push(RecordedSample {
            starts: driven.starts,
            y: Measurement {
                v_x_m_per_s: sample.speed_m_per_s,
                r_rad_per_s: sample.yaw_rate_rad_per_s,
            },
            u: Input {
                t_eng_n_m: driven.drive_torque_n_m,
                delta_rad: sample.steering_rad / spec.sensors.steering_ratio,
            },
        });
    }
    let failed =
        |cause: Cause| DriveError { file: path.to_owned(), line: None, cause: Box::new(cause) };
    if samples.is_empty() {
        return Err(failed(Cause::NoPiece { gap_s: spacing.gap_s }));
    }
    let sha256 = sha256_of_file(path).map_err(|error| failed(error.into()))?;
    let mut reading = vec![reader.reading()];
    reading.extend(columns(&reader));
    let warnings = warnings(&reader, without_torque, samples.len() as f64);
    let drive = RecordedDrive { file: name.to_owned(), sha256, samples };
    Ok(Some(Recording { drive, reading, warnings }))
}
