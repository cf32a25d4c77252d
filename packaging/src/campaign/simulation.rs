//! One drive through the packaged FMUs.

use steerguard_detector::{Actuator, Gust};

use super::drive::Drive;
use super::fault;
use super::gust;
use super::manoeuvre::Course;
use super::outcome::{Observation, Outcome};
use super::settings::Subject;
use super::wheel::Wheel;
use crate::drive::cosimulation::{CosimulationError, Excitation, Rig, Sample};
use crate::drive::scenario::SensorNoise;
use crate::importer::{Fmu, Type};

/// What the drives need: both FMUs and the design under test.
pub struct TestBench {
    /// The detector.
    pub detector: Fmu,
    /// The plant.
    pub plant: Fmu,
    /// The design under test.
    pub subject: Subject,
}

impl TestBench {
    /// Drives `drive`; `record` is handed each sample.
    ///
    /// # Errors
    /// [`CosimulationError`] at the first call that an FMU refuses.
    pub fn run(
        &self,
        drive: &Drive,
        mut record: impl FnMut(&Sample),
    ) -> Result<Outcome, CosimulationError> {
        let step_s = self.subject.period_s;
        let steps = libm::round(drive.duration_s / step_s) as u32;
        let course = Course::of(drive, &self.subject);
        let actuator = Actuator {
            lag_s: drive.actuator_lag_s,
            delay_s: drive.actuator_delay_s,
            ..self.subject.actuator
        };
        let wheel = Wheel::new(&course, &actuator, step_s, steps);
        let mut rig = Rig::new(&self.detector, &self.plant)?;
        self.set_up(&mut rig, drive)?;
        rig.set_actuator(&self.plant, &actuator)?;
        let excite = |t, v_x| excitation(drive, self.subject.gust, &course, &wheel, t, v_x);
        rig.initialise(drive.duration_s, &excite(0.0, drive.speed_m_per_s))?;

        let mut observation = Observation::default();
        for k in 0..steps {
            let time_s = f64::from(k) * step_s;
            let sample = rig.step(time_s, step_s, |[v_x, _]| excite(time_s, v_x))?;
            observation.add(&sample);
            record(&sample);
        }
        rig.terminate()?;
        Ok(observation.outcome(step_s, drive.onset_s))
    }

    /// Gives the plant the vehicle, road, tyres and sensors of `drive`.
    fn set_up(&self, rig: &mut Rig, drive: &Drive) -> Result<(), CosimulationError> {
        let nominal = &self.subject.vehicle;
        let reals = [
            ("initial.v_x", drive.speed_m_per_s),
            ("vehicle.M_v", drive.mass_kg),
            // I_e is mass times wheel radius.
            (
                "vehicle.I_e",
                nominal.effective_longitudinal_inertia_kg_m * drive.mass_kg / nominal.mass_kg,
            ),
            ("vehicle.I_z", drive.yaw_inertia_kg_m2),
            ("vehicle.C_f", drive.front_cornering_stiffness_n_per_rad),
            ("vehicle.C_r", drive.rear_cornering_stiffness_n_per_rad),
            ("tyre.friction", drive.friction.unwrap_or(1.0)),
            ("road.bank", drive.bank_deg.to_radians()),
        ];
        rig.plant
            .set_real(self.plant.reals(reals.map(|(name, _)| name))?, reals.map(|(_, x)| x))?;
        let limited = self.plant.variable("tyre.friction_limited", Type::Boolean)?;
        rig.plant.set_boolean([limited], [drive.friction.is_some().into()])?;
        let noise = SensorNoise {
            v_x_std_m_per_s: drive.v_x_noise_m_per_s,
            r_std_rad_per_s: drive.r_noise_rad_per_s,
            seed: drive.noise_seed,
        };
        rig.set_noise(&self.plant, &noise, self.subject.period_s)
    }
}

/// What acts at time `t` at the speed `v_x` that the plant gives.
fn excitation(
    drive: &Drive,
    gust: Gust,
    course: &Course,
    wheel: &Wheel,
    t: f64,
    v_x: f64,
) -> Excitation {
    let [side_force, yaw_moment] = gust::side_force_and_yaw_moment(drive, gust, t, v_x);
    Excitation {
        drive_torque: course.drive_torque_n_m(t, v_x),
        steering_angle: course.steering_rad(t),
        fault: fault::angle_rad(drive, t, |t| wheel.angle_rad(t)),
        side_force,
        yaw_moment,
        sensor_bias: [drive.v_x_bias_m_per_s, drive.r_bias_rad_per_s],
    }
}
