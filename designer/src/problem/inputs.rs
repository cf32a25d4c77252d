//! The inputs of the error: faults, disturbances and bounded noise.

use std::f64::consts::PI;

use crate::document::Mistakes;
use crate::lmi::matrix::Matrix;
use crate::problem::band::Band;
use crate::problem::channel::Channel;
use crate::problem::model;
use crate::spec::{Spec, check_band};

/// What is asked of the residual: the inputs, in the units of the figures.
#[derive(Clone, Debug)]
pub struct Inputs {
    /// The fault that is designed for, per rad or N m.
    pub fault: Channel,
    /// Disturbances and bounded noise by their bands, per unit of the first disturbance.
    pub disturbances: Vec<Channel>,
    /// Standard deviations of white sensor noise on [v_x, r], m/s and rad/s.
    pub white_std: [f64; 2],
    /// Smallest fault of interest, rad or N m.
    pub smallest_fault: f64,
    /// Bound of the first disturbance, in its unit.
    pub bound: f64,
    /// Diagonal of W_r.
    pub weights: [f64; 2],
}

impl Inputs {
    /// What is asked of the residual, for the fault that is designed for.
    ///
    /// # Errors
    /// [`Mistakes`] for a band that is not possible.
    pub fn of(spec: &Spec) -> Result<Self, Mistakes> {
        Ok(Self {
            fault: fault_channels(spec)?.swap_remove(0),
            disturbances: disturbance_channels(spec)?,
            white_std: spec.noise.white_std(),
            smallest_fault: spec.fault[0].smallest(),
            bound: spec.disturbance[0].bound(),
            weights: spec.evaluation.weights,
        })
    }
}

/// An input by itself, in units of its bound.
#[derive(Clone, Debug)]
pub struct BoundedInput {
    /// Name in reports.
    pub name: String,
    /// Its bound, in its unit.
    pub bound: f64,
    /// Its unit.
    pub unit: &'static str,
    /// Its column.
    pub channel: Channel,
}

/// The faults of interest as inputs of the error, in rad or N m; the first is designed for.
///
/// # Errors
/// [`Mistakes`] for a band that is not possible.
pub fn fault_channels(spec: &Spec) -> Result<Vec<Channel>, Mistakes> {
    let f = model::f(spec);
    let faults = spec.fault.iter().enumerate();
    faults
        .map(|(index, fault)| {
            let band = band(spec, &format!("fault[{index}]"), fault.band_hz())?;
            Ok(Channel::disturbance(f.columns(index, 1).into_owned(), band))
        })
        .collect()
}

/// Disturbances and bounded noise as inputs of the error, one block for each band, in units of
/// the first disturbance: each column in proportion to its bound, so that the norm of the
/// stacked vector weighs every channel by its bound.
///
/// # Errors
/// [`Mistakes`] for a band that is not possible.
pub fn disturbance_channels(spec: &Spec) -> Result<Vec<Channel>, Mistakes> {
    let unit = spec.disturbance[0].bound();
    let d = model::d(spec);
    let mut channels: Vec<Channel> = Vec::new();
    for (index, disturbance) in spec.disturbance.iter().enumerate() {
        let band = band(spec, &format!("disturbance[{index}]"), disturbance.band_hz())?;
        let column = d.columns(index, 1) * (disturbance.bound() / unit);
        Channel::of_band(&mut channels, band).push_direction(&column);
    }
    for (signal, bound, band_hz) in bounded_noise(spec) {
        let band = band(spec, ["noise.v_x", "noise.r"][signal], band_hz)?;
        let column = Matrix::from_fn(2, 1, |row, _| f64::from(row == signal) * bound / unit);
        Channel::of_band(&mut channels, band).push_noise(&column);
    }
    Ok(channels)
}

/// Every disturbance, then every bounded noise, by itself and in units of its bound.
pub fn bounded_inputs(spec: &Spec) -> Vec<BoundedInput> {
    let d = model::d(spec);
    let disturbances = spec.disturbance.iter().enumerate().map(|(index, disturbance)| {
        let column = d.columns(index, 1) * disturbance.bound();
        BoundedInput {
            name: disturbance.name().into(),
            bound: disturbance.bound(),
            unit: disturbance.unit(),
            channel: Channel::disturbance(column, Band::Full),
        }
    });
    let noise = bounded_noise(spec).map(|(signal, bound, _)| {
        let mut channel = Channel::disturbance(Matrix::zeros(3, 0), Band::Full);
        channel.push_noise(&Matrix::from_fn(2, 1, |row, _| f64::from(row == signal) * bound));
        let [name, unit] = [["noise of v_x", "m/s"], ["noise of r", "rad/s"]][signal];
        BoundedInput { name: name.into(), bound, unit, channel }
    });
    disturbances.chain(noise).collect()
}

/// D_y, 2 x n_y: a column of each bounded sensor noise, per m/s or rad/s, in the order v_x, r.
pub fn d_y(spec: &Spec) -> Matrix {
    let signals: Vec<usize> = bounded_noise(spec).map(|(signal, ..)| signal).collect();
    Matrix::from_fn(2, signals.len(), |row, column| f64::from(row == signals[column]))
}

/// Place in y, bound and band of each bounded sensor noise.
fn bounded_noise(spec: &Spec) -> impl Iterator<Item = (usize, f64, [f64; 2])> {
    let nyquist_hz = spec.sampling.nyquist_hz();
    let signals = spec.noise.bounds().into_iter().zip(spec.noise.bands_hz()).enumerate();
    signals.filter_map(move |(signal, (bound, band_hz))| {
        Some((signal, bound?, band_hz.unwrap_or([0.0, nyquist_hz])))
    })
}

/// The kind of the band of `channel`.
fn band(spec: &Spec, channel: &str, band_hz: [f64; 2]) -> Result<Band, Mistakes> {
    let nyquist_hz = spec.sampling.nyquist_hz();
    let mut mistakes = Mistakes::default();
    check_band(channel, band_hz, nyquist_hz, &mut mistakes);
    mistakes.into_result()?;
    let [from, to] = band_hz;
    let theta = |hz: f64| 2.0 * PI * hz * spec.sampling.period_s;
    Ok(match (from == 0.0, to == nyquist_hz) {
        (true, true) => Band::Full,
        (true, false) => Band::Low(theta(to)),
        (false, _) => Band::High(theta(from)),
    })
}
