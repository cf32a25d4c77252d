//! The specification: vehicle, ranges, faults of interest, disturbances, method and evaluation.
//!
//! Read from TOML. Every key has a default; unknown keys and impossible values are refused by name.
//! `examples/paper.toml` spells out every key, with the paper's values.
//!
//! # Conventions
//! Units stand in the keys. Bands are in Hz, from 0 (low), up to the Nyquist frequency (high), or
//! both (all frequencies).

use std::f64::consts::PI;

use serde::{Deserialize, Serialize};
use steerguard_detector::{
    Actuator, Deviations, Interval, MAX_DELAY_SAMPLES, MAX_WINDOW, OperatingRange, TsModel, Vehicle,
};

use crate::lmi::matrix::Matrix;
use crate::problem::band::Band;
use crate::problem::channel::Channel;
use crate::problem::inputs::Inputs;
use crate::spec_error::{Allowed, SpecError, parse};
use crate::synthesis::theorem4::{Multipliers, Theorem4};
use crate::threshold::calibration;
use crate::threshold::guaranteed::BoundedInput;

mod channel;
mod uncertainty;

pub use channel::{Disturbance, Fault, Noise, SpeedNoise, YawRateNoise};
pub use uncertainty::UncertaintyTable;

/// A specification.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Spec {
    /// Vehicle data, Table 1 of the paper.
    #[serde(with = "VehicleTable")]
    pub vehicle: Vehicle,
    /// Design range S_x and arming.
    pub operating_range: OperatingRangeTable,
    /// Sampling.
    pub sampling: Sampling,
    /// The steering actuator, where `u.delta` is its command.
    pub actuator: ActuatorTable,
    /// Faults of interest: the gains are made for the first, the others are reported.
    pub fault: Vec<Fault>,
    /// Disturbances.
    pub disturbance: Vec<Disturbance>,
    /// Sensor noise; the default is that of a wheel-speed and a yaw-rate sensor of a production car.
    pub noise: Noise,
    /// What is not known of vehicle, road and air.
    pub uncertainty: UncertaintyTable,
    /// How the gains are found.
    pub design: Method,
    /// How the residual is evaluated.
    pub evaluation: Evaluation,
}

/// The keys of `[vehicle]`: documented at [`Vehicle`].
#[derive(Serialize, Deserialize)]
#[serde(remote = "Vehicle", default = "paper_vehicle", deny_unknown_fields)]
#[allow(missing_docs)]
pub(crate) struct VehicleTable {
    mass_kg: f64,
    yaw_inertia_kg_m2: f64,
    effective_longitudinal_inertia_kg_m: f64,
    front_axle_distance_m: f64,
    rear_axle_distance_m: f64,
    front_cornering_stiffness_n_per_rad: f64,
    rear_cornering_stiffness_n_per_rad: f64,
    longitudinal_drag_n_m_s2_per_m2: f64,
    lateral_drag_n_s2_per_m2: f64,
}

fn paper_vehicle() -> Vehicle {
    Vehicle::PAPER
}

/// `[operating_range]`: the design range S_x as [min, max]; the detector disarms outside it and arms
/// inside it shrunk by the hysteresis.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct OperatingRangeTable {
    /// Longitudinal speed; default [5, 30].
    pub v_x_m_per_s: [f64; 2],
    /// Lateral speed, true and estimated; default [-1.5, 1.5].
    pub v_y_m_per_s: [f64; 2],
    /// Yaw rate; default [-0.55, 0.55].
    pub r_rad_per_s: [f64; 2],
    /// Arming hysteresis of v_x; default 0.5.
    pub v_x_hysteresis_m_per_s: f64,
    /// Arming hysteresis of the estimated v_y; default 0.25.
    pub v_y_hysteresis_m_per_s: f64,
    /// Arming hysteresis of r; default 0.05.
    pub r_hysteresis_rad_per_s: f64,
}

impl Default for OperatingRangeTable {
    fn default() -> Self {
        Self {
            v_x_m_per_s: [5.0, 30.0],
            v_y_m_per_s: [-1.5, 1.5],
            r_rad_per_s: [-0.55, 0.55],
            v_x_hysteresis_m_per_s: 0.5,
            v_y_hysteresis_m_per_s: 0.25,
            r_hysteresis_rad_per_s: 0.05,
        }
    }
}

