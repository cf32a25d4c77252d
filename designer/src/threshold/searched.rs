//! What a short search for the worst case finds, which the threshold has to cover too (method 8).

use serde::{Deserialize, Serialize};
use steerguard_detector::{Configuration, ConfigurationError};

use crate::spec::Spec;
use crate::threshold::calibration::Level;
use crate::worst::{Family, Objective, Search, worst};

/// Seed of the search.
const SEED: u64 = 1;

/// The largest statistic that a search found of a family.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Searched {
    /// Name of the [`Family`].
    pub family: String,
    /// J/J_th, or the statistic of the second test; 0 where no drive had a monitored sample.
    pub level: f64,
    /// Drives simulated.
    pub drives: u64,
}

/// The J/J_th that share and level cover, before their margin: the largest of drives at random, and of what a
/// search found as far as the whole bound, with the margin, goes.
pub fn covered(at_random: &Level, searched: &[Searched], margin: f64) -> f64 {
    let found = searched.iter().map(|found| found.level).fold(0.0, f64::max);
    at_random.level.max(found.min(1.0 / margin))
}

/// The families that the others are parts of: bank and wind of any course, and all that `spec` states.
fn families(spec: &Spec) -> Vec<Family> {
    let mut families = vec![Family::AnyCourse];
    let last = Family::of(spec).into_iter().rfind(|family| family.is_stated());
    families.extend(last.filter(|last| *last != Family::AnyCourse));
    families
}

/// The largest ratio by `objective` of the detector with `configuration` that is found in as many drives of
/// each of the widest families as `spec` asks for.
///
/// # Errors
/// [`ConfigurationError`] where the detector cannot run with `configuration`.
pub fn searched(
    spec: &Spec,
    configuration: &Configuration,
    objective: Objective,
) -> Result<Vec<Searched>, ConfigurationError> {
    let budget = spec.evaluation.calibration.search_drives;
    if budget == 0 {
        return Ok(Vec::new());
    }
    let search = Search { objective, budget, seed: SEED };
    let found = worst(spec, configuration, &families(spec), search, &|_| ())?;
    let of_family = found.iter().map(|found| Searched {
        family: found.family.name().to_owned(),
        level: found.ratio().unwrap_or(0.0),
        drives: found.drives,
    });
    Ok(of_family.collect())
}
