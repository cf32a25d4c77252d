//! What is needed of a piece of a drive, prepared once: measured signals by column, the smoothed
//! longitudinal acceleration, and where the model is compared with them.

use steerguard_drives::Piece;

/// Up to where the model is compared.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Limits {
    /// Lateral acceleration |v r|, m/s^2.
    pub(crate) lateral_m_per_s2: f64,
    /// Acceleration along the road, of either sign, m/s^2.
    pub(crate) longitudinal_m_per_s2: f64,
}

impl Limits {
    /// Tyres are taken as linear (method 10), and what brakes or drives them as small.
    pub(crate) const LINEAR: Self = Self { lateral_m_per_s2: 4.5, longitudinal_m_per_s2: 1.0 };
    /// The same at half the lateral acceleration.
    pub(crate) const GENTLE: Self = Self { lateral_m_per_s2: 2.25, ..Self::LINEAR };
    /// While braking too, which shows the height of the centre of gravity.
    pub(crate) const BRAKING: Self = Self { longitudinal_m_per_s2: 4.0, ..Self::LINEAR };
}

/// How long the model needs to forget tyres that were not linear, s.
const FORGETTING_S: f64 = 0.5;
/// Half the time over which speed and lateral acceleration are smoothed, s.
const SMOOTHING_S: f64 = 0.25;
/// A standing vehicle's speed may be shown as low as this, m/s; below, it reverses.
const STANDING_M_PER_S: f64 = -0.25;

/// A piece of a drive by columns, all of one length, in SI.
pub(crate) struct Course {
    pub(crate) start_s: f64,
    pub(crate) period_s: f64,
    /// Smoothed: its noise would act on the tyres of the model, and make them look softer.
    pub(crate) speed: Vec<f64>,
    pub(crate) yaw_rate: Vec<f64>,
    /// As the sensor shows it.
    pub(crate) steering: Vec<f64>,
    /// Smoothed: above 1 Hz the body rolls, which the model does not. Empty where not logged.
    pub(crate) lateral_acceleration: Vec<f64>,
    /// Standard deviation of the sensor's noise in it.
    pub(crate) lateral_noise: f64,
    /// Slope of the speed.
    pub(crate) acceleration: Vec<f64>,
    /// Whether the sample is compared.
    pub(crate) compared: Vec<bool>,
}

impl Course {
    /// Columns of `piece`, compared within `limits`; the `lateral` acceleration too if it is logged and
    /// wanted.
    pub(crate) fn new(piece: &Piece, limits: Limits, lateral: bool) -> Self {
        let column = |of: fn(&steerguard_drives::Sample) -> f64| -> Vec<f64> {
            piece.samples.iter().map(of).collect()
        };
        let speed = column(|sample| sample.speed_m_per_s);
        let yaw_rate = column(|sample| sample.yaw_rate_rad_per_s);
        let measured: Option<Vec<f64>> =
            piece.samples.iter().map(|sample| sample.lateral_acceleration_m_per_s2).collect();
        let measured = measured.filter(|_| lateral).unwrap_or_default();
        let (speed, acceleration) = smooth(&speed, piece.period_s);
        let mut compared: Vec<bool> = speed
            .iter()
            .zip(&yaw_rate)
            .zip(&acceleration)
            .map(|((&v, &r), &a_x)| {
                v > STANDING_M_PER_S
                    && (v * r).abs() < limits.lateral_m_per_s2
                    && a_x.abs() < limits.longitudinal_m_per_s2
            })
            .collect();
        forget(&mut compared, (FORGETTING_S / piece.period_s).round() as usize);
        Self {
            start_s: piece.start_s,
            period_s: piece.period_s,
            steering: column(|sample| sample.steering_rad),
            lateral_noise: noise(&measured) / (window(piece.period_s) as f64).sqrt(),
            lateral_acceleration: smooth(&measured, piece.period_s).0,
            acceleration,
            compared,
            speed,
            yaw_rate,
        }
    }

    pub(crate) fn len(&self) -> usize {
        self.speed.len()
    }

    /// The steering at `time` in samples, between its neighbours; beyond the ends what stands there.
    pub(crate) fn steering_at(&self, time: f64) -> f64 {
        let last = self.steering.len() - 1;
        let time = time.clamp(0.0, last as f64);
        let before = (time as usize).min(last.saturating_sub(1));
        let after = (before + 1).min(last);
        let part = time - before as f64;
        self.steering[before] + part * (self.steering[after] - self.steering[before])
    }
}

/// Standard deviation of white noise in `values`, by how they differ from one to the next.
fn noise(values: &[f64]) -> f64 {
    let squares: f64 = values.windows(2).map(|pair| (pair[1] - pair[0]).powi(2)).sum();
    (squares / (2 * values.len().max(1)) as f64).sqrt()
}

/// Samples to either side that are smoothed over.
fn reach(period_s: f64) -> usize {
    ((SMOOTHING_S / period_s).round() as usize).max(1)
}

/// Samples that are smoothed over.
pub(crate) fn window(period_s: f64) -> usize {
    2 * reach(period_s) + 1
}

/// Value and slope of `values` by a straight line through the neighbourhood of each.
pub(crate) fn smooth(values: &[f64], period_s: f64) -> (Vec<f64>, Vec<f64>) {
    // Sums of values and of values by place, so that a window costs the same at any length.
    let mut sums = Vec::with_capacity(values.len() + 1);
    let (mut sum, mut moment) = (0.0, 0.0);
    sums.push((sum, moment));
    for (k, value) in values.iter().enumerate() {
        sum += value;
        moment += k as f64 * value;
        sums.push((sum, moment));
    }
    let most = reach(period_s);
    let line = |k: usize| {
        let reach = most.min(k).min(values.len() - 1 - k);
        let ((from, from_moment), (to, to_moment)) = (sums[k - reach], sums[k + reach + 1]);
        let n = (2 * reach + 1) as f64;
        let squares = n * (n * n - 1.0) / 12.0;
        let slope = (to_moment - from_moment - k as f64 * (to - from)) / (squares * period_s);
        ((to - from) / n, if reach > 0 { slope } else { 0.0 })
    };
    (0..values.len()).map(line).unzip()
}

/// Leaves out the `samples` after each that is not compared.
fn forget(compared: &mut [bool], samples: usize) {
    let mut left = 0_usize;
    for at in compared {
        if *at {
            *at = left == 0;
            left = left.saturating_sub(1);
        } else {
            left = samples;
        }
    }
}
