//! The worst case that a search finds: the fault-free drive with the largest J/J_th, or the largest statistic
//! of the second test over its threshold.
//!
//! A threshold that random drives stay below is none that every drive stays below. An adversary looks for
//! the drive, within all that the specification states, that comes nearest to a false alarm, or makes
//! one: in the [world](steerguard_world), with the detector as it is baked. What it finds is a lower bound
//! on the worst case.
//!
//! # Conventions
//! - A family's budget is a number of drives. Some are those that one would try first, some are driven at
//!   random, and some like the worst so far of the families; from the worst of each kind [`STARTS`] starts in
//!   all move a distribution of drives each ([`evolution`]); the better half of them goes on, until one is
//!   left. What has come to its end begins anew around its best. All families are gone through twice, the
//!   second time with what is known alone.
//! - The result is a function of specification, configuration, budget and seed, to the last bit, on any
//!   machine and any number of processors.
//! - Neither the disturbances nor the bounded noise of a specification act: as in campaigns. White noise
//!   does, the same in every drive of a search.

pub mod drive;
mod evolution;
mod family;
mod judge;

use std::f64::consts::PI;

use rayon::prelude::*;
use steerguard_detector::{Configuration, ConfigurationError};
use steerguard_world::Stream;

use crate::spec::Spec;
use crate::worst::drive::{Drive, Worst};
use crate::worst::evolution::{Evolution, Found, population};
pub use crate::worst::family::Family;
pub(crate) use crate::worst::judge::UNREACHED;
pub use crate::worst::judge::{Judge, Objective};

/// Starts of a family of each kind.
const STARTS_OF_A_KIND: usize = 4;
/// Starts of a family in each pass, at most.
pub const STARTS: usize = 3 * STARTS_OF_A_KIND;
/// Drives of a family where nothing else is asked for.
pub const BUDGET: u64 = 16_000;
/// How often all families are gone through, each time with what is known of the others.
const PASSES: u64 = 2;
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
    /// What is made large.
    pub objective: Objective,
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
    /// The largest ratio of those at random; none where none had a monitored sample.
    pub ratio_at_random: Option<f64>,
    /// The drive, and where its ratio is largest; none where no drive had a monitored sample.
    pub worst: Option<(Drive, Worst)>,
}

impl FamilyWorst {
    /// Largest ratio.
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
    let judge = search.objective.judge(configuration)?;
    let noise_seed = (Stream::new(search.seed, NOISE_STREAM).bits(0) as u32).cast_signed();
    let mut found: Vec<Outcome> = families.iter().map(|_| Outcome::default()).collect();
    for pass in 0..PASSES {
        for (place, &family) in families.iter().enumerate() {
            let test = Test { spec, judge, family, noise_seed, search, pass, progress };
            let known: Vec<Known> = families
                .iter()
                .zip(&found)
                .filter_map(|(&of, outcome)| Some((of, outcome.best.as_ref()?)))
                .collect();
            let outcome = test.search(&known);
            found[place].add(outcome);
        }
    }
    let report = |(&family, outcome): (&Family, Outcome)| {
        let Outcome { best, drives, ratio_at_random } = outcome;
        let worst = best.and_then(|best| {
            let drive = family.drive(spec, &best.point, noise_seed);
            let worst = drive.worst(spec, judge)?;
            Some((drive, worst))
        });
        FamilyWorst { family, drives, ratio_at_random, worst }
    };
    Ok(families.iter().zip(found).map(report).collect())
}

/// What passes have found of a family.
#[derive(Default)]
struct Outcome {
    best: Option<Found>,
    drives: u64,
    ratio_at_random: Option<f64>,
}

impl Outcome {
    /// Adds what a further pass has found.
    fn add(&mut self, other: Self) {
        self.drives += other.drives;
        // None is less than every number.
        if other.ratio_at_random > self.ratio_at_random {
            self.ratio_at_random = other.ratio_at_random;
        }
        let is_more = |more: &Found| self.best.as_ref().is_none_or(|best| more.order(best).is_gt());
        if let Some(more) = other.best.filter(is_more) {
            self.best = Some(more);
        }
    }
}

/// The worst of a family so far.
type Known<'a> = (Family, &'a Found);

/// Streams of a pass's random numbers: the seed of the sensors' noise, drives at random, drives like known
/// ones, how these differ from them, the first of each kind's starts; and the number of all.
const NOISE_STREAM: u64 = 0;
const RANDOM_STREAM: u64 = 1;
const KNOWN_STREAM: u64 = 2;
const AROUND_STREAM: u64 = 3;
const FROM_RANDOM_STREAM: u64 = 4;
const FROM_KNOWN_STREAM: u64 = FROM_RANDOM_STREAM + STARTS_OF_A_KIND as u64;
const FROM_SUSPECTS_STREAM: u64 = FROM_KNOWN_STREAM + STARTS_OF_A_KIND as u64;
const STREAMS: u64 = FROM_SUSPECTS_STREAM + STARTS_OF_A_KIND as u64;