impl OperatingRangeTable {
    /// S_x.
    pub fn range(&self) -> OperatingRange {
        let interval = |[min, max]: [f64; 2]| Interval::new(min, max);
        OperatingRange {
            v_x: interval(self.v_x_m_per_s),
            v_y: interval(self.v_y_m_per_s),
            r: interval(self.r_rad_per_s),
        }
    }

    /// Arming hysteresis of [v_x, v_y, r].
    pub fn hysteresis(&self) -> [f64; 3] {
        [self.v_x_hysteresis_m_per_s, self.v_y_hysteresis_m_per_s, self.r_hysteresis_rad_per_s]
    }
}

/// `[sampling]`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Sampling {
    /// T_s; default 0.01.
    pub period_s: f64,
    /// Whether the detector takes out of the residual what Euler's steps leave out; default true.
    pub euler_correction: bool,
}

impl Default for Sampling {
    fn default() -> Self {
        Self { period_s: 0.01, euler_correction: true }
    }
}

/// `[actuator]`: what lies between the steering angle that the detector is told and the road wheel. The
/// default is nothing: the angle is a measured one, or the actuator is too fast to matter.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ActuatorTable {
    /// Time constant of a first-order lag; default 0.
    pub lag_s: f64,
    /// Dead time; default 0.
    pub delay_s: f64,
    /// Fastest turn of the road wheel; default none.
    pub rate_limit_rad_per_s: Option<f64>,
}

impl ActuatorTable {
    /// Slowest lag, s.
    pub const LARGEST_LAG_S: f64 = 5.0;
    /// Longest dead time, s; the detector's memory may be shorter.
    pub const LARGEST_DELAY_S: f64 = 0.5;
    /// Slowest and fastest rate limit, rad/s.
    pub const RATE_LIMITS_RAD_PER_S: [f64; 2] = [1e-3, 100.0];

    /// The detector's actuator.
    pub fn actuator(self) -> Actuator {
        let Self { lag_s, delay_s, rate_limit_rad_per_s } = self;
        Actuator { lag_s, delay_s, rate_limit_rad_per_s }
    }

    /// Checks every value, for a dead time of at most `largest_delay_s`.
    ///
    /// # Errors
    /// [`SpecError`], for the first value that is not possible.
    pub fn check(&self, largest_delay_s: f64) -> Result<(), SpecError> {
        Allowed::between(0.0, Self::LARGEST_LAG_S).check("actuator.lag_s", self.lag_s)?;
        Allowed::between(0.0, largest_delay_s).check("actuator.delay_s", self.delay_s)?;
        let [slowest, fastest] = Self::RATE_LIMITS_RAD_PER_S;
        self.rate_limit_rad_per_s.map_or(Ok(()), |limit| {
            Allowed::between(slowest, fastest).check("actuator.rate_limit_rad_per_s", limit)
        })
    }
}

/// `[design]`: how the gains are found.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Method {
    /// Which method; default "gap".
    pub method: MethodName,
    /// Disturbance attenuation to hold: residual per unit of the first disturbance, the others
    /// counted in proportion to their bounds; default 0.8.
    pub gamma: f64,
    /// Multiplier of (31); default 2.
    pub alpha_d: f64,
    /// Multiplier of (32); default 1.
    pub alpha_f: f64,
    /// Multiplier of (32): "F'" or three numbers in the unit of F'; default "F'".
    #[serde(rename = "V")]
    pub v: MultiplierV,
    /// Slowest decay of the error, a sample, for (33); default 0.97.
    pub decay: f64,
    /// beta of the synthesis as a fraction of the largest; default 0.97.
    pub beta_fraction: f64,
    /// Method "gap": number of syntheses; default 16.
    pub search_budget: usize,
}

impl Default for Method {
    fn default() -> Self {
        Self {
            method: MethodName::Gap,
            gamma: 0.8,
            alpha_d: 2.0,
            alpha_f: 1.0,
            v: MultiplierV::Name(VName::FTransposed),
            decay: 0.97,
            beta_fraction: 0.97,
            search_budget: 16,
        }
    }
}

/// The methods there are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum MethodName {
    /// A search for the largest detection ratio: over the multipliers of Theorem 4, then over the
    /// gains themselves.
    Gap,
    /// Theorem 4 with given multipliers: largest beta, then smallest gamma near it.
    Paper,
}

