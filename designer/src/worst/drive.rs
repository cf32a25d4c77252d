//! A fault-free drive of the search: vehicle, courses, and the largest ratio along it.
//!
//! # Conventions
//! Those of [`crate::simulation`]. Courses are values for each sampling period, held over it; after their
//! end the last one is held.

use steerguard_detector::{Gust, Monitor, Vehicle, VehicleState};
use steerguard_world::{
    GRAVITY_M_PER_S2, Sensors, State, Steering, TrueVehicle, Tyres, World, bank_m_per_s2,
    held_sample, speed_control_n_m,
};

use crate::simulation::{Acting, Driving, Sampled, Simulation, Surroundings};
use crate::spec::Spec;
use crate::worst::judge::Judge;

/// A fault-free drive.
#[derive(Clone, Debug, PartialEq)]
pub struct Drive {
    /// The vehicle driven.
    pub vehicle: Vehicle,
    /// Its tyres.
    pub tyres: Tyres,
    /// Its steering.
    pub steering: Steering,
    /// Relative error of the speed shown.
    pub v_x_scale: f64,
    /// Yaw rate shown at standstill.
    pub yaw_rate_bias_rad_per_s: f64,
    /// State at the start.
    pub start: VehicleState,
    /// Seed of the sensors' noise.
    pub noise_seed: i32,
    /// What changes along the drive.
    pub courses: Courses,
}

/// What changes along a drive, a value for each sampling period.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Courses {
    /// Sampling period.
    pub period_s: f64,
    /// Commanded road-wheel angle.
    pub steering_rad: Vec<f64>,
    /// Set speed of the driver, who takes the vehicle for the design's.
    pub speed_m_per_s: Vec<f64>,
    /// Road bank, positive with the left side raised.
    pub bank_deg: Vec<f64>,
    /// Wind across the road, positive to the left.
    pub wind_m_per_s: Vec<f64>,
}

/// The sample with the largest ratio of a drive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Worst {
    /// J/J_th, or the statistic of the second test over its threshold.
    pub ratio: f64,
    /// Its time.
    pub time_s: f64,
    /// Measured speed there.
    pub v_x_m_per_s: f64,
    /// Measured speed times measured yaw rate there.
    pub lateral_acceleration_m_per_s2: f64,
}

/// Value of a course at time `t`; 0 of an empty one.
fn at(values: &[f64], period_s: f64, t: f64) -> f64 {
    held_sample(values, period_s, t).unwrap_or(0.0)
}

/// The courses as a driver drives them who takes the vehicle for `vehicle`.
struct Driver<'a> {
    courses: &'a Courses,
    vehicle: &'a Vehicle,
}

impl Driving for Driver<'_> {
    fn steering_rad(&self, t: f64) -> f64 {
        at(&self.courses.steering_rad, self.courses.period_s, t)
    }

    fn drive_torque_n_m(&self, t: f64, v_x: f64) -> f64 {
        let Courses { period_s, speed_m_per_s, .. } = self.courses;
        let [speed, next] = [t, t + period_s].map(|t| at(speed_m_per_s, *period_s, t));
        speed_control_n_m(self.vehicle, speed, (next - speed) / period_s, v_x)
    }
}

/// Road and air.
struct Around<'a> {
    courses: &'a Courses,
    mass_kg: f64,
    action: Gust,
}

impl Acting for Around<'_> {
    fn on_body(&self, t: f64, v_x: f64) -> [f64; 2] {
        let Courses { period_s, bank_deg, wind_m_per_s, .. } = self.courses;
        let wind = Gust { speed_m_per_s: at(wind_m_per_s, *period_s, t), ..self.action };
        let force_n = wind.side_force(v_x);
        let bank_rad = at(bank_deg, *period_s, t).to_radians();
        [force_n + self.mass_kg * bank_m_per_s2(bank_rad), force_n * wind.acting_ahead_m]
    }
}

impl Drive {
    /// Whether the vehicle does not spin: neither axle slides, a linear tyre would not give more than friction
    /// holds; and the yaw rate is not beyond `mu g / v_x`, at which no road bends the path as fast as the
    /// vehicle turns (Rajamani 2012, 8.3).
    fn holds(&self, state: &State, torque_n_m: f64, largest_friction: f64) -> bool {
        let v_x = state.motion.v_x_m_per_s;
        let follows =
            |friction: f64| (v_x * state.motion.r_rad_per_s).abs() <= friction * GRAVITY_M_PER_S2;
        let Tyres::Saturating { friction } = self.tyres else { return follows(largest_friction) };
        let a_x = (torque_n_m - self.vehicle.cruise_torque(v_x))
            / self.vehicle.effective_longitudinal_inertia_kg_m;
        let vehicle = TrueVehicle { data: self.vehicle, tyres: self.tyres };
        let forces = vehicle.axle_forces_n(state.motion, state.steering.angle_rad, a_x);
        let loads = self.vehicle.axle_loads_n(a_x);
        let at_most = friction * libm::tanh(1.0);
        let slides = |(force, load): (f64, f64)| force.abs() > at_most * load;
        follows(friction) && !forces.into_iter().zip(loads).any(slides)
    }

    /// The sample with the largest ratio while the detector of `judge`, made for `spec`, monitors; none
    /// without such a sample.
    pub fn worst(&self, spec: &Spec, judge: Judge) -> Option<Worst> {
        let mut detector = judge.detector;
        let courses = &self.courses;
        let surroundings = Surroundings {
            world: World::of(TrueVehicle { data: self.vehicle, tyres: self.tyres }, self.steering),
            v_x_scale: self.v_x_scale,
            yaw_rate_bias_rad_per_s: self.yaw_rate_bias_rad_per_s,
        };
        let seed = self.noise_seed.cast_unsigned().into();
        let sensors: Sensors = surroundings.sensors(&spec.noise, courses.period_s, seed);
        let simulation = Simulation {
            sensors,
            surroundings,
            course: Driver { courses, vehicle: &spec.vehicle },
            start: self.start,
            period_s: courses.period_s,
            samples: courses.steering_rad.len() as u64,
        };
        let around =
            Around { courses, mass_kg: self.vehicle.mass_kg, action: spec.uncertainty.gust() };
        let range = spec.operating_range.range();
        let largest_friction = spec.uncertainty.friction[1].max(1.0);
        let mut within = true;
        let mut worst: Option<Worst> = None;
        simulation.run(&mut detector, &around, |sample| {
            let Sampled { number, detector, state, input } = *sample;
            within &= range.contains(state.motion)
                && self.holds(state, input.t_eng_n_m, largest_friction);
            let output = detector.output();
            let ratio = judge.ratio(output);
            // What is no number is not more.
            if within
                && output.monitor == Monitor::Monitoring
                && worst.is_none_or(|worst| ratio > worst.ratio)
            {
                let measured = detector.state().last;
                worst = Some(Worst {
                    ratio,
                    time_s: number as f64 * courses.period_s,
                    v_x_m_per_s: measured.v_x_m_per_s,
                    lateral_acceleration_m_per_s2: measured.v_x_m_per_s * measured.r_rad_per_s,
                });
            }
        });
        worst
    }
}
