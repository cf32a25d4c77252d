//! One drive through the packaged FMUs.

use steerguard_world::Tyres;

use super::drive::Drive;
use super::outcome::{Observation, Outcome};
use super::settings::Subject;
use crate::drive::cosimulation::{CosimulationError, Excitation, Rig, Sample};
use crate::drive::wheel::Wheel;
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
        let (course, wind) = (drive.course(&self.subject), drive.wind(&self.subject));
        let wheel = Wheel::new(|t| course.steering_rad(t), &drive.steering, step_s, steps);
        let mut rig = Rig::new(&self.detector, &self.plant)?;
        self.set_up(&mut rig, drive)?;
        let excite = |t, v_x| {
            let [side_force, yaw_moment] = wind.side_force_and_yaw_moment(t, v_x);
            Excitation {
                drive_torque: course.drive_torque_n_m(t, v_x),
                steering_angle: course.steering_rad(t),
                fault: wheel.fault_rad(drive.fault.as_ref(), t),
                side_force,
                yaw_moment,
            }
        };
        rig.initialise(drive.duration_s, &excite(0.0, drive.plan.speed_m_per_s))?;

        // Neither driver nor wind know how the measured speed errs.
        let [v_x_bias, _] = drive.sensor_bias;
        let true_speed = |v_x: f64| (v_x - v_x_bias) / (1.0 + drive.v_x_scale);
        let mut observation = Observation::default();
        for k in 0..steps {
            let time_s = f64::from(k) * step_s;
            let sample = rig.step(time_s, step_s, |seen| excite(time_s, true_speed(seen.v_x)))?;
            observation.add(&sample);
            record(&sample);
        }
        rig.terminate()?;
        Ok(observation.outcome(step_s, drive.fault.map(|fault| fault.onset_s)))
    }

    /// Gives the plant the vehicle, road, tyres, actuator and sensors of `drive`.
    fn set_up(&self, rig: &mut Rig, drive: &Drive) -> Result<(), CosimulationError> {
        let vehicle = &drive.vehicle;
        let [v_x_bias_m_per_s, r_bias_rad_per_s] = drive.sensor_bias;
        let reals = [
            ("initial.v_x", drive.plan.speed_m_per_s),
            ("vehicle.M_v", vehicle.mass_kg),
            ("vehicle.I_e", vehicle.effective_longitudinal_inertia_kg_m),
            ("vehicle.I_z", vehicle.yaw_inertia_kg_m2),
            ("vehicle.C_f", vehicle.front_cornering_stiffness_n_per_rad),
            ("vehicle.C_r", vehicle.rear_cornering_stiffness_n_per_rad),
            ("road.bank", drive.bank_deg.to_radians()),
            ("vehicle.h", vehicle.centre_of_gravity_height_m),
            ("steering.ratio", drive.steering.ratio),
            ("steering.offset", drive.steering.offset_rad),
            ("sensor.v_x_scale", drive.v_x_scale),
            ("sensor.v_x_bias", v_x_bias_m_per_s),
            ("sensor.r_bias", r_bias_rad_per_s),
        ];
        rig.plant
            .set_real(self.plant.reals(reals.map(|(name, _)| name))?, reals.map(|(_, x)| x))?;
        if let Tyres::Saturating { friction } = drive.tyres {
            rig.plant.set_real(self.plant.reals(["tyre.friction"])?, [friction])?;
            let limited = self.plant.variable("tyre.friction_limited", Type::Boolean)?;
            rig.plant.set_boolean([limited], [1])?;
        }
        rig.set_actuator(&self.plant, &drive.steering.actuator)?;
        rig.set_noise(&self.plant, &drive.noise, self.subject.period_s)
    }
}
