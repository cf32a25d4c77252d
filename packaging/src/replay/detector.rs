//! The packaged detector, fed with what was recorded.

use steerguard_detector::{Interval, Vehicle, Zero};

use super::error::ReplayError;
use crate::importer::{CallError, Fmu, ImportError, Instance, Type};

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

/// What the detector is told at a sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Inputs {
    /// m/s.
    pub v_x: f64,
    /// rad/s.
    pub r: f64,
    /// N m.
    pub drive_torque: f64,
    /// At the road wheel, rad.
    pub steering_angle: f64,
}

/// What the detector says of a sample.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Results {
    /// `residual.v_x`, `residual.r`, `J_rms`, `J_th`, `v_y_hat`, `second_ratio`, `fault_estimate` and
    /// `fault_estimate_bound`.
    pub reals: [f64; 8],
    /// Whether a fault is detected.
    pub alarm: bool,
    /// Whether the smallest fault of interest could be seen.
    pub excited: bool,
    /// Items of `state`, `state_cause` and `alarm_cause`.
    pub items: [i32; 3],
}

/// Value references of what is exchanged.
#[derive(Clone, Copy, Debug)]
pub struct Ports {
    inputs: [u32; 4],
    reals: [u32; 8],
    booleans: [u32; 2],
    items: [u32; 3],
}

impl Ports {
    fn find(fmu: &Fmu) -> Result<Self, ImportError> {
        let item = |name| fmu.variable(name, Type::Enumeration);
        Ok(Self {
            inputs: fmu.reals(["v_x", "r", "u.T_eng", "u.delta"])?,
            reals: fmu.reals([
                "residual.v_x",
                "residual.r",
                "J_rms",
                "J_th",
                "v_y_hat",
                "second_ratio",
                "fault_estimate",
                "fault_estimate_bound",
            ])?,
            booleans: [
                fmu.variable("alarm", Type::Boolean)?,
                fmu.variable("excited", Type::Boolean)?,
            ],
            items: [item("state")?, item("state_cause")?, item("alarm_cause")?],
        })
    }
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
        let Inputs { v_x, r, drive_torque, steering_angle } = *inputs;
        let inputs = [v_x, r, drive_torque, steering_angle];
        let sample = match self.sample {
            Some(sample) if !starts => sample + 1,
            before => {
                if before.is_some() {
                    self.instance.reset()?;
                }
                self.instance.setup_experiment(STOP_TIME_S)?;
                self.instance.enter_initialization_mode()?;
                self.instance.set_real(self.ports.inputs, inputs)?;
                self.instance.exit_initialization_mode()?;
                0
            }
        };
        self.sample = Some(sample);
        self.instance.set_real(self.ports.inputs, inputs)?;
        self.instance.do_step(sample as f64 * self.period_s, self.period_s)?;
        // Messages of a long drive would fill the memory; what they say is in the results.
        self.instance.take_log();
        let [alarm, excited] = self.instance.get_boolean(self.ports.booleans)?;
        Ok(Results {
            reals: self.instance.get_real(self.ports.reals)?,
            alarm: alarm != 0,
            excited: excited != 0,
            items: self.instance.get_integer(self.ports.items)?,
        })
    }
}