/// The search of a family.
struct Test<'a, P> {
    spec: &'a Spec,
    judge: Judge,
    family: Family,
    noise_seed: i32,
    search: Search,
    pass: u64,
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
    /// Largest ratio of the drive of `point`.
    fn ratio(&self, point: &[f64]) -> Option<f64> {
        let drive = self.family.drive(self.spec, point, self.noise_seed);
        let worst = drive.worst(self.spec, self.judge);
        (self.progress)(1);
        worst.map(|worst| worst.ratio)
    }

    /// Random numbers of this pass.
    fn stream(&self, stream: u64) -> Stream {
        Stream::new(self.search.seed, self.pass * STREAMS + stream)
    }

    /// What a pass finds; `known` is the worst of all families so far.
    fn search(&self, known: &[Known]) -> Outcome {
        let budget = self.search.budget / PASSES;
        let each = ((0.5 * RANDOM * budget as f64) as u64).max(1);
        // In later passes what is known is better than all else.
        let is_first = self.pass == 0;
        let at_random = if is_first { self.at_random(each) } else { Vec::new() };
        let suspects = if is_first { self.suspects(each) } else { Vec::new() };
        let like_known = self.like_known(each, known);
        let mut drives = (at_random.len() + suspects.len() + like_known.len()) as u64;
        let ratio_at_random = at_random.first().and_then(|found| found.value);
        let begin = |found: Vec<Found>, step: f64, first_stream: u64| {
            let some = found.into_iter().take(STARTS_OF_A_KIND).zip(first_stream..);
            some.map(move |(best, stream)| Start {
                evolution: Evolution::new(best.point.clone(), step),
                best,
                random: self.stream(stream),
                used: 0,
            })
        };
        let like_known = first_of_each(like_known);
        let mut starts: Vec<Start> = begin(at_random, FIRST_STEP, FROM_RANDOM_STREAM)
            .chain(begin(suspects, FIRST_STEP, FROM_SUSPECTS_STREAM))
            .chain(begin(like_known, KNOWN_STEP, FROM_KNOWN_STREAM))
            .collect();
        // The better half goes on, with the same number of drives in every round.
        let rounds = u64::from(starts.len().max(1).ilog2()) + 1;
        for round in 0..rounds {
            let left = (budget - drives.min(budget)) / (rounds - round);
            let share = left / starts.len().max(1) as u64;
            drives += starts.par_iter_mut().map(|start| self.go_on(start, share)).sum::<u64>();
            starts.sort_by(|a, b| b.best.order(&a.best));
            starts.truncate(starts.len().div_ceil(2));
        }
        let best = starts.into_iter().next().map(|start| start.best);
        Outcome { best, drives, ratio_at_random }
    }

    /// So many drives at random, the worst first.
    fn at_random(&self, drives: u64) -> Vec<Found> {
        let random = self.stream(RANDOM_STREAM);
        let dimension = self.family.dimension(self.spec) as u64;
        let point = |k: u64| {
            let numbers = k * dimension..(k + 1) * dimension;
            numbers.map(|number| random.within(number, PI)).collect()
        };
        self.tried((0..drives).map(point).collect())
    }

    /// The drives that one would try first, at most so many, the worst first.
    fn suspects(&self, drives: u64) -> Vec<Found> {
        let mut points = self.family.suspects(self.spec);
        points.truncate(drives as usize);
        self.tried(points)
    }

    /// The drives of `points`, the worst first.
    fn tried(&self, points: Vec<Vec<f64>>) -> Vec<Found> {
        let points = points.into_par_iter();
        let mut found: Vec<Found> =
            points.map(|point| Found { value: self.ratio(&point), point }).collect();
        found.sort_by(|a, b| b.order(a));
        found
    }

    /// As many drives like the `known` ones in turn, the worst first, each with the place of that: first as
    /// it is, then around it, as far as its numbers mean the same; what else there is is random.
    fn like_known(&self, drives: u64, known: &[Known]) -> Vec<(usize, Found)> {
        let (random, normal) = (self.stream(KNOWN_STREAM), self.stream(AROUND_STREAM));
        let dimension = self.family.dimension(self.spec) as u64;
        let drive = |(k, place): (u64, usize)| {
            let numbers = k * dimension..(k + 1) * dimension;
            let (other, like) = known[place];
            let shared = self.family.shared(other, self.spec);
            let around = if k < known.len() as u64 { 0.0 } else { KNOWN_STEP };
            let mut point: Vec<f64> =
                numbers.clone().map(|number| random.within(number, PI)).collect();
            for ((to, from), number) in point.iter_mut().zip(&like.point).zip(numbers).take(shared)
            {
                *to = from + around * normal.normal(number);
            }
            (place, Found { value: self.ratio(&point), point })
        };
        let places = (0..known.len()).cycle();
        let drives: Vec<(u64, usize)> = (0..drives).zip(places).collect();
        let mut found: Vec<(usize, Found)> = drives.into_par_iter().map(drive).collect();
        found.sort_by(|(_, a), (_, b)| b.order(a));
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

/// The first of each place, in their order.
fn first_of_each(found: Vec<(usize, Found)>) -> Vec<Found> {
    let mut met = Vec::new();
    let mut is_new = |place: usize| {
        let is_new = !met.contains(&place);
        met.push(place);
        is_new
    };
    found.into_iter().filter_map(|(place, found)| is_new(place).then_some(found)).collect()
}
