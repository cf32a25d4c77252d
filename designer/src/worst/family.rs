//! Families of fault-free drives, and how a point of the search becomes a drive of one.
//!
//! # Conventions
//! - A point is a list of numbers, each of which may be anything: `1.3 sin` of it, cut to [-1, 1], lies
//!   at an end of its interval for half of all numbers, or `sin` of it in between.
//! - Steering stays within the angle of a steady turn of the design's vehicle at the hardest lateral
//!   acceleration of the calibration and at the set speed, and within the calibration's steering rate.

use std::f64::consts::FRAC_PI_2;

use steerguard_detector::{Actuator, VehicleState};
use steerguard_world::{CALM_S, GUST_S, Gusts, Steering, Tyres, steady_angle};

use crate::spec::{Spec, UncertaintyTable};
use crate::worst::drive::{Courses, Drive};

/// Length of a drive, s; longer where the window is longer than [`WINDOW_S`].
const DURATION_S: f64 = 5.0;
const WINDOW_S: f64 = 0.4;
/// Largest longitudinal acceleration and braking of the driver, m/s^2.
const ACCELERATION_M_PER_S2: f64 = 3.0;
/// How near the set speed comes to an end of the armed range's hysteresis, as a share of that.
const SPEED_MARGIN: f64 = 0.6;
/// Parts that the courses of steering, bank and wind have, and the lengths that these may have, s.
const STEERING_PARTS: usize = 4;
const ROAD_PARTS: usize = 3;
const PART_S: [f64; 2] = [0.08, 2.0];
/// Fastest change of the bank where that is slow, deg/s.
const SLOW_DEG_PER_S: f64 = 1.0;
/// Friction beyond what is stated, as a share of the least that is stated, at most 1.
const BEYOND: f64 = 0.7;

/// What varies in the drives of a family beside vehicle, speed, steering and initial state.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Family {
    /// A constant bank, and gusts of 1-cosine shape.
    Constant,
    /// A bank that changes by at most 1 deg/s, and such gusts.
    SlowBank,
    /// Bank and wind take any course within their bounds.
    AnyCourse,
    /// Beside that the friction, as far as it is stated.
    Friction,
    /// Beside that, of one key: the largest lag, and dead time, of the actuator.
    ActuatorLag,
    /// Dead time of the actuator.
    ActuatorDelay,
    /// Steering ratio.
    SteeringRatio,
    /// Offset of the road wheel.
    SteeringOffset,
    /// Bias of the yaw-rate sensor.
    YawRateBias,
    /// Scale of the measured speed.
    SpeedScale,
    /// Transfer of axle load.
    LoadTransfer,
    /// Everything that is stated at once.
    All,
    /// Less friction than is stated.
    BeyondFriction,
}

