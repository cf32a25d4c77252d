//! The second test of a design, for people.

use schemars::JsonSchema;
use serde::Serialize;
use steerguard_designer::Design;
use steerguard_designer::spec::ThresholdKind;
use steerguard_designer::threshold::searched::{self, Searched};
use steerguard_designer::threshold::second::SecondLevels;
use steerguard_detector::Estimator;

/// What a design's second test rests on.
#[derive(Clone, Debug, PartialEq, JsonSchema, Serialize)]
pub struct SecondTest {
    /// The statistic that raises the alarm.
    pub threshold: f64,
    /// The statistic that an estimate's largest error makes.
    pub estimate_factor: f64,
    /// The largest statistics without a fault.
    pub levels: SecondLevels,
}

/// Whether a design has a second test.
#[derive(Clone, Debug, Default, PartialEq, JsonSchema, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Second {
    /// None is asked for.
    #[default]
    NotAskedFor,
    /// One is, which this kind of threshold cannot have.
    OfNoKind(ThresholdKind),
    /// It has.
    Runs(SecondTest),
}

impl Second {
    /// That of `design`.
    pub fn of(design: &Design) -> Self {
        match (&design.detector.estimator, &design.threshold.second) {
            (Some(estimator), Some(levels)) => {
                let Estimator { threshold, estimate_factor, .. } = *estimator;
                Self::Runs(SecondTest { threshold, estimate_factor, levels: levels.clone() })
            }
            _ if design.spec.estimator.enabled => Self::OfNoKind(design.threshold.kind),
            _ => Self::NotAskedFor,
        }
    }

    /// Its threshold, if it has one, and sentences on it; none where none is asked for.
    pub fn sentences(&self, margin: f64) -> Option<(Option<f64>, Vec<String>)> {
        match self {
            Self::NotAskedFor => None,
            Self::OfNoKind(_) => {
                let off =
                    "off: only evaluation.threshold = \"adaptive\" tells it what is uncertain";
                Some((None, vec![off.into()]))
            }
            Self::Runs(SecondTest { threshold, levels, .. }) => {
                let SecondLevels { calibration, in_99_of_100, search } = levels;
                let mut sentences = vec![format!(
                    "{margin} x {margin} x the largest statistic without a fault: {:.3} in {} drives at random ({:.3} in 99 of \
                     100 seconds), {:.3} found by a search of {} drives",
                    calibration.level,
                    calibration.drives,
                    in_99_of_100,
                    searched::largest(search),
                    searched::drives(search)
                )];
                let of: Vec<String> = search
                    .iter()
                    .map(|Searched { family, level, .. }| format!("{family} {level:.3}"))
                    .collect();
                sentences.push(format!("found by search, by family: {}", of.join(", ")));
                Some((Some(*threshold), sentences))
            }
        }
    }
}
