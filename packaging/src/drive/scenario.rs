//! What is driven in a co-simulation: a TOML file, by default the scenario of the paper's Fig. 1.
//!
#![doc = concat!("```toml\n", include_str!("scenario.toml"), "```")]
//!
//! # Conventions
//! - A key or table left out of the file has the value above; a key left out of a table is 0.
//! - `signal(t) = offset + amplitude sin(angular_frequency t)` from `start_s` on, 0 before; or `values`, each
//!   held for `period_s`, the last one to the end.
//! - The unit of a signal is in the name of its table.
//! - Manoeuvres and faults are those of campaigns, by the same names, from the same code. Only their
//!   `kind` has no default.
//! - A manoeuvre is driven at the initial speed by a speed control. Its driver takes the vehicle for the
//!   one of the plant; who holds `speed_m_per_s` takes it for the one of the detector.

use std::collections::BTreeMap;
use std::f64::consts::PI;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use steerguard_designer::document::{self, Allowed, Mistake, Mistakes};
use steerguard_designer::spec::ActuatorTable;
use steerguard_world::held_sample;

use crate::drive::kinds::{FaultTable, ManoeuvreTable};

/// More communication points than this are taken for a mistake.
const MAX_STEPS: f64 = 1e7;

/// Start times are met to this fraction of a second.
const START_TOLERANCE_S: f64 = 1e-9;

/// The default scenario with every key in it, or in a comment.
pub const DOCUMENTED: &str = include_str!("scenario.toml");

/// Signals, and the tables that take their place.
const REPLACED: [(&str, &str); 5] = [
    ("steering_angle_rad", "manoeuvre"),
    ("drive_torque_n_m", "manoeuvre"),
    ("speed_m_per_s", "manoeuvre"),
    ("drive_torque_n_m", "speed_m_per_s"),
    ("steering_fault_deg", "fault"),
];

/// `offset + amplitude sin(angular_frequency t)` from a start time on, or values.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, JsonSchema, Serialize)]
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
    /// If given, instead of all this: values in the signal's unit, and for how long each is held, s.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub values: Option<Vec<f64>>,
    /// See `values`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub period_s: Option<f64>,
}

impl Signal {
    /// The signal of `values`, each held for `period_s`.
    pub fn of_values(values: Vec<f64>, period_s: f64) -> Self {
        Self { values: Some(values), period_s: Some(period_s), ..Self::default() }
    }

    /// Value at time `t` in s of the run with the given initial speed in m/s.
    pub fn at(&self, t: f64, initial_speed_m_per_s: f64) -> f64 {
        if let (Some(values), Some(period_s)) = (&self.values, self.period_s) {
            return held_sample(values, period_s, t).unwrap_or(0.0);
        }
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
        if let Some(values) = &self.values {
            return values.iter().all(|&value| value == 0.0);
        }
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
        self.check_values(name, mistakes);
    }

    fn check_values(&self, name: &str, mistakes: &mut Mistakes) {
        let Self { values, period_s, .. } = self;
        if let Some(period_s) = *period_s {
            mistakes.number(&format!("{name}.period_s"), period_s, Allowed::POSITIVE);
        }
        let missing = match (values, period_s) {
            (Some(_), None) => Some(("period_s", "values")),
            (None, Some(_)) => Some(("values", "period_s")),
            _ => None,
        };
        if let Some((key, given)) = missing {
            mistakes.add(
                Mistake::missing(format!("{name}.{key}"))
                    .help("`values` are each held for `period_s`: state both")
                    .because_of(&format!("{name}.{given}")),
            );
        }
        let Some(values) = values else { return };
        let alone = Self { values: None, period_s: None, ..self.clone() } == Self::default();
        mistakes.unless(alone, || {
            let allowed = "nothing beside other keys than `period_s`";
            Mistake::value(format!("{name}.values"), format_args!("[ .. ]"), allowed)
        });
        let finite = values.iter().all(|value| value.is_finite());
        mistakes.unless(finite && !values.is_empty(), || {
            let allowed = "one finite number or more";
            Mistake::value(format!("{name}.values"), format_args!("[ .. ]"), allowed)
        });
    }
}

