//! What a campaign is to do, and what it needs to know of the design.

use serde::Serialize;
use steerguard_designer::spec::{Fault, UncertaintyTable};
use steerguard_designer::{Design, Spec};
use steerguard_detector::{Actuator, Gust, Interval, Vehicle, Zero};

/// Settings of a campaign: with a design, they say everything about its drives.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Settings {
    /// Seed of every random number.
    pub seed: u64,
    /// Number of drives.
    pub drives: u64,
    /// Length of a drive, s.
    pub duration_s: f64,
    /// Which drives are mixed.
    pub mix: Mix,
    /// Which faults are drawn.
    pub faults: FaultMix,
    /// Smallest and largest bias, drift and oscillation, degrees at the road wheel.
    pub fault_deg: [f64; 2],
    /// The same of a quarter of them, the large ones, where there are any.
    pub large_fault_deg: Option<[f64; 2]>,
    /// What the design does not know of.
    pub uncertainty: Uncertainty,
    /// Sensor errors.
    pub sensors: Sensors,
}

/// Which drives are mixed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, clap::ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum Mix {
    /// All manoeuvres, friction as stated, large faults among the others.
    #[default]
    Standard,
    /// Without braking in turns and large faults, friction down to 0.7: for comparison with figures of
    /// earlier versions.
    Classic,
}

/// Which faults are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, clap::ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum FaultMix {
    /// No fault in any drive.
    None,
    /// No fault and every kind of fault, equally likely.
    Mixed,
    /// A bias in every drive.
    Bias,
}

/// Bounds of what is drawn of vehicle, road and air.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Uncertainty {
    /// Vehicle parameters, each drawn alone, bank and gusts.
    #[serde(flatten)]
    pub bounds: UncertaintyTable,
    /// Whether friction limits the axle forces in half of the drives.
    pub saturation: bool,
}

impl Uncertainty {
    /// The design's own vehicle on a flat road in still air.
    pub const NOMINAL: Self = Self { bounds: UncertaintyTable::NONE, saturation: false };
}

/// Sensor errors: white noise, and bounds of a bias that is constant in a drive.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Sensors {
    /// Standard deviation of the noise on v_x, m/s, held for a sampling period.
    pub v_x_noise_m_per_s: f64,
    /// Standard deviation of the noise on r, rad/s, held for a sampling period.
    pub r_noise_rad_per_s: f64,
    /// Largest bias of v_x, m/s.
    pub v_x_bias_m_per_s: f64,
    /// Largest bias of r, rad/s.
    pub r_bias_rad_per_s: f64,
}

impl Sensors {
    /// The sensors that the specification describes: its white noise; its bounds, and the bias of the yaw
    /// rate that is uncertain, as bias.
    pub fn of(spec: &Spec) -> Self {
        let [v_x_noise_m_per_s, r_noise_rad_per_s] = spec.noise.white_std();
        let [v_x_bias_m_per_s, r_bound_rad_per_s] =
            spec.noise.bounds().map(Option::unwrap_or_default);
        let r_bias_rad_per_s =
            r_bound_rad_per_s + spec.uncertainty.yaw_rate_bias_deg_per_s.to_radians();
        Self { v_x_noise_m_per_s, r_noise_rad_per_s, v_x_bias_m_per_s, r_bias_rad_per_s }
    }
}

/// The design under test, as far as drives depend on it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Subject {
    /// The vehicle it is made for.
    pub vehicle: Vehicle,
    /// The steering actuator it is made for.
    pub actuator: Actuator,
    /// What its sensors show at zero.
    pub zero: Zero,
    /// Sampling period, the communication step of the drives, s.
    pub period_s: f64,
    /// Speeds at which it arms, m/s.
    pub armed_v_x: Interval,
    /// Lateral acceleration of its hardest manoeuvre, m/s^2.
    pub lateral_acceleration_m_per_s2: f64,
    /// Fastest steering at the road wheel, rad/s.
    pub steering_rate_rad_per_s: f64,
    /// Smallest steering fault of interest, deg.
    pub smallest_fault_deg: f64,
    /// How gusts act on it.
    pub gust: Gust,
}

impl Subject {
    /// What drives take from `design`.
    pub fn of(design: &Design) -> Self {
        let spec = &design.spec;
        let calibration = &spec.evaluation.calibration;
        let smallest = spec.fault.iter().find_map(|fault| match fault {
            Fault::Steering { smallest_deg, .. } => Some(*smallest_deg),
            Fault::Torque { .. } => None,
        });
        let range = &spec.operating_range;
        let [v_x_hysteresis, ..] = range.hysteresis();
        Self {
            vehicle: design.detector.model.vehicle,
            actuator: spec.actuator.actuator(),
            zero: spec.sensors.zero(),
            period_s: design.detector.model.sampling_period_s,
            armed_v_x: range.range().v_x.shrunk(v_x_hysteresis),
            lateral_acceleration_m_per_s2: calibration
                .lateral_acceleration_m_per_s2
                .iter()
                .copied()
                .fold(0.0, f64::max),
            steering_rate_rad_per_s: calibration.steering_rate_rad_per_s,
            smallest_fault_deg: smallest.unwrap_or(0.5),
            gust: spec.uncertainty.gust(),
        }
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    pub const PAPER: Subject = Subject {
        vehicle: Vehicle::PAPER,
        actuator: Actuator::NONE,
        zero: Zero { steering_offset_rad: 0.0, yaw_rate_bias_rad_per_s: 0.0 },
        period_s: 0.01,
        armed_v_x: Interval::new(5.5, 29.5),
        lateral_acceleration_m_per_s2: 3.0,
        steering_rate_rad_per_s: 0.3,
        smallest_fault_deg: 0.5,
        gust: Gust { speed_m_per_s: 10.0, coefficient_n_s2_per_m2: 2.64, acting_ahead_m: 0.25 },
    };

    pub const SETTINGS: Settings = Settings {
        seed: 1,
        drives: 1000,
        duration_s: 60.0,
        mix: Mix::Standard,
        faults: FaultMix::Mixed,
        fault_deg: [0.1, 2.0],
        large_fault_deg: Some([2.0, 20.0]),
        uncertainty: Uncertainty {
            bounds: UncertaintyTable {
                actuator_lag_s: 0.02,
                actuator_delay_s: 0.03,
                steering_ratio_percent: [-5.0, 10.0],
                steering_offset_deg: 0.2,
                v_x_scale_percent: 2.0,
                ..UncertaintyTable::DEFAULT
            },
            saturation: true,
        },
        sensors: Sensors {
            v_x_noise_m_per_s: 0.02,
            r_noise_rad_per_s: 0.002,
            v_x_bias_m_per_s: 0.01,
            r_bias_rad_per_s: 0.001,
        },
    };
}
