//! Drives as rows of a table: flat, what does not apply left empty.

use steerguard_world::{Manoeuvre, Tyres};

use super::drive::Drive;
use super::names::{FaultName, FaultNumbers, ManoeuvreName};
use super::record::record;

record! {
    /// What was driven. Angles are at the road wheel; what does not apply is empty.
    pub struct DriveRecord {
        /// Number of the drive in its campaign.
        pub index: u64,
        /// Length, s.
        pub duration_s: f64,
        /// Course of steering and speed.
        pub manoeuvre: ManoeuvreName,
        /// Set speed.
        pub speed_m_per_s: f64,
        /// Speed that stop and go, or the vehicle in a turn, brakes to.
        pub lowest_speed_m_per_s: Option<f64>,
        /// Braking and acceleration of stop and go, or in a turn.
        pub longitudinal_acceleration_m_per_s2: Option<f64>,
        /// Steady lateral acceleration that the steering corresponds to; the sign is the direction
        /// of the first run.
        pub lateral_acceleration_m_per_s2: f64,
        /// Radius of the roundabout.
        pub radius_m: Option<f64>,
        /// When the first manoeuvre begins.
        pub manoeuvre_start_s: f64,
        /// Time between two runs of the manoeuvre.
        pub pause_s: f64,

        /// Road bank, positive with the left side raised: gravity then pulls to the right.
        pub bank_deg: f64,
        /// Speed of the gusts across the road, positive to the left.
        pub gust_m_per_s: f64,
        /// Length of a gust.
        pub gust_duration_s: f64,
        /// When the first gust begins.
        pub gust_start_s: f64,
        /// Time between two gusts.
        pub gust_pause_s: f64,

        /// Seed of the plant's sensor noise.
        pub noise_seed: i32,
        /// Standard deviation of the noise on v_x.
        pub v_x_noise_m_per_s: f64,
        /// Standard deviation of the noise on r.
        pub r_noise_rad_per_s: f64,
        /// Bias of the measured v_x.
        pub v_x_bias_m_per_s: f64,
        /// Bias of the measured r.
        pub r_bias_rad_per_s: f64,

        /// M_v of the vehicle driven; I_e is in proportion.
        pub mass_kg: f64,
        /// I_z of the vehicle driven.
        pub yaw_inertia_kg_m2: f64,
        /// C_f of the vehicle driven.
        pub front_cornering_stiffness_n_per_rad: f64,
        /// C_r of the vehicle driven.
        pub rear_cornering_stiffness_n_per_rad: f64,
        /// Friction coefficient; empty where the tyres are linear.
        pub friction: Option<f64>,
        /// Height of the centre of gravity of the vehicle driven.
        pub centre_of_gravity_height_m: f64,
        /// Angle of the road wheel per commanded angle.
        pub steering_ratio: f64,
        /// How far the road wheel stands to the right of where it is commanded to be.
        pub steering_offset_deg: f64,
        /// Relative error of the measured v_x.
        pub v_x_scale: f64,
        /// Lag of the steering actuator driven.
        pub actuator_lag_s: f64,
        /// Dead time of the steering actuator driven.
        pub actuator_delay_s: f64,

        /// Kind of the fault.
        pub fault: FaultName,
        /// When it begins.
        pub onset_s: Option<f64>,
        /// Size of a bias, drift or oscillation.
        pub fault_deg: Option<f64>,
        /// Time that a drift takes to its full size.
        pub fault_rise_s: Option<f64>,
        /// Frequency of an oscillation.
        pub fault_hz: Option<f64>,
        /// Share of the command that a loss of effectiveness takes, 0 to 1.
        pub fault_loss: Option<f64>,
        /// Delay of the command.
        pub fault_delay_s: Option<f64>,
    }
}

