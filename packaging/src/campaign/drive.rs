//! The description of one drive: a pure function of settings, design and index.

use steerguard_detector::{Actuator, Vehicle};
use steerguard_world::{CALM_S, Course, Fault, GUST_S, Gusts, Plan, Steering, Stream, Tyres, Wind};

use super::names::{FaultName, FaultNumbers, ManoeuvreName, ManoeuvreNumbers};
use super::settings::{FaultMix, Mix, Settings, Subject};
use crate::drive::scenario::SensorNoise;

/// What is driven; without the last, which the classic mix has not.
const MANOEUVRES: [ManoeuvreName; 8] = [
    ManoeuvreName::DoubleLaneChange,
    ManoeuvreName::Weave,
    ManoeuvreName::StepSteer,
    ManoeuvreName::SineWithDwell,
    ManoeuvreName::Straight,
    ManoeuvreName::Roundabout,
    ManoeuvreName::StopAndGo,
    ManoeuvreName::BrakingInTurn,
];
/// Friction coefficients of dry and wet asphalt, where the classic mix lets friction limit the axle forces.
const CLASSIC_FRICTION: [f64; 2] = [0.7, 1.0];
/// Braking and acceleration in a turn, m/s^2.
const IN_TURN_M_PER_S2: [f64; 2] = [0.5, 2.5];
/// Share of the faults with a size that are large ones.
const LARGE: f64 = 0.25;
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

/// What is drawn for a drive. The discriminant is the place in the drive's stream of random numbers:
/// it never changes.
#[derive(Clone, Copy)]
enum Quantity {
    Manoeuvre = 0,
    Speed = 1,
    LowestSpeed = 2,
    LongitudinalAcceleration = 3,
    LateralAcceleration = 4,
    Direction = 5,
    Radius = 6,
    ManoeuvreStart = 7,
    Pause = 8,
    Bank = 16,
    Gust = 17,
    GustDuration = 18,
    GustStart = 19,
    GustPause = 20,
    NoiseSeed = 24,
    SpeedBias = 25,
    YawRateBias = 26,
    Mass = 32,
    YawInertia = 33,
    FrontStiffness = 34,
    RearStiffness = 35,
    Saturation = 36,
    Friction = 37,
    ActuatorLag = 38,
    ActuatorDelay = 39,
    SteeringRatio = 40,
    SteeringOffset = 41,
    SpeedScale = 42,
    LoadTransfer = 43,
    Fault = 48,
    FaultSize = 49,
    FaultSign = 50,
    FaultRise = 51,
    FaultFrequency = 52,
    FaultLoss = 53,
    FaultDelay = 54,
    Onset = 55,
    Large = 56,
}

/// The random numbers of one drive.
#[derive(Clone, Copy)]
struct Draw(Stream);

impl Draw {
    fn uniform(self, quantity: Quantity, range: [f64; 2]) -> f64 {
        self.0.uniform(quantity as u64, range)
    }

    fn within(self, quantity: Quantity, bound: f64) -> f64 {
        self.0.within(quantity as u64, bound)
    }

    fn sign(self, quantity: Quantity) -> f64 {
        self.0.sign(quantity as u64)
    }

    /// `nominal` plus a share of it between two percentages.
    fn perturbed(self, quantity: Quantity, nominal: f64, [min, max]: [f64; 2]) -> f64 {
        nominal * (1.0 + self.uniform(quantity, [min / 100.0, max / 100.0]))
    }
}

/// What is driven. Angles are at the road wheel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drive {
    /// Number of the drive in its campaign.
    pub index: u64,
    /// Length, s.
    pub duration_s: f64,
    /// Course of steering and speed.
    pub plan: Plan,
    /// Road bank, positive with the left side raised: gravity then pulls to the right.
    pub bank_deg: f64,
    /// Gusts across the road.
    pub gusts: Gusts,
    /// Noise of the plant's sensors.
    pub noise: SensorNoise,
    /// Biases of the plant's sensors: [v_x, r] in m/s, rad/s.
    pub sensor_bias: [f64; 2],
    /// The vehicle driven.
    pub vehicle: Vehicle,
    /// Its tyres.
    pub tyres: Tyres,
    /// Its steering.
    pub steering: Steering,
    /// Relative error of the measured speed.
    pub v_x_scale: f64,
    /// What its steering suffers from.
    pub fault: Option<Fault>,
}

