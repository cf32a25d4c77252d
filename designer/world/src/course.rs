//! Manoeuvres by their standard names: steering and speed as functions of time.
//!
//! # Conventions
//! - Open loop: no driver model corrects the path. The double lane change steers for the lateral
//!   offset of ISO 3888-1 over the lengths of its track; the vehicle need not stay between cones.
//! - The amplitude is the road-wheel angle of a steady turn of the vehicle that the design knows, at
//!   the plan's lateral acceleration, as far as the fastest steering allows.
//! - Manoeuvres that end repeat with a pause between, to the other side each time.

use core::f64::consts::{PI, TAU};

use steerguard_detector::Vehicle;

/// Lateral offset of the double lane change (ISO 3888-1), m.
const LANE_OFFSET_M: f64 = 3.5;
/// Lengths of its lane changes, and of the offset lane between them, m.
const LANE_CHANGES_M: [f64; 2] = [30.0, 25.0];
const OFFSET_LANE_M: f64 = 25.0;
/// Frequency of the paper's sine: 0.5 rad/s, in Hz.
const SINE_HZ: f64 = 0.5 / TAU;
/// Frequency of the weave test (ISO 13674-1), Hz.
const WEAVE_HZ: f64 = 0.2;
/// Frequency of the single lane change, Hz.
const LANE_CHANGE_HZ: f64 = 0.5;
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
/// Time in a turn before braking, and after speeding up again, s, and between the two.
const TURN_BEFORE_BRAKING_S: f64 = 2.0;
const TURN_AFTER_BRAKING_S: f64 = 1.0;
const BRAKED_S: f64 = 1.0;
/// Time constant of the speed control, s.
const SPEED_CONTROL_S: f64 = 1.0;

/// Course of steering and speed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Manoeuvre {
    /// No steering.
    Straight,
    /// A sine of 0.5 rad/s: the paper's.
    Sine,
    /// ISO 13674-1: a sine of 0.2 Hz.
    Weave,
    /// ISO 7401: a fast ramp, held.
    StepSteer,
    /// ISO 4138: a fast ramp, held for good.
    SteadyTurn,
    /// One period of a sine of 0.5 Hz.
    LaneChange,
    /// ISO 3888-1, by an open-loop substitute.
    DoubleLaneChange,
    /// ISO 19365: 0.7 Hz, 0.5 s dwell at the second peak.
    SineWithDwell,
    /// Right, three quarters around to the left, right; or mirrored.
    Roundabout {
        /// Radius of the circle.
        radius_m: f64,
    },
    /// Down to a low speed, and up again, steering gently.
    StopAndGo {
        /// The low speed, not above the plan's.
        lowest_speed_m_per_s: f64,
        /// Braking and acceleration, positive.
        longitudinal_acceleration_m_per_s2: f64,
    },
    /// Down to a lower speed, and up again, in a turn with the wheel held.
    BrakingInTurn {
        /// The lower speed, not above the plan's.
        lowest_speed_m_per_s: f64,
        /// Braking and acceleration, positive.
        longitudinal_acceleration_m_per_s2: f64,
    },
}

/// A manoeuvre and how it is driven.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plan {
    /// The manoeuvre.
    pub manoeuvre: Manoeuvre,
    /// Set speed, positive.
    pub speed_m_per_s: f64,
    /// Steady lateral acceleration that the steering corresponds to; the sign is the direction of the
    /// first run.
    pub lateral_acceleration_m_per_s2: f64,
    /// When the first run begins.
    pub start_s: f64,
    /// Time between two runs.
    pub pause_s: f64,
}