/// White noise of the sensors.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, JsonSchema, Serialize)]
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
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema, Serialize)]
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
    /// Where side wind and wind act, m ahead of the centre of gravity.
    pub side_wind_lever_arm_m: f64,
    /// Side force of the wind: times wind speed times speed of the air against the vehicle, N s^2/m^2.
    pub wind_coefficient_n_s2_per_m2: f64,
    /// Drive torque at the wheels on top of the torque that holds v_x(0), N m.
    pub drive_torque_n_m: Signal,
    /// Commanded angle at the road wheel, rad.
    pub steering_angle_rad: Signal,
    /// Side force per vehicle mass, m/s^2.
    pub side_wind_m_per_s2: Signal,
    /// Wind across the road, m/s, positive to the left: its force grows with the vehicle's speed.
    pub wind_m_per_s: Signal,
    /// Road bank, degrees, positive with the left side raised.
    pub road_bank_deg: Signal,
    /// Angle added by the faulty actuator at the road wheel, degrees.
    pub steering_fault_deg: Signal,
    /// Set speed of a speed control, in place of `drive_torque_n_m`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub speed_m_per_s: Option<Signal>,
    /// Drives in place of `steering_angle_rad` and `drive_torque_n_m`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub manoeuvre: Option<ManoeuvreTable>,
    /// Acts in place of `steering_fault_deg`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fault: Option<FaultTable>,
    /// The vehicle's steering actuator; the design's own if absent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub actuator: Option<ActuatorTable>,
    /// Noise on what the detector is told of v_x and r.
    pub sensor_noise: SensorNoise,
    /// Parameters of the plant's FMU, by name; those of the design if absent.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub plant: BTreeMap<String, PlantParameter>,
}

/// Value of a parameter of the plant's FMU.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, JsonSchema, Serialize)]
#[serde(untagged)]
pub enum PlantParameter {
    /// Of a Boolean parameter.
    Flag(bool),
    /// Of a Real one, in SI units.
    Number(f64),
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
            wind_coefficient_n_s2_per_m2: 2.64,
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
            wind_m_per_s: Signal::default(),
            road_bank_deg: Signal::default(),
            speed_m_per_s: None,
            manoeuvre: None,
            fault: None,
            actuator: None,
            sensor_noise: SensorNoise { v_x_std_m_per_s: 0.02, r_std_rad_per_s: 0.002, seed: 1 },
            plant: BTreeMap::new(),
        }
    }
}

impl Scenario {
    /// Reads and checks the text of a scenario file.
    ///
    /// # Errors
    /// [`Mistakes`], each of which names the key, its value and what is allowed.
    pub fn parse(text: &str) -> Result<Self, Mistakes> {
        // What is no TOML is found by the reader.
        let written: toml::Table = toml::from_str(text).unwrap_or_default();
        document::read(text, |scenario: &Self, mistakes| {
            scenario.find_mistakes(mistakes);
            for (signal, instead) in REPLACED {
                let both = written.contains_key(signal) && written.contains_key(instead);
                mistakes.unless(!both, || {
                    let allowed = format!("nothing beside [{instead}]");
                    Mistake::value(signal, format_args!("{{ .. }}"), allowed)
                        .help(format!("remove [{signal}] or [{instead}]"))
                        .because_of(instead)
                });
            }
        })
    }

