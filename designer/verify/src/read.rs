//! The design file as far as it is checked.
//!
//! Keys, shapes and units are documented where the file is written, at `Design` of the designer, and
//! in docs/formats.md.

use serde::Deserialize;
use serde_json::Value;

use crate::exact::{Matrix, exact};
use crate::identity::{FORMAT, content_hash};
use crate::refusal::Refusal;

/// Rules, and successors of each.
pub const RULES: usize = 4;

/// Rows of a 3 x 3 matrix.
pub type Rows3 = [[f64; 3]; 3];
/// Rows of a matrix that has as many as there are inputs.
type Rows<const K: usize> = Vec<[f64; K]>;

/// `design.json`.
#[derive(Deserialize)]
pub struct Design {
    pub constants: Constants,
    pub spec: Spec,
    pub detector: Detector,
    pub vertices: [Rule; RULES],
    #[serde(rename = "B")]
    pub b: [[f64; 2]; 3],
    #[serde(rename = "G")]
    pub g: [[f64; 1]; 3],
    #[serde(rename = "C")]
    pub c: [[f64; 3]; 2],
    /// A column of each disturbance.
    #[serde(rename = "D")]
    pub d: [Vec<f64>; 3],
    /// A column of each bounded sensor noise, in the order v_x, r.
    #[serde(rename = "D_y")]
    pub d_y: Option<[Vec<f64>; 2]>,
    /// A column of each fault.
    #[serde(rename = "F")]
    pub f: [Vec<f64>; 3],
    pub threshold: Threshold,
    pub synthesis: Synthesis,
    pub performance: Performance,
    pub certificate: Certificate,
}

#[derive(Deserialize)]
pub struct Constants {
    pub gravity_m_per_s2: f64,
    pub air_density_kg_per_m3: f64,
}

#[derive(Deserialize)]
pub struct Spec {
    pub vehicle: Vehicle,
    pub operating_range: OperatingRange,
    pub sampling: Sampling,
    pub sensors: Sensors,
    pub actuator: ActuatorOfSpec,
    pub fault: Vec<Fault>,
    pub disturbance: Vec<Disturbance>,
    pub noise: Noise,
    pub uncertainty: UncertaintyOfSpec,
    pub design: Method,
    pub evaluation: EvaluationOfSpec,
    pub estimator: EstimatorOfSpec,
}

#[derive(Deserialize)]
pub struct EstimatorOfSpec {
    pub enabled: bool,
}

#[derive(Deserialize)]
pub struct OperatingRange {
    pub v_x_m_per_s: [f64; 2],
    pub v_y_m_per_s: [f64; 2],
    pub r_rad_per_s: [f64; 2],
    pub v_x_hysteresis_m_per_s: f64,
    pub v_y_hysteresis_m_per_s: f64,
    pub r_hysteresis_rad_per_s: f64,
}

#[derive(Deserialize)]
pub struct Sampling {
    pub period_s: f64,
    pub euler_correction: bool,
}

#[derive(Deserialize)]
pub struct Sensors {
    pub steering_offset_deg: f64,
    pub yaw_rate_bias_deg_per_s: f64,
}

#[derive(Deserialize)]
pub struct ActuatorOfSpec {
    pub lag_s: f64,
    pub delay_s: f64,
    pub rate_limit_rad_per_s: Option<f64>,
    pub angle_limit_deg: Option<f64>,
}

#[derive(Deserialize)]
pub struct UncertaintyOfSpec {
    pub mass_percent: [f64; 2],
    pub yaw_inertia_percent: [f64; 2],
    pub front_cornering_stiffness_percent: [f64; 2],
    pub rear_cornering_stiffness_percent: [f64; 2],
    pub actuator_lag_s: f64,
    pub actuator_delay_s: f64,
    pub steering_ratio_percent: [f64; 2],
    pub steering_offset_deg: f64,
    pub yaw_rate_bias_deg_per_s: f64,
    pub v_x_scale_percent: f64,
    pub friction: [f64; 2],
    pub load_transfer_percent: f64,
    pub bank_deg: f64,
    pub gust_m_per_s: f64,
    pub gust_acting_ahead_m: f64,
    pub frontal_area_m2: f64,
    pub side_force_per_rad: f64,
}

