//! `band_hz`: the frequency range of a fault, a disturbance or a noise.

use crate::document::{Mistake, Mistakes};

/// [0, 1.5] Hz.
pub(super) fn low_band() -> [f64; 2] {
    [0.0, 1.5]
}

/// Finds what is not possible of the `band_hz` of `channel`.
pub(crate) fn check_band(
    channel: &str,
    band_hz: [f64; 2],
    nyquist_hz: f64,
    mistakes: &mut Mistakes,
) {
    let key = format!("{channel}.band_hz");
    let [from, to] = band_hz;
    mistakes.unless(0.0 <= from && from < to && to <= nyquist_hz, || {
        let allowed = format!("0 <= from < to <= {nyquist_hz} Hz, the Nyquist frequency");
        Mistake::value(&key, band_hz, allowed)
    });
    mistakes.unless(from == 0.0 || to == nyquist_hz, || {
        Mistake::value(&key, band_hz, format!("from 0, or up to {nyquist_hz} Hz"))
            .help("middle bands are not supported: widen it to one side")
    });
}
