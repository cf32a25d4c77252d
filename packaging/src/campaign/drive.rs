//! The description of one drive: a pure function of settings, design and index.

use super::fault::FaultKind;
use super::manoeuvre::Manoeuvre;
use super::random::{Draw, Quantity};
use super::record::record;
use super::settings::{FaultMix, Settings, Subject};

/// Friction coefficients of dry and wet asphalt, where friction limits the axle forces.
const FRICTION: [f64; 2] = [0.7, 1.0];
/// Slowest manoeuvre, as a share of the design's hardest lateral acceleration.
const GENTLEST: f64 = 0.2;
/// Longitudinal acceleration of stop and go, m/s^2.
const LONGITUDINAL_M_PER_S2: [f64; 2] = [0.5, 3.0];
/// Radius of roundabouts, m.
const RADIUS_M: [f64; 2] = [12.0, 30.0];
/// When the first manoeuvre begins, s.
const START_S: [f64; 2] = [1.0, 3.0];
/// Time between two runs of a manoeuvre, s.
const PAUSE_S: [f64; 2] = [2.0, 6.0];
/// Length of a gust, s.
const GUST_S: [f64; 2] = [0.5, 3.0];
/// Time between two gusts, s.
const CALM_S: [f64; 2] = [3.0, 10.0];
/// Onset of the fault, as a share of the drive.
const ONSET: [f64; 2] = [0.1, 0.7];
/// Time that a drift takes to its full size, s.
const RISE_S: [f64; 2] = [1.0, 10.0];
/// Frequency of an oscillation, Hz.
const OSCILLATION_HZ: [f64; 2] = [0.3, 3.0];
/// Share of the command that is lost.
const LOSS: [f64; 2] = [0.1, 1.0];
/// Delay of the command, s.
const DELAY_S: [f64; 2] = [0.05, 0.5];

record! {
    /// What is driven. Angles are at the road wheel; what does not apply is empty.
    pub struct Drive {
        /// Number of the drive in its campaign.
        pub index: u64,
        /// Length, s.
        pub duration_s: f64,
        /// Course of steering and speed.
        pub manoeuvre: Manoeuvre,
        /// Set speed.
        pub speed_m_per_s: f64,
        /// Speed that stop and go brakes to, below the range of the design.
        pub lowest_speed_m_per_s: Option<f64>,
        /// Braking and acceleration of stop and go.
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

        /// Road bank, positive where gravity pulls to the left.
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
        /// Lag of the steering actuator driven.
        pub actuator_lag_s: f64,
        /// Dead time of the steering actuator driven.
        pub actuator_delay_s: f64,

