//! The worst case that a search finds: the fault-free drive with the largest J/J_th.
//!
//! A threshold that random drives stay below is none that every drive stays below. An adversary looks for
//! the drive, within all that the specification states, that comes nearest to a false alarm, or makes
//! one: in the [world](steerguard_world), with the detector as it is baked. What it finds is a lower bound
//! on the worst case.
//!
//! # Conventions
//! - A family's budget is a number of drives. Some are driven at random; from the worst of these [`STARTS`]
//!   starts move a distribution of drives each ([`evolution`]); the better half of them goes on, until one is
//!   left. What has come to its end begins anew around its best.
//! - The result is a function of specification, configuration, budget and seed, to the last bit, on any
//!   machine and any number of processors.
//! - Neither the disturbances nor the bounded noise of a specification act: as in campaigns. White noise
//!   does, the same in every drive of a search.

pub mod drive;
mod evolution;
mod family;

use std::f64::consts::PI;

use rayon::prelude::*;
use steerguard_detector::{Configuration, ConfigurationError, Detector};
use steerguard_world::Stream;

use crate::spec::Spec;
use crate::worst::drive::{Drive, Worst};
use crate::worst::evolution::{Evolution, Found, population};
pub use crate::worst::family::Family;

/// Starts of a family's search.
pub const STARTS: usize = 8;
/// Drives of a family where nothing else is asked for.
pub const BUDGET: u64 = 12_000;
/// Share of the budget that is driven at random.
const RANDOM: f64 = 0.2;
/// Standard deviation of a distribution at its beginning, rad, around a drive at random and one like a known
/// one, and where it has come to its end.
const FIRST_STEP: f64 = 0.5;
const KNOWN_STEP: f64 = 0.2;
const LAST_STEP: f64 = 1e-3;

/// What a search is asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Search {
    /// Drives of each family, at most.
    pub budget: u64,
    /// Same seed, same drives.
    pub seed: u64,
}

/// The worst drive found of a family.
#[derive(Clone, Debug, PartialEq)]
pub struct FamilyWorst {
    /// The family.
    pub family: Family,
    /// Drives simulated.
    pub drives: u64,
    /// The largest J/J_th of those at random; none where none had a monitored sample.
    pub ratio_at_random: Option<f64>,
    /// The drive, and where its J/J_th is largest; none where no drive had a monitored sample.
    pub worst: Option<(Drive, Worst)>,
}

impl FamilyWorst {
    /// Largest J/J_th.
    pub fn ratio(&self) -> Option<f64> {
        self.worst.as_ref().map(|(_, worst)| worst.ratio)
    }
}

/// The worst drives found of `families` for the detector with `configuration` that is designed for `spec`;
/// `progress` hears of drives done.
///
/// # Errors
/// [`ConfigurationError`] where the detector cannot run with `configuration`.
pub fn worst(
    spec: &Spec,
    configuration: &Configuration,
    families: &[Family],
    search: Search,
    progress: &(impl Fn(u64) + Sync),
) -> Result<Vec<FamilyWorst>, ConfigurationError> {
    let detector = Detector::new(configuration)?;
    let noise_seed = (Stream::new(search.seed, NOISE_STREAM).bits(0) as u32).cast_signed();
    let mut known: Vec<(Family, Found)> = Vec::new();
    let mut worst = Vec::with_capacity(families.len());
    for &family in families {
        let test = Test { spec, detector, family, noise_seed, search, progress };
        let (found, of_family) = test.worst(&known);
        known.extend(found.map(|found| (family, found)));
        worst.push(of_family);
    }
    Ok(worst)
}

/// Streams of a search's random numbers: the seed of the sensors' noise, drives at random, drives like known
/// ones, the first of the starts.
const NOISE_STREAM: u64 = 0;
const RANDOM_STREAM: u64 = 1;
const KNOWN_STREAM: u64 = 2;
const FIRST_START_STREAM: u64 = 3;

/// The search of a family.
struct Test<'a, P> {
    spec: &'a Spec,
    detector: Detector,
    family: Family,
    noise_seed: i32,
    search: Search,
    progress: &'a P,
}

/// A start under way.
struct Start {
    evolution: Evolution,
    /// The best drive so far.
    best: Found,
    random: Stream,
    /// Random numbers used.
    used: u64,
}