/// Steering and speed of a drive.
#[derive(Clone, Copy, Debug)]
pub struct Course {
    plan: Plan,
    vehicle: Vehicle,
    /// Length of a run, s.
    run_s: f64,
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

/// Road-wheel angle of a steady turn at speed `v_x` and lateral acceleration `a_y` of the linear
/// single-track model, rad, without sign: Rajamani (2012), 3.3.
pub fn steady_angle(vehicle: &Vehicle, v_x: f64, a_y: f64) -> f64 {
    let (l_f, l_r) = (vehicle.front_axle_distance_m, vehicle.rear_axle_distance_m);
    let (c_f, c_r) =
        (vehicle.front_cornering_stiffness_n_per_rad, vehicle.rear_cornering_stiffness_n_per_rad);
    let wheelbase = l_f + l_r;
    let understeer = vehicle.mass_kg * (c_r * l_r - c_f * l_f) / (2.0 * c_f * c_r * wheelbase);
    (a_y * (wheelbase / (v_x * v_x) + understeer)).abs()
}

/// Drive torque of a speed control at the set `speed` in m/s with slope `acceleration` in m/s^2, at the
/// measured speed `v_x`, of a driver who takes the vehicle for `vehicle`; N m at the wheels.
pub fn speed_control_n_m(vehicle: &Vehicle, speed: f64, acceleration: f64, v_x: f64) -> f64 {
    vehicle.cruise_torque(speed)
        + vehicle.effective_longitudinal_inertia_kg_m
            * (acceleration + (speed - v_x) / SPEED_CONTROL_S)
}

impl Course {
    /// The course of `plan` for a driver who takes the vehicle for `vehicle` and turns the road wheel
    /// by at most `rate_rad_per_s`.
    pub fn new(plan: &Plan, vehicle: &Vehicle, rate_rad_per_s: f64) -> Self {
        let v = plan.speed_m_per_s;
        let a_y = plan.lateral_acceleration_m_per_s2.abs();
        // Amplitude of a sine for lateral acceleration `a_y` that is nowhere too fast.
        let sine =
            |a_y: f64, hz: f64| steady_angle(vehicle, v, a_y).min(rate_rad_per_s / (TAU * hz));
        let lane_changes = lane_changes(v, a_y, sine);
        let held = steady_angle(vehicle, v, a_y);
        let (run_s, amplitude_rad) = match plan.manoeuvre {
            Manoeuvre::Straight => (f64::INFINITY, 0.0),
            Manoeuvre::Sine => (f64::INFINITY, sine(a_y, SINE_HZ)),
            Manoeuvre::Weave => (f64::INFINITY, sine(a_y, WEAVE_HZ)),
            Manoeuvre::StepSteer => (STEP_HOLD_S, held),
            Manoeuvre::SteadyTurn => (f64::INFINITY, held),
            Manoeuvre::LaneChange => (1.0 / LANE_CHANGE_HZ, sine(a_y, LANE_CHANGE_HZ)),
            Manoeuvre::DoubleLaneChange => {
                let [_, second] = lane_changes;
                (second.begin_s + second.duration_s, second.amplitude_rad)
            }
            Manoeuvre::SineWithDwell => {
                (1.0 / SINE_WITH_DWELL_HZ + DWELL_S, sine(a_y, SINE_WITH_DWELL_HZ))
            }
            Manoeuvre::Roundabout { radius_m } => {
                (1.5 * PI * radius_m / v + 2.0 * ROUNDABOUT_ENTRY_S, held)
            }
            Manoeuvre::StopAndGo { lowest_speed_m_per_s, longitudinal_acceleration_m_per_s2 } => {
                let braking_s = (v - lowest_speed_m_per_s) / longitudinal_acceleration_m_per_s2;
                (2.0 * braking_s + STANDSTILL_S, sine(a_y, GENTLE_STEERING_HZ))
            }
            Manoeuvre::BrakingInTurn {
                lowest_speed_m_per_s,
                longitudinal_acceleration_m_per_s2,
            } => {
                let braking_s = (v - lowest_speed_m_per_s) / longitudinal_acceleration_m_per_s2;
                let braked_s = 2.0 * braking_s + BRAKED_S;
                (TURN_BEFORE_BRAKING_S + braked_s + TURN_AFTER_BRAKING_S, held)
            }
        };
        Self { plan: *plan, vehicle: *vehicle, run_s, amplitude_rad, rate_rad_per_s, lane_changes }
    }