impl Drive {
    /// Draws drive `index`.
    pub fn draw(settings: &Settings, subject: &Subject, index: u64) -> Self {
        let stream = Stream::new(settings.seed, index);
        let draw = Draw(stream);
        let (bounds, sensors) = (settings.uncertainty.bounds, settings.sensors);
        let saturated = settings.uncertainty.saturation && draw.sign(Quantity::Saturation) > 0.0;
        let actuator = Actuator {
            lag_s: subject.actuator.lag_s
                + draw.uniform(Quantity::ActuatorLag, [0.0, bounds.actuator_lag_s]),
            delay_s: subject.actuator.delay_s
                + draw.uniform(Quantity::ActuatorDelay, [0.0, bounds.actuator_delay_s]),
            ..subject.actuator
        };
        Self {
            index,
            duration_s: settings.duration_s,
            plan: plan(draw, settings, subject),
            bank_deg: draw.within(Quantity::Bank, bounds.bank_deg),
            gusts: Gusts {
                speed_m_per_s: draw.within(Quantity::Gust, bounds.gust_m_per_s),
                duration_s: draw.uniform(Quantity::GustDuration, GUST_S),
                start_s: draw.uniform(Quantity::GustStart, CALM_S),
                pause_s: draw.uniform(Quantity::GustPause, CALM_S),
            },
            noise: SensorNoise {
                v_x_std_m_per_s: sensors.v_x_noise_m_per_s,
                r_std_rad_per_s: sensors.r_noise_rad_per_s,
                seed: (stream.bits(Quantity::NoiseSeed as u64) as u32).cast_signed(),
            },
            sensor_bias: [
                draw.within(Quantity::SpeedBias, sensors.v_x_bias_m_per_s),
                subject.zero.yaw_rate_bias_rad_per_s
                    + draw.within(Quantity::YawRateBias, sensors.r_bias_rad_per_s),
            ],
            vehicle: vehicle(draw, settings, &subject.vehicle),
            tyres: if saturated {
                let friction = match settings.mix {
                    Mix::Standard => bounds.friction,
                    Mix::Classic => CLASSIC_FRICTION,
                };
                Tyres::Saturating { friction: draw.uniform(Quantity::Friction, friction) }
            } else {
                Tyres::Linear
            },
            steering: Steering {
                actuator,
                ratio: 1.0
                    / (1.0
                        + draw.uniform(Quantity::SteeringRatio, bounds.steering_ratio_percent)
                            / 100.0),
                offset_rad: subject.zero.steering_offset_rad
                    + draw
                        .within(Quantity::SteeringOffset, bounds.steering_offset_deg)
                        .to_radians(),
            },
            v_x_scale: draw.within(Quantity::SpeedScale, bounds.v_x_scale_percent) / 100.0,
            fault: fault(draw, settings),
        }
    }

    /// Course of the driver, who knows the vehicle that `subject` was designed for.
    pub fn course(&self, subject: &Subject) -> Course {
        Course::new(&self.plan, &subject.vehicle, subject.steering_rate_rad_per_s)
    }

    /// The gusts as they act on the vehicle that `subject` was designed for.
    pub fn wind(&self, subject: &Subject) -> Wind {
        Wind { gusts: self.gusts, action: subject.gust }
    }
}

fn plan(draw: Draw, settings: &Settings, subject: &Subject) -> Plan {
    let armed = subject.armed_v_x;
    let hardest = subject.lateral_acceleration_m_per_s2;
    let lateral = draw.uniform(Quantity::LateralAcceleration, [GENTLEST * hardest, hardest]);
    let mut speed_m_per_s = draw.uniform(Quantity::Speed, [armed.min, armed.max]);
    let driven = match (settings.mix, &MANOEUVRES) {
        (Mix::Standard, all) => all.as_slice(),
        (Mix::Classic, [classic @ .., _]) => classic,
    };
    let name = draw.0.choose(Quantity::Manoeuvre as u64, driven);
    let name = name.unwrap_or(ManoeuvreName::Straight);
    let (lowest, braking) = match name {
        ManoeuvreName::BrakingInTurn => ([armed.min, speed_m_per_s], IN_TURN_M_PER_S2),
        _ => ([0.0, armed.min], LONGITUDINAL_M_PER_S2),
    };
    let radius_m = draw.uniform(Quantity::Radius, RADIUS_M);
    if name == ManoeuvreName::Roundabout {
        // Slow enough for the curve.
        speed_m_per_s = libm::sqrt(lateral * radius_m).clamp(armed.min, armed.max);
    }
    let manoeuvre = name.with(ManoeuvreNumbers {
        radius_m,
        lowest_speed_m_per_s: draw.uniform(Quantity::LowestSpeed, lowest),
        longitudinal_acceleration_m_per_s2: draw
            .uniform(Quantity::LongitudinalAcceleration, braking),
    });
    Plan {
        manoeuvre,
        speed_m_per_s,
        lateral_acceleration_m_per_s2: lateral * draw.sign(Quantity::Direction),
        start_s: draw.uniform(Quantity::ManoeuvreStart, START_S),
        pause_s: draw.uniform(Quantity::Pause, PAUSE_S),
    }
}

