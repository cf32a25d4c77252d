//! The design file as far as its proof needs it, and its hash.
//!
//! Keys, shapes and units are documented where the file is written, at `Design` of the designer.

use serde::Deserialize;
use serde_json::Value;
use sha2::{Digest, Sha256};

use crate::Refusal;
use crate::exact::{Matrix, exact};

/// Value of the key `format`.
pub const FORMAT: &str = "steerguard-design/1";
/// Below it every whole number is an f64.
const LARGEST_INTEGERS_OF_F64: f64 = 9_007_199_254_740_992.0;
/// Rules, and successors of each.
pub const RULES: usize = 4;

/// Rows of a 3 x 3 matrix.
pub type Rows3 = [[f64; 3]; 3];
/// Rows of a matrix that has as many as there are inputs.
type Rows<const K: usize> = Vec<[f64; K]>;

/// `design.json`.
#[derive(Deserialize)]
pub struct Design {
    pub spec: Spec,
    pub vehicle: Vehicle,
    pub sampling_period_s: f64,
    pub premise: Premise,
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
    #[serde(rename = "E")]
    pub e: [[f64; 2]; 3],
    #[serde(rename = "M")]
    pub m: Rows3,
    pub evaluation: Evaluation,
    pub performance: Performance,
    pub certificate: Certificate,
}

#[derive(Deserialize)]
pub struct Spec {
    pub fault: Vec<Fault>,
    pub disturbance: Vec<Disturbance>,
    pub noise: Noise,
    pub evaluation: EvaluationOfSpec,
}

#[derive(Deserialize)]
pub struct EvaluationOfSpec {
    pub window_samples: f64,
    pub threshold: String,
}

#[derive(Deserialize)]
#[serde(tag = "channel", rename_all = "lowercase")]
pub enum Fault {
    Steering { smallest_deg: f64, band_hz: [f64; 2] },
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

#[derive(Deserialize)]
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
}

#[derive(Deserialize)]
pub struct Premise {
    pub v_x_m_per_s: [f64; 2],
    pub v_y_m_per_s: [f64; 2],
    pub r_rad_per_s: [f64; 2],
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

#[derive(Deserialize)]
pub struct Evaluation {
    pub kind: String,
    pub window: f64,
    pub weights: [f64; 2],
    pub threshold: f64,
    pub start_up: StartUp,
    pub guaranteed: Option<Guaranteed>,
}

/// The claim of a guaranteed threshold.
#[derive(Deserialize)]
pub struct Guaranteed {
    pub bound: f64,
    pub inputs: Vec<InputBound>,
    pub discretisation: Discretisation,
}

#[derive(Deserialize)]
pub struct InputBound {
    pub name: String,
    pub bound: f64,
    pub j: f64,
}

/// What is simulated, not proven.
#[derive(Deserialize)]
pub struct Discretisation {
    pub level: f64,
}

#[derive(Deserialize)]
pub struct StartUp {
    pub amplitude: f64,
    pub decay: f64,
    #[serde(rename = "P")]
    pub p: [Rows3; RULES],
}

#[derive(Deserialize)]
pub struct Performance {
    pub certified: Option<Certified>,
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
    /// For each of `evaluation.guaranteed.inputs`.
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
    /// Reads `text`, refusing another format, another hash than its content's, and places that
    /// contradict each other.
    pub fn read(text: &str) -> Result<(Self, String), Refusal> {
        // Everything is read from the one value that the hash is taken of.
        let content: Value = serde_json::from_str(text)?;
        let found = content["format"].as_str().unwrap_or_default();
        if found != FORMAT {
            return Err(Refusal::Format { found: found.into() });
        }
        let hash = content_hash(&content);
        let stored = content["hash"].as_str().unwrap_or_default();
        if stored != hash {
            return Err(Refusal::Hash { stored: stored.into(), computed: hash });
        }
        let spec = &content["spec"];
        for (key, of_spec) in [
            ("vehicle", &spec["vehicle"]),
            ("sampling_period_s", &spec["sampling"]["period_s"]),
            ("premise", &spec["operating_range"]),
            ("evaluation.weights", &spec["evaluation"]["weights"]),
        ] {
            let pointer = format!("/{}", key.replace('.', "/"));
            if content.pointer(&pointer) != Some(of_spec) {
                return Err(Refusal::Contradiction { key: key.into() });
            }
        }
        let design = Self::deserialize(&content)?;
        let (evaluation, of_spec) = (&design.evaluation, &design.spec.evaluation);
        for (key, agrees) in [
            ("evaluation.window", evaluation.window == of_spec.window_samples),
            ("evaluation.kind", evaluation.kind == of_spec.threshold),
        ] {
            if !agrees {
                return Err(Refusal::Contradiction { key: key.into() });
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

/// The exact values of `rows` where each has `count` elements, one at least.
pub fn columns(rows: &[Vec<f64>], count: usize) -> Option<Matrix> {
    let fits = count > 0 && rows.iter().all(|row| row.len() == count);
    fits.then(|| Matrix::new(rows.len(), count, |row, column| exact(rows[row][column])))
}

/// SHA-256, in hexadecimal, of a design's canonical text without its key `hash`: keys in the order
/// of their bytes, no white space, every number as the shortest decimal that reads back as the same
/// f64. Layout, order of keys and notation of numbers may change freely, values may not.
pub fn content_hash(design: &Value) -> String {
    let mut text = String::new();
    match design {
        Value::Object(keys) => {
            let without_hash = keys.iter().filter(|(key, _)| *key != "hash");
            write_object(without_hash, &mut text);
        }
        other => write_canonically(other, &mut text),
    }
    let digest = Sha256::digest(text.as_bytes());
    digest.iter().map(|byte| format!("{byte:02x}")).collect()
}

fn write_canonically(value: &Value, text: &mut String) {
    match value {
        Value::Object(keys) => write_object(keys.iter(), text),
        Value::Array(elements) => {
            text.push('[');
            for (index, element) in elements.iter().enumerate() {
                text.push_str(if index == 0 { "" } else { "," });
                write_canonically(element, text);
            }
            text.push(']');
        }
        Value::Number(number) => match number.as_f64() {
            Some(x) if x.abs() < LARGEST_INTEGERS_OF_F64 => text.push_str(&format!("{x:e}")),
            _ => text.push_str(&number.to_string()),
        },
        // Null, Booleans and strings have one notation each as JSON.
        other => text.push_str(&other.to_string()),
    }
}

fn write_object<'a>(keys: impl Iterator<Item = (&'a String, &'a Value)>, text: &mut String) {
    let mut keys: Vec<_> = keys.collect();
    keys.sort_by_key(|&(key, _)| key);
    text.push('{');
    for (index, (key, value)) in keys.into_iter().enumerate() {
        text.push_str(if index == 0 { "" } else { "," });
        text.push_str(&Value::from(key.as_str()).to_string());
        text.push(':');
        write_canonically(value, text);
    }
    text.push('}');
}
