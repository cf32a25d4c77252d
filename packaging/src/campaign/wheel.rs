//! Where the healthy steering actuator of a drive stands: what faults depart from.

use steerguard_detector::{Actuator, ActuatorState};

use super::manoeuvre::Course;

/// The road-wheel angle of the healthy actuator as a function of time.
pub struct Wheel<'a> {
    course: &'a Course,
    period_s: f64,
    /// Averages over the samples, rad; none without an actuator.
    angles: Vec<f64>,
}

impl<'a> Wheel<'a> {
    /// Under the commands of `samples` samples of `course`.
    pub fn new(course: &'a Course, actuator: &Actuator, period_s: f64, samples: u32) -> Self {
        let mut state = ActuatorState::START;
        let mut turn =
            |k| state.sample(actuator, period_s, course.steering_rad(f64::from(k) * period_s));
        let samples = if *actuator == Actuator::NONE { 0 } else { samples };
        Self { course, period_s, angles: (0..samples).map(&mut turn).collect() }
    }

    /// The angle at time `t`: the average over its sample.
    pub fn angle_rad(&self, t: f64) -> f64 {
        // The slack keeps a time of n periods in sample n whatever its last bit.
        let sample = (t / self.period_s + 1e-6) as usize;
        let angle = self.angles.get(sample).or(self.angles.last());
        angle.copied().unwrap_or_else(|| self.course.steering_rad(t))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::campaign::drive::Drive;
    use crate::campaign::manoeuvre::Manoeuvre;
    use crate::campaign::settings::tests::{PAPER, SETTINGS};

    #[test]
    fn the_wheel_follows_the_command_through_the_actuator() {
        let manoeuvre = Manoeuvre::Weave;
        let course = Course::of(&Drive { manoeuvre, ..Drive::draw(&SETTINGS, &PAPER, 0) }, &PAPER);
        let none = Wheel::new(&course, &Actuator::NONE, 0.01, 1000);
        let late = Actuator { delay_s: 0.2, ..Actuator::NONE };
        let late = Wheel::new(&course, &late, 0.01, 1000);
        for k in 0..1000 {
            let t = f64::from(k) * 0.01;
            assert_eq!(none.angle_rad(t + 0.003), course.steering_rad(t + 0.003));
            let expected = course.steering_rad(f64::from((k - 20).max(0)) * 0.01);
            assert!((late.angle_rad(t) - expected).abs() < 1e-12, "{t} s");
        }
        assert_eq!(late.angle_rad(1e3), late.angle_rad(9.995));
    }
}
