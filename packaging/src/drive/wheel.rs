//! Where the healthy steering actuator of a drive stands: what faults depart from.
//!
//! The plant has an actuator too, but tells where it stands only once a step is over: `true.delta` less
//! `fault` is the angle that the last command led to. A wheel that is to stay where it is needs the
//! angle of the step to come, since the fault that holds it is held over that step. Commands are
//! functions of time, so the actuator is run ahead here, by the world's own code.

use steerguard_detector::Actuator;
use steerguard_world::{Fault, STEP_S, Steering, SteeringState};

/// Times are compared to this fraction of a step.
const SLACK: f64 = 1e-6;

/// The road-wheel angle of the healthy actuator as a function of time.
pub struct Wheel {
    period_s: f64,
    /// Averages over the samples, rad.
    angles_rad: Vec<f64>,
}

impl Wheel {
    /// Under the commands of `samples` samples, each held for `period_s`; `command_rad` gives that of a
    /// time in s, rad.
    pub fn new(
        command_rad: impl Fn(f64) -> f64,
        actuator: &Actuator,
        period_s: f64,
        samples: u32,
    ) -> Self {
        let steering = Steering::of(*actuator);
        let mut state = SteeringState::new(&steering, STEP_S, command_rad(0.0));
        let mut internal_steps = 0.0;
        let average_rad = |k: u32| {
            let command_rad = command_rad(f64::from(k) * period_s);
            let (mut sum_rad, mut steps) = (0.0, 0.0);
            while internal_steps * STEP_S < f64::from(k + 1) * period_s - SLACK * STEP_S {
                let [begin, middle, end] = state.step(&steering, STEP_S, command_rad);
                sum_rad += (begin + 4.0 * middle + end) / 6.0;
                internal_steps += 1.0;
                steps += 1.0;
            }
            if steps > 0.0 { sum_rad / steps } else { state.angle_rad }
        };
        Self { period_s, angles_rad: (0..samples).map(average_rad).collect() }
    }

    /// The angle at time `t`, rad: the average over its sample, over the last one after the end.
    pub fn angle_rad(&self, t: f64) -> f64 {
        // The slack keeps a time of n periods in sample n whatever its last bit.
        let sample = (t / self.period_s + SLACK) as usize;
        self.angles_rad.get(sample).or(self.angles_rad.last()).copied().unwrap_or(0.0)
    }

    /// The angle that `fault` adds to it at time `t`, rad.
    pub fn fault_rad(&self, fault: Option<&Fault>, t: f64) -> f64 {
        fault.map_or(0.0, |fault| fault.angle_rad(t, |t| self.angle_rad(t)))
    }
}

#[cfg(test)]
mod tests {
    use steerguard_detector::Vehicle;
    use steerguard_world::{Course, Manoeuvre, Plan};

    use super::*;

    const PERIOD_S: f64 = 0.01;

    fn course(manoeuvre: Manoeuvre) -> Course {
        let plan = Plan {
            manoeuvre,
            speed_m_per_s: 15.0,
            lateral_acceleration_m_per_s2: 2.0,
            start_s: 1.5,
            pause_s: 3.0,
        };
        Course::new(&plan, &Vehicle::PAPER, 0.3)
    }

    #[test]
    fn the_wheel_follows_the_command_through_the_actuator() {
        let course = course(Manoeuvre::Weave);
        let at = |k: u32| course.steering_rad(f64::from(k) * PERIOD_S);
        for steps in [0, 20] {
            let delay_s = f64::from(steps) * PERIOD_S;
            let actuator = Actuator { delay_s, ..Actuator::NONE };
            let wheel = Wheel::new(|t| course.steering_rad(t), &actuator, PERIOD_S, 1000);
            for k in 0..1000_u32 {
                let found = wheel.angle_rad((f64::from(k) + 0.3) * PERIOD_S);
                assert!((found - at(k.saturating_sub(steps))).abs() < 1e-12, "sample {k}");
            }
            assert_eq!(wheel.angle_rad(1e3), wheel.angle_rad(9.995));
        }
    }

    #[test]
    fn a_lag_is_behind_a_ramp_by_its_time() {
        let course = course(Manoeuvre::StepSteer);
        let actuator = Actuator { lag_s: 0.01, ..Actuator::NONE };
        let period_s = 1e-3;
        let wheel = Wheel::new(|t| course.steering_rad(t), &actuator, period_s, 2000);
        let t = 1.55;
        let slope = (course.steering_rad(t + period_s) - course.steering_rad(t)) / period_s;
        assert!((slope - 0.3).abs() < 1e-9, "{slope}");
        // A command that is held is behind the ramp by half a sample, as far as the sample's middle is
        // ahead of its begin. Of the lag's start, e^-5 is left after 5 time constants.
        let expected = course.steering_rad(t) - slope * 0.01;
        let left = slope * 0.01 * (-0.05_f64 / 0.01).exp();
        assert!((wheel.angle_rad(t) - expected).abs() < 2.0 * left, "{}", wheel.angle_rad(t));
    }
}
