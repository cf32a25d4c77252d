//! Manoeuvres by their standard names: steering and speed as functions of time.
//!
//! # Conventions
//! - Open loop: no driver model corrects the path. The double lane change steers for the lateral
//!   offset of ISO 3888-1 over the lengths of its track; the vehicle need not stay between cones.
//! - The amplitude is the road-wheel angle of a steady turn of the vehicle that the design knows, at
//!   the drive's lateral acceleration, as far as the design's fastest steering allows.
//! - Manoeuvres repeat with a pause between, to the other side each time.

use std::f64::consts::{PI, TAU};

use steerguard_detector::Vehicle;

use super::drive::Drive;
use super::record::named;
use super::settings::Subject;

/// Lateral offset of the double lane change (ISO 3888-1), m.
const LANE_OFFSET_M: f64 = 3.5;
/// Lengths of its sections: first change, offset lane, second change, m.
const LANE_SECTIONS_M: [f64; 3] = [30.0, 25.0, 25.0];
/// Frequency of the weave test (ISO 13674-1), Hz.
const WEAVE_HZ: f64 = 0.2;
/// Frequency of the sine with dwell (ISO 19365), Hz, and its dwell, s.
const SINE_WITH_DWELL_HZ: f64 = 0.7;
const DWELL_S: f64 = 0.5;
/// How long a step steer (ISO 7401) is held, s.
const STEP_HOLD_S: f64 = 4.0;
/// How long entry and exit of a roundabout take, s.
const ROUNDABOUT_ENTRY_S: f64 = 1.5;
/// How long stop and go stands, s, and the frequency of its gentle steering, Hz.
const STANDSTILL_S: f64 = 2.0;
const GENTLE_STEERING_HZ: f64 = 0.1;
/// Time constant of the speed control, s.
const SPEED_CONTROL_S: f64 = 1.0;

named! {
    /// Course of steering and speed.
    pub enum Manoeuvre {
        /// ISO 3888-1, by an open-loop substitute.
        DoubleLaneChange = "double lane change",
        /// ISO 13674-1: a sine of 0.2 Hz.
        Weave = "weave",
        /// ISO 7401: a fast ramp, held.
        StepSteer = "step steer",
        /// ISO 19365: 0.7 Hz, 0.5 s dwell at the second peak.
        SineWithDwell = "sine with dwell",
        /// No steering.
        Straight = "straight",
        /// Right, three quarters around to the left, right; or mirrored.
        Roundabout = "roundabout",
        /// Down to and below the design's range, and up again, steering gently.
        StopAndGo = "stop and go",
    }
}

/// Steering and speed of a drive.
#[derive(Clone, Copy, Debug)]
pub struct Course {
    manoeuvre: Manoeuvre,
    vehicle: Vehicle,
    speed_m_per_s: f64,
    lowest_speed_m_per_s: f64,
    longitudinal_acceleration_m_per_s2: f64,
    start_s: f64,
    /// Length of a run, and from one run to the next, s.
    run_s: f64,
    cycle_s: f64,
    /// Largest road-wheel angle, signed for the first run, rad, and rate, rad/s.
    amplitude_rad: f64,
    rate_rad_per_s: f64,
    /// Ends of the three sections of the double lane change since its begin, s.
    sections_s: [f64; 3],
}

impl Course {
    /// The course of `drive`.
    pub fn of(drive: &Drive, subject: &Subject) -> Self {
        let v = drive.speed_m_per_s;
        let lateral = drive.lateral_acceleration_m_per_s2;
        let magnitude = lateral.abs();
        // One period of sin in the acceleration moves the vehicle by a_y T^2 / (2 pi).
        let shortest_s = libm::sqrt(TAU * LANE_OFFSET_M / magnitude);
        let [first, hold, second] = LANE_SECTIONS_M.map(|length_m| length_m / v);
        let (first, second) = (first.max(shortest_s), second.max(shortest_s));
        let sections_s = [first, first + hold, first + hold + second];

        let rate = subject.steering_rate_rad_per_s;
        let acceleration = drive.longitudinal_acceleration_m_per_s2.unwrap_or(1.0);
        let lowest = drive.lowest_speed_m_per_s.unwrap_or(v);
        let (run_s, fastest_rad_per_s) = match drive.manoeuvre {
            Manoeuvre::DoubleLaneChange => (sections_s[2], TAU / second.min(first)),
            Manoeuvre::Weave => (f64::INFINITY, TAU * WEAVE_HZ),
            Manoeuvre::StepSteer => (STEP_HOLD_S, 0.0),
            Manoeuvre::SineWithDwell => {
                (1.0 / SINE_WITH_DWELL_HZ + DWELL_S, TAU * SINE_WITH_DWELL_HZ)
            }
            Manoeuvre::Straight => (f64::INFINITY, 0.0),
            Manoeuvre::Roundabout => {
                let around_s = 1.5 * PI * drive.radius_m.unwrap_or(1.0) / v;
                (around_s + 2.0 * ROUNDABOUT_ENTRY_S, 0.0)
            }
            Manoeuvre::StopAndGo => {
                (2.0 * (v - lowest) / acceleration + STANDSTILL_S, TAU * GENTLE_STEERING_HZ)
            }
        };
        let full = steady_angle(&subject.vehicle, v, magnitude);
        let amplitude =
            if fastest_rad_per_s > 0.0 { full.min(rate / fastest_rad_per_s) } else { full };
        Self {
            manoeuvre: drive.manoeuvre,
            vehicle: subject.vehicle,
            speed_m_per_s: v,
            lowest_speed_m_per_s: lowest,
            longitudinal_acceleration_m_per_s2: acceleration,
            start_s: drive.manoeuvre_start_s,
            run_s,
            cycle_s: run_s + drive.pause_s,
            amplitude_rad: if lateral < 0.0 { -amplitude } else { amplitude },
            rate_rad_per_s: rate,
            sections_s,
        }
    }

