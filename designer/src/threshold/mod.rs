//! The threshold by its kinds, and what it is made of.
//!
//! ```text
//! J_th(k) = threshold + start-up term(k) + share RMS_window( sum_j ||W_r C e_j(k)|| )
//! ```
//!
//! with e_j the error's response to uncertainty j at its bound: method 6.

pub mod calibration;
pub mod guaranteed;
pub mod recorded;
pub mod searched;
pub mod second;
#[cfg(test)]
mod told_apart;

use serde::Serialize;
use steerguard_detector::{
    CAUSES, Cause, Configuration, ConfigurationError, Evaluation, Input, SteadyResponse,
    VehicleState, steady_response,
};
use steerguard_world::steady_angle;

use crate::problem::model;
use crate::progress::Step;
use crate::spec::{Spec, ThresholdKind};
use crate::synthesis::gains::ObserverGains;
use crate::synthesis::theorem4::Theorem4;
use crate::threshold::calibration::{Level, Levels, Population, calibrate, drives};
use crate::threshold::guaranteed::{Guaranteed, PeakCertificate, peak_bounds, without_inputs};
use crate::threshold::recorded::{Recorded, RecordedDrive, RecordedError};
use crate::threshold::searched::{Searched, covered, searched};
use crate::threshold::second::SecondLevels;
use crate::worst::{Objective, UNREACHED};

/// Names of the causes that raise the threshold, in the order of the detector's.
pub fn cause_names() -> [&'static str; CAUSES] {
    Cause::ALL.map(|cause| match cause {
        Cause::Mass => "mass",
        Cause::YawInertia => "yaw inertia",
        Cause::FrontStiffness => "front stiffness",
        Cause::RearStiffness => "rear stiffness",
        Cause::Friction => "friction",
        Cause::LoadTransfer => "load transfer",
        Cause::Bank => "bank",
        Cause::Gust => "gust",
        Cause::Actuator => "actuator",
        Cause::SteeringRatio => "steering ratio",
        Cause::SteeringOffset => "steering offset",
        Cause::FrontUnderSideForce => "front stiffness x side force",
        Cause::RearUnderSideForce => "rear stiffness x side force",
        Cause::YawRateBias => "yaw-rate bias",
        Cause::SpeedScale => "speed scale",
    })
}