    /// Commanded road-wheel angle at time `t`, rad.
    pub fn steering_rad(&self, t: f64) -> f64 {
        let since_s = t - self.plan.start_s;
        if since_s <= 0.0 {
            return 0.0;
        }
        let side = if self.plan.lateral_acceleration_m_per_s2 < 0.0 { -1.0 } else { 1.0 };
        let endless = |hz: f64| side * self.amplitude_rad * sine(hz * since_s);
        match self.plan.manoeuvre {
            Manoeuvre::Straight => 0.0,
            Manoeuvre::Sine => endless(SINE_HZ),
            Manoeuvre::Weave => endless(WEAVE_HZ),
            Manoeuvre::StopAndGo { .. } => endless(GENTLE_STEERING_HZ),
            Manoeuvre::SteadyTurn => {
                side * self.trapezoid(since_s, 0.0, self.run_s, self.amplitude_rad)
            }
            _ => {
                let cycle_s = self.run_s + self.plan.pause_s;
                let run = libm::floor(since_s / cycle_s);
                let alternation = if libm::fmod(run, 2.0) == 0.0 { 1.0 } else { -1.0 };
                alternation * side * self.run_rad(since_s - run * cycle_s)
            }
        }
    }

    /// Road-wheel angle at time `t` of a run, rad.
    fn run_rad(&self, t: f64) -> f64 {
        let amplitude = self.amplitude_rad;
        match self.plan.manoeuvre {
            Manoeuvre::LaneChange if t < self.run_s => amplitude * sine(LANE_CHANGE_HZ * t),
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
            Manoeuvre::StepSteer | Manoeuvre::BrakingInTurn { .. } => {
                self.trapezoid(t, 0.0, self.run_s, amplitude)
            }
            Manoeuvre::Roundabout { .. } => {
                let (entry, exit) = (ROUNDABOUT_ENTRY_S, self.run_s - ROUNDABOUT_ENTRY_S);
                self.trapezoid(t, 0.0, entry, -0.5 * amplitude)
                    + self.trapezoid(t, entry, exit, amplitude)
                    + self.trapezoid(t, exit, self.run_s, -0.5 * amplitude)
            }
            _ => 0.0,
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
        speed_control_n_m(&self.vehicle, speed, acceleration, v_x)
    }

    /// Set speed in m/s and its slope in m/s^2 at time `t`.
    fn speed(&self, t: f64) -> (f64, f64) {
        let set = self.plan.speed_m_per_s;
        let since_s = t - self.plan.start_s;
        // From when to when of a run the speed is lower.
        let (lowest, a, from_s, to_s) = match self.plan.manoeuvre {
            Manoeuvre::StopAndGo { lowest_speed_m_per_s, longitudinal_acceleration_m_per_s2 } => {
                (lowest_speed_m_per_s, longitudinal_acceleration_m_per_s2, 0.0, self.run_s)
            }
            Manoeuvre::BrakingInTurn {
                lowest_speed_m_per_s,
                longitudinal_acceleration_m_per_s2,
            } => {
                let to_s = self.run_s - TURN_AFTER_BRAKING_S;
                let a = longitudinal_acceleration_m_per_s2;
                (lowest_speed_m_per_s, a, TURN_BEFORE_BRAKING_S, to_s)
            }
            _ => return (set, 0.0),
        };
        if since_s <= 0.0 {
            return (set, 0.0);
        }
        let run_s = libm::fmod(since_s, self.run_s + self.plan.pause_s);
        let braked = set - a * (run_s - from_s).min(to_s - run_s);
        if run_s < from_s || run_s >= to_s {
            (set, 0.0)
        } else if braked <= lowest {
            (lowest, 0.0)
        } else {
            (braked, if run_s < 0.5 * (from_s + to_s) { -a } else { a })
        }
    }
}

/// The two changes at speed `v`, as fast as track and lateral acceleration `a_y` allow, `amplitude`
/// giving the road-wheel angle for a lateral acceleration and a frequency in Hz.
fn lane_changes(v: f64, a_y: f64, amplitude: impl Fn(f64, f64) -> f64) -> [LaneChange; 2] {
    // One period T of a_y sin(2 pi t / T) moves the vehicle aside by a_y T^2 / (2 pi).
    let fastest_s = libm::sqrt(TAU * LANE_OFFSET_M / a_y);
    let mut begin_s = 0.0;
    LANE_CHANGES_M.map(|length_m| {
        let duration_s = fastest_s.max(length_m / v);
        let a_y = TAU * LANE_OFFSET_M / (duration_s * duration_s);
        let amplitude_rad = amplitude(a_y, 1.0 / duration_s);
        let change = LaneChange { begin_s, duration_s, amplitude_rad };
        begin_s += duration_s + OFFSET_LANE_M / v;
        change
    })
}

/// Sine of a number of turns.
fn sine(turns: f64) -> f64 {
    libm::sin(TAU * turns)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const RATE_RAD_PER_S: f64 = 0.3;

    const PLAN: Plan = Plan {
        manoeuvre: Manoeuvre::Straight,
        speed_m_per_s: 15.0,
        lateral_acceleration_m_per_s2: 2.0,
        start_s: 1.5,
        pause_s: 3.0,
    };

    const MANOEUVRES: [Manoeuvre; 11] = [
        Manoeuvre::Straight,
        Manoeuvre::Sine,
        Manoeuvre::Weave,
        Manoeuvre::StepSteer,
        Manoeuvre::LaneChange,
        Manoeuvre::DoubleLaneChange,
        Manoeuvre::SineWithDwell,
        Manoeuvre::Roundabout { radius_m: 20.0 },
        Manoeuvre::StopAndGo { lowest_speed_m_per_s: 2.0, longitudinal_acceleration_m_per_s2: 1.5 },
        Manoeuvre::BrakingInTurn {
            lowest_speed_m_per_s: 2.0,
            longitudinal_acceleration_m_per_s2: 2.5,
        },
        Manoeuvre::SteadyTurn,
    ];

    fn course(plan: Plan) -> Course {
        Course::new(&plan, &Vehicle::PAPER, RATE_RAD_PER_S)
    }

    fn of(manoeuvre: Manoeuvre) -> Course {
        course(Plan { manoeuvre, ..PLAN })
    }

    proptest! {
        #[test]
        fn courses_are_continuous_and_within_the_limits(
            manoeuvre in prop::sample::select(&MANOEUVRES),
            speed_m_per_s in 5.5..29.5_f64,
            lateral_acceleration_m_per_s2 in prop_oneof![-3.0..-0.6_f64, 0.6..3.0_f64],
            start_s in 1.0..3.0_f64,
            pause_s in 2.0..6.0_f64,
        ) {
            let plan =
                Plan { manoeuvre, speed_m_per_s, lateral_acceleration_m_per_s2, start_s, pause_s };
            let course = course(plan);
            let largest =
                steady_angle(&Vehicle::PAPER, speed_m_per_s, lateral_acceleration_m_per_s2);
            let (lowest, slope) = match manoeuvre {
                Manoeuvre::StopAndGo {
                    lowest_speed_m_per_s, longitudinal_acceleration_m_per_s2,
                }
                | Manoeuvre::BrakingInTurn {
                    lowest_speed_m_per_s, longitudinal_acceleration_m_per_s2,
                } => (lowest_speed_m_per_s, longitudinal_acceleration_m_per_s2),
                _ => (speed_m_per_s, 0.0),
            };
            let h = 0.01;
            for k in 0..6000 {
                let t = f64::from(k) * h;
                let delta = course.steering_rad(t);
                let rate = (course.steering_rad(t + h) - delta) / h;
                prop_assert!(delta.abs() <= largest + 1e-12, "{delta} rad at {t} s");
                prop_assert!(rate.abs() <= RATE_RAD_PER_S + 1e-9, "{rate} rad/s at {t} s");
                let (speed, _) = course.speed(t);
                let acceleration = (course.speed(t + h).0 - speed) / h;
                prop_assert!((lowest..=speed_m_per_s).contains(&speed));
                prop_assert!(acceleration.abs() <= slope + 1e-9, "{acceleration} at {t} s");
                let mirrored = Course::new(
                    &Plan { lateral_acceleration_m_per_s2: -lateral_acceleration_m_per_s2, ..plan },
                    &Vehicle::PAPER,
                    RATE_RAD_PER_S,
                );
                prop_assert_eq!(mirrored.steering_rad(t), -delta);
            }
        }
    }

    #[test]
    fn a_lane_change_moves_the_vehicle_by_the_offset_of_the_standard() {
        for speed_m_per_s in [6.0, 10.0, 15.0, 20.0, 29.0] {
            let plan = Plan { manoeuvre: Manoeuvre::DoubleLaneChange, speed_m_per_s, ..PLAN };
            let course = course(plan);
            let per_angle = 1.0 / steady_angle(&Vehicle::PAPER, speed_m_per_s, 1.0);
            let h = 1e-3;
            let [_, back] = course.lane_changes;
            let (mut offset, mut speed) = (0.0, 0.0);
            for k in 0..(back.begin_s / h) as u32 {
                let a_y = per_angle * course.steering_rad(plan.start_s + f64::from(k) * h);
                speed += h * a_y;
                offset += h * speed;
            }
            assert!((offset - LANE_OFFSET_M).abs() < 0.01, "{offset} m at {speed_m_per_s} m/s");
        }
    }

    #[test]
    fn runs_alternate_sides() {
        let course = of(Manoeuvre::StepSteer);
        let cycle_s = course.run_s + PLAN.pause_s;
        let held = |run: f64| course.steering_rad(PLAN.start_s + run * cycle_s + 0.5 * STEP_HOLD_S);
        assert!(held(0.0) > 0.0);
        assert_eq!(held(0.0), -held(1.0));
        assert_eq!(held(0.0), held(2.0));
    }

    #[test]
    fn a_steady_turn_stays() {
        let course = of(Manoeuvre::SteadyTurn);
        assert_eq!(course.steering_rad(PLAN.start_s + 1.0), course.amplitude_rad);
        assert_eq!(course.steering_rad(1e6), course.amplitude_rad);
    }

    #[test]
    fn stop_and_go_reaches_its_lowest_speed_and_comes_back() {
        let course = of(MANOEUVRES[8]);
        let at = |run_s| course.speed(PLAN.start_s + run_s).0;
        assert_eq!(at(0.5 * course.run_s), 2.0);
        assert_eq!(at(course.run_s), PLAN.speed_m_per_s);
    }

    #[test]
    fn braking_in_a_turn_holds_the_wheel() {
        let course = of(MANOEUVRES[9]);
        let middle_s = 0.5 * (TURN_BEFORE_BRAKING_S + course.run_s - TURN_AFTER_BRAKING_S);
        assert_eq!(course.speed(PLAN.start_s + middle_s).0, 2.0);
        for run_s in [TURN_BEFORE_BRAKING_S, middle_s, course.run_s - TURN_AFTER_BRAKING_S] {
            assert_eq!(course.steering_rad(PLAN.start_s + run_s), course.amplitude_rad);
        }
    }

    #[test]
    fn sines_have_the_frequencies_of_their_tests() {
        for (manoeuvre, quarter_s) in
            [(Manoeuvre::Sine, PI), (Manoeuvre::Weave, 1.25), (Manoeuvre::LaneChange, 0.5)]
        {
            let course = of(manoeuvre);
            for (quarter, expected) in [(1.0, 1.0), (2.0, 0.0), (3.0, -1.0)] {
                let found = course.steering_rad(PLAN.start_s + quarter * quarter_s);
                let expected = expected * course.amplitude_rad;
                assert!((found - expected).abs() < 1e-12, "{manoeuvre:?}: {found}");
            }
        }
    }

    #[test]
    fn dwells_at_the_second_peak() {
        let course = of(Manoeuvre::SineWithDwell);
        let at = |t: f64| course.run_rad(t) / course.amplitude_rad;
        let peak_s = 0.75 / SINE_WITH_DWELL_HZ;
        assert!((at(peak_s / 3.0) - 1.0).abs() < 1e-12);
        for dwell_s in [0.0, 0.25, 0.5] {
            assert!((at(peak_s + dwell_s) + 1.0).abs() < 1e-12);
        }
        assert_eq!(at(course.run_s + 1e-9), 0.0);
    }
}
