//! Whether a drive was prepared as the design expects: the yaw rate that the design's own vehicle has under
//! the recorded steering, held against the recorded one.
//!
//! # Conventions
//! - The vehicle on linear tyres is driven along by the recorded speed and steering, from 5 m/s on. By r the
//!   recorded yaw rate less its bias, by m the vehicle's. Turns do not count that are harder than 4 m/s^2 by
//!   both: in a wrong unit one of them alone is large.
//! - The *lag* is the shift at which r and m are most alike, positive where r is ahead: the steering is late by
//!   it. The *gain* is the least-squares factor from m to r there, r about g m + c.
//! - A real fault looks like a wrong preparation. So what need not be one is said only where a fault-free drive
//!   alarms.
//! - Speeds above the design's range that are inside it in km/h are taken for km/h.

use std::collections::VecDeque;

use steerguard_detector::{Input, Interval, Vehicle, VehicleState};

/// Below this speed the vehicle is not driven along, m/s.
const SLOWEST_M_PER_S: f64 = 5.0;
/// Harder turns do not count, m/s^2.
const HARDEST_M_PER_S2: f64 = 4.0;
/// After a start the vehicle has no memory of it any more, s.
const SETTLED_S: f64 = 1.0;
/// Shifts that are looked at go so far either way, s.
const FARTHEST_S: f64 = 0.5;
/// Fewer samples than in this time show nothing, s.
const SHORTEST_S: f64 = 10.0;
/// Spreads of the vehicle's yaw rate and of the recorded one below these show nothing, rad/s. The recorded
/// one has noise and the road in it.
const SMALLEST_SPREADS: [f64; 2] = [0.004, 0.02];
/// Metres a second that are read for a kilometre an hour too many.
const KM_PER_H: f64 = 3.6;

/// Sums over pairs (m, r).
#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    n: f64,
    m: f64,
    r: f64,
    mm: f64,
    mr: f64,
    rr: f64,
}

impl Sums {
    fn add(&mut self, m: f64, r: f64) {
        self.n += 1.0;
        self.m += m;
        self.r += r;
        self.mm += m * m;
        self.mr += m * r;
        self.rr += r * r;
    }

    /// Covariance of m and r, and both variances.
    fn spread(&self) -> [f64; 3] {
        let n = self.n.max(1.0);
        let about = |ab: f64, a: f64, b: f64| ab / n - a / n * (b / n);
        [
            about(self.mr, self.m, self.r),
            about(self.mm, self.m, self.m),
            about(self.rr, self.r, self.r),
        ]
    }

    fn correlation(&self) -> f64 {
        let [mr, mm, rr] = self.spread();
        if mm > 0.0 && rr > 0.0 { mr / (mm * rr).sqrt() } else { 0.0 }
    }
}

/// Gathers what the steering explains of the yaw rate.
#[derive(Clone, Debug)]
pub(super) struct Preparation {
    vehicle: Vehicle,
    /// Speeds that the design is made for, m/s.
    speeds: Interval,
    period_s: f64,
    /// Samples, those too fast, and those of them that are not in km/h.
    fast: [u64; 3],
    /// `[v_y, r]` of the vehicle, and since when it is driven along, samples.
    state: Option<([f64; 2], u64)>,
    /// The last yaw rates `[m, r]`, newest last.
    last: VecDeque<[f64; 2]>,
    /// Sums of r(k) with m(k + shift), shifts from -n to n.
    shifted: Vec<Sums>,
    /// Yaw rate that the vehicle turns with per steering angle, and what is left of r, for the offset.
    slopes: f64,
    left: f64,
}

/// What is found.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Found {
    correlation: f64,
    gain: f64,
    steering_late_s: f64,
    offset_rad: f64,
}

impl Preparation {
    /// Of samples every `period_s` of a `vehicle` and a design for `speeds`.
    pub fn new(vehicle: Vehicle, speeds: Interval, period_s: f64) -> Self {
        let shifts = 2 * (FARTHEST_S / period_s).round() as usize + 1;
        Self {
            vehicle,
            speeds,
            period_s,
            fast: [0; 3],
            state: None,
            last: VecDeque::with_capacity(shifts),
            shifted: vec![Sums::default(); shifts],
            slopes: 0.0,
            left: 0.0,
        }
    }