/// Why there is no threshold.
#[derive(Debug, thiserror::Error)]
pub enum ThresholdError {
    /// The residual has no bound that the inequalities prove.
    #[error(
        "no bound on J under \"{input}\" was found for evaluation.threshold = \"guaranteed\": the \
         error must contract whatever the course of the premise; lower design.decay, narrow \
         operating_range.v_x_m_per_s or operating_range.v_y_m_per_s, or take another kind of threshold"
    )]
    Guarantee {
        /// The disturbance or noise.
        input: String,
    },
    /// Nothing to calibrate from.
    #[error(
        "the detector monitored no sample of the calibration's drives past its start-up: every one left \
         the operating range, or is too short: lengthen evaluation.calibration.duration_s"
    )]
    Calibration,
    /// A recorded drive gives no level.
    #[error(transparent)]
    Recorded(#[from] RecordedError),
    /// The detector refuses the numbers found.
    #[error(transparent)]
    Configuration(#[from] ConfigurationError),
}

/// A threshold, and where it comes from.
#[derive(Clone, Debug, PartialEq)]
pub struct Threshold {
    /// On J once the start-up has passed, where nothing is uncertain.
    pub threshold: f64,
    /// Share of the uncertainties' bound that is added.
    pub uncertainty_share: f64,
    /// Largest fault-free level of the vehicle as specified, of kinds "calibrated" and "adaptive".
    pub calibration: Option<Level>,
    /// Largest J over that level and the uncertainties' bound, of kind "adaptive".
    pub uncertain: Option<Level>,
    /// What recorded drives reach likewise, of kinds "calibrated" and "adaptive".
    pub recorded: Vec<Recorded>,
    /// Of kind "adaptive", the largest of the drives that a search finds.
    pub searched: Vec<Searched>,
    /// Largest statistics of the second test, where it runs.
    pub second: Option<SecondLevels>,
    /// The bound and its causes, of kind "guaranteed".
    pub guaranteed: Option<Guaranteed>,
    /// What proves it.
    pub peaks: Option<Vec<PeakCertificate>>,
}

impl Threshold {
    fn constant(threshold: f64) -> Self {
        Self {
            threshold,
            uncertainty_share: 0.0,
            calibration: None,
            uncertain: None,
            recorded: Vec::new(),
            searched: Vec::new(),
            second: None,
            guaranteed: None,
            peaks: None,
        }
    }
}

/// The threshold that `spec` asks for of a detector with `gains` of `theorem` and with
/// `configuration`, whose own threshold is not looked at. `drives` are those of
/// `evaluation.calibration.drives`.
///
/// # Errors
/// [`ThresholdError`] where the detector cannot run or monitors no sample, or where no bound is found.
pub fn threshold(
    spec: &Spec,
    drives: &[RecordedDrive],
    theorem: &Theorem4,
    gains: &ObserverGains,
    configuration: &Configuration,
    progress: &mut dyn FnMut(Step),
) -> Result<Threshold, ThresholdError> {
    let e = &spec.evaluation;
    match e.threshold {
        // A specification without the number is refused when it is read.
        ThresholdKind::Constant => Ok(Threshold::constant(e.constant.unwrap_or_default())),
        ThresholdKind::Calibrated => {
            let level = largest(spec, configuration, Population::Specified, progress)?.j;
            let recorded = recorded::levels(configuration, drives, Population::Specified)?;
            let most = recorded.iter().map(|drive| drive.level).fold(level.level, f64::max);
            Ok(Threshold {
                calibration: Some(level),
                recorded,
                ..Threshold::constant(e.margin * most)
            })
        }
        ThresholdKind::Adaptive => {
            let level = largest(spec, configuration, Population::Specified, progress)?.j;
            let evaluation = Evaluation {
                threshold: level.level,
                uncertainty_share: 1.0,
                ..configuration.evaluation
            };
            let estimator = model::estimator(spec, UNREACHED, UNREACHED);
            let bounded = Configuration { evaluation, estimator, ..*configuration };
            let Levels { j: ratio, second: at_random } =
                largest(spec, &bounded, Population::Uncertain, progress)?;
            let mut recorded = recorded::levels(&bounded, drives, Population::Uncertain)?;
            for ratio in recorded.iter_mut().filter_map(|drive| drive.second.as_mut()) {
                *ratio *= UNREACHED;
            }
            progress(Step::Worst);
            let budget = e.calibration.search_drives;
            let searched = searched(spec, &bounded, Objective::Residual, budget)?;
            let second = at_random
                .map(|at_random| SecondLevels::of(spec, &bounded, at_random))
                .transpose()?;
            let factor = e.margin * covered(&ratio, &recorded, &searched, e.margin, e.covers);
            Ok(Threshold {
                uncertainty_share: factor,
                calibration: Some(level.clone()),
                uncertain: Some(ratio),
                recorded,
                searched,
                second,
                ..Threshold::constant(factor * level.level)
            })
        }
        ThresholdKind::Guaranteed => {
            progress(Step::Guarantee);
            let bounds = peak_bounds(spec, theorem, gains);
            let (inputs, peaks) =
                bounds.map_err(|input| ThresholdError::Guarantee { input })?.into_iter().unzip();
            let undisturbed = without_inputs(spec);
            let discretisation =
                largest(&undisturbed, configuration, Population::Specified, progress)?.j;
            let guaranteed = Guaranteed::new(inputs, discretisation);
            Ok(Threshold {
                peaks: Some(peaks),
                guaranteed: Some(guaranteed.clone()),
                ..Threshold::constant(e.margin * guaranteed.level())
            })
        }
    }
}

/// The largest statistic of the drives that `spec` asks for.
fn largest(
    spec: &Spec,
    configuration: &Configuration,
    population: Population,
    progress: &mut dyn FnMut(Step),
) -> Result<Levels, ThresholdError> {
    let drives = drives(spec);
    let of = drives.len();
    progress(Step::Calibration { done: 0, of });
    let mut count = |done| progress(Step::Calibration { done, of });
    // Within the start-up J may stay below the term that covers it.
    calibrate(spec, configuration, &drives, population, &mut count)?
        .filter(|levels| levels.j.level > 0.0)
        .ok_or(ThresholdError::Calibration)
}

/// The threshold in a steady turn, cause by cause.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct SteadyThreshold {
    /// Speed.
    pub v_x_m_per_s: f64,
    /// Lateral acceleration.
    pub lateral_acceleration_m_per_s2: f64,
    /// Noise, disturbances and what else a fault-free drive of the specified vehicle shows.
    pub level: f64,
    /// Each cause, in the order of [`cause_names`].
    pub uncertainties: [f64; CAUSES],
    /// The sum: J_th.
    pub j_th: f64,
    /// The J that the smallest fault of interest makes alone.
    pub smallest_fault_j: f64,
}

