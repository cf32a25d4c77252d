//! Exact confidence intervals, and quantiles of delays.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use statrs::distribution::{Beta, ContinuousCDF, Gamma};

/// Confidence of the intervals, and of the one-sided bound.
pub const CONFIDENCE: f64 = 0.95;

/// An estimate with its two-sided interval of [`CONFIDENCE`].
#[derive(Clone, Copy, Debug, PartialEq, JsonSchema, Serialize, Deserialize)]
pub struct Estimate {
    /// The estimate.
    pub value: f64,
    /// Lower end.
    pub lower: f64,
    /// Upper end.
    pub upper: f64,
}

/// Quantile of the beta distribution, 0 or 1 where a parameter is 0.
fn beta_quantile(a: f64, b: f64, p: f64) -> f64 {
    match Beta::new(a, b) {
        Ok(beta) => beta.inverse_cdf(p),
        Err(_) if a <= 0.0 => 0.0,
        Err(_) => 1.0,
    }
}

/// A probability from `hits` in `trials`, with Clopper and Pearson's (1934) interval; `None` without
/// trials.
pub fn probability(hits: u64, trials: u64) -> Option<Estimate> {
    if trials == 0 {
        return None;
    }
    let (k, n) = (hits as f64, trials as f64);
    let tail = (1.0 - CONFIDENCE) / 2.0;
    Some(Estimate {
        value: k / n,
        lower: beta_quantile(k, n - k + 1.0, tail),
        upper: beta_quantile(k + 1.0, n - k, 1.0 - tail),
    })
}

/// Lower bound of [`CONFIDENCE`] on a probability: Clopper and Pearson's, one-sided.
pub fn probability_at_least(hits: u64, trials: u64) -> f64 {
    let (k, n) = (hits as f64, trials as f64);
    beta_quantile(k, n - k + 1.0, 1.0 - CONFIDENCE)
}

/// Quantile of the gamma distribution with rate 1.
fn gamma_quantile(shape: f64, p: f64) -> f64 {
    Gamma::new(shape, 1.0).map_or(0.0, |gamma| gamma.inverse_cdf(p))
}

/// Events an hour from `events` in `hours`, with Garwood's (1936) interval of a Poisson process;
/// `None` without time.
pub fn rate_per_hour(events: u64, hours: f64) -> Option<Estimate> {
    if hours <= 0.0 {
        return None;
    }
    let k = events as f64;
    let tail = (1.0 - CONFIDENCE) / 2.0;
    Some(Estimate {
        value: k / hours,
        lower: gamma_quantile(k, tail) / hours,
        upper: gamma_quantile(k + 1.0, 1.0 - tail) / hours,
    })
}

/// The smallest of `values` that at least the share `p` of them does not exceed. A `None` is larger
/// than any number.
pub fn quantile(values: &mut [Option<f64>], p: f64) -> Option<f64> {
    values.sort_by(|a, b| match (a, b) {
        (Some(a), Some(b)) => a.total_cmp(b),
        (a, b) => b.is_some().cmp(&a.is_some()),
    });
    let rank = (p * values.len() as f64).ceil().max(1.0) as usize;
    values.get(rank - 1).copied().flatten()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(a: f64, b: f64) {
        assert!((a - b).abs() < 1e-6 * b.abs().max(1e-3), "{a} instead of {b}");
    }

    /// Ends solve the equations that define them, summed term by term.
    #[test]
    fn probabilities_have_the_interval_of_clopper_and_pearson() {
        let binomial = |n: u64, k: u64, p: f64| {
            let ways = (0..k).fold(1.0, |c, i| c * (n - i) as f64 / (i + 1) as f64);
            ways * p.powi(k as i32) * (1.0 - p).powi((n - k) as i32)
        };
        for (k, n) in [(1, 10), (7, 10), (3, 40), (19, 20)] {
            let estimate = probability(k, n).unwrap();
            let at_least: f64 = (k..=n).map(|i| binomial(n, i, estimate.lower)).sum();
            let at_most: f64 = (0..=k).map(|i| binomial(n, i, estimate.upper)).sum();
            close(at_least, 0.025);
            close(at_most, 0.025);
        }
        let none = probability(0, 100).unwrap();
        assert_eq!(none.lower, 0.0);
        close(none.upper, 1.0 - 0.025_f64.powf(0.01));
        assert_eq!(probability(100, 100).unwrap().upper, 1.0);
        assert_eq!(probability(0, 0), None);
    }

    #[test]
    fn a_hundredth_is_excluded_by_299_of_299() {
        assert!(probability_at_least(299, 299) >= 0.99);
        assert!(probability_at_least(298, 298) < 0.99);
        assert!(probability_at_least(472, 473) >= 0.99);
        assert!(probability_at_least(471, 472) < 0.99);
        assert_eq!(probability_at_least(0, 10), 0.0);
    }

    #[test]
    fn rates_have_garwoods_interval() {
        let poisson = |k: u32, mean: f64| {
            (-mean).exp() * (1..=k).fold(1.0, |term, i| term * mean / f64::from(i))
        };
        let none = rate_per_hour(0, 10.0).unwrap();
        assert_eq!((none.value, none.lower), (0.0, 0.0));
        close(none.upper, -(0.025_f64.ln()) / 10.0);
        for k in [1_u32, 4, 20] {
            let estimate = rate_per_hour(k.into(), 2.0).unwrap();
            let at_most: f64 = (0..=k).map(|i| poisson(i, 2.0 * estimate.upper)).sum();
            let fewer: f64 = (0..k).map(|i| poisson(i, 2.0 * estimate.lower)).sum();
            close(at_most, 0.025);
            close(1.0 - fewer, 0.025);
        }
        assert_eq!(rate_per_hour(0, 0.0), None);
    }

    #[test]
    fn quantiles_count_what_never_came_as_latest() {
        let mut delays = [Some(3.0), None, Some(1.0), Some(2.0)];
        assert_eq!(quantile(&mut delays, 0.5), Some(2.0));
        assert_eq!(quantile(&mut delays, 0.75), Some(3.0));
        assert_eq!(quantile(&mut delays, 0.95), None);
        assert_eq!(quantile(&mut [], 0.5), None);
    }
}