/// The multiplier V.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged, expecting = "expected \"F'\" or three numbers")]
pub enum MultiplierV {
    /// By name.
    Name(VName),
    /// By its numbers, in the unit of F'.
    Given([f64; 3]),
}

/// Named choices of V.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum VName {
    /// The transpose of F.
    #[serde(rename = "F'")]
    FTransposed,
}

/// `[evaluation]`: how the residual is evaluated.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Evaluation {
    /// Window of the RMS; default 40.
    pub window_samples: usize,
    /// Diagonal of W_r for the residuals of v_x (per m/s) and r (per rad/s); default [0.1, 1], the
    /// inverse proportion of their noise.
    pub weights: [f64; 2],
    /// How the threshold is found; default "adaptive".
    pub threshold: ThresholdKind,
    /// Threshold of kind "constant", on J once the start-up has passed; for no other kind.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub constant: Option<f64>,
    /// Threshold over the level: of kinds "calibrated" and "adaptive" the largest of the calibration's
    /// drives; of kind "guaranteed" the proven bound plus the simulated discretisation, so that it
    /// stands for what neither holds, such as other vehicle data; default 1.1.
    pub margin: f64,
    /// Consecutive samples above the threshold that raise the alarm; default 1.
    pub debounce_samples: u32,
    /// The fault-free drives of the calibration.
    pub calibration: Calibration,
}

impl Default for Evaluation {
    fn default() -> Self {
        Self {
            window_samples: 40,
            weights: [0.1, 1.0],
            threshold: ThresholdKind::Adaptive,
            constant: None,
            margin: 1.1,
            debounce_samples: 1,
            calibration: Calibration::default(),
        }
    }
}

/// How the threshold is found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ThresholdKind {
    /// A given number.
    Constant,
    /// Largest level of simulated fault-free drives of the vehicle as specified, times a margin.
    Calibrated,
    /// That level and, sample by sample, the bound on what the uncertainties can do in the manoeuvre
    /// driven; both times the largest ratio of J to their sum over simulated fault-free drives of
    /// uncertain vehicles, times a margin.
    Adaptive,
    /// A proven bound on J for all disturbances and sensor noise within their bounds, plus the
    /// largest level of simulated drives without either, times a margin. White noise has no bound: a
    /// sensor with a white standard deviation must be given a bound too, which then is what counts.
    Guaranteed,
}

/// `[evaluation.calibration]`: every manoeuvre at every speed and lateral acceleration, under every
/// frequency and phase of the disturbances, from every initial lateral speed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Calibration {
    /// Number of initial speeds, evenly spread over the armed range; default 7.
    pub speeds: usize,
    /// Manoeuvres; default all.
    pub manoeuvres: Vec<Manoeuvre>,
    /// Steady-state lateral accelerations that the steering amplitudes correspond to;
    /// default [1, 2, 3].
    pub lateral_acceleration_m_per_s2: Vec<f64>,
    /// Fastest steering, at the road wheel: amplitudes are reduced to it; default 0.3.
    pub steering_rate_rad_per_s: f64,
    /// Number of frequencies, evenly spread over each disturbance's band; default 3.
    pub disturbance_frequencies: usize,
    /// Number of phases, evenly spread over a period; default 4.
    pub disturbance_phases: usize,
    /// Initial lateral speeds; default [-1, 0, 1].
    pub initial_v_y_m_per_s: Vec<f64>,
    /// Length of a drive; default 8.
    pub duration_s: f64,
}

impl Default for Calibration {
    fn default() -> Self {
        use Manoeuvre::{LaneChange, Sine, StepSteer, Straight, Weave};
        Self {
            speeds: 7,
            manoeuvres: vec![Straight, Sine, Weave, StepSteer, LaneChange],
            lateral_acceleration_m_per_s2: vec![1.0, 2.0, 3.0],
            steering_rate_rad_per_s: 0.3,
            disturbance_frequencies: 3,
            disturbance_phases: 4,
            initial_v_y_m_per_s: vec![-1.0, 0.0, 1.0],
            duration_s: 8.0,
        }
    }
}

/// A course of the road-wheel angle.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Manoeuvre {
    /// No steering.
    Straight,
    /// Sine of 0.5 rad/s: the paper's.
    Sine,
    /// Sine of 0.2 Hz: the weave of ISO 13674.
    Weave,
    /// From 1 s on at the steering rate to the full angle, then held: the step of ISO 7401.
    StepSteer,
    /// One period of a 0.5 Hz sine from 1 s on.
    LaneChange,
}

