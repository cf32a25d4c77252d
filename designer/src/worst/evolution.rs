//! Maximisation by an evolution strategy with a diagonal covariance matrix.
//!
//! The sep-CMA-ES of Ros and Hansen (2008), "A simple modification in CMA-ES achieving linear time and space
//! complexity", which learns so many dimensions in fewer trials than the full matrix takes. Constants by
//! Hansen (2016), "The CMA evolution strategy: a tutorial", but for positive weights alone.
//!
//! # Conventions
//! - Random numbers by counter: a start is a function of its stream alone. `+ - * /`, `sqrt` and `libm`
//!   in a fixed order: the same bits on every machine and any number of processors.
//! - What is maximised is a number or none; none, and what is not a number, is less than every number.

use std::cmp::Ordering;

use rayon::prelude::*;
use steerguard_world::Stream;

/// A point and its value.
#[derive(Clone, Debug, PartialEq)]
pub struct Found {
    /// The point.
    pub point: Vec<f64>,
    /// What is maximised.
    pub value: Option<f64>,
}

impl Found {
    /// By value; none is less than every number.
    pub fn order(&self, other: &Self) -> Ordering {
        let value = |found: &Self| found.value.unwrap_or(f64::NEG_INFINITY);
        value(self).total_cmp(&value(other))
    }
}

/// The search distribution, `mean + step diag(scale) N(0, I)`, and its paths.
pub struct Evolution {
    mean: Vec<f64>,
    step: f64,
    scale: Vec<f64>,
    path_of_step: Vec<f64>,
    path_of_scale: Vec<f64>,
    generation: u64,
    constants: Constants,
}

/// What depends on the dimension alone.
struct Constants {
    /// Points a generation.
    population: usize,
    /// Weights of the best points, the best first; their sum is 1.
    weights: Vec<f64>,
    /// mu_eff: 1 over the sum of the weights' squares.
    effective: f64,
    step_path: f64,
    damping: f64,
    scale_path: f64,
    rank_one: f64,
    rank_mu: f64,
    /// Expected length of N(0, I).
    length: f64,
}

impl Constants {
    fn of(dimension: usize) -> Self {
        let n = dimension as f64;
        let population = population(dimension);
        let weights: Vec<f64> = (1..=population / 2)
            .map(|rank| libm::log(0.5 * (population as f64 + 1.0)) - libm::log(rank as f64))
            .collect();
        let sum: f64 = weights.iter().sum();
        let weights: Vec<f64> = weights.iter().map(|weight| weight / sum).collect();
        let effective = 1.0 / weights.iter().map(|weight| weight * weight).sum::<f64>();
        let step_path = (effective + 2.0) / (n + effective + 5.0);
        // Ros and Hansen: n numbers are learnt in place of (n^2 + n)/2.
        let faster = (n + 2.0) / 3.0;
        let rank_one = faster * 2.0 / ((n + 1.3) * (n + 1.3) + effective);
        let rank_mu = faster * 2.0 * (effective - 2.0 + 1.0 / effective)
            / ((n + 2.0) * (n + 2.0) + effective);
        let beyond = libm::sqrt((effective - 1.0) / (n + 1.0)) - 1.0;
        Self {
            population,
            weights,
            effective,
            step_path,
            damping: 1.0 + 2.0 * beyond.max(0.0) + step_path,
            scale_path: (4.0 + effective / n) / (n + 4.0 + 2.0 * effective / n),
            rank_one: rank_one.min(1.0),
            rank_mu: rank_mu.min(1.0 - rank_one.min(1.0)),
            length: libm::sqrt(n) * (1.0 - 1.0 / (4.0 * n) + 1.0 / (21.0 * n * n)),
        }
    }
}

/// Points of a generation in so many dimensions.
pub fn population(dimension: usize) -> usize {
    4 + libm::floor(3.0 * libm::log(dimension.max(1) as f64)) as usize
}

impl Evolution {
    /// A round distribution around `mean`, of standard deviation `step`.
    pub fn new(mean: Vec<f64>, step: f64) -> Self {
        let n = mean.len();
        Self {
            mean,
            step,
            scale: vec![1.0; n],
            path_of_step: vec![0.0; n],
            path_of_scale: vec![0.0; n],
            generation: 0,
            constants: Constants::of(n),
        }
    }

    /// Standard deviation of the distribution, but for its shape.
    pub fn step(&self) -> f64 {
        self.step
    }