    /// The text of a file that [`Self::parse`] reads.
    ///
    /// # Errors
    /// None that a scenario can cause.
    pub fn to_toml(&self) -> Result<String, toml::ser::Error> {
        let mut written = toml::Table::try_from(self)?;
        for (signal, instead) in REPLACED {
            if written.contains_key(instead) {
                written.remove(signal);
            }
        }
        toml::to_string(&written)
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
            ("wind_coefficient_n_s2_per_m2", self.wind_coefficient_n_s2_per_m2),
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
            ("wind_m_per_s", &self.wind_m_per_s),
            ("road_bank_deg", &self.road_bank_deg),
            ("steering_fault_deg", &self.steering_fault_deg),
        ] {
            signal.check(name, mistakes);
        }
        if let Some(speed) = &self.speed_m_per_s {
            speed.check("speed_m_per_s", mistakes);
        }
        for (name, value) in &self.plant {
            if let PlantParameter::Number(number) = value {
                mistakes.number(&format!("plant.{name}"), *number, Allowed::FINITE);
            }
        }
        if let Some(manoeuvre) = &self.manoeuvre {
            manoeuvre.check(speeds, mistakes);
        }
        if let Some(fault) = &self.fault {
            fault.check(mistakes);
        }
        if let Some(actuator) = &self.actuator {
            actuator.check(ActuatorTable::LARGEST_DELAY_S, mistakes);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::campaign::names::{FaultName, ManoeuvreName};

    #[test]
    fn the_documented_file_is_the_default() {
        assert_eq!(Scenario::parse(DOCUMENTED).unwrap(), Scenario::default());
        assert_eq!(Scenario::parse("").unwrap(), Scenario::default());
    }

    /// The tables in the comments of the documented file, of the kinds that use each number.
    #[test]
    fn the_documented_manoeuvres_and_faults_are_the_defaults() {
        let documented = |table: &str| -> Vec<(String, String, String)> {
            DOCUMENTED
                .lines()
                .skip_while(|line| !line.starts_with(&format!("# [{table}]")))
                .skip(1)
                .map_while(|line| line.strip_prefix("# "))
                .filter_map(|line| line.split_once(" = "))
                .map(|(key, rest)| {
                    let (value, comment) = rest.split_once('#').unwrap_or((rest, ""));
                    (key.into(), value.trim().into(), comment.into())
                })
                .collect()
        };
        let read = |table: &str, kind: &str, line: &str| {
            let text = format!("initial_speeds_m_per_s = [6]\n[{table}]\nkind = '{kind}'\n{line}");
            Scenario::parse(&text)
        };
        for (table, kinds) in [
            ("manoeuvre", ManoeuvreName::ALL.iter().map(|kind| kind.name()).collect::<Vec<_>>()),
            ("fault", FaultName::ALL.iter().map(|kind| kind.name()).collect()),
        ] {
            let mut keys = documented(table);
            assert_eq!(keys.remove(0).0, "kind");
            assert!(keys.len() >= 6, "{table}: {keys:?}");
            for kind in kinds {
                assert!(DOCUMENTED.contains(&format!("\"{kind}\"")), "{kind}");
                let plain = read(table, kind, "").unwrap();
                for (key, value, comment) in &keys {
                    let line = format!("{key} = {value}");
                    let has_use =
                        !comment.contains('"') || comment.contains(&format!("\"{kind}\""));
                    match read(table, kind, &line) {
                        Ok(stated) => {
                            assert!(has_use, "{kind}: {key}");
                            let manoeuvre = |scenario: &Scenario| {
                                scenario.manoeuvre.map(|table| table.plan(6.0))
                            };
                            assert_eq!(manoeuvre(&stated), manoeuvre(&plain), "{kind}: {key}");
                            let rate = |scenario: &Scenario| {
                                scenario.manoeuvre.map(|table| table.steering_rate_rad_per_s)
                            };
                            assert_eq!(rate(&stated), rate(&plain), "{kind}: {key}");
                            let fault =
                                |scenario: &Scenario| scenario.fault.map(|table| table.fault());
                            assert_eq!(fault(&stated), fault(&plain), "{kind}: {key}");
                        }
                        Err(mistakes) => {
                            assert!(!has_use, "{kind}: {mistakes}");
                            assert!(mistakes.to_string().contains("nothing, unless kind = "));
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn survives_a_round_trip() {
        let kinds = Scenario::parse(
            "[manoeuvre]\nkind = 'roundabout'\nradius_m = 15\n[fault]\nkind = 'drift'\nrise_s = 1",
        );
        let courses = Scenario::parse(
            "[speed_m_per_s]\nvalues = [6, 7.5]\nperiod_s = 2\n[plant]\n'vehicle.M_v' = 1600\n\
             'tyre.friction_limited' = true",
        );
        for scenario in [Scenario::default(), kinds.unwrap(), courses.unwrap()] {
            let read = Scenario::parse(&scenario.to_toml().unwrap());
            assert_eq!(read.unwrap(), scenario);
        }
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
            ("[manoeuvre]\nstart_s = 1", "manoeuvre.kind"),
            ("[manoeuvre]\nkind = 'slalom'", "manoeuvre.kind"),
            ("[manoeuvre]\nkind = 'weave'\nspeed = 3", "manoeuvre.speed"),
            (
                "[manoeuvre]\nkind = 'weave'\nlateral_acceleration_m_per_s2 = 0",
                "manoeuvre.lateral_acceleration_m_per_s2",
            ),
            (
                "[manoeuvre]\nkind = 'weave'\nlateral_acceleration_m_per_s2 = -20.1",
                "manoeuvre.lateral_acceleration_m_per_s2",
            ),
            (
                "[manoeuvre]\nkind = 'weave'\nsteering_rate_rad_per_s = 0",
                "manoeuvre.steering_rate_rad_per_s",
            ),
            ("[manoeuvre]\nkind = 'weave'\nstart_s = -1", "manoeuvre.start_s"),
            ("[manoeuvre]\nkind = 'weave'\npause_s = -1", "manoeuvre.pause_s"),
            ("[manoeuvre]\nkind = 'weave'\nradius_m = 20", "manoeuvre.radius_m"),
            ("[manoeuvre]\nkind = 'roundabout'\nradius_m = 0", "manoeuvre.radius_m"),
            (
                "[manoeuvre]\nkind = 'stop and go'\nlowest_speed_m_per_s = -1",
                "manoeuvre.lowest_speed_m_per_s",
            ),
            (
                "[manoeuvre]\nkind = 'stop and go'\nlowest_speed_m_per_s = 5.1",
                "at most the lowest initial speed, 5",
            ),
            (
                "[manoeuvre]\nkind = 'stop and go'\nlongitudinal_acceleration_m_per_s2 = 0",
                "manoeuvre.longitudinal_acceleration_m_per_s2",
            ),
            ("[fault]\nangle_deg = 1", "fault.kind"),
            ("[fault]\nkind = 'biass'", "\"bias\""),
            ("[fault]\nkind = 'bias'\nstart_s = -1", "fault.start_s"),
            ("[fault]\nkind = 'bias'\nangle_deg = 90.1", "fault.angle_deg"),
            ("[fault]\nkind = 'bias'\nrise_s = 1", "fault.rise_s"),
            ("[fault]\nkind = 'drift'\nrise_s = 0", "fault.rise_s"),
            ("[fault]\nkind = 'oscillation'\nfrequency_hz = 0", "fault.frequency_hz"),
            ("[fault]\nkind = 'loss of effectiveness'\nlost_share = 1.1", "fault.lost_share"),
            ("[fault]\nkind = 'delay'\ndelay_s = -0.1", "fault.delay_s"),
            ("[manoeuvre]\nkind = 'sine'\n[steering_angle_rad]", "steering_angle_rad"),
            ("[manoeuvre]\nkind = 'sine'\n[drive_torque_n_m]", "drive_torque_n_m"),
            ("[fault]\nkind = 'none'\n[steering_fault_deg]", "steering_fault_deg"),
            ("[manoeuvre]\nkind = 'sine'\n[speed_m_per_s]", "speed_m_per_s"),
            ("[speed_m_per_s]\n[drive_torque_n_m]", "drive_torque_n_m"),
            ("[wind_m_per_s]\nvalues = [1]", "wind_m_per_s.period_s"),
            ("[wind_m_per_s]\nperiod_s = 1", "wind_m_per_s.values"),
            ("[wind_m_per_s]\nvalues = []\nperiod_s = 1", "wind_m_per_s.values"),
            ("[wind_m_per_s]\nvalues = [inf]\nperiod_s = 1", "wind_m_per_s.values"),
            ("[wind_m_per_s]\nvalues = [1]\nperiod_s = 0", "wind_m_per_s.period_s"),
            ("[wind_m_per_s]\nvalues = [1]\nperiod_s = 1\noffset = 1", "wind_m_per_s.values"),
            ("[plant]\nm = nan", "plant.m"),
            ("[plant]\nm = 'heavy'", "plant"),
        ] {
            let message = Scenario::parse(text).unwrap_err().to_string();
            assert!(message.contains(key), "{text}: {message}");
        }
    }
}