impl Default for Spec {
    /// The paper's vehicle and disturbance, sensors with noise, and method "gap".
    fn default() -> Self {
        Self {
            vehicle: Vehicle::PAPER,
            operating_range: OperatingRangeTable::default(),
            sampling: Sampling::default(),
            actuator: ActuatorTable::default(),
            fault: vec![Fault::Steering {
                smallest_deg: channel::half_a_degree(),
                band_hz: channel::low_band(),
            }],
            disturbance: vec![Disturbance::SideWind {
                name: "side wind".into(),
                acting_ahead_m: channel::quarter_of_a_metre(),
                bound_m_per_s2: 0.1,
                band_hz: channel::low_band(),
            }],
            noise: Noise::default(),
            uncertainty: UncertaintyTable::default(),
            design: Method::default(),
            evaluation: Evaluation::default(),
        }
    }
}

impl Spec {
    /// The paper's own case: Theorem 4 with its multipliers, no sensor noise, W_r = I, Euler's steps as
    /// they are, everything known.
    pub fn paper() -> Self {
        Self {
            noise: Noise {
                v_x: SpeedNoise { white_std_m_per_s: 0.0, ..SpeedNoise::default() },
                r: YawRateNoise { white_std_rad_per_s: 0.0, ..YawRateNoise::default() },
            },
            sampling: Sampling { euler_correction: false, ..Sampling::default() },
            uncertainty: UncertaintyTable::NONE,
            design: Method { method: MethodName::Paper, ..Method::default() },
            evaluation: Evaluation {
                weights: [1.0, 1.0],
                threshold: ThresholdKind::Calibrated,
                margin: 1.25,
                ..Evaluation::default()
            },
            ..Self::default()
        }
    }

    /// Reads and checks a specification in TOML.
    ///
    /// # Errors
    /// [`SpecError`], which names the key, its value and what is allowed.
    pub fn from_toml(text: &str) -> Result<Self, SpecError> {
        let spec: Self = parse(text)?;
        spec.check()?;
        Ok(spec)
    }

    /// Checks every value.
    ///
    /// # Errors
    /// [`SpecError`], for the first value that is not possible.
    pub fn check(&self) -> Result<(), SpecError> {
        self.check_vehicle_and_range()?;
        self.check_sampling()?;
        self.check_channels()?;
        self.uncertainty.check(self.largest_delay_s() - self.actuator.delay_s)?;
        self.check_design()?;
        self.check_evaluation()
    }

    fn check_vehicle_and_range(&self) -> Result<(), SpecError> {
        let v = &self.vehicle;
        for (key, value, allowed) in [
            ("mass_kg", v.mass_kg, Allowed::POSITIVE),
            ("yaw_inertia_kg_m2", v.yaw_inertia_kg_m2, Allowed::POSITIVE),
            (
                "effective_longitudinal_inertia_kg_m",
                v.effective_longitudinal_inertia_kg_m,
                Allowed::POSITIVE,
            ),
            ("front_axle_distance_m", v.front_axle_distance_m, Allowed::POSITIVE),
            ("rear_axle_distance_m", v.rear_axle_distance_m, Allowed::POSITIVE),
            (
                "front_cornering_stiffness_n_per_rad",
                v.front_cornering_stiffness_n_per_rad,
                Allowed::POSITIVE,
            ),
            (
                "rear_cornering_stiffness_n_per_rad",
                v.rear_cornering_stiffness_n_per_rad,
                Allowed::POSITIVE,
            ),
            (
                "longitudinal_drag_n_m_s2_per_m2",
                v.longitudinal_drag_n_m_s2_per_m2,
                Allowed::NOT_NEGATIVE,
            ),
            ("lateral_drag_n_s2_per_m2", v.lateral_drag_n_s2_per_m2, Allowed::NOT_NEGATIVE),
        ] {
            allowed.check(&format!("vehicle.{key}"), value)?;
        }

        let range = &self.operating_range;
        for (name, unit, interval, hysteresis) in [
            ("v_x", "m_per_s", range.v_x_m_per_s, range.v_x_hysteresis_m_per_s),
            ("v_y", "m_per_s", range.v_y_m_per_s, range.v_y_hysteresis_m_per_s),
            ("r", "rad_per_s", range.r_rad_per_s, range.r_hysteresis_rad_per_s),
        ] {
            let key = format!("operating_range.{name}_{unit}");
            let [min, max] = interval;
            let finite = min.is_finite() && max.is_finite();
            SpecError::unless(
                finite && min < max,
                &key,
                interval,
                "two finite numbers, min < max",
            )?;
            if name == "v_x" {
                SpecError::unless(min > 0.0, &key, interval, "min > 0: the model holds 1/v_x")?;
            } else {
                SpecError::unless(min < 0.0 && max > 0.0, &key, interval, "min < 0 < max")?;
            }
            let key = format!("operating_range.{name}_hysteresis_{unit}");
            let half = (max - min) / 2.0;
            SpecError::unless(
                (0.0..half).contains(&hysteresis),
                &key,
                hysteresis,
                &format!("from 0 to below half the range's width, {half}"),
            )?;
        }
        Ok(())
    }

