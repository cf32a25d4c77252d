//! What a detector FMU is told and says at a sample, by value reference.

use crate::importer::{CallError, Fmu, ImportError, Instance, Type};

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
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Results {
    /// Residual of the longitudinal speed, m/s.
    pub residual_v_x: f64,
    /// Residual of the yaw rate, rad/s.
    pub residual_r: f64,
    /// Windowed RMS of the weighted residual.
    pub j_rms: f64,
    /// Threshold.
    pub j_th: f64,
    /// Estimated lateral speed, m/s.
    pub v_y_hat: f64,
    /// Statistic of the second test over its threshold.
    pub second_ratio: f64,
    /// The fault that the second test has found, rad; 0 for none.
    pub fault_estimate: f64,
    /// Its largest error, rad.
    pub fault_estimate_bound: f64,
    /// Whether a fault is detected.
    pub alarm: bool,
    /// Whether the smallest fault of interest could be seen.
    pub excited: bool,
    /// Item of the enumeration `DetectorState`.
    pub state: i32,
    /// Item of the enumeration `DetectorStateCause`.
    pub state_cause: i32,
    /// Item of the enumeration `DetectorAlarmCause`.
    pub alarm_cause: i32,
}

/// An FMU gave what is no number.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("{fmu}: `{variable}` = {value} at {time_s} s, which is no finite number")]
pub struct NotFinite {
    /// Name of the instance.
    pub fmu: &'static str,
    /// Name of the variable.
    pub variable: &'static str,
    /// What it is.
    pub value: f64,
    /// Time of the sample, s.
    pub time_s: f64,
}

/// Finds the first of the `values`, of the variables called `names`, that is not finite.
///
/// # Errors
/// [`NotFinite`].
pub(crate) fn finite<const N: usize>(
    fmu: &'static str,
    names: [&'static str; N],
    values: [f64; N],
    time_s: f64,
) -> Result<(), NotFinite> {
    match names.into_iter().zip(values).find(|(_, value)| !value.is_finite()) {
        Some((variable, value)) => Err(NotFinite { fmu, variable, value, time_s }),
        None => Ok(()),
    }
}

impl Results {
    /// Finds a result of the sample at `time_s` that is not finite.
    ///
    /// # Errors
    /// [`NotFinite`].
    pub(crate) fn finite(&self, time_s: f64) -> Result<(), NotFinite> {
        let values = [
            self.residual_v_x,
            self.residual_r,
            self.j_rms,
            self.j_th,
            self.v_y_hat,
            self.second_ratio,
            self.fault_estimate,
            self.fault_estimate_bound,
        ];
        finite("detector", REALS, values, time_s)
    }
}

/// The detector's outputs of type Real, in the order of [`Results`].
const REALS: [&str; 8] = [
    "residual.v_x",
    "residual.r",
    "J_rms",
    "J_th",
    "v_y_hat",
    "second_ratio",
    "fault_estimate",
    "fault_estimate_bound",
];

/// Value references of what is exchanged.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ports {
    inputs: [u32; 4],
    reals: [u32; 8],
    booleans: [u32; 2],
    items: [u32; 3],
}

impl Ports {
    /// Those of a `detector`.
    ///
    /// # Errors
    /// [`ImportError`] if a variable is missing.
    pub fn find(detector: &Fmu) -> Result<Self, ImportError> {
        let flag = |name| detector.variable(name, Type::Boolean);
        let item = |name| detector.variable(name, Type::Enumeration);
        Ok(Self {
            inputs: detector.reals(["v_x", "r", "u.T_eng", "u.delta"])?,
            reals: detector.reals(REALS)?,
            booleans: [flag("alarm")?, flag("excited")?],
            items: [item("state")?, item("state_cause")?, item("alarm_cause")?],
        })
    }

    /// Tells `detector` the `inputs`.
    ///
    /// # Errors
    /// [`CallError`] if it refuses.
    pub fn tell(&self, detector: &mut Instance, inputs: &Inputs) -> Result<(), CallError> {
        let Inputs { v_x, r, drive_torque, steering_angle } = *inputs;
        detector.set_real(self.inputs, [v_x, r, drive_torque, steering_angle])
    }

    /// What `detector` says of its last sample.
    ///
    /// # Errors
    /// [`CallError`] if it refuses.
    pub fn hear(&self, detector: &Instance) -> Result<Results, CallError> {
        let [
            residual_v_x,
            residual_r,
            j_rms,
            j_th,
            v_y_hat,
            second_ratio,
            fault_estimate,
            fault_estimate_bound,
        ] = detector.get_real(self.reals)?;
        let [alarm, excited] = detector.get_boolean(self.booleans)?;
        let [state, state_cause, alarm_cause] = detector.get_integer(self.items)?;
        Ok(Results {
            residual_v_x,
            residual_r,
            j_rms,
            j_th,
            v_y_hat,
            second_ratio,
            fault_estimate,
            fault_estimate_bound,
            alarm: alarm != 0,
            excited: excited != 0,
            state,
            state_cause,
            alarm_cause,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_result_that_is_no_number_is_told_by_name_and_time() {
        let mut results = Results {
            residual_v_x: 0.0,
            residual_r: 0.0,
            j_rms: 1.0,
            j_th: 1.0,
            v_y_hat: 0.0,
            second_ratio: 0.0,
            fault_estimate: 0.0,
            fault_estimate_bound: 0.0,
            alarm: false,
            excited: true,
            state: 2,
            state_cause: 1,
            alarm_cause: 1,
        };
        assert_eq!(results.finite(1.5), Ok(()));
        results.j_th = f64::NAN;
        results.fault_estimate = f64::INFINITY;
        let said = results.finite(1.5).unwrap_err().to_string();
        assert_eq!(said, "detector: `J_th` = NaN at 1.5 s, which is no finite number");
        let said = finite("plant", ["v_x", "r"], [1.0, -f64::INFINITY], 0.0).unwrap_err();
        assert_eq!(said.to_string(), "plant: `r` = -inf at 0 s, which is no finite number");
    }
}