    /// Takes the next sample: speed, yaw rate less its bias, angle at the road wheel less its offset.
    pub fn add(&mut self, starts: bool, v_x: f64, r: f64, delta: f64) {
        let too_fast = v_x > self.speeds.max;
        let in_km_per_h = too_fast && self.speeds.contains(v_x / KM_PER_H);
        for (count, holds) in self.fast.iter_mut().zip([true, too_fast, in_km_per_h]) {
            *count += u64::from(holds);
        }
        if starts || v_x < SLOWEST_M_PER_S {
            self.state = None;
            self.last.clear();
        }
        if v_x < SLOWEST_M_PER_S {
            return;
        }
        let (state, age) = self.state.unwrap_or(([0.0, r], 0));
        let m = state[1];
        let moved = self.moved(state, v_x, delta);
        self.state = Some((moved, age + 1));
        let settled = age as f64 * self.period_s >= SETTLED_S;
        let hard = v_x * r.abs().min(m.abs()) > HARDEST_M_PER_S2;
        if !settled || hard || !m.is_finite() {
            self.last.clear();
            return;
        }
        self.last.push_back([m, r]);
        let shifts = self.shifted.len();
        if self.last.len() < shifts {
            return;
        }
        // r in the middle of the last samples, m at each of them.
        let [m_middle, r_middle] = self.last[shifts / 2];
        for (sums, [m, _]) in self.shifted.iter_mut().zip(&self.last) {
            sums.add(*m, r_middle);
        }
        self.last.pop_front();
        let slope = self.yaw_rate_by_angle(v_x);
        self.slopes += slope * slope;
        self.left += slope * (r_middle - m_middle);
    }

    /// The vehicle a sample later: Runge and Kutta's method of the fourth order.
    fn moved(&self, state: [f64; 2], v_x: f64, delta: f64) -> [f64; 2] {
        let slope = |[v_y, r]: [f64; 2]| {
            let x = VehicleState { v_x_m_per_s: v_x, v_y_m_per_s: v_y, r_rad_per_s: r };
            let [_, v_y, r] =
                self.vehicle.derivative(x, Input { t_eng_n_m: 0.0, delta_rad: delta });
            [v_y, r]
        };
        let h = self.period_s;
        let along = |by: [f64; 2], h: f64| [state[0] + h * by[0], state[1] + h * by[1]];
        let k_1 = slope(state);
        let k_2 = slope(along(k_1, h / 2.0));
        let k_3 = slope(along(k_2, h / 2.0));
        let k_4 = slope(along(k_3, h));
        let mean = |i: usize| (k_1[i] + 2.0 * k_2[i] + 2.0 * k_3[i] + k_4[i]) / 6.0;
        along([mean(0), mean(1)], h)
    }

    /// Steady yaw rate per steering angle at a speed, 1/s: `v_x / (L + U v_x^2)`, method 2.
    fn yaw_rate_by_angle(&self, v_x: f64) -> f64 {
        let Vehicle {
            mass_kg,
            front_axle_distance_m: l_f,
            rear_axle_distance_m: l_r,
            front_cornering_stiffness_n_per_rad: c_f,
            rear_cornering_stiffness_n_per_rad: c_r,
            ..
        } = self.vehicle;
        let wheelbase = l_f + l_r;
        let understeer = mass_kg * (c_r * l_r - c_f * l_f) / (2.0 * c_f * c_r * wheelbase);
        v_x / (wheelbase + understeer * v_x * v_x)
    }

    /// What looks wrong, a sentence each: always what no fault explains; where a fault-free drive alarms also
    /// what a fault might. The steering is that of a sensor `ratio` times the road wheel's angle.
    pub fn remarks(&self, false_alarms: bool, ratio: f64) -> Vec<String> {
        let [all, fast, in_km_per_h] = self.fast;
        if 2 * fast > all && in_km_per_h == fast {
            return vec![format!(
                "most speeds are above the design's {} m/s and would be in its range if they were in km/h: \
                 --speed NAME:km/h",
                self.speeds.max
            )];
        }
        self.found().map_or(vec![], |found| found.remarks(false_alarms, ratio))
    }

