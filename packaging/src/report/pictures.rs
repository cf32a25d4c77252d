//! What the figures of a page show: computed from the design, the same for the same design.

use std::f64::consts::PI;

use steerguard_designer::analysis::frequency::at_frequency;
use steerguard_designer::analysis::operating_point::{FrozenError, OperatingPoint};
use steerguard_designer::problem::inputs::Inputs;
use steerguard_designer::sight::{Moment, course};
use steerguard_designer::threshold::{SteadyThreshold, steady, steady_points};
use steerguard_designer::{Design, spec};
use steerguard_detector::ConfigurationError;

/// Speeds over the armed range at which threshold and poles are taken.
const SPEEDS: u32 = 13;
/// Frequencies a decade, and the lowest, Hz.
const FREQUENCIES_A_DECADE: f64 = 30.0;
const LOWEST_HZ: f64 = 0.01;
/// The fault that is driven, in smallest ones.
const SMALLEST_FAULTS: f64 = 2.0;

/// What the figures show of a design.
#[derive(Clone, Debug, PartialEq)]
pub struct Pictures {
    /// Drives with a fault, at low, middle and high speed; none where the fault is one of the drive torque.
    pub drives: Vec<FaultDrive>,
    /// The threshold over speed, straight ahead, then in a turn.
    pub thresholds: [Vec<SteadyThreshold>; 2],
    /// Residuals over frequency.
    pub frequencies: Vec<Residuals>,
    /// The bands of the fault and of each block of disturbances, Hz.
    pub bands_hz: Vec<(String, [f64; 2])>,
    /// The certified residuals in their bands: of the smallest fault at least, of disturbances at their bounds at
    /// most; none without a certificate.
    pub certified: Option<[f64; 2]>,
    /// Speed in m/s, and magnitudes of the error's poles straight ahead.
    pub poles: Vec<(f64, [f64; 3])>,
}

/// A drive of the verdict on sight.
#[derive(Clone, Debug, PartialEq)]
pub struct FaultDrive {
    /// Speed, m/s.
    pub v_x_m_per_s: f64,
    /// The fault, deg.
    pub fault_deg: f64,
    /// When it begins, s.
    pub onset_s: f64,
    /// The drive.
    pub moments: Vec<Moment>,
}

/// The weighted residual at a frequency, the worst over the operating points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Residuals {
    /// Frequency, Hz.
    pub hz: f64,
    /// Of the smallest fault, the least.
    pub fault: f64,
    /// Of the disturbances at their bounds, the largest; 0 outside their bands.
    pub disturbances: f64,
}

impl Pictures {
    /// Of `design`.
    ///
    /// # Errors
    /// [`ConfigurationError`] if the detector cannot run on its numbers.
    pub fn of(design: &Design) -> Result<Self, ConfigurationError> {
        let (frequencies, bands_hz, certified) = over_frequency(design);
        Ok(Self {
            drives: drives(design)?,
            thresholds: thresholds(design),
            frequencies,
            bands_hz,
            certified,
            poles: poles(design),
        })
    }
}

fn drives(design: &Design) -> Result<Vec<FaultDrive>, ConfigurationError> {
    let (Some(sight), spec::Fault::Steering { smallest_deg, .. }) =
        (&design.performance.sight, design.spec.fault[0])
    else {
        return Ok(Vec::new());
    };
    let fault_deg = SMALLEST_FAULTS * smallest_deg;
    let points = steady_points(&design.detector).into_iter().enumerate();
    let straight = points.filter(|(_, [_, a_y])| *a_y == 0.0);
    straight
        .map(|(number, [v_x_m_per_s, _])| {
            let moments = course(&design.spec, &design.detector, number, fault_deg)?;
            Ok(FaultDrive { v_x_m_per_s, fault_deg, onset_s: sight.onset_s, moments })
        })
        .collect()
}

/// Evenly spread over the armed range.
fn speeds(design: &Design) -> impl Iterator<Item = f64> {
    let range = design.detector.model.range.shrunk(design.detector.hysteresis).v_x;
    let step = (range.max - range.min) / f64::from(SPEEDS - 1);
    (0..SPEEDS).map(move |k| range.min + step * f64::from(k))
}

fn thresholds(design: &Design) -> [Vec<SteadyThreshold>; 2] {
    let most = |[_, a_y]: [f64; 2]| a_y;
    let turn = steady_points(&design.detector).into_iter().map(most).fold(0.0, f64::max);
    let r_max = design.detector.model.range.shrunk(design.detector.hysteresis).r.max;
    [0.0, turn].map(|a_y| {
        speeds(design).map(|v_x| steady(&design.detector, v_x, a_y.min(v_x * r_max))).collect()
    })
}

type OverFrequency = (Vec<Residuals>, Vec<(String, [f64; 2])>, Option<[f64; 2]>);

fn over_frequency(design: &Design) -> OverFrequency {
    // A design's specification has been checked.
    let Ok(inputs) = Inputs::of(&design.spec) else {
        return OverFrequency::default();
    };
    let detector = &design.detector;
    let points = OperatingPoint::coarse_grid(&detector.model);
    let period_s = detector.model.sampling_period_s;
    let nyquist_hz = 0.5 / period_s;
    let steps = ((nyquist_hz / LOWEST_HZ).log10() * FREQUENCIES_A_DECADE).ceil();
    let hz = (0..=steps as u32)
        .map(|k| LOWEST_HZ * 10_f64.powf(f64::from(k) / FREQUENCIES_A_DECADE))
        .map(|hz| hz.min(nyquist_hz));
    let residuals = hz.filter_map(|hz| {
        let w = (2.0 * PI * hz * period_s).min(PI);
        let [fault, disturbances] = at_frequency(&points, &detector.gains, &inputs, w)?;
        Some(Residuals {
            hz,
            fault: fault * inputs.smallest_fault,
            disturbances: disturbances * inputs.bound,
        })
    });
    let in_hz = |[from, to]: [f64; 2]| [from, to].map(|w| w / (2.0 * PI * period_s));
    let fault_band = (String::from("fault"), in_hz(inputs.fault.band.limits()));
    let others = inputs.disturbances.iter();
    let others = others.map(|x| (String::from("disturbance"), in_hz(x.band.limits())));
    let certified = design.performance.certified.as_ref();
    (
        residuals.collect(),
        std::iter::once(fault_band).chain(others).collect(),
        certified.map(|x| [x.beta * inputs.smallest_fault, x.gamma * inputs.bound]),
    )
}

fn poles(design: &Design) -> Vec<(f64, [f64; 3])> {
    let detector = &design.detector;
    let at = |v_x: f64| {
        let point = OperatingPoint::new(&detector.model, [v_x, 0.0, 0.0]);
        let error = FrozenError::new(&point, &detector.gains, detector.evaluation.weights);
        Some((v_x, error.pole_magnitudes()?))
    };
    speeds(design).filter_map(at).collect()
}
