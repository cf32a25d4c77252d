//! Maximisation by a covariance matrix adaptation evolution strategy.
//!
//! The strategy of Hansen and Ostermeier (2001) with cumulative step-size adaptation, rank-one and rank-mu
//! update, on a triangular factor of the covariance: Krause, Arbones and Igel (2016), "CMA-ES with optimal
//! covariance update and storage complexity". Constants by Hansen (2016), "The CMA evolution strategy: a
//! tutorial", but for positive weights alone.
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

/// The search distribution, `mean + step A N(0, I)`, and its paths.
pub struct Evolution {
    mean: Vec<f64>,
    step: f64,
    /// A, lower triangular, row by row.
    factor: Vec<Vec<f64>>,
    path_of_step: Vec<f64>,
    path_of_factor: Vec<f64>,
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
    factor_path: f64,
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
        let rank_one = 2.0 / ((n + 1.3) * (n + 1.3) + effective);
        let rank_mu = 2.0 * (effective - 2.0 + 1.0 / effective)
            / ((n + 2.0) * (n + 2.0) + effective);
        let beyond = libm::sqrt((effective - 1.0) / (n + 1.0)) - 1.0;
        Self {
            population,
            weights,
            effective,
            step_path,
            damping: 1.0 + 2.0 * beyond.max(0.0) + step_path,
            factor_path: (4.0 + effective / n) / (n + 4.0 + 2.0 * effective / n),
            rank_one,
            rank_mu: rank_mu.min(1.0 - rank_one),
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
        let row = |i: usize| (0..=i).map(|j| if i == j { 1.0 } else { 0.0 }).collect();
        Self {
            mean,
            step,
            factor: (0..n).map(row).collect(),
            path_of_step: vec![0.0; n],
            path_of_factor: vec![0.0; n],
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
                let point: Vec<f64> =
                    self.mean.iter().zip(self.turned(&direction)).map(|(m, y)| m + self.step * y).collect();
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

    /// A times `direction`.
    fn turned(&self, direction: &[f64]) -> Vec<f64> {
        let row = |row: &Vec<f64>| row.iter().zip(direction).map(|(a, z)| a * z).sum();
        self.factor.iter().map(row).collect()
    }

    /// Moves the distribution to where the best points lie; `tried` in their order, with the normal
    /// numbers behind each.
    fn learn(&mut self, tried: &[(Found, Vec<f64>)]) {
        self.generation += 1;
        let n = self.mean.len();
        let Constants { effective, step_path, factor_path, rank_one, rank_mu, length, damping, .. } =
            self.constants;
        let mut direction = vec![0.0; n];
        for (weight, (_, z)) in self.constants.weights.iter().zip(tried) {
            direction.iter_mut().zip(z).for_each(|(sum, z)| *sum += weight * z);
        }
        let shift = self.turned(&direction);
        let gain = libm::sqrt(step_path * (2.0 - step_path) * effective);
        for (path, z) in self.path_of_step.iter_mut().zip(&direction) {
            *path = (1.0 - step_path) * *path + gain * z;
        }
        let path_length = libm::sqrt(self.path_of_step.iter().map(|x| x * x).sum());
        let settled = 1.0 - libm::pow(1.0 - step_path, 2.0 * self.generation as f64);
        let stalled = path_length / libm::sqrt(settled) >= (1.4 + 2.0 / (n as f64 + 1.0)) * length;
        let gain = if stalled {
            0.0
        } else {
            libm::sqrt(factor_path * (2.0 - factor_path) * effective)
        };
        for (path, y) in self.path_of_factor.iter_mut().zip(&shift) {
            *path = (1.0 - factor_path) * *path + gain * y;
        }
        let best: Vec<(f64, Vec<f64>)> = self
            .constants
            .weights
            .iter()
            .zip(tried)
            .map(|(weight, (_, z))| (rank_mu * weight, self.turned(z)))
            .collect();
        for (mean, y) in self.mean.iter_mut().zip(&shift) {
            *mean += self.step * y;
        }
        let kept = libm::sqrt(1.0 - rank_one - rank_mu);
        self.factor.iter_mut().flatten().for_each(|a| *a *= kept);
        add_outer_product(&mut self.factor, rank_one, self.path_of_factor.clone());
        for (weight, y) in best {
            add_outer_product(&mut self.factor, weight, y);
        }
        self.step *= libm::exp((step_path / damping * (path_length / length - 1.0)).min(1.0));
    }
}

/// Makes the triangular A of `A A'` that of `A A' + weight v v'`, `weight` positive: Krause and others
/// (2016), algorithm 3.1.
fn add_outer_product(factor: &mut [Vec<f64>], weight: f64, mut v: Vec<f64>) {
    let mut b = 1.0;
    for j in 0..factor.len() {
        let (old, alpha) = (factor[j][j], v[j]);
        let gamma = old * old * b + weight * alpha * alpha;
        let new = libm::sqrt(old * old + weight / b * alpha * alpha);
        for k in j + 1..factor.len() {
            v[k] -= alpha / old * factor[k][j];
            factor[k][j] = new / old * factor[k][j] + new * weight * alpha / gamma * v[k];
        }
        factor[j][j] = new;
        b += weight * alpha * alpha / (old * old);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The best of `generations` on `value` from `mean`.
    fn best(value: impl Fn(&[f64]) -> Option<f64> + Sync, mean: Vec<f64>, generations: u64) -> Found {
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
    fn a_factor_takes_an_outer_product() {
        let mut factor = vec![vec![2.0], vec![0.5, 1.5], vec![-1.0, 0.25, 3.0]];
        let product = |factor: &[Vec<f64>], i: usize, j: usize| -> f64 {
            factor[i].iter().zip(&factor[j]).map(|(a, b)| a * b).sum()
        };
        let before = factor.clone();
        let v = [1.0, -2.0, 0.5];
        add_outer_product(&mut factor, 0.7, v.to_vec());
        for i in 0..3 {
            for j in 0..3 {
                let expected = product(&before, i, j) + 0.7 * v[i] * v[j];
                assert!((product(&factor, i, j) - expected).abs() < 1e-14);
            }
        }
    }

    #[test]
    fn narrow_and_curved_valleys_are_followed_to_their_end() {
        let ellipsoid = |x: &[f64]| {
            let square = |(i, x): (usize, &f64)| libm::pow(1e6, i as f64 / 7.0) * x * x;
            Some(-x.iter().enumerate().map(square).sum::<f64>())
        };
        assert!(best(ellipsoid, vec![1.0; 8], 600).value.unwrap() > -1e-12);
        let rosenbrock = |x: &[f64]| {
            let term = |x: &[f64]| {
                let [a, b] = [x[0], x[1]];
                100.0 * (b - a * a) * (b - a * a) + (1.0 - a) * (1.0 - a)
            };
            Some(-x.windows(2).map(term).sum::<f64>())
        };
        assert!(best(rosenbrock, vec![0.0; 6], 800).value.unwrap() > -1e-12);
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