    /// What the drive shows; `None` where it shows too little.
    fn found(&self) -> Option<Found> {
        let middle = self.shifted.len() / 2;
        let now = self.shifted.get(middle)?;
        let [_, mm, rr] = now.spread();
        let [smallest_m, smallest_r] = SMALLEST_SPREADS;
        let shows = mm.sqrt() >= smallest_m || rr.sqrt() >= smallest_r;
        if now.n * self.period_s < SHORTEST_S || !shows || mm <= 0.0 {
            return None;
        }
        let best = (0..self.shifted.len())
            .max_by(|&a, &b| {
                let likeness = |k: usize| self.shifted[k].correlation().abs();
                likeness(a).total_cmp(&likeness(b))
            })
            .unwrap_or(middle);
        let between = self.peak(best);
        let most_alike = self.shifted.get(best)?;
        let [mr, mm, _] = most_alike.spread();
        Some(Found {
            correlation: most_alike.correlation(),
            gain: mr / mm,
            // m(k + shift) is like r(k): the vehicle answers later than the recording, since it is told late.
            steering_late_s: (best as f64 + between - middle as f64) * self.period_s,
            offset_rad: if self.slopes > 0.0 { -self.left / self.slopes } else { 0.0 },
        })
    }

    /// Where between its neighbours the correlation is largest, -0.5 to 0.5: the top of a parabola.
    fn peak(&self, at: usize) -> f64 {
        let likeness = |k: usize| self.shifted.get(k).map(|sums| sums.correlation().abs());
        let (Some(left), Some(top), Some(right)) =
            (at.checked_sub(1).and_then(likeness), likeness(at), likeness(at + 1))
        else {
            return 0.0;
        };
        let bend = left - 2.0 * top + right;
        if bend < 0.0 { (0.5 * (left - right) / bend).clamp(-0.5, 0.5) } else { 0.0 }
    }
}

/// Factors that wrong units of an angle leave.
const DEGREES: f64 = 180.0 / std::f64::consts::PI;