    fn check_sampling(&self) -> Result<(), SpecError> {
        let t = self.sampling.period_s;
        Allowed::between(1e-4, 0.1).check("sampling.period_s", t)?;
        // The Euler step must follow the lateral and yaw dynamics, fastest at the lowest speed.
        let v = &self.vehicle;
        let (c_f, c_r) =
            (v.front_cornering_stiffness_n_per_rad, v.rear_cornering_stiffness_n_per_rad);
        let (l_f, l_r) = (v.front_axle_distance_m, v.rear_axle_distance_m);
        let lateral = 2.0 * (c_f + c_r) / v.mass_kg;
        let yaw = 2.0 * (c_f * l_f * l_f + c_r * l_r * l_r) / v.yaw_inertia_kg_m2;
        let lowest_speed = t * lateral.max(yaw);
        SpecError::unless(
            self.operating_range.v_x_m_per_s[0] > lowest_speed,
            "operating_range.v_x_m_per_s",
            self.operating_range.v_x_m_per_s,
            &format!(
                "min above {lowest_speed:.3} m/s: below it the lateral dynamics outrun \
                 sampling.period_s = {t}"
            ),
        )?;
        self.actuator.check(self.largest_delay_s())
    }

    /// Longest dead time of the actuator, s.
    fn largest_delay_s(&self) -> f64 {
        let memory_s = MAX_DELAY_SAMPLES as f64 * self.sampling.period_s;
        memory_s.min(ActuatorTable::LARGEST_DELAY_S)
    }

    fn check_channels(&self) -> Result<(), SpecError> {
        let count = self.fault.len();
        SpecError::unless((1..=8).contains(&count), "fault", count, "from 1 to 8 of them")?;
        for (index, fault) in self.fault.iter().enumerate() {
            let key = match fault {
                Fault::Steering { smallest_deg, .. } => ("smallest_deg", *smallest_deg),
                Fault::Torque { smallest_n_m, .. } => ("smallest_n_m", *smallest_n_m),
            };
            Allowed::POSITIVE.check(&format!("fault[{index}].{}", key.0), key.1)?;
            self.band(&format!("fault[{index}]"), fault.band_hz())?;
        }

        let count = self.disturbance.len();
        SpecError::unless((1..=8).contains(&count), "disturbance", count, "from 1 to 8 of them")?;
        for (index, disturbance) in self.disturbance.iter().enumerate() {
            let key = format!("disturbance[{index}]");
            let (bound_key, bound) = match disturbance {
                Disturbance::SideWind { bound_m_per_s2, acting_ahead_m, .. } => {
                    Allowed::FINITE.check(&format!("{key}.acting_ahead_m"), *acting_ahead_m)?;
                    ("bound_m_per_s2", *bound_m_per_s2)
                }
                Disturbance::Bank { bound_deg, .. } => ("bound_deg", *bound_deg),
                Disturbance::YawMoment { bound_n_m, .. } => ("bound_n_m", *bound_n_m),
                Disturbance::Direction { bound, direction, .. } => {
                    let proper = direction.iter().all(|x| x.is_finite())
                        && direction.iter().any(|&x| x != 0.0);
                    let allowed = "finite numbers, not all zero";
                    SpecError::unless(proper, &format!("{key}.direction"), direction, allowed)?;
                    ("bound", *bound)
                }
            };
            Allowed::POSITIVE.check(&format!("{key}.{bound_key}"), bound)?;
            self.band(&key, disturbance.band_hz())?;
        }
        self.check_noise()
    }

