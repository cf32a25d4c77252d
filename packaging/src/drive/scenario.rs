//! What is driven in a co-simulation: a TOML file, by default the scenario of the paper's Fig. 1.
//!
//! ```toml
//! duration_s = 20.0
//! # communication_step_s = 0.01          # default: the detector's sampling period
//! initial_speeds_m_per_s = [6.0, 15.0, 25.0, 5.0]   # one run each
//! initial_lateral_speed_m_per_s = 1.0
//! initial_yaw_rate_rad_per_s = 0.0
//! side_wind_lever_arm_m = 0.25           # ahead of the centre of gravity
//!
//! [drive_torque_n_m]                     # on top of the torque that holds the initial speed
//!
//! [steering_angle_rad]
//! amplitude = 0.02
//! angular_frequency_rad_per_s = 0.5
//! reference_speed_m_per_s = 5.0          # times sqrt(reference speed / initial speed)
//!
//! [side_wind_m_per_s2]                   # side force / vehicle mass
//! amplitude = -0.1
//! angular_frequency_rad_per_s = 0.3141592653589793
//!
//! [steering_fault_deg]
//! offset = 0.5
//! amplitude = -0.1
//! angular_frequency_rad_per_s = 0.3141592653589793
//! start_s = 5.0
//!
//! # [actuator]                           # of the vehicle; default: the one of the design
//! # lag_s = 0.1
//! # delay_s = 0.03
//! # rate_limit_rad_per_s = 0.5
//!
//! [sensor_noise]                         # white, a new value each communication step
//! v_x_std_m_per_s = 0.02
//! r_std_rad_per_s = 0.002
//! seed = 1
//! ```
//!
//! # Conventions
//! - A key or table left out of the file has the value above; a key left out of a table is 0.
//! - `signal(t) = offset + amplitude sin(angular_frequency t)` from `start_s` on, 0 before.
//! - The unit of a signal is in the name of its table.

use std::f64::consts::PI;

use serde::{Deserialize, Serialize};
use steerguard_designer::document::{self, Allowed, Mistake, Mistakes};
use steerguard_designer::spec::ActuatorTable;

/// More communication points than this are taken for a mistake.
const MAX_STEPS: f64 = 1e7;

/// Start times are met to this fraction of a second.
const START_TOLERANCE_S: f64 = 1e-9;

/// `offset + amplitude sin(angular_frequency t)` from a start time on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct Signal {
    /// Constant part, in the signal's unit.
    pub offset: f64,
    /// Amplitude of the sine, in the signal's unit.
    pub amplitude: f64,
    /// Angular frequency of the sine, rad/s.
    pub angular_frequency_rad_per_s: f64,
    /// The signal is 0 before this time, s.
    pub start_s: f64,
    /// If given, the signal is scaled by `sqrt(reference speed / initial speed)`, m/s.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reference_speed_m_per_s: Option<f64>,
}

impl Signal {
    /// Value at time `t` in s of the run with the given initial speed in m/s.
    pub fn at(&self, t: f64, initial_speed_m_per_s: f64) -> f64 {
        if t < self.start_s - START_TOLERANCE_S {
            return 0.0;
        }
        let scale = match self.reference_speed_m_per_s {
            Some(reference) => (reference / initial_speed_m_per_s).sqrt(),
            None => 1.0,
        };
        scale * (self.offset + self.amplitude * libm::sin(self.angular_frequency_rad_per_s * t))
    }

    /// Whether the signal is 0 at all times.
    pub fn is_zero(&self) -> bool {
        self.offset == 0.0 && (self.amplitude == 0.0 || self.angular_frequency_rad_per_s == 0.0)
    }

    /// Finds what is not possible of the signal called `name`.
    fn check(&self, name: &str, mistakes: &mut Mistakes) {
        for (key, value) in [
            ("offset", self.offset),
            ("amplitude", self.amplitude),
            ("angular_frequency_rad_per_s", self.angular_frequency_rad_per_s),
            ("start_s", self.start_s),
        ] {
            mistakes.number(&format!("{name}.{key}"), value, Allowed::FINITE);
        }
        if let Some(speed) = self.reference_speed_m_per_s {
            let key = format!("{name}.reference_speed_m_per_s");
            mistakes.number(&key, speed, Allowed::POSITIVE);
        }
    }
}