impl Family {
    /// Its name in results and files: of those of a key the key's.
    pub fn name(self) -> &'static str {
        match self {
            Self::Constant => "constant",
            Self::SlowBank => "slow_bank",
            Self::AnyCourse => "any_course",
            Self::Friction => "friction",
            Self::ActuatorLag => "actuator_lag_s",
            Self::ActuatorDelay => "actuator_delay_s",
            Self::SteeringRatio => "steering_ratio_percent",
            Self::SteeringOffset => "steering_offset_deg",
            Self::YawRateBias => "yaw_rate_bias_deg_per_s",
            Self::SpeedScale => "v_x_scale_percent",
            Self::LoadTransfer => "load_transfer_percent",
            Self::All => "all",
            Self::BeyondFriction => "friction_beyond",
        }
    }

    /// Whether the specification states all that varies in it.
    pub fn is_stated(self) -> bool {
        self != Self::BeyondFriction
    }

    /// The families that `spec` asks for, those that others extend first.
    pub fn of(spec: &Spec) -> Vec<Self> {
        let u = &spec.uncertainty;
        let further: Vec<Self> = [
            (Self::Friction, u.tyres_end()),
            (Self::ActuatorLag, u.actuator_lag_s != 0.0),
            (Self::ActuatorDelay, u.actuator_delay_s != 0.0),
            (Self::SteeringRatio, u.steering_ratio_percent != [0.0; 2]),
            (Self::SteeringOffset, u.steering_offset_deg != 0.0),
            (Self::YawRateBias, u.yaw_rate_bias_deg_per_s != 0.0),
            (Self::SpeedScale, u.v_x_scale_percent != 0.0),
            (Self::LoadTransfer, transfers(spec)),
        ]
        .into_iter()
        .filter_map(|(family, is_stated)| is_stated.then_some(family))
        .collect();
        let all = (further.len() > 1).then_some(Self::All);
        let first = [Self::Constant, Self::SlowBank, Self::AnyCourse];
        first.into_iter().chain(further).chain(all).chain([Self::BeyondFriction]).collect()
    }

    fn varies(self, key: Self) -> bool {
        self == key || self == Self::All
    }

    /// Numbers of a point.
    pub fn dimension(self, spec: &Spec) -> usize {
        let mut point = Point::of(&[]);
        self.read(spec, &mut point, 0);
        point.next
    }

    /// How many numbers, from the first on, mean the same in points of `other`: all but those of keys
    /// where bank and wind are of the same kind.
    pub fn shared(self, other: Self, spec: &Spec) -> usize {
        let mut point = Point::of(&[]);
        self.read(spec, &mut point, 0);
        if self.road() == other.road() { point.at_keys } else { point.at_road }
    }

    /// The family whose bank and wind its own are like.
    fn road(self) -> Self {
        match self {
            Self::Constant | Self::SlowBank => self,
            _ => Self::AnyCourse,
        }
    }

    /// The drive of a point of the search.
    pub fn drive(self, spec: &Spec, numbers: &[f64], noise_seed: i32) -> Drive {
        self.read(spec, &mut Point::of(numbers), noise_seed)
    }

    /// The points of drives that one would try first: heavy vehicles that oversteer or understeer as much as
    /// stated, braked from the lowest or the highest speed in a turn, while bank and wind push into the turn
    /// or out of it, with what a key states at an end.
    pub fn suspects(self, spec: &Spec) -> Vec<Vec<f64>> {
        let mut point = Point::of(&[]);
        self.read(spec, &mut point, 0);
        let suspect = |number: u32| {
            let end = |bit: u32| if (number >> bit) & 1 == 1 { FRAC_PI_2 } else { -FRAC_PI_2 };
            let [front_stiffness, speed, aside, key] = [0, 1, 2, 3].map(end);
            let factors = [FRAC_PI_2, 0.0, front_stiffness, -front_stiffness];
            // Slope, and when that begins and ends.
            let braking = [-FRAC_PI_2, 0.0, FRAC_PI_2];
            let mut suspect = [&factors[..], &[speed], &braking].concat();
            suspect.resize(point.at_road, FRAC_PI_2);
            suspect.resize(point.at_keys, aside);
            suspect.resize(point.next, key);
            suspect
        };
        // Families without keys have each of these once.
        (0..if point.next > point.at_keys { 16 } else { 8 }).map(suspect).collect()
    }

    /// Reads a drive; what other families have too comes first, what only some have last.
    fn read(self, spec: &Spec, point: &mut Point<'_>, noise_seed: i32) -> Drive {
        let u = &spec.uncertainty;
        let factors = u.intervals_percent().map(|interval| 1.0 + point.end(interval) / 100.0);
        let mut vehicle = UncertaintyTable::vehicle(&spec.vehicle, factors);
        let speed_m_per_s = speed(spec, point);
        let start_v_x = speed_m_per_s[0];
        let start = initial_state(spec, start_v_x, point);
        let steering_rad = steering(spec, &speed_m_per_s, point);
        point.at_road = point.next;
        let samples = speed_m_per_s.len();
        let (bank_deg, wind_m_per_s) = match self.road() {
            Self::Constant => {
                let bank_deg = vec![point.end([-u.bank_deg, u.bank_deg]); samples];
                (bank_deg, gusts(spec, samples, point))
            }
            Self::SlowBank => (slow_bank(spec, samples, point), gusts(spec, samples, point)),
            _ => {
                let bank_deg = any_course(spec, u.bank_deg, samples, point);
                (bank_deg, any_course(spec, u.gust_m_per_s, samples, point))
            }
        };

        point.at_keys = point.next;
        // In the order of the keys.
        let tyres = if self == Self::BeyondFriction {
            Tyres::Saturating { friction: BEYOND * u.friction[0].min(1.0) }
        } else if u.tyres_end() && self.varies(Self::Friction) {
            Tyres::Saturating { friction: point.end(u.friction) }
        } else {
            Tyres::Linear
        };
        let mut of_key = |key: Self, interval: [f64; 2]| {
            if self.varies(key) { point.end(interval) } else { 0.0 }
        };
        let either = |most: f64| [-most, most];
        let actuator = spec.actuator.actuator();
        let zero = spec.sensors.zero();
        let steering = Steering {
            actuator: Actuator {
                lag_s: actuator.lag_s + of_key(Self::ActuatorLag, [0.0, u.actuator_lag_s]),
                delay_s: actuator.delay_s + of_key(Self::ActuatorDelay, [0.0, u.actuator_delay_s]),
                ..actuator
            },
            ratio: 1.0 / (1.0 + of_key(Self::SteeringRatio, u.steering_ratio_percent) / 100.0),
            offset_rad: zero.steering_offset_rad
                + of_key(Self::SteeringOffset, either(u.steering_offset_deg)).to_radians(),
        };
        let yaw_rate_bias_rad_per_s = zero.yaw_rate_bias_rad_per_s
            + of_key(Self::YawRateBias, either(u.yaw_rate_bias_deg_per_s)).to_radians();
        let v_x_scale = of_key(Self::SpeedScale, either(u.v_x_scale_percent)) / 100.0;
        let transfer = of_key(Self::LoadTransfer, either(u.load_transfer_percent)) / 100.0;
        vehicle.centre_of_gravity_height_m *= 1.0 + transfer;
        Drive {
            vehicle,
            tyres,
            steering,
            v_x_scale,
            yaw_rate_bias_rad_per_s,
            start,
            noise_seed,
            courses: Courses {
                period_s: spec.sampling.period_s,
                steering_rad,
                speed_m_per_s,
                bank_deg,
                wind_m_per_s,
            },
        }
    }
}

