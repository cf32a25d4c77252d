//! The figures of a design that people ask for first.

use serde::Serialize;
use steerguard_designer::{Design, DesignStatus};
use steerguard_fmu::BakedDesign;

use crate::table::aligned;

/// Figures of a design.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DesignSummary {
    /// What the design may be called.
    pub status: DesignStatus,
    /// SHA-256 of the design file's content.
    pub hash: String,
    /// Fault sensitivity of the gains, per rad or N m.
    pub beta: f64,
    /// Largest beta that the paper's problem reaches, and what no beta exceeds.
    pub largest_beta: f64,
    /// Closed-form bound on beta.
    pub beta_bound: f64,
    /// Disturbance gain, per unit of the first disturbance.
    pub gamma: f64,
    /// beta / gamma in units of smallest fault and disturbance bound.
    pub gap: f64,
    /// The same, certified a posteriori for the gains as stored; `None` without a certificate.
    pub certified_gap: Option<f64>,
    /// The same at frozen operating points.
    pub frozen_gap: f64,
    /// Smallest eigenvalues of (31), (32), (33) for the gains, all to be positive.
    pub margins: [f64; 3],
    /// Largest spectral radius of the rules at the lowest and the highest speed.
    pub spectral_radii: [f64; 2],
    /// Lowest and highest speed of the design range, m/s.
    pub speeds_m_per_s: [f64; 2],
    /// J_th after the start-up.
    pub threshold: f64,
    /// What J tends to under the smallest fault of interest, at least.
    pub smallest_fault_j: f64,
    /// Margin on the largest fault-free J, and the number of drives that gave it.
    pub threshold_margin: f64,
    /// Fault-free drives behind the threshold.
    pub calibration_drives: usize,
}

impl DesignSummary {
    /// The figures of `design`.
    pub fn of(design: &Design) -> Self {
        let (synthesis, performance) = (&design.synthesis, &design.performance);
        let margins = &design.certificate.margins;
        let [slow_1, slow_2, fast_1, fast_2] = performance.spectral_radii;
        Self {
            status: synthesis.status,
            hash: design.hash.clone(),
            beta: synthesis.beta,
            largest_beta: synthesis.largest_beta.beta,
            beta_bound: synthesis.beta_bound,
            gamma: synthesis.gamma,
            gap: synthesis.gap,
            certified_gap: performance.certified.as_ref().map(|certified| certified.gap),
            frozen_gap: performance.frozen.gap,
            margins: [
                margins.disturbance_attenuation.smallest_eigenvalue,
                margins.fault_sensitivity.smallest_eigenvalue,
                margins.stability.smallest_eigenvalue,
            ],
            spectral_radii: [slow_1.max(slow_2), fast_1.max(fast_2)],
            speeds_m_per_s: design.premise.v_x_m_per_s,
            threshold: design.evaluation.threshold,
            smallest_fault_j: performance.smallest_fault_residual,
            threshold_margin: design.evaluation.margin,
            calibration_drives: design.evaluation.calibration.drives,
        }
    }

    /// Aligned lines for people; `proof` is what a check of the design file said.
    pub fn text(&self, proof: Option<&str>) -> String {
        let [slow, fast] = self.speeds_m_per_s;
        let [at_slow, at_fast] = self.spectral_radii;
        let [at_31, at_32, at_33] = self.margins;
        let rows = [
            ("status", status(self.status).to_owned(), proof.unwrap_or_default().to_owned()),
            (
                "beta",
                format!("{:.6}", self.beta),
                format!("bound {:.6}, largest found {:.6}", self.beta_bound, self.largest_beta),
            ),
            ("gamma", format!("{:.6}", self.gamma), String::new()),
            (
                "gap",
                format!("{:.3}", self.gap),
                format!(
                    "{}at frozen operating points {:.3}",
                    self.certified_gap.map_or(String::new(), |gap| format!("certified {gap:.3}, ")),
                    self.frozen_gap
                ),
            ),
            (
                "least eigenvalue",
                format!("{:.2e}", at_31.min(at_32).min(at_33)),
                format!("(31) {at_31:.2e}, (32) {at_32:.2e}, (33) {at_33:.2e}"),
            ),
            (
                "spectral radius",
                format!("{:.4}", at_slow.max(at_fast)),
                format!("{at_slow:.4} at {slow} m/s, {at_fast:.4} at {fast} m/s"),
            ),
            (
                "threshold J_th",
                format!("{:.6}", self.threshold),
                format!(
                    "{} x the largest J of {} fault-free drives",
                    self.threshold_margin, self.calibration_drives
                ),
            ),
        ];
        let rows = rows.map(|(name, value, remark)| vec![name.to_owned(), value, remark]);
        aligned(&rows, "  ")
    }
}

/// A status in words.
pub fn status(status: DesignStatus) -> &'static str {
    match status {
        DesignStatus::Certified => "certified",
        DesignStatus::Uncertified => "not certified",
        DesignStatus::AlmostSolved => "almost solved, not certified",
    }
}

/// What is baked into the FMU.
///
/// # Errors
/// The design's hash, if it is not the 64 digits of a SHA-256.
pub fn baked(design: &Design) -> Result<BakedDesign, String> {
    Ok(BakedDesign {
        hash: design.hash.as_bytes().try_into().map_err(|_| design.hash.clone())?,
        beta: design.synthesis.beta,
        gamma: design.synthesis.gamma,
        gap: design.synthesis.gap,
        configuration: design.configuration(),
    })
}
