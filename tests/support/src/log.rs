//! A drive of Table 1's car as a logger would record it, simulated by a rule of its own in small steps.
//!
//! # Conventions
//! SI; the yaw rate is shown with a bias, the steering at a hand wheel, whose zero is off, and ahead of the
//! road wheel.

use std::f64::consts::TAU;
use std::fmt::Write as _;

use chacha20::ChaCha8Rng;
use chacha20::rand_core::SeedableRng;
use rand_distr::{Distribution, Normal};
use steerguard_detector::Vehicle;

/// From a sample to the next, s.
pub const PERIOD_S: f64 = 0.01;
/// Hand wheel over road wheel.
pub const RATIO: f64 = 16.0;
/// Road-wheel angle that is shown straight ahead.
pub const OFFSET_DEG: f64 = 0.1875;
/// Yaw rate that is shown at standstill.
pub const BIAS_DEG_PER_S: f64 = 0.2;
/// The road wheel follows by as much, s.
pub const DELAY_S: f64 = 0.02;

/// What is driven: speed in m/s and road-wheel angle in rad by time in s.
#[derive(Clone, Copy)]
pub struct Drive {
    /// So long, s.
    pub duration_s: f64,
    speed: fn(f64) -> f64,
    angle: fn(f64, f64) -> f64,
}

/// A row of the log.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    /// s.
    pub time_s: f64,
    /// m/s.
    pub speed: f64,
    /// rad/s.
    pub yaw_rate: f64,
    /// rad, at the hand wheel.
    pub steering: f64,
    /// m/s^2.
    pub lateral_acceleration: f64,
}

/// The rows as a CSV file with names and units.
pub fn csv(rows: &[Row]) -> String {
    let mut text = String::from("time [s],v [m/s],yaw_rate [deg/s],hand_wheel [deg],a_y [m/s^2]\n");
    for row in rows {
        let (yaw_rate, steering) = (row.yaw_rate.to_degrees(), row.steering.to_degrees());
        let Row { time_s, speed, lateral_acceleration, .. } = row;
        let _ = writeln!(
            text,
            "{time_s:.3},{speed:.4},{yaw_rate:.4},{steering:.4},{lateral_acceleration:.4}"
        );
    }
    text
}

fn between(t: f64, from: f64, to: f64) -> f64 {
    ((t - from) / (to - from)).clamp(0.0, 1.0)
}

/// Standstill, slow turns, a sweep, braking in a weave.
pub const VARIED: Drive = Drive {
    duration_s: 90.0,
    speed: |t| {
        6.0 * between(t, 8.0, 12.0) + 13.0 * between(t, 35.0, 47.0) - 11.0 * between(t, 80.0, 85.0)
    },
    angle: |t, v| match t {
        ..12.0 => 0.0,
        12.0..35.0 => 0.1 * (TAU * (t - 12.0) / 11.5).sin(),
        35.0..48.0 => 0.0,
        48.0..78.0 => {
            let tau = t - 48.0;
            let phase = TAU * (0.12 * tau + 0.5 * (1.6 / 30.0) * tau * tau);
            3.0 * 2.62 / (v * v) * phase.sin() * between(t, 48.0, 50.0)
        }
        78.0..80.0 => 0.0,
        _ => 1.5 * 2.62 / (v * v).max(40.0) * (TAU * (t - 80.0) / 4.0).sin(),
    },
};

/// One speed, straight on but for slow bends.
pub const MOTORWAY: Drive = Drive {
    duration_s: 60.0,
    speed: |t| 30.0 + 0.3 * (TAU * t / 40.0).sin(),
    angle: |t, _| 0.003 * (TAU * t / 15.0).sin(),
};

/// The log of Table 1's car, with load transfer, on `drive`.
pub fn recorded(drive: &Drive) -> Vec<Row> {
    let vehicle = Vehicle { centre_of_gravity_height_m: 0.55, ..Vehicle::PAPER };
    let (l_f, l_r) = (vehicle.front_axle_distance_m, vehicle.rear_axle_distance_m);
    let slope = |[v_y, r]: [f64; 2], t: f64| {
        let v = (drive.speed)(t);
        let a_x = ((drive.speed)(t + 0.05) - (drive.speed)(t - 0.05)) / 0.1;
        let delta = (drive.angle)(t, v);
        let [front_load, rear_load] = vehicle.load_factors(a_x);
        let front = 2.0
            * vehicle.front_cornering_stiffness_n_per_rad
            * front_load
            * (delta - (v_y + l_f * r) / v);
        let rear =
            2.0 * vehicle.rear_cornering_stiffness_n_per_rad * rear_load * (l_r * r - v_y) / v;
        let force = (front + rear) / vehicle.mass_kg;
        ([force - v * r, (l_f * front - l_r * rear) / vehicle.yaw_inertia_kg_m2], force)
    };
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let mut noise = |deviation: f64| Normal::new(0.0, deviation).unwrap().sample(&mut rng);
    let mut x = [0.0, 0.0];
    let samples = (0..(drive.duration_s / PERIOD_S) as usize).map(|k| {
        let t = k as f64 * PERIOD_S;
        let v = (drive.speed)(t);
        let force = if v < 1.0 {
            let r = v * (drive.angle)(t, v) / (l_f + l_r);
            x = [r * l_r, r];
            v * r
        } else {
            slope(x, t).1
        };
        let shown = x[1];
        if v >= 1.0 {
            let h = PERIOD_S / 10.0;
            for step in 0..10 {
                // Heun.
                let at = t + f64::from(step) * h;
                let (first, _) = slope(x, at);
                let (second, _) = slope([x[0] + h * first[0], x[1] + h * first[1]], at + h);
                x = [
                    x[0] + h / 2.0 * (first[0] + second[0]),
                    x[1] + h / 2.0 * (first[1] + second[1]),
                ];
            }
        }
        let ahead = t + DELAY_S;
        let angle = (drive.angle)(ahead, (drive.speed)(ahead));
        Row {
            time_s: t,
            speed: v + noise(0.02),
            yaw_rate: shown + BIAS_DEG_PER_S.to_radians() + noise(0.002),
            steering: RATIO * (angle + OFFSET_DEG.to_radians()),
            lateral_acceleration: force + noise(0.05),
        }
    });
    samples.collect()
}