/// White noise of the sensors.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct SensorNoise {
    /// Standard deviation on v_x, m/s.
    pub v_x_std_m_per_s: f64,
    /// Standard deviation on r, rad/s.
    pub r_std_rad_per_s: f64,
    /// Same seed, same noise.
    pub seed: i32,
}

/// One co-simulation run per initial speed.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct Scenario {
    /// Length of each run, s.
    pub duration_s: f64,
    /// Communication step, s; the detector's sampling period if absent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub communication_step_s: Option<f64>,
    /// v_x(0) of each run, m/s.
    pub initial_speeds_m_per_s: Vec<f64>,
    /// v_y(0), m/s.
    pub initial_lateral_speed_m_per_s: f64,
    /// r(0), rad/s.
    pub initial_yaw_rate_rad_per_s: f64,
    /// Where the side wind acts, m ahead of the centre of gravity.
    pub side_wind_lever_arm_m: f64,
    /// Drive torque at the wheels on top of the torque that holds v_x(0), N m.
    pub drive_torque_n_m: Signal,
    /// Commanded angle at the road wheel, rad.
    pub steering_angle_rad: Signal,
    /// Side force per vehicle mass, m/s^2.
    pub side_wind_m_per_s2: Signal,
    /// Angle added by the faulty actuator at the road wheel, degrees.
    pub steering_fault_deg: Signal,
    /// The vehicle's steering actuator; the design's own if absent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub actuator: Option<ActuatorTable>,
    /// Noise on what the detector is told of v_x and r.
    pub sensor_noise: SensorNoise,
}

impl Default for Scenario {
    /// The scenario of the paper's Fig. 1, method 7, with its 5 m/s as the last run: that speed
    /// is the edge of the range of the design. The sensors' noise is that of the default
    /// specification.
    fn default() -> Self {
        Self {
            duration_s: 20.0,
            communication_step_s: None,
            initial_speeds_m_per_s: vec![6.0, 15.0, 25.0, 5.0],
            initial_lateral_speed_m_per_s: 1.0,
            initial_yaw_rate_rad_per_s: 0.0,
            side_wind_lever_arm_m: 0.25,
            drive_torque_n_m: Signal::default(),
            steering_angle_rad: Signal {
                amplitude: 0.02,
                angular_frequency_rad_per_s: 0.5,
                reference_speed_m_per_s: Some(5.0),
                ..Signal::default()
            },
            side_wind_m_per_s2: Signal {
                amplitude: -0.1,
                angular_frequency_rad_per_s: 0.1 * PI,
                ..Signal::default()
            },
            steering_fault_deg: Signal {
                offset: 0.5,
                amplitude: -0.1,
                angular_frequency_rad_per_s: 0.1 * PI,
                start_s: 5.0,
                ..Signal::default()
            },
            actuator: None,
            sensor_noise: SensorNoise { v_x_std_m_per_s: 0.02, r_std_rad_per_s: 0.002, seed: 1 },
        }
    }
}

impl Scenario {
    /// Reads and checks the text of a scenario file.
    ///
    /// # Errors
    /// [`Mistakes`], each of which names the key, its value and what is allowed.
    pub fn parse(text: &str) -> Result<Self, Mistakes> {
        document::read(text, Self::find_mistakes)
    }

    /// Number of communication steps of `step_s` seconds in a run.
    ///
    /// # Errors
    /// [`Mistakes`] if there would be none or unreasonably many.
    pub fn steps(&self, step_s: f64) -> Result<u32, Mistakes> {
        let steps = (self.duration_s / step_s).round();
        if (1.0..=MAX_STEPS).contains(&steps) {
            return Ok(steps as u32);
        }
        let value = format_args!("{} with steps of {step_s} s", self.duration_s);
        let allowed = format!("from 1 to {MAX_STEPS} steps");
        Err(Mistake::value("duration_s", value, allowed).into())
    }

    /// Steering fault in rad at time `t` in s of the run with the given initial speed in m/s.
    pub fn steering_fault_rad(&self, t: f64, initial_speed_m_per_s: f64) -> f64 {
        self.steering_fault_deg.at(t, initial_speed_m_per_s) * (PI / 180.0)
    }

