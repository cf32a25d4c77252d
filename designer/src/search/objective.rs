//! What the search maximises: the detection ratio at frozen operating points.

use nalgebra::Complex;
use steerguard_detector::{C, Gains, RULES, TsModel};

use crate::analysis::frequency::{detection_ratio, noise_rms};
use crate::analysis::operating_point::{
    Column, FrozenError, OperatingPoint, extreme_gains, spectral_radius,
};
use crate::lmi::matrix::{Matrix, matrix};
use crate::problem::band::Band;
use crate::problem::inputs::Inputs;
use crate::synthesis::gains::ObserverGains;
use crate::synthesis::theorem4::Theorem4;

/// Price of a mode that decays too slowly.
const PENALTY: f64 = 1e3;
/// Price of a residual whose scale drifts, by the square of its logarithm.
const DRIFT_PRICE: f64 = 0.01;
/// Modes no slower than this keep their noise in the search.
const STABLE: f64 = 0.995;
/// Frequencies across a low band, and across others.
const LOW_FREQUENCIES: u32 = 3;
const OTHER_FREQUENCIES: u32 = 15;

/// beta, gamma and noise, each at its worst operating point.
#[derive(Clone, Copy, Debug)]
pub(super) struct Worst {
    beta: f64,
    gamma: f64,
    noise_rms: f64,
}

impl Worst {
    pub(super) fn ratio(self, inputs: &Inputs) -> f64 {
        detection_ratio(self.beta, self.gamma, self.noise_rms, inputs)
    }
}

/// What the search maximises.
pub(super) struct Objective<'a> {
    points: Vec<OperatingPoint>,
    pub(super) inputs: &'a Inputs,
    /// The beta that refined gains are held near: the ratio does not change with the residual's
    /// scale.
    scale: f64,
    fault_frequencies: Vec<f64>,
    disturbance_frequencies: Vec<Vec<f64>>,
}

impl<'a> Objective<'a> {
    pub(super) fn new(model: &TsModel, inputs: &'a Inputs, scale: f64) -> Self {
        let frequencies = |band: Band| match band {
            Band::Low(_) => band.grid(LOW_FREQUENCIES).collect(),
            _ => band.grid(OTHER_FREQUENCIES).collect(),
        };
        Self {
            points: OperatingPoint::coarse_grid(model),
            inputs,
            scale,
            fault_frequencies: frequencies(inputs.fault.band),
            disturbance_frequencies: inputs
                .disturbances
                .iter()
                .map(|channel| frequencies(channel.band))
                .collect(),
        }
    }

    /// beta and gamma squared at a point. None where a frequency is an eigenvalue.
    fn at(&self, error: &FrozenError) -> Option<[f64; 2]> {
        let output = error.output.map(Complex::from);
        let extremes = |columns: &[Column], w| {
            let to_residual = output * error.resolvent(w)?;
            Some(extreme_gains(columns.iter().map(|(b, d)| to_residual * b + d)))
        };
        let mut beta = f64::INFINITY;
        let fault = error.columns(&self.inputs.fault);
        for &w in &self.fault_frequencies {
            beta = beta.min(extremes(&fault, w)?[1]);
        }
        let mut gamma_squared = 0.0;
        for (channel, frequencies) in
            self.inputs.disturbances.iter().zip(&self.disturbance_frequencies)
        {
            let columns = error.columns(channel);
            let mut gamma = 0.0_f64;
            for &w in frequencies {
                gamma = gamma.max(extremes(&columns, w)?[0]);
            }
            gamma_squared += gamma * gamma;
        }
        Some([beta, gamma_squared])
    }