#[derive(Deserialize)]
pub struct Method {
    pub method: String,
    pub decay: Option<f64>,
    pub decay_per_s: Option<f64>,
}

#[derive(Deserialize)]
pub struct EvaluationOfSpec {
    /// One of the two, or neither.
    pub window_s: Option<f64>,
    pub window_samples: Option<f64>,
    pub weights: [f64; 2],
    pub threshold: String,
    /// Of kind "constant".
    pub constant: Option<f64>,
    pub margin: f64,
    pub covers: String,
    pub debounce_samples: f64,
    pub alarm_hold_s: f64,
    pub calibration: Calibration,
}

#[derive(Deserialize)]
pub struct Calibration {
    pub search_drives: f64,
    #[serde(default)]
    pub drives: Vec<String>,
}

#[derive(Debug, PartialEq, Deserialize)]
#[serde(tag = "channel", rename_all = "lowercase")]
pub enum Fault {
    Steering { smallest_deg: f64, largest_deg: f64, band_hz: [f64; 2] },
    Torque { smallest_n_m: f64, band_hz: [f64; 2] },
}

#[derive(Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum Disturbance {
    SideWind { name: String, acting_ahead_m: f64, bound_m_per_s2: f64, band_hz: [f64; 2] },
    Bank { name: String, bound_deg: f64, band_hz: [f64; 2] },
    YawMoment { name: String, bound_n_m: f64, band_hz: [f64; 2] },
    Direction { name: String, direction: [f64; 3], bound: f64, band_hz: [f64; 2] },
}

#[derive(Deserialize)]
pub struct Noise {
    pub v_x: SpeedNoise,
    pub r: YawRateNoise,
}

#[derive(Deserialize)]
pub struct SpeedNoise {
    pub white_std_m_per_s: f64,
    pub bound_m_per_s: Option<f64>,
    /// Null for all frequencies.
    pub band_hz: Option<[f64; 2]>,
}

#[derive(Deserialize)]
pub struct YawRateNoise {
    pub white_std_rad_per_s: f64,
    pub bound_rad_per_s: Option<f64>,
    /// Null for all frequencies.
    pub band_hz: Option<[f64; 2]>,
}

/// Vehicle data.
#[derive(Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Vehicle {
    pub mass_kg: f64,
    pub yaw_inertia_kg_m2: f64,
    pub effective_longitudinal_inertia_kg_m: f64,
    pub front_axle_distance_m: f64,
    pub rear_axle_distance_m: f64,
    pub front_cornering_stiffness_n_per_rad: f64,
    pub rear_cornering_stiffness_n_per_rad: f64,
    pub longitudinal_drag_n_m_s2_per_m2: f64,
    pub lateral_drag_n_s2_per_m2: f64,
    pub centre_of_gravity_height_m: f64,
}

#[derive(Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Actuator {
    pub lag_s: f64,
    pub delay_s: f64,
    pub rate_limit_rad_per_s: Option<f64>,
    pub angle_limit_rad: Option<f64>,
}

/// What is subtracted of what the sensors show.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Zero {
    pub steering_offset_rad: f64,
    pub yaw_rate_bias_rad_per_s: f64,
}

/// When measurements are stale.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Staleness {
    pub after_s: f64,
    pub v_x_jump_m_per_s: f64,
    pub r_jump_rad_per_s: f64,
}

/// Every number that is baked. A key that is not known here is a number that nothing vouches for, so
/// it is refused.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Detector {
    pub model: Model,
    pub hysteresis: [f64; 3],
    pub gains: Gains,
    pub evaluation: Evaluation,
    pub deviations: Deviations,
    pub actuator: Actuator,
    pub zero: Zero,
    pub staleness: Staleness,
    pub estimator: Option<Estimator>,
}

