//! What hides the smallest fault from a blind design.
//!
//! The input or uncertainty whose key lowers the threshold most when it is set to 0, where the fault is
//! missed; and, with the same gains, the value at which the fault is seen.
//!
//! # Conventions
//! A key's numbers are scaled together, from as specified, 1, down to nothing, 0. What the threshold
//! would be is recomputed: shares of uncertainties by the detector, the level from the calibration's worst
//! drive, driven once more. The share of the uncertainties' bound is held.

use std::slice;

use serde::{Deserialize, Serialize};
use steerguard_detector::{Configuration, ConfigurationError, Evaluation, LEAST};

use crate::problem::model;
use crate::spec::{Spec, ThresholdKind, UncertaintyTable};
use crate::threshold::calibration::worst_again;
use crate::threshold::{Threshold, steady};

/// Halvings of the interval of scales.
const HALVINGS: u32 = 12;

/// What hides a fault.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct HiddenBy {
    /// Its key in the specification.
    pub key: String,
    /// As specified; of an interval both ends.
    pub value: Vec<f64>,
    /// About where the fault would be seen; null where it is missed even with 0.
    pub seen_at: Option<Vec<f64>>,
}

/// The numbers of a key of `[uncertainty]`.
type Numbers = fn(&mut UncertaintyTable) -> &mut [f64];

/// Those that raise the threshold straight ahead.
const UNCERTAINTIES: [(&str, Numbers); 9] = [
    ("mass_percent", |table| &mut table.mass_percent),
    ("yaw_inertia_percent", |table| &mut table.yaw_inertia_percent),
    ("front_cornering_stiffness_percent", |table| &mut table.front_cornering_stiffness_percent),
    ("rear_cornering_stiffness_percent", |table| &mut table.rear_cornering_stiffness_percent),
    ("bank_deg", |table| slice::from_mut(&mut table.bank_deg)),
    ("gust_m_per_s", |table| slice::from_mut(&mut table.gust_m_per_s)),
    ("steering_offset_deg", |table| slice::from_mut(&mut table.steering_offset_deg)),
    ("yaw_rate_bias_deg_per_s", |table| slice::from_mut(&mut table.yaw_rate_bias_deg_per_s)),
    ("v_x_scale_percent", |table| slice::from_mut(&mut table.v_x_scale_percent)),
];

/// A key that the threshold rises with.
#[derive(Clone, Copy)]
enum Key {
    /// Of `[uncertainty]`.
    Uncertainty(&'static str, Numbers),
    /// Bound of a disturbance.
    Disturbance(usize),
    /// White noise of a sensor, v_x or r.
    WhiteNoise(usize),
    /// Bound on the noise of a sensor.
    NoiseBound(usize),
    /// The threshold as specified.
    Constant,
}

impl Key {
    /// All that are set in `spec`.
    fn all(spec: &Spec) -> Vec<Self> {
        let uncertainties = UNCERTAINTIES.map(|(key, numbers)| Self::Uncertainty(key, numbers));
        let disturbances = (0..spec.disturbance.len()).map(Self::Disturbance);
        let noise = (0..2).flat_map(|sensor| [Self::WhiteNoise(sensor), Self::NoiseBound(sensor)]);
        let keys = uncertainties.into_iter().chain(disturbances).chain(noise);
        let is_constant = spec.evaluation.threshold == ThresholdKind::Constant;
        let keys = keys.chain(is_constant.then_some(Self::Constant));
        keys.filter(|key| key.numbers(&mut spec.clone()).iter().any(|&x| x != 0.0)).collect()
    }

    /// Its name in the specification.
    fn name(self, spec: &Spec) -> String {
        match self {
            Self::Uncertainty(key, _) => format!("uncertainty.{key}"),
            Self::Disturbance(k) => {
                let disturbance = &spec.disturbance[k];
                format!("{} of disturbance \"{}\"", disturbance.bound_key(), disturbance.name())
            }
            Self::WhiteNoise(0) => "noise.v_x.white_std_m_per_s".into(),
            Self::WhiteNoise(_) => "noise.r.white_std_rad_per_s".into(),
            Self::NoiseBound(0) => "noise.v_x.bound_m_per_s".into(),
            Self::NoiseBound(_) => "noise.r.bound_rad_per_s".into(),
            Self::Constant => "evaluation.constant".into(),
        }
    }

    /// Its numbers; none where the key is not set.
    fn numbers(self, spec: &mut Spec) -> &mut [f64] {
        let noise = &mut spec.noise;
        match self {
            Self::Uncertainty(_, numbers) => numbers(&mut spec.uncertainty),
            Self::Disturbance(k) => slice::from_mut(spec.disturbance[k].bound_mut()),
            Self::WhiteNoise(0) => slice::from_mut(&mut noise.v_x.white_std_m_per_s),
            Self::WhiteNoise(_) => slice::from_mut(&mut noise.r.white_std_rad_per_s),
            Self::NoiseBound(0) => noise.v_x.bound_m_per_s.as_mut_slice(),
            Self::NoiseBound(_) => noise.r.bound_rad_per_s.as_mut_slice(),
            Self::Constant => spec.evaluation.constant.as_mut_slice(),
        }
    }