    /// Commanded road-wheel angle at time `t`, rad.
    pub fn steering_rad(&self, t: f64) -> f64 {
        let since_s = t - self.start_s;
        match self.manoeuvre {
            _ if since_s <= 0.0 => 0.0,
            Manoeuvre::Straight => 0.0,
            Manoeuvre::Weave => self.amplitude_rad * sine(WEAVE_HZ * since_s),
            Manoeuvre::StopAndGo => self.amplitude_rad * sine(GENTLE_STEERING_HZ * since_s),
            _ => {
                let run = libm::floor(since_s / self.cycle_s);
                let side = if libm::fmod(run, 2.0) == 0.0 { 1.0 } else { -1.0 };
                side * self.run_rad(since_s - run * self.cycle_s)
            }
        }
    }

    /// Road-wheel angle at time `t` of a run, rad.
    fn run_rad(&self, t: f64) -> f64 {
        let amplitude = self.amplitude_rad;
        match self.manoeuvre {
            Manoeuvre::DoubleLaneChange => {
                let [first, hold, second] = self.sections_s;
                if t < first {
                    amplitude * sine(t / first)
                } else if hold <= t && t < second {
                    -amplitude * sine((t - hold) / (second - hold))
                } else {
                    0.0
                }
            }
            Manoeuvre::SineWithDwell => {
                let period_s = 1.0 / SINE_WITH_DWELL_HZ;
                let peak_s = 0.75 * period_s;
                // The phase stands still during the dwell.
                let phase_s = if t < peak_s { t } else { peak_s.max(t - DWELL_S) };
                if phase_s < period_s { amplitude * sine(phase_s / period_s) } else { 0.0 }
            }
            Manoeuvre::StepSteer => self.trapezoid(t, 0.0, self.run_s, amplitude),
            Manoeuvre::Roundabout => {
                let (entry, exit) = (ROUNDABOUT_ENTRY_S, self.run_s - ROUNDABOUT_ENTRY_S);
                self.trapezoid(t, 0.0, entry, -0.5 * amplitude)
                    + self.trapezoid(t, entry, exit, amplitude)
                    + self.trapezoid(t, exit, self.run_s, -0.5 * amplitude)
            }
            Manoeuvre::Weave | Manoeuvre::Straight | Manoeuvre::StopAndGo => 0.0,
        }
    }

    /// A ramp to `amplitude` from time `from` on, and back to 0 until `to`, at the fastest rate.
    fn trapezoid(&self, t: f64, from: f64, to: f64, amplitude: f64) -> f64 {
        let ramp = self.rate_rad_per_s * (t - from).min(to - t);
        let magnitude = ramp.max(0.0).min(amplitude.abs());
        if amplitude < 0.0 { -magnitude } else { magnitude }
    }

    /// Drive torque of the speed control at time `t` and measured speed `v_x`, N m at the wheels.
    pub fn drive_torque_n_m(&self, t: f64, v_x: f64) -> f64 {
        let (speed, acceleration) = self.speed(t);
        self.vehicle.cruise_torque(speed)
            + self.vehicle.effective_longitudinal_inertia_kg_m
                * (acceleration + (speed - v_x) / SPEED_CONTROL_S)
    }

    /// Set speed in m/s and its slope in m/s^2 at time `t`.
    fn speed(&self, t: f64) -> (f64, f64) {
        let since_s = t - self.start_s;
        if self.manoeuvre != Manoeuvre::StopAndGo || since_s <= 0.0 {
            return (self.speed_m_per_s, 0.0);
        }
        let run_s = libm::fmod(since_s, self.cycle_s);
        let a = self.longitudinal_acceleration_m_per_s2;
        let braked = self.speed_m_per_s - a * run_s.min(self.run_s - run_s);
        if run_s >= self.run_s {
            (self.speed_m_per_s, 0.0)
        } else if braked <= self.lowest_speed_m_per_s {
            (self.lowest_speed_m_per_s, 0.0)
        } else {
            (braked, if run_s < 0.5 * self.run_s { -a } else { a })
        }
    }
}

/// Sine of a number of turns, on every machine the same.
fn sine(turns: f64) -> f64 {
    libm::sin(TAU * turns)
}

/// Road-wheel angle of a steady turn at speed `v_x` and lateral acceleration `a_y` of the linear
/// single-track model, rad: Rajamani (2012), 3.3.
pub fn steady_angle(vehicle: &Vehicle, v_x: f64, a_y: f64) -> f64 {
    let (l_f, l_r) = (vehicle.front_axle_distance_m, vehicle.rear_axle_distance_m);
    let (c_f, c_r) =
        (vehicle.front_cornering_stiffness_n_per_rad, vehicle.rear_cornering_stiffness_n_per_rad);
    let gradient = vehicle.mass_kg * (c_r * l_r - c_f * l_f) / (2.0 * c_f * c_r * (l_f + l_r));
    (a_y * ((l_f + l_r) / (v_x * v_x) + gradient)).abs()
}
