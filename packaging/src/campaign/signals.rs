//! The signals of drives as one Parquet file: what the detector was given and what it said.
//!
//! # Conventions
//! A row a sample, under the names of the FMU variables; a row group a drive, in the order of the
//! indices. So other detectors can be judged by the same drives.

use std::ops::Range;
use std::path::Path;

use rayon::ThreadPoolBuilder;
use rayon::iter::{IntoParallelIterator, ParallelIterator};

use super::Manifest;
use super::drive::Drive;
use super::error::CampaignError;
use super::record::{Kind, Value};
use super::settings::Settings;
use super::simulation::TestBench;
use super::table::{Column, Table};
use crate::drive::cosimulation::Sample;
use crate::output;

/// A sample of a drive.
type Signal = (u64, Sample);

fn columns() -> Vec<Column<Signal>> {
    fn real(name: &'static str, value: fn(&Sample) -> f64) -> Column<Signal> {
        (name, Kind::Real, Box::new(move |(_, sample)| Value::Real(Some(value(sample)))))
    }
    fn integer(name: &'static str, value: fn(&Signal) -> i64) -> Column<Signal> {
        (name, Kind::Integer, Box::new(move |signal| Value::Integer(value(signal))))
    }
    vec![
        // Indices stay below 2^63.
        integer("drive", |(index, _)| index.cast_signed()),
        real("time", |sample| sample.time),
        real("v_x", |sample| sample.v_x),
        real("r", |sample| sample.r),
        real("u.T_eng", |sample| sample.drive_torque),
        real("u.delta", |sample| sample.steering_angle),
        real("fault", |sample| sample.fault),
        real("J_rms", |sample| sample.j_rms),
        real("J_th", |sample| sample.j_th),
        real("second_ratio", |sample| sample.second_ratio),
        integer("alarm", |(_, sample)| sample.alarm.into()),
        integer("state", |(_, sample)| sample.state.into()),
    ]
}

/// Drives `drives` on `jobs` workers and writes their signals to `path`; `progress` hears the number
/// of drives done.
///
/// # Errors
/// The first [`CampaignError`]; there is no file then.
pub fn write(
    bench: &TestBench,
    manifest: &Manifest,
    drives: Range<u64>,
    jobs: usize,
    path: &Path,
    progress: impl Fn(u64) + Sync,
) -> Result<(), CampaignError> {
    let workers = ThreadPoolBuilder::new().num_threads(jobs).build()?;
    let metadata = serde_json::to_string_pretty(manifest)? + "\n";
    let mut table = Table::new(output::begin(path)?, "sample", columns(), metadata)?;
    // A few drives for each worker: enough to keep them busy, few enough for the memory.
    let together = 4 * jobs;
    for begin in drives.clone().step_by(together) {
        let some = begin..drives.end.min(begin + together as u64);
        let signals = workers.install(|| {
            let drive = |index| {
                let signals = signals(bench, &manifest.settings, index);
                progress(1);
                signals
            };
            some.into_par_iter().map(drive).collect::<Result<Vec<_>, _>>()
        })?;
        for drive in signals {
            table.write(&drive)?;
        }
    }
    Ok(table.finish()?.finish()?)
}

/// The samples of drive `index`.
fn signals(
    bench: &TestBench,
    settings: &Settings,
    index: u64,
) -> Result<Vec<Signal>, CampaignError> {
    let mut signals = Vec::new();
    let drive = Drive::draw(settings, &bench.subject, index);
    bench
        .run(&drive, |sample| signals.push((index, *sample)))
        .map_err(CampaignError::drive(index))?;
    Ok(signals)
}