    fn check_noise(&self) -> Result<(), SpecError> {
        let noise = &self.noise;
        for (((signal, unit), white_std), (bound, band_hz)) in
            [("v_x", "m_per_s"), ("r", "rad_per_s")]
                .into_iter()
                .zip(noise.white_std())
                .zip(noise.bounds().into_iter().zip(noise.bands_hz()))
        {
            let key = format!("noise.{signal}");
            Allowed::NOT_NEGATIVE.check(&format!("{key}.white_std_{unit}"), white_std)?;
            let bound_key = format!("{key}.bound_{unit}");
            if let Some(bound) = bound {
                Allowed::POSITIVE.check(&bound_key, bound)?;
            }
            if self.evaluation.threshold == ThresholdKind::Guaranteed {
                SpecError::unless(
                    bound.is_some() || white_std == 0.0,
                    &bound_key,
                    format_args!("not given"),
                    &format!(
                        "a number > 0, as evaluation.threshold = \"guaranteed\" covers noise up to a \
                         bound and white noise has none: 4 standard deviations, {}, are rarely \
                         exceeded; or set {key}.white_std_{unit} = 0",
                        4.0 * white_std
                    ),
                )?;
            }
            if let Some(band_hz) = band_hz {
                self.band(&key, band_hz)?;
                SpecError::unless(
                    bound.is_some(),
                    &format!("{key}.band_hz"),
                    band_hz,
                    "with a bound only: white noise has all frequencies",
                )?;
            }
        }
        Ok(())
    }

    fn check_design(&self) -> Result<(), SpecError> {
        let design = &self.design;
        Allowed::POSITIVE.check("design.gamma", design.gamma)?;
        Allowed::FINITE.check("design.alpha_d", design.alpha_d)?;
        Allowed::FINITE.check("design.alpha_f", design.alpha_f)?;
        if let MultiplierV::Given(v) = design.v {
            // The bound on beta is ||C V'|| / |alpha_f + exp(jw)|.
            let proper = v.iter().all(|x| x.is_finite()) && (v[0] != 0.0 || v[2] != 0.0);
            let allowed =
                "finite numbers, the first or third not zero: beta cannot exceed ||C V'||";
            SpecError::unless(proper, "design.V", v, allowed)?;
        }
        Allowed::inside(0.0, 1.0).check("design.decay", design.decay)?;
        Allowed::inside(0.0, 1.0).check("design.beta_fraction", design.beta_fraction)?;
        let budget = design.search_budget;
        SpecError::unless(
            (1..=10_000).contains(&budget),
            "design.search_budget",
            budget,
            "from 1 to 10000 syntheses",
        )
    }

