//! The single-track model with linear tyres along a drive: (1)-(3) at the measured speed, axle loads
//! with the measured longitudinal acceleration (method 10).
//!
//! # Conventions
//! The implicit midpoint rule, which is stable at any speed. Below [`SLOW_M_PER_S`], where tyres take
//! less than a sample to settle, the steady motion of the moment.

use crate::course::Course;
use crate::parameter::{Parameter::*, Values};

/// Speed from which on the motion has a memory, m/s.
const SLOW_M_PER_S: f64 = 2.0;
/// Steps of the rule a sample: at 100 Hz and 2 Hz of steering its error is then below a thousandth.
const SUBSTEPS: usize = 2;
/// Standard gravity, m/s^2.
pub(crate) const GRAVITY_M_PER_S2: f64 = 9.80665;

/// Logarithms of stiffnesses and yaw inertia that any vehicle has: beyond, a search learns no more.
const LEAST: f64 = 0.0;
const MOST: f64 = 20.0;
/// What a search that has lost itself is shown of an unstable vehicle, m/s and rad/s.
const LOST: f64 = 1e4;

/// What is told of every vehicle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Chassis {
    /// M_v, kg.
    pub mass_kg: f64,
    /// l_f, m.
    pub front_axle_distance_m: f64,
    /// l_r, m.
    pub rear_axle_distance_m: f64,
}

impl Chassis {
    /// L, m.
    pub fn wheelbase_m(&self) -> f64 {
        self.front_axle_distance_m + self.rear_axle_distance_m
    }

    /// M l_f l_r, kg m^2: the yaw inertia of a car of which no more is known.
    pub fn yaw_inertia_kg_m2(&self) -> f64 {
        self.mass_kg * self.front_axle_distance_m * self.rear_axle_distance_m
    }
}

/// The model in one sample: the yaw rate that the sensor would show, and the lateral acceleration that
/// there is.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Shown {
    pub(crate) yaw_rate: f64,
    pub(crate) lateral_acceleration: f64,
}

/// dx/dt = A x + B delta of x = (v_y, r) at one speed and one longitudinal acceleration.
struct Linear {
    a: [[f64; 2]; 2],
    b: [f64; 2],
    /// (F_yf + F_yr) / M = c x + d delta.
    c: [f64; 2],
    d: f64,
}

impl Linear {
    /// For `speed` > 0.
    fn new(chassis: &Chassis, values: &Values, speed: f64, acceleration: f64) -> Self {
        let Chassis { mass_kg: m, front_axle_distance_m: l_f, rear_axle_distance_m: l_r } =
            *chassis;
        // Cornering stiffness goes with axle load (method 10).
        let shift = acceleration * values[Height] / GRAVITY_M_PER_S2;
        let [front, rear, i_z] = [FrontStiffness, RearStiffness, YawInertia]
            .map(|of| values[of].clamp(LEAST, MOST).exp());
        let front = 2.0 * front * (1.0 - shift / l_r);
        let rear = 2.0 * rear * (1.0 + shift / l_f);
        let sum = (front + rear) / speed;
        let moment = (l_f * front - l_r * rear) / speed;
        let c = [-sum / m, -moment / m];
        Self {
            a: [
                [c[0], c[1] - speed],
                [-moment / i_z, -(l_f * l_f * front + l_r * l_r * rear) / (speed * i_z)],
            ],
            b: [front / m, l_f * front / i_z],
            c,
            d: front / m,
        }
    }

    /// The state a `period` later, under a constant angle.
    fn after(&self, [v_y, r]: [f64; 2], delta: f64, period: f64) -> [f64; 2] {
        let h = period / 2.0;
        let [[a, b], [c, d]] = self.a;
        let right = [
            v_y + h * (a * v_y + b * r) + period * self.b[0] * delta,
            r + h * (c * v_y + d * r) + period * self.b[1] * delta,
        ];
        solve([[1.0 - h * a, -h * b], [-h * c, 1.0 - h * d]], right)
    }

    /// The state that stays under a constant angle.
    fn steady(&self, delta: f64) -> [f64; 2] {
        solve(self.a, [-self.b[0] * delta, -self.b[1] * delta])
    }
}

/// x of A x = b; of a singular A whatever comes, not finite.
fn solve([[a, b], [c, d]]: [[f64; 2]; 2], [p, q]: [f64; 2]) -> [f64; 2] {
    let determinant = a * d - b * c;
    [(p * d - b * q) / determinant, (a * q - c * p) / determinant]
}

/// The model along `course`.
pub(crate) fn shown(chassis: &Chassis, values: &Values, course: &Course) -> Vec<Shown> {
    let period = course.period_s;
    let delay = values[Delay] / period;
    // A lag, over one sample.
    let stays = if values[Lag] > 0.0 { (-period / values[Lag]).exp() } else { 0.0 };
    let wheel = |k: usize| {
        course.steering_at(k as f64 - delay) * values[SteeringRatio] - values[SteeringOffset]
    };
    let mut delta = wheel(0);
    let mut state: Option<[f64; 2]> = None;
    let mut all = Vec::with_capacity(course.len());
    for k in 0..course.len() {
        let (speed, acceleration) = (course.speed[k], course.acceleration[k]);
        let turned = wheel(k) + stays * (delta - wheel(k));
        let now = if speed < SLOW_M_PER_S {
            state = None;
            // Tyres that slip a little: the wheels roll where they point to.
            let rolling = speed.max(0.0) * turned / chassis.wheelbase_m();
            Shown { yaw_rate: rolling, lateral_acceleration: speed.max(0.0) * rolling }
        } else {
            let linear = Linear::new(chassis, values, speed, acceleration);
            let x = match state {
                None => linear.steady(turned),
                Some(before) => {
                    let between = |from: f64, to: f64, part: f64| from + part * (to - from);
                    let mut x = before;
                    for step in 0..SUBSTEPS {
                        let part = (step as f64 + 0.5) / SUBSTEPS as f64;
                        let v = between(course.speed[k - 1], speed, part);
                        let a_x = between(course.acceleration[k - 1], acceleration, part);
                        let mid = Linear::new(chassis, values, v, a_x);
                        x = mid.after(x, between(delta, turned, part), period / SUBSTEPS as f64);
                    }
                    x
                }
            };
            let x = x.map(|x| x.clamp(-LOST, LOST));
            state = Some(x);
            let force = linear.c[0] * x[0] + linear.c[1] * x[1] + linear.d * turned;
            Shown { yaw_rate: x[1], lateral_acceleration: force }
        };
        delta = turned;
        all.push(Shown {
            yaw_rate: now.yaw_rate + values[YawRateBias],
            lateral_acceleration: now.lateral_acceleration,
        });
    }
    all
}
