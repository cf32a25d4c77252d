//! The packaged detector, fed with what was recorded.

use steerguard_detector::{Interval, Vehicle, Zero};

use super::error::ReplayError;
use crate::drive::exchange::{Inputs, Ports, Results};
use crate::importer::{CallError, Fmu, Instance};

/// The detector under test, and what is known of its design.
pub struct Bench {
    /// Its FMU.
    pub fmu: Fmu,
    /// The vehicle it is made for.
    pub vehicle: Vehicle,
    /// What its sensors show at zero.
    pub zero: Zero,
    /// Angle of the steering sensor over that of the road wheel.
    pub steering_ratio: f64,
    /// Speeds that it is made for, m/s.
    pub speeds: Interval,
    /// Sampling period, s.
    pub period_s: f64,
}

/// End of a run that the detector is told, s: a drive's is not known before it is over.
const STOP_TIME_S: f64 = 1e8;

/// An instance of the detector that goes along a drive.
pub struct Detector {
    instance: Instance,
    ports: Ports,
    period_s: f64,
    /// Sample of the piece; none before the first.
    sample: Option<u64>,
}

impl Detector {
    /// A new instance.
    ///
    /// # Errors
    /// [`ReplayError`] if a variable is missing, or the FMU gives no instance.
    pub fn new(bench: &Bench, name: &str) -> Result<Self, ReplayError> {
        Ok(Self {
            instance: bench.fmu.instantiate(name)?,
            ports: Ports::find(&bench.fmu)?,
            period_s: bench.period_s,
            sample: None,
        })
    }

    /// Runs a sample, the first of a piece where `starts`.
    ///
    /// # Errors
    /// [`CallError`] at the first call that the FMU refuses.
    pub fn step(&mut self, starts: bool, inputs: &Inputs) -> Result<Results, CallError> {
        let sample = match self.sample {
            Some(sample) if !starts => sample + 1,
            before => {
                if before.is_some() {
                    self.instance.reset()?;
                }
                self.instance.setup_experiment(STOP_TIME_S)?;
                self.instance.enter_initialization_mode()?;
                self.ports.tell(&mut self.instance, inputs)?;
                self.instance.exit_initialization_mode()?;
                0
            }
        };
        self.sample = Some(sample);
        self.ports.tell(&mut self.instance, inputs)?;
        self.instance.do_step(sample as f64 * self.period_s, self.period_s)?;
        // Messages of a long drive would fill the memory; what they say is in the results.
        self.instance.take_log();
        self.ports.hear(&self.instance)
    }
}
