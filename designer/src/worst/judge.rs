//! What a drive is judged by: J/J_th, or the statistic of the second test over its threshold.

use serde::Serialize;
use steerguard_detector::{Configuration, ConfigurationError, Detector, Estimator, Output};

/// A threshold of the second test that no drive reaches: what is found would change what follows.
pub(crate) const UNREACHED: f64 = 1e6;

/// What a search makes large.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Objective {
    /// J/J_th.
    Residual,
    /// The statistic of the second test over its threshold, 0 where it does not run.
    Second,
}

impl Objective {
    /// The detector with `configuration` as a drive is judged by it.
    ///
    /// # Errors
    /// [`ConfigurationError`] where none can run with it.
    pub fn judge(self, configuration: &Configuration) -> Result<Judge, ConfigurationError> {
        let threshold = configuration.estimator.map_or(f64::INFINITY, |x| x.threshold);
        let unreached = |x: Estimator| Estimator { threshold: UNREACHED, ..x };
        let estimator = match self {
            // J does not depend on the second test.
            Self::Residual => None,
            Self::Second => configuration.estimator.map(unreached),
        };
        let detector = Detector::new(&Configuration { estimator, ..*configuration })?;
        Ok(Judge { detector, objective: self, second_per_ratio: UNREACHED / threshold })
    }
}

/// A detector that drives are judged by.
#[derive(Clone, Copy, Debug)]
pub struct Judge {
    pub(super) detector: Detector,
    objective: Objective,
    /// Ratio to the threshold that is, over the ratio to the one that no drive reaches.
    second_per_ratio: f64,
}

impl Judge {
    /// The ratio that is made large, at the detector's last sample.
    pub(super) fn ratio(&self, output: &Output) -> f64 {
        match self.objective {
            Objective::Residual => output.j_rms / output.j_th,
            Objective::Second => self.second_per_ratio * output.second_ratio,
        }
    }
}