    /// Tries a generation and moves the distribution; `random` gives its normal numbers from `first` on.
    /// The best point.
    pub fn generation(
        &mut self,
        random: Stream,
        first: u64,
        value: &(impl Fn(&[f64]) -> Option<f64> + Sync),
    ) -> Found {
        let n = self.mean.len();
        let directions: Vec<Vec<f64>> = (0..self.constants.population as u64)
            .map(|k| (0..n as u64).map(|i| random.normal(first + k * n as u64 + i)).collect())
            .collect();
        let mut tried: Vec<(Found, Vec<f64>)> = directions
            .into_par_iter()
            .map(|direction| {
                let axes = self.mean.iter().zip(&self.scale).zip(&direction);
                let point: Vec<f64> =
                    axes.map(|((mean, scale), z)| mean + self.step * scale * z).collect();
                let value = value(&point).filter(|value| !value.is_nan());
                (Found { point, value }, direction)
            })
            .collect();
        // Stable: of equal values the first.
        tried.sort_by(|(a, _), (b, _)| b.order(a));
        self.learn(&tried);
        let (best, _) = tried.swap_remove(0);
        best
    }

    /// Moves the distribution to where the best points lie; `tried` in their order, with the normal
    /// numbers behind each.
    fn learn(&mut self, tried: &[(Found, Vec<f64>)]) {
        self.generation += 1;
        let n = self.mean.len();
        let Constants {
            effective, step_path, scale_path, rank_one, rank_mu, length, damping, ..
        } = self.constants;
        let weighted = |of: &dyn Fn(f64) -> f64| -> Vec<f64> {
            let mut sums = vec![0.0; n];
            for (weight, (_, direction)) in self.constants.weights.iter().zip(tried) {
                sums.iter_mut().zip(direction).for_each(|(sum, z)| *sum += weight * of(*z));
            }
            sums
        };
        let (direction, square) = (weighted(&|z| z), weighted(&|z| z * z));
        let gain = libm::sqrt(step_path * (2.0 - step_path) * effective);
        for (path, z) in self.path_of_step.iter_mut().zip(&direction) {
            *path = (1.0 - step_path) * *path + gain * z;
        }
        let path_length = libm::sqrt(self.path_of_step.iter().map(|x| x * x).sum());
        let settled = 1.0 - libm::pow(1.0 - step_path, 2.0 * self.generation as f64);
        let too_fast = path_length / libm::sqrt(settled) >= (1.4 + 2.0 / (n as f64 + 1.0)) * length;
        let gain =
            if too_fast { 0.0 } else { libm::sqrt(scale_path * (2.0 - scale_path) * effective) };
        for i in 0..n {
            let scale = self.scale[i];
            self.mean[i] += self.step * scale * direction[i];
            self.path_of_scale[i] =
                (1.0 - scale_path) * self.path_of_scale[i] + gain * scale * direction[i];
            let path = self.path_of_scale[i];
            let variance = (1.0 - rank_one - rank_mu) * scale * scale
                + rank_one * path * path
                + rank_mu * scale * scale * square[i];
            self.scale[i] = libm::sqrt(variance);
        }
        self.step *= libm::exp((step_path / damping * (path_length / length - 1.0)).min(1.0));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The best of `generations` on `value` from `mean`.
    fn best(
        value: impl Fn(&[f64]) -> Option<f64> + Sync,
        mean: Vec<f64>,
        generations: u64,
    ) -> Found {
        let mut evolution = Evolution::new(mean.clone(), 0.5);
        let mut best = Found { value: value(&mean), point: mean };
        for generation in 0..generations {
            let first = generation * 1000;
            let found = evolution.generation(Stream::new(1, 0), first, &value);
            if found.order(&best).is_gt() {
                best = found;
            }
        }
        best
    }

    #[test]
    fn narrow_valleys_along_an_axis_are_followed_to_their_end() {
        let ellipsoid = |x: &[f64]| {
            let square = |(i, x): (usize, &f64)| libm::pow(1e6, i as f64 / 7.0) * x * x;
            Some(-x.iter().enumerate().map(square).sum::<f64>())
        };
        assert!(best(ellipsoid, vec![1.0; 8], 600).value.unwrap() > -1e-12);
    }

    #[test]
    fn none_and_no_number_are_less_than_every_number() {
        let half = |x: &[f64]| match x[0] {
            x if x > 0.1 => None,
            x if x > 0.05 => Some(f64::NAN),
            x => Some(x),
        };
        let value = best(half, vec![-1.0, 0.0], 60).value.unwrap();
        assert!((0.049..=0.05).contains(&value), "{value}");
        assert_eq!(best(|_| None, vec![0.0; 3], 20).value, None);
        assert_eq!(best(|x| Some(-x[0] * x[0]), vec![1.0], 60).point.len(), 1);
    }
}