        /// Kind of the fault.
        pub fault: FaultKind,
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

impl Drive {
    /// Draws drive `index`.
    pub fn draw(settings: &Settings, subject: &Subject, index: u64) -> Self {
        let mut draw = Draw::new(settings.seed, index);
        let between =
            |draw: &mut Draw, quantity, [min, max]: [f64; 2]| draw.uniform(quantity, min, max);
        let (uncertainty, sensors) = (settings.uncertainty, settings.sensors);
        let armed = subject.armed_v_x;

        let manoeuvre =
            draw.choose(Quantity::Manoeuvre, Manoeuvre::ALL).unwrap_or(Manoeuvre::Straight);
        let hardest = subject.lateral_acceleration_m_per_s2;
        let lateral = draw.uniform(Quantity::LateralAcceleration, GENTLEST * hardest, hardest);
        let radius_m = (manoeuvre == Manoeuvre::Roundabout)
            .then(|| between(&mut draw, Quantity::Radius, RADIUS_M));
        let speed_m_per_s = match radius_m {
            // Slow enough for the curve.
            Some(radius_m) => libm::sqrt(lateral * radius_m).clamp(armed.min, armed.max),
            None => draw.uniform(Quantity::Speed, armed.min, armed.max),
        };
        let stops = manoeuvre == Manoeuvre::StopAndGo;

        let bounds = uncertainty.bounds;
        let (vehicle, actuator) = (&subject.vehicle, &subject.actuator);
        let mut perturbed = |quantity, nominal: f64, [min, max]: [f64; 2]| {
            nominal * (1.0 + draw.uniform(quantity, min / 100.0, max / 100.0))
        };
        let [of_mass, of_yaw_inertia, of_front, of_rear] = bounds.intervals_percent();
        let mass_kg = perturbed(Quantity::Mass, vehicle.mass_kg, of_mass);
        let yaw_inertia_kg_m2 =
            perturbed(Quantity::YawInertia, vehicle.yaw_inertia_kg_m2, of_yaw_inertia);
        let front_cornering_stiffness_n_per_rad = perturbed(
            Quantity::FrontStiffness,
            vehicle.front_cornering_stiffness_n_per_rad,
            of_front,
        );
        let rear_cornering_stiffness_n_per_rad =
            perturbed(Quantity::RearStiffness, vehicle.rear_cornering_stiffness_n_per_rad, of_rear);
        let saturated = uncertainty.saturation && draw.sign(Quantity::Saturation) > 0.0;

        let fault = match settings.faults {
            FaultMix::None => FaultKind::None,
            FaultMix::Bias => FaultKind::Bias,
            FaultMix::Mixed => {
                draw.choose(Quantity::Fault, FaultKind::ALL).unwrap_or(FaultKind::None)
            }
        };
        let onset = ONSET.map(|share| share * settings.duration_s);
        let has_size = matches!(fault, FaultKind::Bias | FaultKind::Drift | FaultKind::Oscillation);

        Self {
            index,
            duration_s: settings.duration_s,
            manoeuvre,
            speed_m_per_s,
            lowest_speed_m_per_s: stops
                .then(|| draw.uniform(Quantity::LowestSpeed, 0.0, armed.min)),
            longitudinal_acceleration_m_per_s2: stops.then(|| {
                between(&mut draw, Quantity::LongitudinalAcceleration, LONGITUDINAL_M_PER_S2)
            }),
            lateral_acceleration_m_per_s2: lateral * draw.sign(Quantity::Direction),
            radius_m,
            manoeuvre_start_s: between(&mut draw, Quantity::ManoeuvreStart, START_S),
            pause_s: between(&mut draw, Quantity::Pause, PAUSE_S),

            bank_deg: draw.within(Quantity::Bank, bounds.bank_deg),
            gust_m_per_s: draw.within(Quantity::Gust, bounds.gust_m_per_s),
            gust_duration_s: between(&mut draw, Quantity::GustDuration, GUST_S),
            gust_start_s: between(&mut draw, Quantity::GustStart, CALM_S),
            gust_pause_s: between(&mut draw, Quantity::GustPause, CALM_S),

            noise_seed: (draw.bits(Quantity::NoiseSeed) as u32).cast_signed(),
            v_x_noise_m_per_s: sensors.v_x_noise_m_per_s,
            r_noise_rad_per_s: sensors.r_noise_rad_per_s,
            v_x_bias_m_per_s: draw.within(Quantity::SpeedBias, sensors.v_x_bias_m_per_s),
            r_bias_rad_per_s: draw.within(Quantity::YawRateBias, sensors.r_bias_rad_per_s),

            mass_kg,
            yaw_inertia_kg_m2,
            front_cornering_stiffness_n_per_rad,
            rear_cornering_stiffness_n_per_rad,
            friction: saturated.then(|| between(&mut draw, Quantity::Friction, FRICTION)),
            actuator_lag_s: actuator.lag_s
                + draw.uniform(Quantity::ActuatorLag, 0.0, bounds.actuator_lag_s),
            actuator_delay_s: actuator.delay_s
                + draw.uniform(Quantity::ActuatorDelay, 0.0, bounds.actuator_delay_s),

            fault,
            onset_s: (fault != FaultKind::None).then(|| between(&mut draw, Quantity::Onset, onset)),
            fault_deg: has_size.then(|| {
                between(&mut draw, Quantity::FaultSize, settings.fault_deg)
                    * draw.sign(Quantity::FaultSign)
            }),
            fault_rise_s: (fault == FaultKind::Drift)
                .then(|| between(&mut draw, Quantity::FaultRise, RISE_S)),
            fault_hz: (fault == FaultKind::Oscillation)
                .then(|| between(&mut draw, Quantity::FaultFrequency, OSCILLATION_HZ)),
            fault_loss: (fault == FaultKind::LossOfEffectiveness)
                .then(|| between(&mut draw, Quantity::FaultLoss, LOSS)),
            fault_delay_s: (fault == FaultKind::Delay)
                .then(|| between(&mut draw, Quantity::FaultDelay, DELAY_S)),
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use steerguard_detector::Actuator;

    use super::*;
    use crate::campaign::settings::Uncertainty;
    use crate::campaign::settings::tests::{PAPER, SETTINGS};

    fn draw(settings: &Settings, index: u64) -> Drive {
        Drive::draw(settings, &PAPER, index)
    }

    proptest! {
        #[test]
        fn drives_stay_within_the_settings(seed: u64, index in 0..1_u64 << 60) {
            let drive = draw(&Settings { seed, ..SETTINGS }, index);
            let within = |value: f64, [min, max]: [f64; 2]| (min..=max).contains(&value);
            let optional = |value: Option<f64>, range| value.is_none_or(|x| within(x, range));
            let near = |value: f64, nominal: f64| within(value / nominal, [0.9 - 1e-9, 1.1 + 1e-9]);
            let vehicle = &PAPER.vehicle;
            let lateral = drive.lateral_acceleration_m_per_s2.abs();
            prop_assert!(PAPER.armed_v_x.contains(drive.speed_m_per_s));
            prop_assert!(within(lateral, [0.6 - 1e-12, 3.0]));
            prop_assert!(optional(drive.lowest_speed_m_per_s, [0.0, 5.5]));
            prop_assert!(within(drive.bank_deg, [-3.0, 3.0]));
            prop_assert!(within(drive.gust_m_per_s, [-10.0, 10.0]));
            prop_assert!(within(drive.v_x_bias_m_per_s, [-0.01, 0.01]));
            prop_assert!(within(drive.r_bias_rad_per_s, [-0.001, 0.001]));
            prop_assert!(near(drive.mass_kg, vehicle.mass_kg));
            prop_assert!(near(drive.yaw_inertia_kg_m2, vehicle.yaw_inertia_kg_m2));
            prop_assert!(near(
                drive.front_cornering_stiffness_n_per_rad,
                vehicle.front_cornering_stiffness_n_per_rad
            ));
            prop_assert!(near(
                drive.rear_cornering_stiffness_n_per_rad,
                vehicle.rear_cornering_stiffness_n_per_rad
            ));
            prop_assert!(optional(drive.friction, FRICTION));
            prop_assert!(within(drive.actuator_lag_s, [0.0, 0.02]));
            prop_assert!(within(drive.actuator_delay_s, [0.0, 0.03]));
            prop_assert!(optional(drive.onset_s, [6.0 - 1e-9, 42.0]));
            prop_assert!(optional(drive.fault_deg.map(f64::abs), SETTINGS.fault_deg));
        }

        #[test]
        fn each_kind_of_fault_has_its_own_figures(index: u64) {
            use FaultKind::{Bias, Delay, Drift, LossOfEffectiveness, Oscillation};
            let drive = draw(&SETTINGS, index);
            let kind = drive.fault;
            prop_assert_eq!(drive.onset_s.is_some(), kind != FaultKind::None);
            prop_assert_eq!(
                drive.fault_deg.is_some(),
                [Bias, Drift, Oscillation].contains(&kind)
            );
            prop_assert_eq!(drive.fault_rise_s.is_some(), kind == Drift);
            prop_assert_eq!(drive.fault_hz.is_some(), kind == Oscillation);
            prop_assert_eq!(drive.fault_loss.is_some(), kind == LossOfEffectiveness);
            prop_assert_eq!(drive.fault_delay_s.is_some(), kind == Delay);
        }

        /// What is not asked about stays: campaigns that differ in one thing compare drive by drive.
        #[test]
        fn settings_change_what_they_name_and_nothing_else(index: u64) {
            let drive = draw(&SETTINGS, index);
            prop_assert_eq!(&draw(&SETTINGS, index), &drive);
            let nominal =
                draw(&Settings { uncertainty: Uncertainty::NOMINAL, ..SETTINGS }, index);
            prop_assert_eq!(&nominal, &Drive {
                bank_deg: 0.0,
                gust_m_per_s: 0.0,
                mass_kg: PAPER.vehicle.mass_kg,
                yaw_inertia_kg_m2: PAPER.vehicle.yaw_inertia_kg_m2,
                front_cornering_stiffness_n_per_rad:
                    PAPER.vehicle.front_cornering_stiffness_n_per_rad,
                rear_cornering_stiffness_n_per_rad:
                    PAPER.vehicle.rear_cornering_stiffness_n_per_rad,
                friction: None,
                actuator_lag_s: 0.0,
                actuator_delay_s: 0.0,
                ..drive.clone()
            });
            let healthy = draw(&Settings { faults: FaultMix::None, ..SETTINGS }, index);
            prop_assert_eq!(&healthy, &Drive {
                fault: FaultKind::None,
                onset_s: None,
                fault_deg: None,
                fault_rise_s: None,
                fault_hz: None,
                fault_loss: None,
                fault_delay_s: None,
                ..drive
            });
        }
    }

    #[test]
    fn the_actuator_is_the_design_s_and_slower() {
        let actuator = Actuator { lag_s: 0.1, delay_s: 0.2, rate_limit_rad_per_s: None };
        let subject = Subject { actuator, ..PAPER };
        let nominal = Settings { uncertainty: Uncertainty::NOMINAL, ..SETTINGS };
        for index in 0..100 {
            let drive = Drive::draw(&SETTINGS, &subject, index);
            assert!((0.1..=0.12).contains(&drive.actuator_lag_s));
            assert!((0.2..=0.23).contains(&drive.actuator_delay_s));
            let drive = Drive::draw(&nominal, &subject, index);
            assert_eq!((drive.actuator_lag_s, drive.actuator_delay_s), (0.1, 0.2));
        }
    }

    #[test]
    fn manoeuvres_and_faults_are_equally_likely() {
        let drives: Vec<_> = (0..7000).map(|index| draw(&SETTINGS, index)).collect();
        let near = |count: usize| assert!(count.abs_diff(1000) < 150, "{count} of 7000");
        for manoeuvre in Manoeuvre::ALL {
            near(drives.iter().filter(|drive| drive.manoeuvre == *manoeuvre).count());
        }
        for kind in FaultKind::ALL {
            near(drives.iter().filter(|drive| drive.fault == *kind).count());
        }
        let saturated = drives.iter().filter(|drive| drive.friction.is_some()).count();
        assert!(saturated.abs_diff(3500) < 250, "{saturated} of 7000");
    }
}
