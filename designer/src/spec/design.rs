//! `[design]`: how the gains are found.

use serde::{Deserialize, Serialize};

use crate::document::{Allowed, Mistake, Mistakes};

/// `[design]`.
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
    /// Slowest decay of the error, a sample, for (33); left out, `decay_per_s` is.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub decay: Option<f64>,
    /// Slowest decay of the error a second, for (33): exp(-decay_per_s period_s) a sample. Left out
    /// it is searched: the first of 3, 4, 2, 5 and 1 with which there is a certified design. Method
    /// "paper" searches nothing and takes 0.97 a sample.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub decay_per_s: Option<f64>,
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
            decay: None,
            decay_per_s: None,
            beta_fraction: 0.97,
            search_budget: 16,
        }
    }
}

/// The methods there are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
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

/// Decay rates tried where none is stated, per second, the likeliest first.
const SEARCHED_DECAY_PER_S: [f64; 5] = [3.0, 4.0, 2.0, 5.0, 1.0];

/// Decay a sample of method "paper" where none is stated.
const DECAY_OF_PAPER: f64 = 0.97;

impl Method {
    /// The decay rates to try one after the other, a sample of `period_s`: the stated one, or those
    /// of the search.
    pub fn decays(&self, period_s: f64) -> Vec<f64> {
        let a_sample = |per_s: f64| libm::exp(-per_s * period_s);
        match (self.decay, self.decay_per_s, self.method) {
            (Some(decay), ..) => vec![decay],
            (None, Some(per_s), _) => vec![a_sample(per_s)],
            (None, None, MethodName::Gap) => SEARCHED_DECAY_PER_S.map(a_sample).to_vec(),
            (None, None, MethodName::Paper) => vec![DECAY_OF_PAPER],
        }
    }

    /// Finds what is not possible by itself.
    pub(super) fn check(&self, mistakes: &mut Mistakes) {
        mistakes.number("design.gamma", self.gamma, Allowed::POSITIVE);
        mistakes.number("design.alpha_d", self.alpha_d, Allowed::FINITE);
        mistakes.number("design.alpha_f", self.alpha_f, Allowed::FINITE);
        if let MultiplierV::Given(v) = self.v {
            // The bound on beta is ||C V'|| / |alpha_f + exp(jw)|.
            let proper = v.iter().all(|x| x.is_finite()) && (v[0] != 0.0 || v[2] != 0.0);
            mistakes.unless(proper, || {
                Mistake::value("design.V", v, "finite numbers, the first or third not zero")
                    .help("beta cannot exceed ||C V'||")
            });
        }
        if let Some(decay) = self.decay {
            mistakes.number("design.decay", decay, Allowed::inside(0.0, 1.0));
        }
        if let Some(decay_per_s) = self.decay_per_s {
            mistakes.number("design.decay_per_s", decay_per_s, Allowed::POSITIVE);
            mistakes.unless(self.decay.is_none(), || {
                Mistake::value("design.decay_per_s", decay_per_s, "nothing beside design.decay")
                    .help("state one of them: decay a sample is exp(-decay_per_s period_s)")
                    .because_of("design.decay")
            });
        }
        mistakes.number("design.beta_fraction", self.beta_fraction, Allowed::inside(0.0, 1.0));
        let budget = self.search_budget;
        mistakes.unless((1..=10_000).contains(&budget), || {
            Mistake::value("design.search_budget", budget, "from 1 to 10000 syntheses")
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn decay_is_as_stated_or_searched() {
        let gap = Method::default();
        let searched = gap.decays(0.01);
        assert_eq!(searched.len(), SEARCHED_DECAY_PER_S.len());
        assert!((searched[0] - 0.970_445_533_548_508_2).abs() < 1e-15);
        // A rate per second is one whatever the sampling period.
        let slower = gap.decays(0.02);
        assert!((slower[0] - searched[0] * searched[0]).abs() < 1e-15);
        let a_sample = Method { decay: Some(0.9), ..gap.clone() };
        assert_eq!(a_sample.decays(0.01), [0.9]);
        let a_second = Method { decay_per_s: Some(2.0), ..gap.clone() };
        assert_eq!(a_second.decays(0.01), [searched[2]]);
        let paper = Method { method: MethodName::Paper, ..gap };
        assert_eq!(paper.decays(0.01), [0.97]);
    }
}