impl<P: Fn(u64) + Sync> Test<'_, P> {
    fn drive(&self, point: &[f64]) -> Drive {
        self.family.drive(self.spec, point, self.noise_seed)
    }

    /// Largest J/J_th of the drive of `point`.
    fn ratio(&self, point: &[f64]) -> Option<f64> {
        let worst = self.drive(point).worst(self.spec, self.detector);
        (self.progress)(1);
        worst.map(|worst| worst.ratio)
    }

    /// The worst found, and what is reported of it; `known` is the worst of other families.
    fn worst(&self, known: &[(Family, Found)]) -> (Option<Found>, FamilyWorst) {
        let budget = self.search.budget;
        let each = ((0.5 * RANDOM * budget as f64) as u64).max(1);
        let at_random = self.at_random(each, RANDOM_STREAM, &[]);
        let like_known = self.at_random(each, KNOWN_STREAM, known);
        let mut drives = 2 * each;
        let ratio_at_random = at_random.first().and_then(|found| found.value);
        let starts = |found: Vec<Found>, step: f64, first_stream: u64| {
            let some = found.into_iter().take(STARTS / 2).zip(first_stream..);
            some.map(move |(best, stream)| Start {
                evolution: Evolution::new(best.point.clone(), step),
                best,
                random: Stream::new(self.search.seed, stream),
                used: 0,
            })
        };
        let mut starts: Vec<Start> = starts(at_random, FIRST_STEP, FIRST_START_STREAM)
            .chain(starts(like_known, KNOWN_STEP, FIRST_START_STREAM + STARTS as u64))
            .collect();
        // The better half goes on, with the same number of drives in every round.
        let rounds = u64::from(starts.len().ilog2()) + 1;
        for round in 0..rounds {
            let left = (budget - drives.min(budget)) / (rounds - round);
            let share = left / starts.len() as u64;
            drives += starts.par_iter_mut().map(|start| self.go_on(start, share)).sum::<u64>();
            starts.sort_by(|a, b| b.best.order(&a.best));
            if std::env::var("TRACE").is_ok() { eprintln!("{:?} {drives} {:?}", self.family, starts.iter().map(|s| (s.best.value.unwrap(), s.evolution.step())).collect::<Vec<_>>()); }
            starts.truncate(starts.len().div_ceil(2));
        }
        let best = starts.into_iter().next().map(|start| start.best);
        let worst = best.as_ref().and_then(|best| {
            let drive = self.drive(&best.point);
            let worst = drive.worst(self.spec, self.detector)?;
            Some((drive, worst))
        });
        (best, FamilyWorst { family: self.family, drives, ratio_at_random, worst })
    }

    /// So many drives at random, the worst first; of those like a `known` one of another family only what
    /// does not mean the same is random.
    fn at_random(&self, drives: u64, stream: u64, known: &[(Family, Found)]) -> Vec<Found> {
        let random = Stream::new(self.search.seed, stream);
        let dimension = self.family.dimension(self.spec) as u64;
        let drive = |k: u64| {
            let numbers = k * dimension..(k + 1) * dimension;
            let mut point: Vec<f64> = numbers.map(|number| random.within(number, PI)).collect();
            if let Some((other, found)) = known.get(k as usize % known.len().max(1)) {
                let shared = self.family.shared(*other, self.spec);
                point.iter_mut().zip(&found.point).take(shared).for_each(|(to, from)| *to = *from);
            }
            Found { value: self.ratio(&point), point }
        };
        let mut found: Vec<Found> = (0..drives).into_par_iter().map(drive).collect();
        found.sort_by(|a, b| b.order(a));
        found
    }

    /// Goes on with `start` for at most so many `drives`; the number driven.
    fn go_on(&self, start: &mut Start, drives: u64) -> u64 {
        let dimension = start.best.point.len();
        let population = population(dimension) as u64;
        let generations = drives / population;
        for _ in 0..generations {
            if start.evolution.step() < LAST_STEP {
                start.evolution = Evolution::new(start.best.point.clone(), FIRST_STEP);
            }
            let ratio = |point: &[f64]| self.ratio(point);
            let found = start.evolution.generation(start.random, start.used, &ratio);
            start.used += population * dimension as u64;
            if found.order(&start.best).is_gt() {
                start.best = found;
            }
        }
        generations * population
    }
}