/// The `nominal` vehicle, within the bounds of `settings`.
fn vehicle(draw: Draw, settings: &Settings, nominal: &Vehicle) -> Vehicle {
    let transfer = settings.uncertainty.bounds.load_transfer_percent;
    let [of_mass, of_yaw_inertia, of_front, of_rear] =
        settings.uncertainty.bounds.intervals_percent();
    let Vehicle {
        yaw_inertia_kg_m2,
        front_cornering_stiffness_n_per_rad: front,
        rear_cornering_stiffness_n_per_rad: rear,
        ..
    } = *nominal;
    let mass_kg = draw.perturbed(Quantity::Mass, nominal.mass_kg, of_mass);
    Vehicle {
        mass_kg,
        // Mass times wheel radius.
        effective_longitudinal_inertia_kg_m: nominal.effective_longitudinal_inertia_kg_m * mass_kg
            / nominal.mass_kg,
        yaw_inertia_kg_m2: draw.perturbed(Quantity::YawInertia, yaw_inertia_kg_m2, of_yaw_inertia),
        front_cornering_stiffness_n_per_rad: draw.perturbed(
            Quantity::FrontStiffness,
            front,
            of_front,
        ),
        rear_cornering_stiffness_n_per_rad: draw.perturbed(Quantity::RearStiffness, rear, of_rear),
        centre_of_gravity_height_m: draw.perturbed(
            Quantity::LoadTransfer,
            nominal.centre_of_gravity_height_m,
            [-transfer, transfer],
        ),
        ..*nominal
    }
}