    fn check_evaluation(&self) -> Result<(), SpecError> {
        let e = &self.evaluation;
        SpecError::unless(
            (1..=MAX_WINDOW).contains(&e.window_samples),
            "evaluation.window_samples",
            e.window_samples,
            &format!("from 1 to {MAX_WINDOW}"),
        )?;
        SpecError::unless(
            e.weights.iter().all(|&w| w >= 0.0 && w.is_finite()) && e.weights != [0.0, 0.0],
            "evaluation.weights",
            e.weights,
            "finite, not negative and not both zero",
        )?;
        Allowed::between(1.0, 100.0).check("evaluation.margin", e.margin)?;
        match (e.threshold, e.constant) {
            (ThresholdKind::Constant, Some(constant)) => {
                Allowed::POSITIVE.check("evaluation.constant", constant)?;
            }
            (ThresholdKind::Constant, None) => {
                let allowed = "with `evaluation.constant`, the threshold on J";
                SpecError::unless(false, "evaluation.threshold", "constant", allowed)?;
            }
            (_, constant) => SpecError::unless(
                constant.is_none(),
                "evaluation.constant",
                constant.unwrap_or_default(),
                "with threshold = \"constant\" only",
            )?,
        }
        let at_least_one = "1 or more";
        SpecError::unless(
            e.debounce_samples >= 1,
            "evaluation.debounce_samples",
            e.debounce_samples,
            at_least_one,
        )?;

        let c = &e.calibration;
        for (key, count) in [
            ("speeds", c.speeds),
            ("disturbance_frequencies", c.disturbance_frequencies),
            ("disturbance_phases", c.disturbance_phases),
            ("manoeuvres", c.manoeuvres.len()),
            ("lateral_acceleration_m_per_s2", c.lateral_acceleration_m_per_s2.len()),
            ("initial_v_y_m_per_s", c.initial_v_y_m_per_s.len()),
        ] {
            let key = format!("evaluation.calibration.{key}");
            SpecError::unless((1..=100).contains(&count), &key, count, "from 1 to 100 of them")?;
        }
        for &a_y in &c.lateral_acceleration_m_per_s2 {
            let key = "evaluation.calibration.lateral_acceleration_m_per_s2";
            Allowed::POSITIVE.check(key, a_y)?;
        }
        let drives = calibration::count(self);
        let most = 100_000;
        SpecError::unless(
            drives <= most,
            "evaluation.calibration",
            format_args!("{drives} drives"),
            &format!("at most {most} drives in all"),
        )?;
        let [min, max] = self.operating_range.v_y_m_per_s;
        for &v_y in &c.initial_v_y_m_per_s {
            Allowed::between(min, max).check("evaluation.calibration.initial_v_y_m_per_s", v_y)?;
        }
        Allowed::POSITIVE
            .check("evaluation.calibration.steering_rate_rad_per_s", c.steering_rate_rad_per_s)?;
        Allowed::between(2.0, 3600.0).check("evaluation.calibration.duration_s", c.duration_s)
    }

    /// The band's kind.
    fn band(&self, channel: &str, band_hz: [f64; 2]) -> Result<Band, SpecError> {
        let nyquist = 0.5 / self.sampling.period_s;
        let [from, to] = band_hz;
        let key = format!("{channel}.band_hz");
        SpecError::unless(
            0.0 <= from && from < to && to <= nyquist,
            &key,
            band_hz,
            &format!("0 <= from < to <= {nyquist} Hz, the Nyquist frequency"),
        )?;
        let theta = |hz: f64| 2.0 * PI * hz * self.sampling.period_s;
        match (from == 0.0, to == nyquist) {
            (true, true) => Ok(Band::Full),
            (true, false) => Ok(Band::Low(theta(to))),
            (false, true) => Ok(Band::High(theta(from))),
            (false, false) => Err(SpecError::Value {
                key,
                value: format!("{band_hz:?}"),
                allowed: format!("from 0, or up to {nyquist} Hz: middle bands are not supported"),
            }),
        }
    }

    /// The N-TS model.
    pub fn model(&self) -> TsModel {
        TsModel {
            vehicle: self.vehicle,
            sampling_period_s: self.sampling.period_s,
            range: self.operating_range.range(),
        }
    }

    /// What the detector is told of deviations from the model.
    pub fn deviations(&self) -> Deviations {
        let column = self.fault[0].column();
        Deviations {
            euler_correction: self.sampling.euler_correction,
            uncertainty: self.uncertainty.bounds(),
            smallest_fault: self.model().b().map(|row| row[column] * self.fault[0].smallest()),
        }
    }

    /// D, 3 x n_d: a column of each disturbance, per unit.
    pub fn d(&self) -> Matrix {
        let t = self.sampling.period_s;
        Matrix::from_fn(3, self.disturbance.len(), |row, column| {
            t * self.disturbance[column].direction(&self.vehicle)[row]
        })
    }

    /// F, 3 x n_f: a column of each fault, per rad or N m.
    pub fn f(&self) -> Matrix {
        let b = self.model().b();
        Matrix::from_fn(3, self.fault.len(), |row, column| b[row][self.fault[column].column()])
    }

    /// D_y, 2 x n_y: a column of each bounded sensor noise, per m/s or rad/s, in the order v_x, r.
    pub fn d_y(&self) -> Matrix {
        let signals: Vec<usize> = self.bounded_noise().map(|(signal, ..)| signal).collect();
        Matrix::from_fn(2, signals.len(), |row, column| f64::from(row == signals[column]))
    }

