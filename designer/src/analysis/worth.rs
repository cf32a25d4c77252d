//! What gains are worth: their figures at frozen operating points and their certificate.

use steerguard_detector::TsModel;

use crate::analysis::certified::{APosteriori, CertifiedFigures, certified};
use crate::analysis::frequency::{Frozen, PointFigures, at_point, detection_ratio, frozen};
use crate::analysis::operating_point::OperatingPoint;
use crate::problem::inputs::Inputs;
use crate::synthesis::gains::ObserverGains;
use crate::synthesis::theorem4::Theorem4;

/// The figures of gains.
#[derive(Clone, Debug)]
pub struct Worth {
    /// At every operating point of the grid.
    pub points: Vec<PointFigures>,
    /// Worst gains over the grid.
    pub frozen: Frozen,
    /// Largest RMS of the weighted residual under white noise over the grid.
    pub noise_rms: f64,
    /// The certified figures and their matrices, if the solver found them.
    pub certified: Option<(CertifiedFigures, APosteriori)>,
}

impl Worth {
    /// The figures of `gains`.
    pub fn of(gains: &ObserverGains, theorem: &Theorem4, model: &TsModel, inputs: &Inputs) -> Self {
        let points = OperatingPoint::grid(model);
        let frozen = frozen(&points, &gains.gains, inputs);
        let points: Vec<_> =
            points.iter().map(|point| at_point(point, &gains.gains, inputs)).collect();
        let noise_rms = points.iter().map(|x| x.noise_rms).fold(0.0, f64::max);
        let certified = certified(theorem, gains, &frozen, inputs).ok();
        Self { points, frozen, noise_rms, certified }
    }

    /// [`detection_ratio`] of the frozen figures.
    pub fn detection_ratio(&self, inputs: &Inputs) -> f64 {
        detection_ratio(self.frozen.beta, self.frozen.gamma, self.noise_rms, inputs)
    }

    /// [`detection_ratio`] of the certified gains; 0 without a certificate.
    pub fn certified_ratio(&self, inputs: &Inputs) -> f64 {
        self.certified.as_ref().map_or(0.0, |(certified, _)| {
            detection_ratio(certified.beta, certified.gamma, self.noise_rms, inputs)
        })
    }
}