/// Whether axle load is transferred, and not known exactly.
fn transfers(spec: &Spec) -> bool {
    spec.uncertainty.load_transfer_percent != 0.0 && spec.vehicle.centre_of_gravity_height_m != 0.0
}

/// A point that is being read.
struct Point<'a> {
    numbers: &'a [f64],
    next: usize,
    /// Where the numbers of bank and wind begin, and those of keys.
    at_road: usize,
    at_keys: usize,
}

impl<'a> Point<'a> {
    fn of(numbers: &'a [f64]) -> Self {
        Self { numbers, next: 0, at_road: 0, at_keys: 0 }
    }

    /// The sine of the next number; of those that are missing 0.
    fn sine(&mut self) -> f64 {
        let number = self.numbers.get(self.next).copied().unwrap_or(0.0);
        self.next += 1;
        libm::sin(number)
    }

    /// In `[min, max]`, at an end for half of all numbers.
    fn end(&mut self, [min, max]: [f64; 2]) -> f64 {
        let place = (1.3 * self.sine()).clamp(-1.0, 1.0);
        // Each end exactly.
        0.5 * ((1.0 - place) * min + (1.0 + place) * max)
    }

    /// In `[min, max]`.
    fn between(&mut self, [min, max]: [f64; 2]) -> f64 {
        min + 0.5 * (max - min) * (1.0 + self.sine())
    }

    /// In `[min, max]`, both positive, on a logarithmic scale.
    fn scale(&mut self, [min, max]: [f64; 2]) -> f64 {
        libm::exp(self.between([libm::log(min), libm::log(max)]))
    }
}

/// Length of a drive, s.
fn duration_s(spec: &Spec) -> f64 {
    let period_s = spec.sampling.period_s;
    let window_s = spec.evaluation.window(period_s) as f64 * period_s;
    DURATION_S * (window_s / WINDOW_S).max(1.0)
}

/// Sampling periods of a drive.
fn samples(spec: &Spec) -> usize {
    libm::ceil(duration_s(spec) / spec.sampling.period_s) as usize
}

/// Set speed: constant, then slower or faster for a while.
fn speed(spec: &Spec, point: &mut Point<'_>) -> Vec<f64> {
    let range = &spec.operating_range;
    let hysteresis = range.hysteresis().map(|hysteresis| SPEED_MARGIN * hysteresis);
    let [min, max] = {
        let held = range.range().shrunk(hysteresis).v_x;
        [held.min, held.max]
    };
    let armed = range.range().shrunk(range.hysteresis()).v_x;
    let first = point.end([armed.min, armed.max]);
    let slope = point.end([-ACCELERATION_M_PER_S2, ACCELERATION_M_PER_S2]);
    let [begin_s, end_s] = [(); 2].map(|()| point.between([0.0, duration_s(spec)]));
    let at = |k: usize| {
        let t = k as f64 * spec.sampling.period_s;
        (first + slope * (t.min(begin_s.max(end_s)) - begin_s.min(end_s)).max(0.0)).clamp(min, max)
    };
    (0..samples(spec)).map(at).collect()
}