    /// Place in y, bound and band of each bounded sensor noise.
    fn bounded_noise(&self) -> impl Iterator<Item = (usize, f64, [f64; 2])> {
        let nyquist = 0.5 / self.sampling.period_s;
        let signals = self.noise.bounds().into_iter().zip(self.noise.bands_hz()).enumerate();
        signals.filter_map(move |(signal, (bound, band_hz))| {
            Some((signal, bound?, band_hz.unwrap_or([0.0, nyquist])))
        })
    }

    /// Every disturbance, then every bounded noise, by itself and in units of its bound.
    pub fn bounded_inputs(&self) -> Vec<BoundedInput> {
        let d = self.d();
        let disturbances = self.disturbance.iter().enumerate().map(|(index, disturbance)| {
            let column = d.columns(index, 1) * disturbance.bound();
            BoundedInput {
                name: disturbance.name().into(),
                bound: disturbance.bound(),
                unit: disturbance.unit(),
                channel: Channel::disturbance(column, Band::Full),
            }
        });
        let noise = self.bounded_noise().map(|(signal, bound, _)| {
            let mut channel = Channel::disturbance(Matrix::zeros(3, 0), Band::Full);
            channel.push_noise(&Matrix::from_fn(2, 1, |row, _| f64::from(row == signal) * bound));
            let [name, unit] = [["noise of v_x", "m/s"], ["noise of r", "rad/s"]][signal];
            BoundedInput { name: name.into(), bound, unit, channel }
        });
        disturbances.chain(noise).collect()
    }

    /// Disturbances and bounded noise as inputs of the error, one block for each band, in units of
    /// the first disturbance: each column in proportion to its bound, so that the norm of the
    /// stacked vector weighs every channel by its bound.
    ///
    /// # Errors
    /// [`SpecError`] for a band that is not possible.
    pub fn disturbance_channels(&self) -> Result<Vec<Channel>, SpecError> {
        let unit = self.disturbance[0].bound();
        let d = self.d();
        let mut channels: Vec<Channel> = Vec::new();
        for (index, disturbance) in self.disturbance.iter().enumerate() {
            let band = self.band(&format!("disturbance[{index}]"), disturbance.band_hz())?;
            let column = d.columns(index, 1) * (disturbance.bound() / unit);
            Channel::of_band(&mut channels, band).push_direction(&column);
        }
        for (signal, bound, band_hz) in self.bounded_noise() {
            let band = self.band(["noise.v_x", "noise.r"][signal], band_hz)?;
            let column = Matrix::from_fn(2, 1, |row, _| f64::from(row == signal) * bound / unit);
            Channel::of_band(&mut channels, band).push_noise(&column);
        }
        Ok(channels)
    }

    /// The faults of interest as inputs of the error, in rad or N m; the first is designed for.
    ///
    /// # Errors
    /// [`SpecError`] for a band that is not possible.
    pub fn fault_channels(&self) -> Result<Vec<Channel>, SpecError> {
        let f = self.f();
        let faults = self.fault.iter().enumerate();
        faults
            .map(|(index, fault)| {
                let band = self.band(&format!("fault[{index}]"), fault.band_hz())?;
                Ok(Channel::disturbance(f.columns(index, 1).into_owned(), band))
            })
            .collect()
    }

    /// What is asked of the residual, for the fault that is designed for.
    ///
    /// # Errors
    /// [`SpecError`] for a band that is not possible.
    pub fn inputs(&self) -> Result<Inputs, SpecError> {
        Ok(Inputs {
            fault: self.fault_channels()?.swap_remove(0),
            disturbances: self.disturbance_channels()?,
            white_std: self.noise.white_std(),
            smallest_fault: self.fault[0].smallest(),
            bound: self.disturbance[0].bound(),
            weights: self.evaluation.weights,
        })
    }

    /// Theorem 4 with the given multipliers.
    pub fn theorem(&self, inputs: &Inputs) -> Theorem4 {
        Theorem4::new(
            &self.model(),
            &inputs.disturbances,
            &inputs.fault,
            inputs.weights,
            &self.multipliers(),
            self.design.decay,
        )
    }

    /// The multipliers of Theorem 4.
    pub fn multipliers(&self) -> Multipliers {
        Multipliers {
            alpha_d: self.design.alpha_d,
            alpha_f: self.design.alpha_f,
            v: match self.design.v {
                MultiplierV::Name(VName::FTransposed) => self.f().columns(0, 1).transpose(),
                MultiplierV::Given(v) => Matrix::from_row_slice(1, 3, &v),
            },
        }
    }
}
