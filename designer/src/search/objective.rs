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
