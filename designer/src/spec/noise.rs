//! `[noise]`: noise of the sensors.

use serde::{Deserialize, Serialize};

use super::band::check_band;
use crate::document::{Allowed, Mistake, Mistakes};

/// Largest standard deviations and bounds of [v_x, r], m/s and rad/s.
const LARGEST: [f64; 2] = [10.0, 2.0];

/// `[noise]`: sensor noise. Bounds count like those of disturbances, in the norm of their band;
/// standard deviations of white noise give the RMS of the residual.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Noise {
    /// Of the speed.
    pub v_x: SpeedNoise,
    /// Of the yaw rate.
    pub r: YawRateNoise,
}

/// `[noise.v_x]`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SpeedNoise {
    /// Standard deviation of a sample, white; default 0.02.
    pub white_std_m_per_s: f64,
    /// Largest magnitude; default none.
    pub bound_m_per_s: Option<f64>,
    /// Frequency range of what is bounded; default all.
    pub band_hz: Option<[f64; 2]>,
}

/// `[noise.r]`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct YawRateNoise {
    /// Standard deviation of a sample, white; default 0.002.
    pub white_std_rad_per_s: f64,
    /// Largest magnitude; default none.
    pub bound_rad_per_s: Option<f64>,
    /// Frequency range of what is bounded; default all.
    pub band_hz: Option<[f64; 2]>,
}

impl Default for SpeedNoise {
    fn default() -> Self {
        Self { white_std_m_per_s: 0.02, bound_m_per_s: None, band_hz: None }
    }
}

impl Default for YawRateNoise {
    fn default() -> Self {
        Self { white_std_rad_per_s: 0.002, bound_rad_per_s: None, band_hz: None }
    }
}

impl Noise {
    /// Standard deviations of [v_x, r], m/s and rad/s.
    pub fn white_std(&self) -> [f64; 2] {
        [self.v_x.white_std_m_per_s, self.r.white_std_rad_per_s]
    }

    /// Largest magnitudes of [v_x, r], m/s and rad/s.
    pub fn bounds(&self) -> [Option<f64>; 2] {
        [self.v_x.bound_m_per_s, self.r.bound_rad_per_s]
    }

    /// Frequency ranges of [v_x, r], Hz; none for all frequencies.
    pub fn bands_hz(&self) -> [Option<[f64; 2]>; 2] {
        [self.v_x.band_hz, self.r.band_hz]
    }

    /// Finds what is not possible by itself; of bands where the Nyquist frequency is known.
    pub(super) fn check(&self, nyquist_hz: Option<f64>, mistakes: &mut Mistakes) {
        for signal in self.signals() {
            let NoiseOfSignal { at, unit, most, white_std, bound, band_hz } = signal;
            let allowed = Allowed::between(0.0, most);
            mistakes.number(&format!("{at}.white_std_{unit}"), white_std, allowed);
            if let Some(bound) = bound {
                let allowed = Allowed::above_up_to(0.0, most);
                mistakes.number(&format!("{at}.bound_{unit}"), bound, allowed);
            }
            if let Some(band_hz) = band_hz {
                if let Some(nyquist_hz) = nyquist_hz {
                    check_band(at, band_hz, nyquist_hz, mistakes);
                }
                mistakes.unless(bound.is_some(), || {
                    Mistake::value(format!("{at}.band_hz"), band_hz, "with a bound only")
                        .help(format!("white noise has all frequencies: give `bound_{unit}`"))
                });
            }
        }
    }

    /// Finds noise without a bound, for a threshold that needs them.
    pub(super) fn check_bounded(&self, mistakes: &mut Mistakes) {
        for NoiseOfSignal { at, unit, white_std, bound, .. } in self.signals() {
            mistakes.unless(bound.is_some() || white_std == 0.0, || {
                let key = format!("{at}.bound_{unit}");
                Mistake::missing(key)
                    .help(format!(
                        "a guaranteed threshold covers noise up to a bound, and white noise has \
                         none: 4 standard deviations, {}, are rarely exceeded; or set \
                         {at}.white_std_{unit} = 0",
                        4.0 * white_std
                    ))
                    .because_of("evaluation.threshold")
            });
        }
    }

    fn signals(&self) -> [NoiseOfSignal; 2] {
        let names = [("noise.v_x", "m_per_s", LARGEST[0]), ("noise.r", "rad_per_s", LARGEST[1])];
        std::array::from_fn(|signal| NoiseOfSignal {
            at: names[signal].0,
            unit: names[signal].1,
            most: names[signal].2,
            white_std: self.white_std()[signal],
            bound: self.bounds()[signal],
            band_hz: self.bands_hz()[signal],
        })
    }
}

/// A table of `[noise]` as what all have in common.
struct NoiseOfSignal {
    at: &'static str,
    unit: &'static str,
    /// Largest that any sensor has.
    most: f64,
    white_std: f64,
    bound: Option<f64>,
    band_hz: Option<[f64; 2]>,
}