/// State at the start, at speed `v_x`: a lateral speed as the calibration's, a yaw rate as in a turn.
fn initial_state(spec: &Spec, v_x: f64, point: &mut Point<'_>) -> VehicleState {
    let range = spec.operating_range.range();
    let of = spec.evaluation.calibration.initial_v_y_in([range.v_y.min, range.v_y.max]);
    let v_y = of.iter().fold([0.0_f64; 2], |[min, max], &v_y| [min.min(v_y), max.max(v_y)]);
    let most = lateral_acceleration(spec) / v_x;
    VehicleState {
        v_x_m_per_s: v_x,
        v_y_m_per_s: point.end(v_y),
        r_rad_per_s: point.end([range.r.min.max(-most), range.r.max.min(most)]),
    }
}

/// Hardest lateral acceleration of the calibration, m/s^2.
fn lateral_acceleration(spec: &Spec) -> f64 {
    let of = &spec.evaluation.calibration.lateral_acceleration_m_per_s2;
    of.iter().copied().fold(0.0, f64::max)
}

/// Steering along the set speed: parts that each begin with a ramp to their level.
fn steering(spec: &Spec, speed_m_per_s: &[f64], point: &mut Point<'_>) -> Vec<f64> {
    let period_s = spec.sampling.period_s;
    let most = lateral_acceleration(spec);
    let step_rad = spec.evaluation.calibration.steering_rate_rad_per_s * period_s;
    let parts: Vec<[f64; 3]> = (0..STEERING_PARTS)
        .map(|_| [point.scale(PART_S), point.end([-1.0, 1.0]), point.between([0.0, 1.0])])
        .collect();
    let mut angle_rad = 0.0;
    let at = |(k, v_x): (usize, &f64)| {
        let level = along(&parts, k as f64 * period_s);
        let target = level * steady_angle(&spec.vehicle, *v_x, most);
        angle_rad += (target - angle_rad).clamp(-step_rad, step_rad);
        angle_rad
    };
    speed_m_per_s.iter().enumerate().map(at).collect()
}

/// At time `t` of a course of parts, each of a length in s, a level, and the share of it in which it comes
/// there from the level before; from 0, and held after the last.
fn along(parts: &[[f64; 3]], t: f64) -> f64 {
    let (mut begin_s, mut level) = (0.0, 0.0);
    for &[length_s, to, ramp] in parts {
        if t < begin_s + length_s {
            let ramp_s = ramp * length_s;
            let done = if t - begin_s < ramp_s { (t - begin_s) / ramp_s } else { 1.0 };
            return level + done * (to - level);
        }
        (begin_s, level) = (begin_s + length_s, to);
    }
    level
}

/// A course within `[-most, most]` that may jump.
fn any_course(spec: &Spec, most: f64, samples: usize, point: &mut Point<'_>) -> Vec<f64> {
    let parts: Vec<[f64; 3]> =
        (0..ROAD_PARTS).map(|_| [point.scale(PART_S), point.end([-most, most]), 0.0]).collect();
    (0..samples).map(|k| along(&parts, k as f64 * spec.sampling.period_s)).collect()
}

/// A bank that changes slowly.
fn slow_bank(spec: &Spec, samples: usize, point: &mut Point<'_>) -> Vec<f64> {
    let period_s = spec.sampling.period_s;
    let most = spec.uncertainty.bank_deg;
    let mut bank_deg = point.end([-most, most]);
    let parts: Vec<[f64; 3]> = (0..ROAD_PARTS)
        .map(|_| [point.scale(PART_S), point.end([-SLOW_DEG_PER_S, SLOW_DEG_PER_S]), 0.0])
        .collect();
    let at = |k: usize| {
        let now = bank_deg;
        let change_deg = along(&parts, k as f64 * period_s) * period_s;
        bank_deg = (bank_deg + change_deg).clamp(-most, most);
        now
    };
    (0..samples).map(at).collect()
}

/// Gusts as those of campaigns, each to the same side or the other.
fn gusts(spec: &Spec, samples: usize, point: &mut Point<'_>) -> Vec<f64> {
    let fastest = spec.uncertainty.gust_m_per_s;
    let [first, then] = [(); 2].map(|()| point.end([-fastest, fastest]));
    let start_s = point.between([0.0, duration_s(spec) - GUST_S[0]]);
    let [duration_s, next_s] = [(); 2].map(|()| point.between(GUST_S));
    let pause_s = point.between(CALM_S);
    let gust = |speed_m_per_s: f64, since_s: f64, duration_s: f64| {
        let once = Gusts { speed_m_per_s, duration_s, start_s: 0.0, pause_s: f64::INFINITY };
        once.wind_m_per_s(since_s)
    };
    let at = |k: usize| {
        let since_s = k as f64 * spec.sampling.period_s - start_s;
        gust(first, since_s, duration_s) + gust(then, since_s - duration_s - pause_s, next_s)
    };
    (0..samples).map(at).collect()
}
