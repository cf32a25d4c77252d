//! Sensors of speed and yaw rate, and how they err.
//!
//! # Conventions
//! - A reading is `(1 + scale) x + noise + bias`, added in this order and rounded to the resolution.
//! - The noise of time t is number `floor(t / period)` of its signal's stream: a run reproduces from
//!   its seed whatever is read, saved or restored between.

use crate::Stream;

/// Number of the period of `period_s` that time `t` lies in, from 0 on.
fn number_at(period_s: f64, t: f64) -> u64 {
    // The slack keeps a time of n periods at number n whatever its last bit.
    libm::floor(t / period_s + 1e-6) as u64
}

/// Value at time `t` of a signal that has one for each period of `period_s`, held over it; after its end
/// the last one. None of an empty signal.
pub fn held_sample(values: &[f64], period_s: f64, t: f64) -> Option<f64> {
    let number = usize::try_from(number_at(period_s, t)).unwrap_or(usize::MAX);
    values.get(number).or(values.last()).copied()
}

/// How one sensor errs; all in the signal's unit but `scale`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sensor {
    /// Standard deviation of its white noise.
    pub noise_std: f64,
    /// What it shows at zero.
    pub bias: f64,
    /// Relative error of its scale.
    pub scale: f64,
    /// Distance between the values that it can show; 0 for any.
    pub resolution: f64,
}

impl Sensor {
    /// What it shows of `x` with the standard normal number `normal`.
    pub fn reading(&self, x: f64, normal: f64) -> f64 {
        let shown = (1.0 + self.scale) * x + self.noise_std * normal + self.bias;
        let values = shown / self.resolution;
        // Finer than the number itself: any value can be shown.
        if self.resolution > 0.0 && values.is_finite() {
            self.resolution * libm::round(values)
        } else {
            shown
        }
    }
}

/// The sensors of a vehicle: `[v_x, r]` in m/s, rad/s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sensors {
    /// How each errs.
    pub sensors: [Sensor; 2],
    /// Time for which a value of the noise is held, s, positive.
    pub period_s: f64,
    /// Whether a reading is held as long; otherwise it follows the vehicle.
    pub held: bool,
    /// Same seed, same noise.
    pub seed: u64,
}

impl Sensors {
    /// Number of the noise value at time `t`, s.
    pub fn number(&self, t: f64) -> u64 {
        number_at(self.period_s, t)
    }

    /// What they show of `truth` with noise number `number`.
    pub fn readings(&self, number: u64, truth: [f64; 2]) -> [f64; 2] {
        let [v_x, r] = self.sensors;
        let [of_v_x, of_r] = truth;
        // Without noise no number is drawn: it takes a logarithm and a cosine.
        let normal = |sensor: &Sensor, signal| {
            if sensor.noise_std > 0.0 { Stream::new(self.seed, signal).normal(number) } else { 0.0 }
        };
        [v_x.reading(of_v_x, normal(&v_x, 0)), r.reading(of_r, normal(&r, 1))]
    }
}

/// Readings that may be held.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Readings {
    /// Number of the noise value in them; none before the first.
    pub number: Option<u64>,
    /// `[v_x, r]` in m/s, rad/s.
    pub values: [f64; 2],
}

impl Readings {
    /// Samples `truth` at time `t` if the sensors hold their readings and it is time for a new one.
    pub fn sample(&mut self, sensors: &Sensors, t: f64, truth: [f64; 2]) {
        let number = sensors.number(t);
        if sensors.held && self.number != Some(number) {
            *self = Self { number: Some(number), values: sensors.readings(number, truth) };
        }
    }

    /// What `sensors` show at time `t` at which `truth` holds.
    pub fn at(&self, sensors: &Sensors, t: f64, truth: [f64; 2]) -> [f64; 2] {
        if sensors.held && self.number.is_some() {
            self.values
        } else {
            sensors.readings(sensors.number(t), truth)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const EXACT: Sensors = Sensors {
        sensors: [Sensor { noise_std: 0.0, bias: 0.0, scale: 0.0, resolution: 0.0 }; 2],
        period_s: 0.01,
        held: false,
        seed: 1,
    };

    #[test]
    fn an_exact_sensor_shows_the_truth() {
        let truth = [12.345_678_901, -0.1];
        assert_eq!(EXACT.readings(7, truth), truth);
    }

    #[test]
    fn errors_add_up_as_stated() {
        let sensor = Sensor { noise_std: 0.5, bias: 0.1, scale: 0.02, resolution: 0.0 };
        assert!((sensor.reading(10.0, -2.0) - (10.2 + 0.1 - 1.0)).abs() < 1e-15);
        let rounded = Sensor { resolution: 0.25, ..sensor };
        assert_eq!(rounded.reading(10.0, -2.0), 9.25);
        assert_eq!(rounded.reading(0.0, 0.0), 0.0);
        assert_eq!(Sensor { resolution: 5e-324, ..Sensor::default() }.reading(10.0, 0.0), 10.0);
    }

    #[test]
    fn noise_is_that_of_its_number_and_has_its_standard_deviation() {
        let noisy = Sensor { noise_std: 0.02, ..Sensor::default() };
        let sensors = Sensors { sensors: [noisy; 2], ..EXACT };
        for k in 0..1000_u64 {
            assert_eq!(sensors.number(k as f64 * 0.01), k);
        }
        let n = 20_000_u32;
        for signal in 0..2 {
            let square = |k: u32| libm::pow(sensors.readings(k.into(), [0.0; 2])[signal], 2.0);
            let variance = (0..n).map(square).sum::<f64>() / f64::from(n);
            // Five standard errors of a variance.
            let ratio = variance / (0.02 * 0.02);
            assert!((ratio - 1.0).abs() < 5.0 * libm::sqrt(2.0 / f64::from(n)), "{ratio}");
        }
        assert_ne!(sensors.readings(0, [0.0; 2])[0], sensors.readings(0, [0.0; 2])[1]);
    }

    #[test]
    fn a_held_reading_waits_for_the_next_period() {
        let sensors = Sensors { held: true, ..EXACT };
        let mut readings = Readings::default();
        assert_eq!(readings.at(&sensors, 0.0, [1.0, 2.0]), [1.0, 2.0]);
        for k in 0..50_u32 {
            let t = f64::from(k) * 1e-3;
            readings.sample(&sensors, t, [f64::from(k), 0.0]);
            let shown = readings.at(&sensors, t, [f64::from(k), 0.0]);
            assert_eq!(shown, [f64::from(k / 10 * 10), 0.0]);
        }
    }
}