impl Found {
    /// As [`Preparation::remarks`].
    fn remarks(&self, false_alarms: bool, ratio: f64) -> Vec<String> {
        let Self { correlation, gain, steering_late_s, offset_rad } = *self;
        let mut remarks = Vec::new();
        if correlation < -0.5 {
            remarks.push(format!(
                "the yaw rate goes against the steering (correlation {correlation:.2}): an axis is turned; \
                 --yaw NAME:-UNIT or --steering NAME:-UNIT turns it back"
            ));
        }
        if correlation.abs() < 0.5 {
            if false_alarms {
                remarks.push(format!(
                    "the steering does not explain the yaw rate (correlation {correlation:.2}): is it the \
                     right column, of the same drive, and in time?"
                ));
            }
            return remarks;
        }
        let size = gain.abs();
        let unit_is_wrong = |factor: f64| (factor / 2.0..2.0 * factor).contains(&size);
        if unit_is_wrong(DEGREES) {
            remarks.push(format!(
                "the yaw rate is {size:.0} times what the steering makes: steering in rad is read as deg, \
                 or yaw rate in deg/s as rad/s"
            ));
        } else if unit_is_wrong(1.0 / DEGREES) {
            remarks.push(format!(
                "the yaw rate is 1/{:.0} of what the steering makes: steering in deg is read as rad, or \
                 yaw rate in rad/s as deg/s",
                1.0 / size
            ));
        } else if false_alarms && correlation > 0.9 && !(0.93..1.07).contains(&size) {
            remarks.push(format!(
                "the yaw rate is {size:.2} times what the steering makes: with this design a \
                 sensors.steering_ratio of {:.1} would fit (it is {ratio})",
                ratio / size
            ));
        }
        if false_alarms && steering_late_s.abs() > 0.012 && correlation > 0.5 {
            remarks.push(format!(
                "the steering is {:.0} ms {} than the yaw rate: --delay steering={:.3}, beside what is \
                 told already, would fit",
                1e3 * steering_late_s.abs(),
                if steering_late_s > 0.0 { "later" } else { "earlier" },
                steering_late_s
            ));
        }
        let offset_deg = offset_rad.to_degrees();
        if false_alarms && offset_deg.abs() > 0.15 && (0.8..1.25).contains(&gain) {
            remarks.push(format!(
                "the car goes straight at {offset_deg:+.2} deg at the road wheel beyond \
                 sensors.steering_offset_deg (or the yaw rate's bias is wrong)"
            ));
        }
        remarks
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What is found of a minute of swerving, in which the recorded steering and yaw rate are made of the
    /// vehicle's own.
    fn found(steering: impl Fn(f64) -> f64, yaw_rate: impl Fn(f64) -> f64) -> Found {
        let delta = |t: f64| 0.02 * (1.3 * t).sin() + 0.01 * (3.1 * t).cos();
        let mut preparation = Preparation::new(Vehicle::PAPER, Interval::new(5.0, 30.0), 0.01);
        let mut vehicle = [0.0, 0.0];
        for k in 0..6000_u32 {
            let t = f64::from(k) * 0.01;
            let v_x = 15.0 + (0.1 * t).sin();
            preparation.add(k == 0, v_x, yaw_rate(vehicle[1]), steering(t));
            vehicle = preparation.moved(vehicle, v_x, delta(t));
        }
        preparation.found().unwrap()
    }

    fn steering(t: f64) -> f64 {
        0.02 * (1.3 * t).sin() + 0.01 * (3.1 * t).cos()
    }

    #[test]
    fn a_right_preparation_has_nothing_to_say() {
        let found = found(steering, |r| r);
        assert!(
            (found.gain - 1.0).abs() < 0.01 && found.steering_late_s.abs() < 0.002,
            "{found:?}"
        );
        assert_eq!(found.remarks(true, 16.0), Vec::<String>::new());
    }

    #[test]
    fn each_wrong_preparation_is_named() {
        let half = 0.5_f64.to_radians();
        for (found, parts) in [
            (found(steering, |r| -r), &["an axis is turned"][..]),
            (found(|t| steering(t).to_degrees(), |r| r), &["steering in deg is read as rad"]),
            (found(steering, f64::to_degrees), &["yaw rate in deg/s as rad/s"]),
            (found(|t| steering(t).to_radians(), |r| r), &["steering in rad is read as deg"]),
            (found(|t| steering(t - 0.03), |r| r), &["30 ms later", "--delay steering=0.030"]),
            (
                found(|t| steering(t) / 0.88, |r| r),
                &["steering_ratio of 18.2 would fit (it is 16)"],
            ),
            (found(|t| steering(t) + half, |r| r), &["+0.50 deg at the road wheel"]),
        ] {
            let remarks = found.remarks(true, 16.0);
            for part in parts {
                assert!(remarks.iter().any(|remark| remark.contains(part)), "{part}: {remarks:?}");
            }
        }
        // What a fault may be is said of fault-free drives only.
        let late = found(|t| steering(t - 0.03) + half, |r| r);
        assert_eq!(late.remarks(false, 16.0), Vec::<String>::new());
    }

    #[test]
    fn a_straight_road_shows_nothing() {
        let mut preparation = Preparation::new(Vehicle::PAPER, Interval::new(5.0, 30.0), 0.01);
        for k in 0..6000 {
            preparation.add(k == 0, 20.0, 0.001, 0.0);
        }
        assert_eq!(preparation.found(), None);
    }

    #[test]
    fn km_per_h_are_recognised_by_the_range_of_the_design() {
        let remarks = |v_x: f64| {
            let mut preparation = Preparation::new(Vehicle::PAPER, Interval::new(5.0, 30.0), 0.01);
            (0..100).for_each(|k| preparation.add(k == 0, v_x, 0.0, 0.0));
            preparation.remarks(true, 1.0)
        };
        assert!(remarks(80.0)[0].contains("--speed NAME:km/h"));
        assert_eq!(remarks(25.0), Vec::<String>::new());
    }
}
