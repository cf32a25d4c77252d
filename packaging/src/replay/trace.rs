//! A run, sample by sample, as CSV: inputs and results under the names of the FMU's variables.

use std::io::BufWriter;
use std::path::Path;

use serde::Serialize;

use super::error::ReplayError;
use crate::drive::cosimulation::{self, as_digit};
use crate::drive::exchange::{Inputs, Results};
use crate::output::{self, Output};

/// A sample of a run: the columns of its CSV file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct TraceRow {
    /// From the drive's first sample, s.
    pub time: f64,
    /// Number of the piece between gaps, from 0.
    pub piece: u64,
    /// m/s.
    pub v_x: f64,
    /// rad/s.
    pub r: f64,
    /// N m.
    #[serde(rename = "u.T_eng")]
    pub drive_torque: f64,
    /// What the detector was told, rad.
    #[serde(rename = "u.delta")]
    pub steering_angle: f64,
    /// The injected fault, rad.
    pub fault: f64,
    /// m/s.
    #[serde(rename = "residual.v_x")]
    pub residual_v_x: f64,
    /// rad/s.
    #[serde(rename = "residual.r")]
    pub residual_r: f64,
    /// Windowed RMS of the weighted residual.
    #[serde(rename = "J_rms")]
    pub j_rms: f64,
    /// Threshold.
    #[serde(rename = "J_th")]
    pub j_th: f64,
    /// m/s.
    pub v_y_hat: f64,
    /// 0 or 1 in the file.
    #[serde(serialize_with = "as_digit")]
    pub alarm: bool,
    /// 0 or 1 in the file.
    #[serde(serialize_with = "as_digit")]
    pub excited: bool,
    /// Item of the enumeration `DetectorState`.
    pub state: i32,
    /// Item of the enumeration `DetectorStateCause`.
    pub state_cause: i32,
    /// Item of the enumeration `DetectorAlarmCause`.
    pub alarm_cause: i32,
    /// Statistic of the second test over its threshold.
    pub second_ratio: f64,
    /// The fault that the second test has found, rad; 0 for none.
    pub fault_estimate: f64,
    /// Its largest error, rad.
    pub fault_estimate_bound: f64,
}

impl TraceRow {
    /// What the detector was told and said.
    pub(super) fn new(
        time: f64,
        piece: u64,
        fault: f64,
        inputs: &Inputs,
        results: &Results,
    ) -> Self {
        let Inputs { v_x, r, drive_torque, steering_angle } = *inputs;
        let Results {
            residual_v_x,
            residual_r,
            j_rms,
            j_th,
            v_y_hat,
            second_ratio,
            fault_estimate,
            fault_estimate_bound,
            alarm,
            excited,
            state,
            state_cause,
            alarm_cause,
        } = *results;
        Self {
            time,
            piece,
            v_x,
            r,
            drive_torque,
            steering_angle,
            fault,
            residual_v_x,
            residual_r,
            j_rms,
            j_th,
            v_y_hat,
            alarm,
            excited,
            state,
            state_cause,
            alarm_cause,
            second_ratio,
            fault_estimate,
            fault_estimate_bound,
        }
    }

    /// The same as campaigns observe it.
    pub(super) fn observed(&self) -> cosimulation::Sample {
        cosimulation::Sample {
            time: self.time,
            v_x: self.v_x,
            r: self.r,
            fault: self.fault,
            j_rms: self.j_rms,
            j_th: self.j_th,
            alarm: self.alarm,
            excited: self.excited,
            state: self.state,
            state_cause: self.state_cause,
            alarm_cause: self.alarm_cause,
            second_ratio: self.second_ratio,
            fault_estimate: self.fault_estimate,
            fault_estimate_bound: self.fault_estimate_bound,
            ..cosimulation::Sample::default()
        }
    }
}

/// A trace that is being written.
pub(super) struct Trace {
    writer: csv::Writer<BufWriter<Output>>,
}

impl Trace {
    /// Begins the file at `path`.
    pub fn begin(path: &Path) -> Result<Self, ReplayError> {
        let file = BufWriter::with_capacity(1 << 16, output::begin(path)?);
        Ok(Self { writer: csv::Writer::from_writer(file) })
    }

    /// Adds a sample.
    pub fn add(&mut self, row: &TraceRow) -> Result<(), ReplayError> {
        Ok(self.writer.serialize(row)?)
    }

    /// Ends the file.
    pub fn finish(self) -> Result<(), ReplayError> {
        let buffer =
            self.writer.into_inner().map_err(|error| csv::Error::from(error.into_error()))?;
        let file = buffer.into_inner().map_err(|error| csv::Error::from(error.into_error()))?;
        Ok(file.finish()?)
    }
}