/// The second test.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Estimator {
    pub threshold: f64,
    pub estimate_factor: f64,
    pub noise: [f64; 2],
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Model {
    pub vehicle: Vehicle,
    pub sampling_period_s: f64,
    pub range: Range,
}

/// S_x.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Range {
    pub v_x: Interval,
    pub v_y: Interval,
    pub r: Interval,
}

#[derive(Clone, Copy, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Interval {
    pub min: f64,
    pub max: f64,
}

impl Interval {
    /// Both.
    pub fn ends(self) -> [f64; 2] {
        [self.min, self.max]
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Gains {
    pub n: [Rows3; RULES],
    pub l: [[[f64; 2]; 3]; RULES],
    pub m: Rows3,
    pub e: [[f64; 2]; 3],
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Evaluation {
    pub window: f64,
    pub weights: [f64; 2],
    pub threshold: f64,
    pub uncertainty_share: f64,
    pub start_up_amplitude: f64,
    pub start_up_decay: f64,
    pub debounce_samples: f64,
    pub alarm_hold_s: f64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Deviations {
    pub euler_correction: bool,
    pub uncertainty: Uncertainty,
    pub smallest_fault: [f64; 3],
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Uncertainty {
    pub mass: f64,
    pub yaw_inertia: f64,
    pub front_cornering_stiffness: f64,
    pub rear_cornering_stiffness: f64,
    pub friction: Option<f64>,
    pub load_transfer: f64,
    pub bank_m_per_s2: f64,
    pub gust: Gust,
    pub actuator_lag_s: f64,
    pub actuator_delay_s: f64,
    pub steering_ratio: f64,
    pub steering_offset_rad: f64,
    pub yaw_rate_bias_rad_per_s: f64,
    pub v_x_scale: f64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Gust {
    pub speed_m_per_s: f64,
    pub coefficient_n_s2_per_m2: f64,
    pub acting_ahead_m: f64,
}

#[derive(Deserialize)]
pub struct Rule {
    #[serde(rename = "A")]
    pub a: Rows3,
    #[serde(rename = "N")]
    pub n: Rows3,
    #[serde(rename = "L")]
    pub l: [[f64; 2]; 3],
    #[serde(rename = "H")]
    pub h: [[f64; 2]; 3],
}

/// The threshold by its causes.
#[derive(Deserialize)]
pub struct Threshold {
    pub kind: String,
    pub margin: f64,
    pub start_up: StartUp,
    pub calibration: Option<Level>,
    pub uncertain: Option<Level>,
    #[serde(default)]
    pub recorded: Vec<Recorded>,
    pub searched: Vec<Searched>,
    pub second: Option<SecondLevels>,
    pub guaranteed: Option<Guaranteed>,
}

/// The largest of simulated drives.
#[derive(Deserialize)]
pub struct Level {
    pub level: f64,
    pub drives: f64,
    pub exceeded_at_most: f64,
}

/// What a recorded drive reached.
#[derive(Deserialize)]
pub struct Recorded {
    pub file: String,
    pub sha256: String,
    pub level: f64,
    pub second: Option<f64>,
}

/// The largest that a search found of a family.
#[derive(Deserialize)]
pub struct Searched {
    pub family: String,
    pub level: f64,
    pub drives: f64,
}

/// The largest statistics of the second test.
#[derive(Deserialize)]
pub struct SecondLevels {
    pub calibration: Level,
    pub in_99_of_100: f64,
    pub search: Vec<Searched>,
}

/// The claim of a guaranteed threshold.
#[derive(Deserialize)]
pub struct Guaranteed {
    pub bound: f64,
    pub inputs: Vec<InputBound>,
    /// Simulated, not proven.
    pub discretisation: Level,
}

#[derive(Deserialize)]
pub struct InputBound {
    pub name: String,
    pub bound: f64,
    pub j: f64,
}

#[derive(Deserialize)]
pub struct StartUp {
    #[serde(rename = "P")]
    pub p: [Rows3; RULES],
}

#[derive(Deserialize)]
pub struct Synthesis {
    pub method: String,
    pub alpha_f: f64,
    #[serde(rename = "V")]
    pub v: [[f64; 3]; 1],
    pub gamma: f64,
    pub beta: f64,
    pub beta_bound: f64,
    pub gap: f64,
    pub status: Status,
}

/// What the design may be called.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Status {
    /// Its figures are proven.
    Certified,
    /// The solver says solved; there is no proof.
    Uncertified,
    /// The solver says almost solved; there is no proof.
    AlmostSolved,
    /// Proven or not, its own drives miss the smallest fault of interest.
    Blind,
}

#[derive(Deserialize)]
pub struct Performance {
    /// Null: unbounded.
    pub limit: Option<f64>,
    pub detection_ratio: f64,
    pub noise_rms: f64,
    pub frozen: Frozen,
    pub certified: Option<Certified>,
    pub spectral_radii: [f64; RULES],
    pub smallest_fault_residual: f64,
    pub decay: f64,
    /// Null for torque.
    pub estimate: Option<Estimate>,
    pub operating_points: Vec<Point>,
    pub other_faults: Vec<OtherFault>,
    /// Null where the first fault is one of the drive torque.
    pub sight: Option<Sight>,
}

/// What simulated drives with faults show.
#[derive(Deserialize)]
pub struct Sight {
    pub courses: Vec<CourseSight>,
    pub bank_and_wind_deg: f64,
    /// Null where the design is not blind.
    pub blind: Option<Value>,
}

#[derive(Deserialize)]
pub struct CourseSight {
    pub v_x_m_per_s: f64,
    pub lateral_acceleration_m_per_s2: f64,
    /// The smallest of interest first.
    pub faults: Vec<FaultSight>,
}

#[derive(Deserialize)]
pub struct FaultSight {
    pub fault_deg: f64,
    pub seen: bool,
}

impl Sight {
    /// The courses straight ahead, on which the verdict rests.
    pub fn judged(&self) -> impl Iterator<Item = &CourseSight> {
        self.courses.iter().filter(|course| course.lateral_acceleration_m_per_s2 == 0.0)
    }
}

/// What the first fault does to the estimated lateral speed.
#[derive(Deserialize)]
pub struct Estimate {
    pub peak_m_per_s_per_deg: f64,
    pub cap_m_per_s_per_deg: f64,
    pub leaves_range_from_deg: f64,
}

/// Worst gains at frozen operating points.
#[derive(Deserialize)]
pub struct Frozen {
    pub beta: f64,
    pub beta_at_least: f64,
    pub gamma: f64,
    pub gamma_at_most: Option<f64>,
    pub gap: f64,
}

/// The figures at an operating point.
#[derive(Deserialize)]
pub struct Point {
    pub v_x_m_per_s: f64,
    pub v_y_m_per_s: f64,
    pub r_rad_per_s: f64,
    pub beta: f64,
    pub gamma: f64,
    pub noise_rms: f64,
    pub detection_ratio: f64,
    pub limit: Option<f64>,
}

/// The figures of a fault that the gains were not made for.
#[derive(Deserialize)]
pub struct OtherFault {
    pub fault: Fault,
    pub detection_ratio: f64,
    pub frozen: Frozen,
}

/// The figures that the certificate proves.
#[derive(Deserialize)]
pub struct Certified {
    pub beta: f64,
    pub gamma: f64,
    pub gap: f64,
    pub gamma_full_band: f64,
    pub decay: f64,
}

#[derive(Deserialize)]
pub struct Certificate {
    #[serde(rename = "P_s")]
    pub p_s: [Rows3; RULES],
    pub a_posteriori: Option<APosteriori>,
    /// For each of `threshold.guaranteed.inputs`.
    pub peaks: Option<Vec<PeakCertificate>>,
}

#[derive(Deserialize)]
pub struct PeakCertificate {
    pub lambda: f64,
    pub gain: f64,
    pub energy: f64,
    #[serde(rename = "P")]
    pub p: [Rows3; RULES],
    #[serde(rename = "V")]
    pub v: [Rows3; RULES],
}

#[derive(Deserialize)]
pub struct APosteriori {
    pub beta: GainCertificate,
    /// For each band of the disturbances, see [`crate::channel::Channels`].
    pub gamma: Vec<GainCertificate>,
    pub gamma_full_band: GainCertificate,
}

#[derive(Deserialize)]
pub struct GainCertificate {
    /// In the unit of the figure.
    pub gain: f64,
    /// Null for the full band.
    pub band: Option<BandCertificate>,
    #[serde(rename = "P")]
    pub p: [Rows3; RULES],
    /// X_jk by j and k.
    #[serde(rename = "X")]
    pub x: [[Rows<3>; RULES]; RULES],
}

#[derive(Deserialize)]
pub struct BandCertificate {
    pub two_cos_theta: f64,
    #[serde(rename = "Q")]
    pub q: Rows3,
}

impl Design {
    /// Reads `text`, refusing another format and another hash than its content's.
    pub fn read(text: &str) -> Result<(Self, String), Refusal> {
        let (content, hash) = content(text)?;
        let design: Self = serde_path_to_error::deserialize(content)?;
        for (key, empty) in [
            ("spec.fault", design.spec.fault.is_empty()),
            ("spec.disturbance", design.spec.disturbance.is_empty()),
        ] {
            if empty {
                return Err(Refusal::Shape { key, expected: "one at least" });
            }
        }
        Ok((design, hash))
    }

    /// D, 3 x n_d.
    pub fn d(&self) -> Result<Matrix, Refusal> {
        columns(&self.d, self.spec.disturbance.len())
            .ok_or(Refusal::Shape { key: "D", expected: "a column of each disturbance" })
    }

    /// F, 3 x n_f.
    pub fn f(&self) -> Result<Matrix, Refusal> {
        columns(&self.f, self.spec.fault.len())
            .ok_or(Refusal::Shape { key: "F", expected: "a column of each fault" })
    }
}

/// The JSON of a design of any version, and its format. Zero has no sign in it, as in its hash.
///
/// # Errors
/// [`Refusal`] for what is no design.
pub fn parse(text: &str) -> Result<(Value, String), Refusal> {
    if text.trim().is_empty() {
        return Err(Refusal::Empty);
    }
    let mut content: Value = serde_json::from_str(text).map_err(|error| match error.is_eof() {
        true => Refusal::Truncated(error),
        false => Refusal::Unreadable(error),
    })?;
    let format = content["format"].as_str().ok_or(Refusal::NoFormat)?.to_owned();
    drop_signs_of_zero(&mut content);
    Ok((content, format))
}

/// The JSON of a design of this version, and its hash, which is right.
///
/// # Errors
/// [`Refusal`] for what is no design, another format, and another hash than the content's.
pub fn content(text: &str) -> Result<(Value, String), Refusal> {
    let (content, found) = parse(text)?;
    if found != FORMAT {
        return Err(Refusal::Format { found });
    }
    let hash = content_hash(&content)?;
    let stored = content["hash"].as_str().unwrap_or_default();
    if stored != hash {
        return Err(Refusal::Hash { stored: stored.into(), computed: hash });
    }
    Ok((content, hash))
}

fn drop_signs_of_zero(value: &mut Value) {
    match value {
        Value::Number(number) if number.is_f64() && number.as_f64() == Some(0.0) => {
            *value = 0.0.into();
        }
        Value::Array(elements) => elements.iter_mut().for_each(drop_signs_of_zero),
        Value::Object(keys) => keys.values_mut().for_each(drop_signs_of_zero),
        _ => {}
    }
}

/// The exact values of `rows` where each has `count` elements, one at least.
pub fn columns(rows: &[Vec<f64>], count: usize) -> Option<Matrix> {
    let fits = count > 0 && rows.iter().all(|row| row.len() == count);
    fits.then(|| Matrix::new(rows.len(), count, |row, column| exact(rows[row][column])))
}
