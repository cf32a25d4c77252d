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
use steerguard_world::steady_angle;

use super::drive::Drive;
pub use super::kind::Manoeuvre;
use super::settings::Subject;

/// Lateral offset of the double lane change (ISO 3888-1), m.
const LANE_OFFSET_M: f64 = 3.5;
/// Lengths of its lane changes, and of the offset lane between them, m.
const LANE_CHANGES_M: [f64; 2] = [30.0, 25.0];
const OFFSET_LANE_M: f64 = 25.0;
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
    /// 1 if the first run is to the left, otherwise -1.
    side: f64,
    /// Largest road-wheel angle, rad, and rate, rad/s.
    amplitude_rad: f64,
    rate_rad_per_s: f64,
    lane_changes: [LaneChange; 2],
}

/// A change of lanes, within a run of the double lane change.
#[derive(Clone, Copy, Debug, Default)]
struct LaneChange {
    begin_s: f64,
    duration_s: f64,
    amplitude_rad: f64,
}

/// The two changes at speed `v`, as fast as track and lateral acceleration `a_y` allow.
fn lane_changes(subject: &Subject, v: f64, a_y: f64) -> [LaneChange; 2] {
    // One period T of a_y sin(2 pi t / T) moves the vehicle aside by a_y T^2 / (2 pi).
    let fastest_s = libm::sqrt(TAU * LANE_OFFSET_M / a_y);
    let mut begin_s = 0.0;
    LANE_CHANGES_M.map(|length_m| {
        let duration_s = fastest_s.max(length_m / v);
        let a_y = TAU * LANE_OFFSET_M / (duration_s * duration_s);
        let amplitude_rad = limited(subject, v, a_y, TAU / duration_s);
        let change = LaneChange { begin_s, duration_s, amplitude_rad };
        begin_s += duration_s + OFFSET_LANE_M / v;
        change
    })
}

/// Amplitude of a sine of angular frequency `rad_per_s` for lateral acceleration `a_y` at speed `v`
/// that is nowhere faster than the design's fastest steering, rad.
fn limited(subject: &Subject, v: f64, a_y: f64, rad_per_s: f64) -> f64 {
    steady_angle(&subject.vehicle, v, a_y).min(subject.steering_rate_rad_per_s / rad_per_s)
}

impl Course {
    /// The course of `drive`.
    pub fn of(drive: &Drive, subject: &Subject) -> Self {
        let v = drive.speed_m_per_s;
        let lateral = drive.lateral_acceleration_m_per_s2;
        let acceleration = drive.longitudinal_acceleration_m_per_s2.unwrap_or(1.0);
        let lowest = drive.lowest_speed_m_per_s.unwrap_or(v);
        let side = if lateral < 0.0 { -1.0 } else { 1.0 };
        let lane_changes = lane_changes(subject, v, lateral.abs());
        let sine = |hz: f64| limited(subject, v, lateral.abs(), TAU * hz);
        let held = steady_angle(&subject.vehicle, v, lateral.abs());
        let (run_s, amplitude_rad) = match drive.manoeuvre {
            Manoeuvre::DoubleLaneChange => {
                let [_, second] = lane_changes;
                (second.begin_s + second.duration_s, second.amplitude_rad)
            }
            Manoeuvre::Weave => (f64::INFINITY, sine(WEAVE_HZ)),
            Manoeuvre::StepSteer => (STEP_HOLD_S, held),
            Manoeuvre::SineWithDwell => {
                (1.0 / SINE_WITH_DWELL_HZ + DWELL_S, sine(SINE_WITH_DWELL_HZ))
            }
            Manoeuvre::Straight => (f64::INFINITY, 0.0),
            Manoeuvre::Roundabout => {
                let around_s = 1.5 * PI * drive.radius_m.unwrap_or(1.0) / v;
                (around_s + 2.0 * ROUNDABOUT_ENTRY_S, held)
            }
            Manoeuvre::StopAndGo => {
                let braking_s = (v - lowest) / acceleration;
                (2.0 * braking_s + STANDSTILL_S, sine(GENTLE_STEERING_HZ))
            }
        };
        Self {
            manoeuvre: drive.manoeuvre,
            vehicle: subject.vehicle,
            speed_m_per_s: v,
            lowest_speed_m_per_s: lowest,
            longitudinal_acceleration_m_per_s2: acceleration,
            start_s: drive.manoeuvre_start_s,
            run_s,
            cycle_s: run_s + drive.pause_s,
            side,
            amplitude_rad,
            rate_rad_per_s: subject.steering_rate_rad_per_s,
            lane_changes,
        }
    }

    /// Commanded road-wheel angle at time `t`, rad.
    pub fn steering_rad(&self, t: f64) -> f64 {
        let since_s = t - self.start_s;
        match self.manoeuvre {
            _ if since_s <= 0.0 => 0.0,
            Manoeuvre::Straight => 0.0,
            Manoeuvre::Weave => self.side * self.amplitude_rad * sine(WEAVE_HZ * since_s),
            Manoeuvre::StopAndGo => {
                self.side * self.amplitude_rad * sine(GENTLE_STEERING_HZ * since_s)
            }
            _ => {
                let run = libm::floor(since_s / self.cycle_s);
                let alternation = if libm::fmod(run, 2.0) == 0.0 { 1.0 } else { -1.0 };
                alternation * self.side * self.run_rad(since_s - run * self.cycle_s)
            }
        }
    }

