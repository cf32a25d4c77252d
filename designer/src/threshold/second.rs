//! What the threshold of the second test rests on: random drives, and a short search for the worst one.

use serde::{Deserialize, Serialize};
use steerguard_detector::{Configuration, ConfigurationError};

use crate::spec::Spec;
use crate::threshold::calibration::Level;
use crate::threshold::recorded::Recorded;
use crate::threshold::searched::{Searched, largest, searched};
use crate::worst::{Objective, UNREACHED};

/// Drives of a family over those of the search for the residual's worst: this statistic's lie further apart.
const FURTHER: u64 = 16;

/// The largest statistics of the second test without a fault.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct SecondLevels {
    /// Of the calibration's drives of uncertain vehicles.
    pub calibration: Level,
    /// What these drives stay below in 99 of 100 seconds.
    pub in_99_of_100: f64,
    /// The largest that a short search found, family by family.
    pub search: Vec<Searched>,
}

impl SecondLevels {
    /// Those of a detector with `configuration`, whose second test has a threshold that no drive reaches, and
    /// `at_random` of the calibration's drives: the largest ratio to that threshold, and what they stay below in
    /// 99 of 100 seconds.
    ///
    /// # Errors
    /// [`ConfigurationError`] where the detector cannot run with `configuration`.
    pub(super) fn of(
        spec: &Spec,
        configuration: &Configuration,
        (calibration, in_99_of_100): (Level, f64),
    ) -> Result<Self, ConfigurationError> {
        let drives = FURTHER * spec.evaluation.calibration.search_drives;
        let statistic = |ratio: f64| UNREACHED * ratio;
        let search = searched(spec, configuration, Objective::Second, drives)?.into_iter();
        Ok(Self {
            calibration: Level { level: statistic(calibration.level), ..calibration },
            in_99_of_100: statistic(in_99_of_100),
            search: search.map(|x| Searched { level: statistic(x.level), ..x }).collect(),
        })
    }

    /// The threshold: `margin` over the largest of all, with those of `recorded` drives, twice: once for drives
    /// that were not driven, once for what a short search misses.
    pub fn threshold(&self, margin: f64, recorded: &[Recorded]) -> f64 {
        let recorded = recorded.iter().filter_map(|drive| drive.second);
        let simulated = self.calibration.level.max(largest(&self.search));
        margin * margin * recorded.fold(simulated, f64::max)
    }
}