    fn find_mistakes(&self, mistakes: &mut Mistakes) {
        mistakes.number("duration_s", self.duration_s, Allowed::POSITIVE);
        if let Some(step_s) = self.communication_step_s {
            mistakes.number("communication_step_s", step_s, Allowed::POSITIVE);
        }
        let speeds = &self.initial_speeds_m_per_s;
        mistakes.unless(!speeds.is_empty(), || {
            Mistake::value("initial_speeds_m_per_s", speeds, "one speed or more")
        });
        for (index, &speed) in speeds.iter().enumerate() {
            let key = format!("initial_speeds_m_per_s[{index}]");
            mistakes.number(&key, speed, Allowed::POSITIVE);
        }
        for (key, value) in [
            ("initial_lateral_speed_m_per_s", self.initial_lateral_speed_m_per_s),
            ("initial_yaw_rate_rad_per_s", self.initial_yaw_rate_rad_per_s),
            ("side_wind_lever_arm_m", self.side_wind_lever_arm_m),
        ] {
            mistakes.number(key, value, Allowed::FINITE);
        }
        for (key, std) in [
            ("sensor_noise.v_x_std_m_per_s", self.sensor_noise.v_x_std_m_per_s),
            ("sensor_noise.r_std_rad_per_s", self.sensor_noise.r_std_rad_per_s),
        ] {
            mistakes.number(key, std, Allowed::NOT_NEGATIVE);
        }
        for (name, signal) in [
            ("drive_torque_n_m", &self.drive_torque_n_m),
            ("steering_angle_rad", &self.steering_angle_rad),
            ("side_wind_m_per_s2", &self.side_wind_m_per_s2),
            ("steering_fault_deg", &self.steering_fault_deg),
        ] {
            signal.check(name, mistakes);
        }
        if let Some(actuator) = &self.actuator {
            actuator.check(ActuatorTable::LARGEST_DELAY_S, mistakes);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_documented_file_is_the_default() {
        let documented: String = include_str!("scenario.rs")
            .lines()
            .skip_while(|line| *line != "//! ```toml")
            .skip(1)
            .take_while(|line| *line != "//! ```")
            .map(|line| format!("{}\n", line.trim_start_matches("//!").trim_start()))
            .collect();
        assert_eq!(Scenario::parse(&documented).unwrap(), Scenario::default());
        assert_eq!(Scenario::parse("").unwrap(), Scenario::default());
    }

    #[test]
    fn survives_a_round_trip() {
        let text = toml::to_string(&Scenario::default()).unwrap();
        assert_eq!(Scenario::parse(&text).unwrap(), Scenario::default());
    }

    #[test]
    fn signals_are_those_of_the_paper() {
        let scenario = Scenario::default();
        let t = 7.3;
        let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-15, "{a} {b}");
        close(
            scenario.steering_angle_rad.at(t, 20.0),
            0.02 * (0.5 * t).sin() * (5.0_f64 / 20.0).sqrt(),
        );
        close(scenario.side_wind_m_per_s2.at(t, 20.0), 0.1 * (-0.1 * PI * t).sin());
        close(scenario.steering_fault_deg.at(t, 20.0), 0.5 + 0.1 * (-0.1 * PI * t).sin());
        assert_eq!(scenario.steering_fault_deg.at(4.99, 20.0), 0.0);
        assert_ne!(scenario.steering_fault_deg.at(500.0 * 0.01, 20.0), 0.0);
    }

    #[test]
    fn bad_files_name_the_key() {
        for (text, key) in [
            ("duration = 3", "duration"),
            ("duration_s = 0", "duration_s"),
            ("duration_s = nan", "duration_s"),
            ("initial_speeds_m_per_s = []", "initial_speeds_m_per_s"),
            ("initial_speeds_m_per_s = [6, -1]", "initial_speeds_m_per_s"),
            ("side_wind_lever_arm_m = inf", "side_wind_lever_arm_m"),
            ("[steering_fault_deg]\nsize = 1", "size"),
            ("[actuator]\nlag = 0.1", "lag_s"),
            ("[actuator]\ndelay_s = 0.6", "actuator.delay_s"),
            (
                "[steering_angle_rad]\nreference_speed_m_per_s = 0",
                "steering_angle_rad.reference_speed",
            ),
            ("[steering_angle_rad]\noffset = nan", "steering_angle_rad.offset"),
        ] {
            let message = Scenario::parse(text).unwrap_err().to_string();
            assert!(message.contains(key), "{text}: {message}");
        }
    }
}