/// Lateral acceleration of the turns among the [`steady_points`], m/s^2.
const TURN_M_PER_S2: f64 = 3.0;
/// Time until a response counts as steady, s: of the observer and of the vehicle's own motion.
const STEADY_S: f64 = 20.0;

/// The threshold of a detector with `configuration` at the [`steady_points`].
pub fn by_cause(configuration: &Configuration) -> Vec<SteadyThreshold> {
    let points = steady_points(configuration).into_iter();
    points.map(|[v_x, a_y]| steady(configuration, v_x, a_y)).collect()
}

/// Speed in m/s and lateral acceleration in m/s^2 straight ahead and in a turn of 3 m/s^2, or as much
/// as the range of r allows, at the lowest, middle and highest armed speed.
pub fn steady_points(configuration: &Configuration) -> Vec<[f64; 2]> {
    let armed = configuration.model.range.shrunk(configuration.hysteresis);
    let middle = 0.5 * (armed.v_x.min + armed.v_x.max);
    let speeds = [armed.v_x.min, middle, armed.v_x.max];
    let turn = |v_x: f64| TURN_M_PER_S2.min(v_x * armed.r.max);
    speeds.into_iter().flat_map(|v_x| [[v_x, 0.0], [v_x, turn(v_x)]]).collect()
}

/// The threshold of a detector with `configuration` at speed `v_x` and lateral acceleration `a_y`.
pub fn steady(configuration: &Configuration, v_x: f64, a_y: f64) -> SteadyThreshold {
    let Configuration { model, evaluation, .. } = configuration;
    let (x, u) = steady_turn(configuration, v_x, a_y);
    let samples = (STEADY_S / model.sampling_period_s).ceil() as u32;
    let SteadyResponse { by_cause, fault } = steady_response(configuration, x, u, samples);
    let uncertainties = by_cause.map(|level| evaluation.uncertainty_share * level);
    SteadyThreshold {
        v_x_m_per_s: v_x,
        lateral_acceleration_m_per_s2: a_y,
        level: evaluation.threshold,
        uncertainties,
        j_th: evaluation.threshold + uncertainties.iter().sum::<f64>(),
        smallest_fault_j: fault,
    }
}

/// State and input of a steady turn to the left of the linear single-track model at speed `v_x` and
/// lateral acceleration `a_y`: Rajamani (2012), 3.3.
fn steady_turn(configuration: &Configuration, v_x: f64, a_y: f64) -> (VehicleState, Input) {
    let v = &configuration.model.vehicle;
    let r = a_y / v_x;
    let wheelbase = v.front_axle_distance_m + v.rear_axle_distance_m;
    let rear_force = v.mass_kg * a_y * v.front_axle_distance_m / wheelbase;
    let rear_slip = rear_force / (2.0 * v.rear_cornering_stiffness_n_per_rad);
    let v_y = v.rear_axle_distance_m * r - v_x * rear_slip;
    let x = [v_x, v_y, r].into();
    let delta_rad = steady_angle(v, v_x, a_y);
    (x, Input { t_eng_n_m: v.cruise_torque(v_x), delta_rad })
}
