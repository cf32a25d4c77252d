//! What the threshold of the second test rests on: random drives, and a short search for the worst one.

use serde::{Deserialize, Serialize};
use steerguard_detector::{Configuration, ConfigurationError};

use crate::progress::Step;
use crate::spec::Spec;
use crate::threshold::calibration::Level;
use crate::worst::{Family, Objective, Search, UNREACHED, worst};

/// Drives of each family that the short search takes, and its seed.
const BUDGET: u64 = 2000;
const SEED: u64 = 1;

/// The largest statistics of the second test without a fault.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SecondLevels {
    /// Of the calibration's drives of uncertain vehicles.
    pub calibration: Level,
    /// What 99 of 100 of these drives stay below.
    pub in_99_of_100: f64,
    /// The largest that a short search found: of bank and wind of any course, and of all that is stated.
    pub search: Vec<SearchLevel>,
}

/// The largest statistic that a search found of a family.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SearchLevel {
    /// Name of the [`Family`].
    pub family: String,
    /// The statistic; 0 where no drive had a monitored sample.
    pub level: f64,
    /// Drives simulated.
    pub drives: u64,
}

impl SecondLevels {
    /// Those of a detector with `configuration`, whose second test has a threshold that no drive reaches, and
    /// `at_random` of the calibration's drives: the largest ratio to that threshold, and what 99 of 100 stay
    /// below.
    ///
    /// # Errors
    /// [`ConfigurationError`] where the detector cannot run with `configuration`.
    pub(super) fn of(
        spec: &Spec,
        configuration: &Configuration,
        (calibration, in_99_of_100): (Level, f64),
        progress: &mut dyn FnMut(Step),
    ) -> Result<Self, ConfigurationError> {
        progress(Step::Worst);
        // The last one that is stated extends the others.
        let last = Family::of(spec).into_iter().rfind(|family| family.is_stated());
        let mut families = vec![Family::AnyCourse];
        families.extend(last.filter(|last| *last != Family::AnyCourse));
        let search = Search { objective: Objective::Second, budget: BUDGET, seed: SEED };
        let found = worst(spec, configuration, &families, search, &|_| ())?;
        let statistic = |ratio: f64| UNREACHED * ratio;
        Ok(Self {
            calibration: Level { level: statistic(calibration.level), ..calibration },
            in_99_of_100: statistic(in_99_of_100),
            search: found
                .iter()
                .map(|found| SearchLevel {
                    family: found.family.name().to_owned(),
                    level: statistic(found.ratio().unwrap_or(0.0)),
                    drives: found.drives,
                })
                .collect(),
        })
    }

    /// The largest of all.
    pub fn largest(&self) -> f64 {
        self.search.iter().map(|of_family| of_family.level).fold(self.calibration.level, f64::max)
    }
}