    /// Road-wheel angle at time `t` of a run, rad.
    fn run_rad(&self, t: f64) -> f64 {
        let amplitude = self.amplitude_rad;
        match self.manoeuvre {
            Manoeuvre::DoubleLaneChange => {
                let [there, back] = self.lane_changes.map(|change| {
                    let turns = (t - change.begin_s) / change.duration_s;
                    let drives = (0.0..1.0).contains(&turns);
                    if drives { change.amplitude_rad * sine(turns) } else { 0.0 }
                });
                there - back
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

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::campaign::settings::tests::{PAPER, SETTINGS};

    /// Drive number `index` with the given manoeuvre, and its course.
    fn course(manoeuvre: Manoeuvre, index: u64) -> (Drive, Course) {
        let drive = (index..)
            .map(|index| Drive::draw(&SETTINGS, &PAPER, index))
            .find(|drive| drive.manoeuvre == manoeuvre)
            .unwrap();
        let course = Course::of(&drive, &PAPER);
        (drive, course)
    }

    proptest! {
        #[test]
        fn courses_are_continuous_and_within_the_limits(index in 0..u64::MAX / 2) {
            let drive = Drive::draw(&SETTINGS, &PAPER, index);
            let course = Course::of(&drive, &PAPER);
            let largest = steady_angle(
                &PAPER.vehicle,
                drive.speed_m_per_s,
                drive.lateral_acceleration_m_per_s2,
            );
            let slope = drive.longitudinal_acceleration_m_per_s2.unwrap_or(0.0);
            let lowest = drive.lowest_speed_m_per_s.unwrap_or(drive.speed_m_per_s);
            let h = 0.01;
            for k in 0..6000 {
                let t = f64::from(k) * h;
                let delta = course.steering_rad(t);
                let rate = (course.steering_rad(t + h) - delta) / h;
                prop_assert!(delta.abs() <= largest + 1e-12, "{delta} rad at {t} s");
                prop_assert!(rate.abs() <= PAPER.steering_rate_rad_per_s + 1e-9, "{rate} at {t}");
                let (speed, _) = course.speed(t);
                let acceleration = (course.speed(t + h).0 - speed) / h;
                prop_assert!((lowest..=drive.speed_m_per_s).contains(&speed));
                prop_assert!(acceleration.abs() <= slope + 1e-9, "{acceleration} at {t}");
            }
        }
    }

    #[test]
    fn a_lane_change_moves_the_vehicle_by_the_offset_of_the_standard() {
        for index in 0..20 {
            let (drive, course) = course(Manoeuvre::DoubleLaneChange, index);
            let v = drive.speed_m_per_s;
            let per_angle = 1.0 / steady_angle(&PAPER.vehicle, v, 1.0);
            let h = 1e-3;
            let end_s = course.lane_changes[1].begin_s;
            let (mut offset, mut speed) = (0.0, 0.0);
            for k in 0..(end_s / h) as u32 {
                let a_y = per_angle * course.steering_rad(course.start_s + f64::from(k) * h);
                speed += h * a_y;
                offset += h * speed;
            }
            assert!((offset.abs() - LANE_OFFSET_M).abs() < 0.01, "{offset} m at {v} m/s");
        }
    }

    #[test]
    fn runs_alternate_sides() {
        let (_, course) = course(Manoeuvre::StepSteer, 0);
        let held = |run: f64| {
            course.steering_rad(course.start_s + run * course.cycle_s + 0.5 * STEP_HOLD_S)
        };
        assert!(held(0.0).abs() > 0.0);
        assert_eq!(held(0.0), -held(1.0));
        assert_eq!(held(0.0), held(2.0));
    }

    #[test]
    fn stop_and_go_reaches_its_lowest_speed_and_comes_back() {
        let (drive, course) = course(Manoeuvre::StopAndGo, 0);
        let at = |run_s| course.speed(course.start_s + run_s).0;
        assert_eq!(Some(at(0.5 * course.run_s)), drive.lowest_speed_m_per_s);
        assert!(at(0.5 * course.run_s) < PAPER.armed_v_x.min);
        assert_eq!(at(course.run_s), drive.speed_m_per_s);
    }

    #[test]
    fn dwells_at_the_second_peak() {
        let (_, course) = course(Manoeuvre::SineWithDwell, 0);
        let at = |t: f64| course.run_rad(t) / course.amplitude_rad;
        let peak_s = 0.75 / SINE_WITH_DWELL_HZ;
        assert!((at(peak_s / 3.0) - 1.0).abs() < 1e-12);
        for dwell_s in [0.0, 0.25, 0.5] {
            assert!((at(peak_s + dwell_s) + 1.0).abs() < 1e-12);
        }
        assert_eq!(at(course.run_s + 1e-9), 0.0);
    }
}