impl From<&Drive> for DriveRecord {
    fn from(drive: &Drive) -> Self {
        let Drive { index, duration_s, plan, bank_deg, gusts, noise, sensor_bias, .. } = *drive;
        let Drive { vehicle, tyres, steering, v_x_scale, fault, .. } = *drive;
        let [v_x_bias_m_per_s, r_bias_rad_per_s] = sensor_bias;
        let numbers = FaultNumbers::of(fault.as_ref());
        let mut record = Self {
            index,
            duration_s,
            manoeuvre: ManoeuvreName::of(&plan.manoeuvre),
            speed_m_per_s: plan.speed_m_per_s,
            lowest_speed_m_per_s: None,
            longitudinal_acceleration_m_per_s2: None,
            lateral_acceleration_m_per_s2: plan.lateral_acceleration_m_per_s2,
            radius_m: None,
            manoeuvre_start_s: plan.start_s,
            pause_s: plan.pause_s,
            bank_deg,
            gust_m_per_s: gusts.speed_m_per_s,
            gust_duration_s: gusts.duration_s,
            gust_start_s: gusts.start_s,
            gust_pause_s: gusts.pause_s,
            noise_seed: noise.seed,
            v_x_noise_m_per_s: noise.v_x_std_m_per_s,
            r_noise_rad_per_s: noise.r_std_rad_per_s,
            v_x_bias_m_per_s,
            r_bias_rad_per_s,
            mass_kg: vehicle.mass_kg,
            yaw_inertia_kg_m2: vehicle.yaw_inertia_kg_m2,
            front_cornering_stiffness_n_per_rad: vehicle.front_cornering_stiffness_n_per_rad,
            rear_cornering_stiffness_n_per_rad: vehicle.rear_cornering_stiffness_n_per_rad,
            friction: match tyres {
                Tyres::Linear => None,
                Tyres::Saturating { friction } => Some(friction),
            },
            centre_of_gravity_height_m: vehicle.centre_of_gravity_height_m,
            steering_ratio: steering.ratio,
            steering_offset_deg: steering.offset_rad.to_degrees(),
            v_x_scale,
            actuator_lag_s: steering.actuator.lag_s,
            actuator_delay_s: steering.actuator.delay_s,
            fault: FaultName::of(fault.as_ref()),
            onset_s: fault.map(|fault| fault.onset_s),
            fault_deg: numbers.angle_rad.map(f64::to_degrees),
            fault_rise_s: numbers.rise_s,
            fault_hz: numbers.hz,
            fault_loss: numbers.lost,
            fault_delay_s: numbers.delay_s,
        };
        match plan.manoeuvre {
            Manoeuvre::Roundabout { radius_m } => record.radius_m = Some(radius_m),
            Manoeuvre::StopAndGo { lowest_speed_m_per_s, longitudinal_acceleration_m_per_s2 }
            | Manoeuvre::BrakingInTurn {
                lowest_speed_m_per_s,
                longitudinal_acceleration_m_per_s2,
            } => {
                record.lowest_speed_m_per_s = Some(lowest_speed_m_per_s);
                record.longitudinal_acceleration_m_per_s2 =
                    Some(longitudinal_acceleration_m_per_s2);
            }
            _ => {}
        }
        record
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::campaign::settings::tests::{PAPER, SETTINGS};

    proptest! {
        #[test]
        fn what_does_not_apply_is_empty(index: u64) {
            use FaultName::{Bias, Delay, Drift, LossOfEffectiveness, Oscillation};
            let record = DriveRecord::from(&Drive::draw(&SETTINGS, &PAPER, index));
            let stops = [ManoeuvreName::StopAndGo, ManoeuvreName::BrakingInTurn]
                .contains(&record.manoeuvre);
            prop_assert_eq!(record.lowest_speed_m_per_s.is_some(), stops);
            prop_assert_eq!(record.longitudinal_acceleration_m_per_s2.is_some(), stops);
            let round = record.manoeuvre == ManoeuvreName::Roundabout;
            prop_assert_eq!(record.radius_m.is_some(), round);
            let fault = record.fault;
            prop_assert_eq!(record.onset_s.is_some(), fault != FaultName::None);
            let has_size = [Bias, Drift, Oscillation].contains(&fault);
            prop_assert_eq!(record.fault_deg.is_some(), has_size);
            prop_assert_eq!(record.fault_rise_s.is_some(), fault == Drift);
            prop_assert_eq!(record.fault_hz.is_some(), fault == Oscillation);
            prop_assert_eq!(record.fault_loss.is_some(), fault == LossOfEffectiveness);
            prop_assert_eq!(record.fault_delay_s.is_some(), fault == Delay);
        }
    }
}