fn fault(draw: Draw, settings: &Settings) -> Option<Fault> {
    let name = match settings.faults {
        FaultMix::None => FaultName::None,
        FaultMix::Bias => FaultName::Bias,
        FaultMix::Mixed => draw.0.choose(Quantity::Fault as u64, FaultName::ALL)?,
    };
    let is_large = draw.uniform(Quantity::Large, [0.0, 1.0]) < LARGE;
    let sizes_deg = settings.large_fault_deg.filter(|_| is_large).unwrap_or(settings.fault_deg);
    let numbers = FaultNumbers {
        angle_rad: (draw.uniform(Quantity::FaultSize, sizes_deg) * draw.sign(Quantity::FaultSign))
            .to_radians(),
        rise_s: draw.uniform(Quantity::FaultRise, RISE_S),
        hz: draw.uniform(Quantity::FaultFrequency, OSCILLATION_HZ),
        lost: draw.uniform(Quantity::FaultLoss, LOSS),
        delay_s: draw.uniform(Quantity::FaultDelay, DELAY_S),
    };
    let onset = ONSET.map(|share| share * settings.duration_s);
    name.with(draw.uniform(Quantity::Onset, onset), numbers)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use steerguard_world::{FaultKind, Manoeuvre};

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
            let near = |value: f64, nominal: f64| within(value / nominal, [0.9 - 1e-9, 1.1 + 1e-9]);
            let (vehicle, nominal) = (&drive.vehicle, &PAPER.vehicle);
            let lateral = drive.plan.lateral_acceleration_m_per_s2.abs();
            prop_assert!(PAPER.armed_v_x.contains(drive.plan.speed_m_per_s));
            prop_assert!(within(lateral, [0.6 - 1e-12, 3.0]));
            if let Manoeuvre::StopAndGo { lowest_speed_m_per_s, .. } = drive.plan.manoeuvre {
                prop_assert!(within(lowest_speed_m_per_s, [0.0, 5.5]));
            }
            prop_assert!(within(drive.bank_deg, [-3.0, 3.0]));
            prop_assert!(within(drive.gusts.speed_m_per_s, [-10.0, 10.0]));
            prop_assert!(within(drive.gusts.duration_s, GUST_S));
            let [v_x_bias, r_bias] = drive.sensor_bias;
            prop_assert!(within(v_x_bias, [-0.01, 0.01]) && within(r_bias, [-0.001, 0.001]));
            prop_assert!(near(vehicle.mass_kg, nominal.mass_kg));
            prop_assert!(near(vehicle.yaw_inertia_kg_m2, nominal.yaw_inertia_kg_m2));
            prop_assert!(near(
                vehicle.front_cornering_stiffness_n_per_rad,
                nominal.front_cornering_stiffness_n_per_rad
            ));
            prop_assert!(near(
                vehicle.rear_cornering_stiffness_n_per_rad,
                nominal.rear_cornering_stiffness_n_per_rad
            ));
            if let Tyres::Saturating { friction } = drive.tyres {
                prop_assert!(within(friction, SETTINGS.uncertainty.bounds.friction));
            }
            let Steering { actuator, ratio, offset_rad } = drive.steering;
            prop_assert!(within(actuator.lag_s, [0.0, 0.02]));
            prop_assert!(within(actuator.delay_s, [0.0, 0.03]));
            prop_assert!(within(1.0 / ratio, [0.95 - 1e-12, 1.1 + 1e-12]));
            prop_assert!(within(offset_rad.to_degrees(), [-0.2, 0.2]));
            prop_assert!(within(drive.v_x_scale, [-0.02, 0.02]));
            let Some(Fault { onset_s, kind }) = drive.fault else { return Ok(()) };
            prop_assert!(within(onset_s, [6.0 - 1e-9, 42.0]));
            match kind {
                FaultKind::Bias { angle_rad }
                | FaultKind::Drift { angle_rad, .. }
                | FaultKind::Oscillation { angle_rad, .. } => {
                    let size_deg = angle_rad.abs().to_degrees();
                    prop_assert!(
                        within(size_deg, [0.1 - 1e-9, 2.0 + 1e-9])
                            || within(size_deg, [2.0 - 1e-9, 20.0 + 1e-9])
                    );
                }
                FaultKind::LossOfEffectiveness { lost } => prop_assert!(within(lost, LOSS)),
                FaultKind::Delay { delay_s } => prop_assert!(within(delay_s, DELAY_S)),
                FaultKind::Stuck => {}
            }
        }

        /// What is not asked about stays: campaigns that differ in one thing compare drive by drive.
        #[test]
        fn settings_change_what_they_name_and_nothing_else(index: u64) {
            let drive = draw(&SETTINGS, index);
            prop_assert_eq!(draw(&SETTINGS, index), drive);
            let nominal =
                draw(&Settings { uncertainty: Uncertainty::NOMINAL, ..SETTINGS }, index);
            prop_assert_eq!(nominal, Drive {
                bank_deg: 0.0,
                gusts: Gusts { speed_m_per_s: 0.0, ..drive.gusts },
                vehicle: PAPER.vehicle,
                tyres: Tyres::Linear,
                steering: Steering::of(PAPER.actuator),
                v_x_scale: 0.0,
                ..drive
            });
            let healthy = draw(&Settings { faults: FaultMix::None, ..SETTINGS }, index);
            prop_assert_eq!(healthy, Drive { fault: None, ..drive });
        }
    }

    #[test]
    fn the_actuator_is_the_design_s_and_slower() {
        let actuator = Actuator {
            lag_s: 0.1,
            delay_s: 0.2,
            rate_limit_rad_per_s: Some(0.5),
            angle_limit_rad: Some(0.6),
        };
        let subject = Subject { actuator, ..PAPER };
        let nominal = Settings { uncertainty: Uncertainty::NOMINAL, ..SETTINGS };
        for index in 0..100 {
            let slower = Drive::draw(&SETTINGS, &subject, index).steering.actuator;
            assert!((0.1..=0.12).contains(&slower.lag_s));
            assert!((0.2..=0.23).contains(&slower.delay_s));
            assert_eq!(slower.rate_limit_rad_per_s, Some(0.5));
            assert_eq!(slower.angle_limit_rad, Some(0.6));
            assert_eq!(Drive::draw(&nominal, &subject, index).steering.actuator, actuator);
        }
    }

    #[test]
    fn manoeuvres_and_faults_are_equally_likely() {
        let drives: Vec<_> = (0..7000).map(|index| draw(&SETTINGS, index)).collect();
        let near = |count: usize, expected| {
            assert!(count.abs_diff(expected) < 150, "{count} of 7000");
        };
        for manoeuvre in MANOEUVRES {
            let of = |drive: &&Drive| ManoeuvreName::of(&drive.plan.manoeuvre) == manoeuvre;
            near(drives.iter().filter(of).count(), 7000 / MANOEUVRES.len());
        }
        for name in FaultName::ALL {
            let of = |drive: &&Drive| FaultName::of(drive.fault.as_ref()) == *name;
            near(drives.iter().filter(of).count(), 7000 / FaultName::ALL.len());
        }
        let saturated = drives.iter().filter(|drive| drive.tyres != Tyres::Linear).count();
        assert!(saturated.abs_diff(3500) < 250, "{saturated} of 7000");
    }
}
