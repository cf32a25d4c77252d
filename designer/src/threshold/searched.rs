//! What a short search for the worst case finds, which the threshold has to cover too (method 8).

use serde::{Deserialize, Serialize};
use steerguard_detector::{Configuration, ConfigurationError};

use crate::spec::{Covers, Spec};
use crate::threshold::calibration::Level;
use crate::threshold::recorded::Recorded;
use crate::worst::{Family, Objective, Search, worst};

/// Seed of the search.
const SEED: u64 = 1;

/// The largest statistic that a search found of a family.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Searched {
    /// Name of the [`Family`].
    pub family: String,
    /// J/J_th, or the statistic of the second test; 0 where no drive had a monitored sample.
    pub level: f64,
    /// Drives simulated.
    pub drives: u64,
}

/// The largest that a search found; 0 of none.
pub fn largest(searched: &[Searched]) -> f64 {
    searched.iter().map(|found| found.level).fold(0.0, f64::max)
}

/// Drives that a search took.
pub fn drives(searched: &[Searched]) -> u64 {
    searched.iter().map(|found| found.drives).sum()
}

/// The J/J_th that share and level cover, before their `margin`: the largest of drives at random, of recorded
/// ones, and, where it is to be covered, of what a search found, as far as the whole bound goes with the margin.
pub fn covered(
    at_random: &Level,
    recorded: &[Recorded],
    searched: &[Searched],
    margin: f64,
    covers: Covers,
) -> f64 {
    let driven = recorded.iter().map(|drive| drive.level).fold(at_random.level, f64::max);
    match covers {
        Covers::RandomDrives => driven,
        Covers::WorstCase => driven.max(largest(searched).min(1.0 / margin)),
    }
}

/// The families that the others are parts of: bank and wind of any course, and all that `spec` states.
fn families(spec: &Spec) -> Vec<Family> {
    let mut families = vec![Family::AnyCourse];
    let last = Family::of(spec).into_iter().rfind(|family| family.is_stated());
    families.extend(last.filter(|last| *last != Family::AnyCourse));
    families
}

/// The largest ratio by `objective` of the detector with `configuration` that is found in so many `drives` of
/// each of the widest families.
///
/// # Errors
/// [`ConfigurationError`] where the detector cannot run with `configuration`.
pub fn searched(
    spec: &Spec,
    configuration: &Configuration,
    objective: Objective,
    drives: u64,
) -> Result<Vec<Searched>, ConfigurationError> {
    if drives == 0 {
        return Ok(Vec::new());
    }
    let search = Search { objective, budget: drives, seed: SEED };
    let found = worst(spec, configuration, &families(spec), search, &|_| ())?;
    let of_family = found.iter().map(|found| Searched {
        family: found.family.name().to_owned(),
        level: found.ratio().unwrap_or(0.0),
        drives: found.drives,
    });
    Ok(of_family.collect())
}