    /// The worst figures of `gains`.
    pub(super) fn worst(&self, gains: &Gains) -> Worst {
        let none = Worst { beta: 0.0, gamma: f64::INFINITY, noise_rms: f64::INFINITY };
        let mut worst = Worst { beta: f64::INFINITY, gamma: 0.0, noise_rms: 0.0 };
        for point in &self.points {
            let error = FrozenError::new(point, gains, self.inputs.weights);
            let Some([beta, gamma_squared]) = self.at(&error) else { return none };
            worst.beta = worst.beta.min(beta);
            worst.gamma = worst.gamma.max(gamma_squared.sqrt());
            worst.noise_rms = worst.noise_rms.max(noise_rms(&error, self.inputs.white_std));
        }
        worst
    }

    /// A smooth cost near `-ln` of the detection ratio: sums of powers in place of extremes, and a
    /// price on modes slower than `slowest`.
    pub(super) fn cost(&self, gains: &Gains, exponent: f64, slowest: f64) -> f64 {
        let (mut ln_beta, mut ln_gamma, mut ln_noise) = (vec![], vec![], vec![]);
        let mut penalty = 0.0;
        for point in &self.points {
            let error = FrozenError::new(point, gains, self.inputs.weights);
            let radius = spectral_radius(&error.n);
            penalty += PENALTY * (radius - slowest).max(0.0).powi(2);
            // Beyond stability the noise goes on growing with the gains, not to infinity: the line
            // search can turn back.
            let contracted = FrozenError { n: error.n * f64::min(1.0, STABLE / radius), ..error };
            let Some([beta, gamma_squared]) = self.at(&error) else {
                return f64::INFINITY;
            };
            let variance = noise_rms(&contracted, self.inputs.white_std).powi(2);
            ln_beta.push(beta.ln());
            ln_gamma.push(gamma_squared.ln());
            ln_noise.push(variance.ln());
        }
        let smallest = -soft_maximum(ln_beta.iter().map(|x| -x), exponent);
        let largest = |x: &[f64]| soft_maximum(x.iter().copied(), exponent / 2.0).exp();
        let bound = self.inputs.bound;
        let background = largest(&ln_gamma) * bound * bound + largest(&ln_noise);
        let ratio = smallest + self.inputs.smallest_fault.ln() - background.ln() / 2.0;
        let scale = smallest - self.scale.ln();
        penalty + DRIFT_PRICE * scale * scale - ratio
    }
}

impl Objective<'_> {
    /// Gains with the same ratio whose beta is that of the scale: with T = diag(s, 1, s) in place of
    /// the error e stands T e, N_i becomes T N_i T^-1 and M becomes T M, which keeps its second
    /// column, and N_i's that of M A_i; the residual becomes s r. G rho acts on v_y alone, which T
    /// leaves as it is.
    pub(super) fn to_scale(&self, gains: &ObserverGains, theorem: &Theorem4) -> ObserverGains {
        let s = self.scale / self.worst(&gains.gains).beta;
        if !s.is_normal() {
            return *gains;
        }
        let t = |k: usize| if k == 1 { 1.0 } else { s };
        let c = matrix(&C);
        let m = matrix(&gains.gains.m);
        let scaled_m = Matrix::from_fn(3, 3, |row, k| t(row) * m[(row, k)]);
        let e = (&scaled_m - Matrix::identity(3, 3)) * c.transpose();
        let h: [Matrix; RULES] = std::array::from_fn(|i| {
            let n = matrix(&gains.gains.n[i]);
            let n = Matrix::from_fn(3, 3, |row, k| t(row) * n[(row, k)] / t(k));
            (&scaled_m * &theorem.a[i] - n) * c.transpose() // (35)
        });
        ObserverGains::new(&e, &h, &theorem.a)
    }
}

/// `ln (sum exp(k x))^(1/k)`, near the largest x.
fn soft_maximum(x: impl Iterator<Item = f64> + Clone, k: f64) -> f64 {
    let largest = x.clone().fold(f64::NEG_INFINITY, f64::max);
    if !largest.is_finite() {
        return largest;
    }
    largest + x.map(|x| (k * (x - largest)).exp()).sum::<f64>().ln() / k
}
