//! What the search maximises: the detection ratio at frozen operating points.

use nalgebra::Complex;
use steerguard_detector::{C, Gains, RULES, TsModel};

use crate::analysis::estimate;
use crate::analysis::frequency::{detection_ratio, noise_rms};
use crate::analysis::operating_point::{Column, FrozenError, OperatingPoint, extreme_gains};
use crate::lmi::matrix::{Matrix, matrix};
use crate::problem::band::Band;
use crate::problem::inputs::Inputs;
use crate::synthesis::gains::ObserverGains;
use crate::synthesis::theorem4::Theorem4;

/// Largest shift of e_2 tried, m/s per rad/s.
const LARGEST_SHIFT_M: f64 = 300.0;
/// Steps of the search for the best one, each to two thirds.
const TRISECTIONS: u32 = 40;
/// Frequencies across a low band, and across others.
const LOW_FREQUENCIES: u32 = 3;
const OTHER_FREQUENCIES: u32 = 24;

/// beta, gamma and noise, each at its worst operating point.
#[derive(Clone, Copy, Debug)]
pub(super) struct Worst {
    beta: f64,
    gamma: f64,
    noise_rms: f64,
    /// Largest |e_2| after a unit step of the fault.
    peak: f64,
}

impl Worst {
    pub(super) fn ratio(self, inputs: &Inputs) -> f64 {
        detection_ratio(self.beta, self.gamma, self.noise_rms, inputs)
    }

    /// By how much e_2 exceeds the cap: 1 where it does not.
    pub(super) fn excess(self, cap: Option<f64>) -> f64 {
        cap.map_or(1.0, |cap| (self.peak / cap).max(1.0))
    }
}

/// What the search maximises.
pub(super) struct Objective<'a> {
    pub(super) points: Vec<OperatingPoint>,
    /// The vertices of premise and rho.
    pub(super) vertices: Vec<OperatingPoint>,
    pub(super) inputs: &'a Inputs,
    /// The beta that refined gains are held near: the ratio does not change with the residual's
    /// scale.
    pub(super) scale: f64,
    /// What a unit step of the fault may make of e_2, if it is held.
    pub(super) cap: Option<f64>,
    pub(super) fault_frequencies: Vec<f64>,
    pub(super) disturbance_frequencies: Vec<Vec<f64>>,
}

impl<'a> Objective<'a> {
    pub(super) fn new(model: &TsModel, inputs: &'a Inputs, scale: f64, cap: Option<f64>) -> Self {
        let frequencies = |band: Band| match band {
            Band::Low(_) => band.grid(LOW_FREQUENCIES).collect(),
            // Closer together where they are low, as the modes are.
            _ => {
                let [from, to] = band.limits();
                let share = |k| (f64::from(k) / f64::from(OTHER_FREQUENCIES)).powi(2);
                (0..=OTHER_FREQUENCIES).map(|k| from + (to - from) * share(k)).collect()
            }
        };
        Self {
            points: OperatingPoint::coarse_grid(model),
            vertices: OperatingPoint::vertices(model),
            inputs,
            scale,
            cap,
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
        let none = Worst {
            beta: 0.0,
            gamma: f64::INFINITY,
            noise_rms: f64::INFINITY,
            peak: f64::INFINITY,
        };
        let mut worst = Worst { beta: f64::INFINITY, gamma: 0.0, noise_rms: 0.0, peak: 0.0 };
        for point in &self.points {
            let error = FrozenError::new(point, gains, self.inputs.weights);
            let Some([beta, gamma_squared]) = self.at(&error) else { return none };
            worst.beta = worst.beta.min(beta);
            worst.gamma = worst.gamma.max(gamma_squared.sqrt());
            worst.noise_rms = worst.noise_rms.max(noise_rms(&error, self.inputs.white_std));
            worst.peak = worst.peak.max(estimate::peak(&error, &self.inputs.fault));
        }
        worst
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
        let diagonal = |t: &dyn Fn(usize) -> f64| {
            Matrix::from_fn(3, 3, |row, k| if row == k { t(k) } else { 0.0 })
        };
        transformed(gains, theorem, &diagonal(&t), &diagonal(&|k| 1.0 / t(k)))
    }

    /// Gains with nearly the same residual whose e_2 after a step of the fault is the smallest: with
    /// `e_2 + t e_3` in place of e_2, that is with T = I + t [0 1 0]' [0 0 1], the residual stays what it
    /// is but for rho, which acts on e_2 and is small. The largest |e_2 + t e_3| is convex in t.
    pub(super) fn with_least_e_2(
        &self,
        gains: &ObserverGains,
        theorem: &Theorem4,
    ) -> ObserverGains {
        if self.cap.is_none() {
            return *gains;
        }
        let shifted = |t: f64| {
            let of = |t: f64| {
                let mut matrix = Matrix::identity(3, 3);
                matrix[(1, 2)] = t;
                matrix
            };
            transformed(gains, theorem, &of(t), &of(-t))
        };
        let peak = |t: f64| self.worst(&shifted(t).gains).peak;
        let [mut from, mut to] = [-LARGEST_SHIFT_M, LARGEST_SHIFT_M];
        for _ in 0..TRISECTIONS {
            let third = (to - from) / 3.0;
            if peak(from + third) < peak(to - third) { to -= third } else { from += third }
        }
        let least = shifted((from + to) / 2.0);
        let better = self.worst(&least.gains).peak < self.worst(&gains.gains).peak;
        if better { least } else { *gains }
    }
}

/// The observer of T e in place of e: T N_i T^-1 and T M, where T keeps M's second column.
fn transformed(
    gains: &ObserverGains,
    theorem: &Theorem4,
    t: &Matrix,
    inverse: &Matrix,
) -> ObserverGains {
    let c = matrix(&C);
    let m = t * matrix(&gains.gains.m);
    let e = (&m - Matrix::identity(3, 3)) * c.transpose();
    let h: [Matrix; RULES] = std::array::from_fn(|i| {
        (&m * &theorem.a[i] - t * matrix(&gains.gains.n[i]) * inverse) * c.transpose() // (35)
    });
    ObserverGains::new(&e, &h, &theorem.a)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::problem::model;
    use crate::search::starts::starts;
    use crate::spec::Spec;

    /// What e_2 is measured from is free: gains that lose v_y are led back, and their residual stays.
    #[test]
    fn e_2_is_brought_back_without_the_residual() {
        let spec = Spec::default();
        let inputs = Inputs::of(&spec).unwrap_or_else(|mistakes| panic!("{mistakes}"));
        let theorem = Theorem4::of(&spec, &inputs, 0.97);
        let cap = Some(1.0);
        let objective = Objective::new(&model::model(&spec), &inputs, 0.3, cap);
        let gains = starts(&theorem)[0];
        let mut shift = Matrix::identity(3, 3);
        shift[(1, 2)] = 25.0;
        let inverse = shift.clone().try_inverse().unwrap_or_default();
        let lost = transformed(&gains, &theorem, &shift, &inverse);
        assert!(lost.observer_equation_error(&theorem.a) < 1e-10);
        let back = objective.with_least_e_2(&lost, &theorem);
        let [gains, lost, back] = [gains, lost, back].map(|x| objective.worst(&x.gains));
        assert!(lost.peak > 3.0 * gains.peak, "{lost:?} {gains:?}");
        assert!(back.peak <= gains.peak, "{back:?} {gains:?}");
        let ratio = back.ratio(&inputs) / lost.ratio(&inputs);
        assert!((ratio - 1.0).abs() < 0.05, "{ratio}");
    }
}