    /// `spec` with its numbers times `scale`.
    fn scaled(self, spec: &Spec, scale: f64) -> Spec {
        let mut scaled = spec.clone();
        self.numbers(&mut scaled).iter_mut().for_each(|number| *number *= scale);
        scaled
    }
}

/// A straight course on which the smallest fault is missed.
#[derive(Clone, Copy, Debug)]
pub struct Missed {
    /// Speed.
    pub v_x_m_per_s: f64,
    /// Whether an alarm stood before the fault.
    pub false_alarm: bool,
}

/// Whether the smallest fault is seen straight ahead at every speed.
pub type Sees = fn(&Spec, &Configuration) -> Result<bool, ConfigurationError>;

/// A design whose keys can be scaled.
struct Scaled<'a> {
    sees: Sees,
    spec: &'a Spec,
    configuration: &'a Configuration,
    threshold: &'a Threshold,
}

/// What hides the smallest fault on the `missed` courses, the first of its kind where it is hidden most;
/// none where the threshold does not hide it.
pub fn hidden_by(
    spec: &Spec,
    configuration: &Configuration,
    threshold: &Threshold,
    missed: &[Missed],
    sees: Sees,
) -> Result<Option<HiddenBy>, ConfigurationError> {
    let straight = |course: &Missed| {
        let at = steady(configuration, course.v_x_m_per_s, 0.0);
        (course.v_x_m_per_s, at.j_th / at.smallest_fault_j)
    };
    let worst = missed.iter().map(straight).reduce(|a, b| if b.1 > a.1 { b } else { a });
    let Some((v_x, ratio)) = worst else {
        return Ok(None);
    };
    // An alarm that stood, or none although J is above the threshold: something else is wrong.
    if ratio < 1.0 || missed.iter().any(|course| course.false_alarm) {
        return Ok(None);
    }
    let design = Scaled { sees, spec, configuration, threshold };
    let mut most: Option<(Key, f64)> = None;
    for key in Key::all(spec) {
        let j_th = steady(&design.configuration(key, 0.0)?, v_x, 0.0).j_th;
        if most.is_none_or(|(_, least)| j_th < least) {
            most = Some((key, j_th));
        }
    }
    let Some((key, _)) = most else {
        return Ok(None);
    };
    let numbers = |scale| key.numbers(&mut key.scaled(spec, scale)).to_vec();
    Ok(Some(HiddenBy {
        key: key.name(spec),
        value: numbers(1.0),
        seen_at: design
            .seen_at(key)?
            .map(|scale| numbers(scale).into_iter().map(two_digits).collect()),
    }))
}

impl Scaled<'_> {
    /// The configuration with the numbers of `key` scaled, the gains as they are.
    fn configuration(&self, key: Key, scale: f64) -> Result<Configuration, ConfigurationError> {
        let scaled = key.scaled(self.spec, scale);
        let of_level = match key {
            Key::Uncertainty(..) => 1.0,
            Key::Constant => scale,
            _ => self.level_ratio(&scaled, key, scale)?,
        };
        let evaluation = &self.configuration.evaluation;
        // A threshold of nothing is none.
        let threshold = LEAST.max(of_level * evaluation.threshold);
        Ok(Configuration {
            deviations: model::deviations(&scaled),
            evaluation: Evaluation { threshold, ..*evaluation },
            ..*self.configuration
        })
    }

    /// How the level of J changes with an input.
    fn level_ratio(&self, scaled: &Spec, key: Key, scale: f64) -> Result<f64, ConfigurationError> {
        let Threshold { calibration, guaranteed, .. } = self.threshold;
        if let Some(level) = calibration {
            let of = |spec| worst_again(spec, self.configuration, level);
            let levels = of(scaled)?.zip(of(self.spec)?);
            return Ok(levels.map_or(1.0, |(scaled, as_specified)| scaled / as_specified));
        }
        // Disturbances come first, then the noise that is bounded.
        let disturbances = self.spec.disturbance.len();
        let bounded = |sensor: usize| self.spec.noise.bounds()[sensor].is_some();
        let input = match key {
            Key::Disturbance(k) => Some(k),
            Key::NoiseBound(0) => Some(disturbances),
            Key::NoiseBound(_) => Some(disturbances + usize::from(bounded(0))),
            _ => None,
        };
        let share = guaranteed.as_ref().zip(input).and_then(|(guaranteed, input)| {
            Some(guaranteed.inputs.get(input)?.j / guaranteed.level())
        });
        Ok(1.0 - (1.0 - scale) * share.unwrap_or(0.0))
    }

    /// The largest scale of `key` at which the smallest fault is seen straight ahead at every speed.
    fn seen_at(&self, key: Key) -> Result<Option<f64>, ConfigurationError> {
        let seen = |scale: f64| -> Result<bool, ConfigurationError> {
            let spec = key.scaled(self.spec, scale);
            let configuration = self.configuration(key, scale)?;
            (self.sees)(&spec, &configuration)
        };
        if !seen(0.0)? {
            return Ok(None);
        }
        let [mut least, mut most] = [0.0, 1.0];
        for _ in 0..HALVINGS {
            let middle = 0.5 * (least + most);
            if seen(middle)? {
                least = middle;
            } else {
                most = middle;
            }
        }
        Ok(Some(least))
    }
}

/// The first two digits of `x`.
fn two_digits(x: f64) -> f64 {
    if x == 0.0 {
        return 0.0;
    }
    let unit = libm::pow(10.0, libm::floor(libm::log10(x.abs())) - 1.0);
    let digits = (x / unit).trunc();
    // 0.034 as written, not 34 times 0.001.
    if unit < 1.0 { digits / (1.0 / unit).round() } else { digits * unit }
}
