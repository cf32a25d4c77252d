//! `[manoeuvre]` and `[fault]` of a scenario: the world's manoeuvres and faults, by the names that
//! campaigns give them.
//!
//! # Conventions
//! - A table is flat: `kind`, what every kind has, and numbers that only some kinds have. The latter
//!   have their defaults where they are left out, and are mistakes where the kind has no use for them.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use steerguard_designer::document::{Allowed, Mistake, Mistakes};
use steerguard_detector::Vehicle;
use steerguard_world::{Course, Fault, Manoeuvre, Plan};

use crate::campaign::names::{FaultName, FaultNumbers, ManoeuvreName, ManoeuvreNumbers};

/// Lateral accelerations of a manoeuvre to either side, m/s^2: none would be no manoeuvre.
const LATERAL_M_PER_S2: [f64; 2] = [0.01, 20.0];
/// Largest angle that a fault adds to either side, deg.
const LARGEST_FAULT_DEG: f64 = 90.0;

/// `[manoeuvre]`: course of steering and speed; the set speed is the run's initial speed.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, JsonSchema, Serialize)]
#[serde(deny_unknown_fields)]
pub struct ManoeuvreTable {
    /// Which one.
    pub kind: ManoeuvreName,
    /// Steady lateral acceleration that the steering corresponds to, 0.01 to 20 to either side; the
    /// sign is the direction of the first run, left positive; default 2.
    #[serde(default = "two")]
    pub lateral_acceleration_m_per_s2: f64,
    /// Fastest steering, at the road wheel, positive: amplitudes are reduced to it; default 0.3, as in
    /// the specification's `[evaluation.calibration]`.
    #[serde(default = "fastest_steering")]
    pub steering_rate_rad_per_s: f64,
    /// When the first run begins, not negative; default 1.
    #[serde(default = "one")]
    pub start_s: f64,
    /// Time between two runs of a manoeuvre that ends, not negative; default 2.
    #[serde(default = "two")]
    pub pause_s: f64,
    /// Radius of a roundabout, positive; default 20.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub radius_m: Option<f64>,
    /// Speed that stop and go, or the vehicle in a turn, brakes to, from 0 to the lowest initial speed; default 2.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lowest_speed_m_per_s: Option<f64>,
    /// Braking and acceleration of stop and go, or in a turn, positive; default 1.5.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub longitudinal_acceleration_m_per_s2: Option<f64>,
}

fn one() -> f64 {
    1.0
}

fn two() -> f64 {
    2.0
}

fn fastest_steering() -> f64 {
    0.3
}

impl ManoeuvreTable {
    /// The manoeuvre of its kind, with the defaults of what is left out.
    pub fn manoeuvre(&self) -> Manoeuvre {
        self.kind.with(ManoeuvreNumbers {
            radius_m: self.radius_m.unwrap_or(20.0),
            lowest_speed_m_per_s: self.lowest_speed_m_per_s.unwrap_or(2.0),
            longitudinal_acceleration_m_per_s2: self
                .longitudinal_acceleration_m_per_s2
                .unwrap_or(1.5),
        })
    }

    /// The manoeuvre as it is driven at a set speed, m/s.
    pub fn plan(&self, speed_m_per_s: f64) -> Plan {
        Plan {
            manoeuvre: self.manoeuvre(),
            speed_m_per_s,
            lateral_acceleration_m_per_s2: self.lateral_acceleration_m_per_s2,
            start_s: self.start_s,
            pause_s: self.pause_s,
        }
    }

    /// Its course for a driver who takes the vehicle for `vehicle`, at a set speed, m/s.
    pub fn course(&self, vehicle: &Vehicle, speed_m_per_s: f64) -> Course {
        Course::new(&self.plan(speed_m_per_s), vehicle, self.steering_rate_rad_per_s)
    }

    /// Finds what is not possible in runs with these initial speeds, m/s.
    pub(super) fn check(&self, initial_speeds_m_per_s: &[f64], mistakes: &mut Mistakes) {
        let lateral = self.lateral_acceleration_m_per_s2;
        let [gentlest, hardest] = LATERAL_M_PER_S2;
        mistakes.unless(Allowed::between(gentlest, hardest).holds(lateral.abs()), || {
            let allowed = format!("from {gentlest} to {hardest} or from -{hardest} to -{gentlest}");
            Mistake::value("manoeuvre.lateral_acceleration_m_per_s2", lateral, allowed)
        });
        let rate = self.steering_rate_rad_per_s;
        mistakes.number("manoeuvre.steering_rate_rad_per_s", rate, Allowed::POSITIVE);
        mistakes.number("manoeuvre.start_s", self.start_s, Allowed::NOT_NEGATIVE);
        mistakes.number("manoeuvre.pause_s", self.pause_s, Allowed::NOT_NEGATIVE);

        let table = Table { name: "manoeuvre", kind: self.kind.name() };
        let roundabout = [ManoeuvreName::Roundabout.name()];
        table.check("radius_m", self.radius_m, Allowed::POSITIVE, &roundabout, mistakes);
        let braking = [ManoeuvreName::StopAndGo.name(), ManoeuvreName::BrakingInTurn.name()];
        for (key, value, allowed) in [
            ("lowest_speed_m_per_s", self.lowest_speed_m_per_s, Allowed::NOT_NEGATIVE),
            (
                "longitudinal_acceleration_m_per_s2",
                self.longitudinal_acceleration_m_per_s2,
                Allowed::POSITIVE,
            ),
        ] {
            table.check(key, value, allowed, &braking, mistakes);
        }
        if let Manoeuvre::StopAndGo { lowest_speed_m_per_s: lowest, .. }
        | Manoeuvre::BrakingInTurn { lowest_speed_m_per_s: lowest, .. } = self.manoeuvre()
        {
            let slowest = initial_speeds_m_per_s.iter().copied().fold(f64::INFINITY, f64::min);
            mistakes.unless(lowest <= slowest || !mistakes.sound("initial_speeds_m_per_s"), || {
                let allowed = format!("at most the lowest initial speed, {slowest}");
                Mistake::value("manoeuvre.lowest_speed_m_per_s", lowest, allowed)
                    .because_of("initial_speeds_m_per_s")
            });
        }
    }
}

/// `[fault]`: what the steering suffers from. Angles are at the road wheel.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, JsonSchema, Serialize)]
#[serde(deny_unknown_fields)]
pub struct FaultTable {
    /// Which one.
    pub kind: FaultName,
    /// When it begins, not negative; default 5.
    #[serde(default = "five")]
    pub start_s: f64,
    /// Size of a bias, drift or oscillation, -90 to 90; default 0.5.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub angle_deg: Option<f64>,
    /// Time that a drift takes to its size, positive; default 5.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rise_s: Option<f64>,
    /// Frequency of an oscillation, positive; default 1.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub frequency_hz: Option<f64>,
    /// Share of the command that a loss of effectiveness takes, 0 to 1; default 0.5.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lost_share: Option<f64>,
    /// How late a delay is, not negative; default 0.2.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub delay_s: Option<f64>,
}

fn five() -> f64 {
    5.0
}

impl FaultTable {
    /// The fault of its kind, with the defaults of what is left out.
    pub fn fault(&self) -> Option<Fault> {
        let numbers = FaultNumbers {
            angle_rad: self.angle_deg.unwrap_or(0.5).to_radians(),
            rise_s: self.rise_s.unwrap_or(5.0),
            hz: self.frequency_hz.unwrap_or(1.0),
            lost: self.lost_share.unwrap_or(0.5),
            delay_s: self.delay_s.unwrap_or(0.2),
        };
        self.kind.with(self.start_s, numbers)
    }

    /// Finds what is not possible.
    pub(super) fn check(&self, mistakes: &mut Mistakes) {
        mistakes.number("fault.start_s", self.start_s, Allowed::NOT_NEGATIVE);
        let table = Table { name: "fault", kind: self.kind.name() };
        let angle_deg = Allowed::between(-LARGEST_FAULT_DEG, LARGEST_FAULT_DEG);
        let having = FaultName::having;
        table.check("angle_deg", self.angle_deg, angle_deg, &having(|of| of.angle_rad), mistakes);
        table.check("rise_s", self.rise_s, Allowed::POSITIVE, &having(|of| of.rise_s), mistakes);
        let frequency_hz = self.frequency_hz;
        table.check("frequency_hz", frequency_hz, Allowed::POSITIVE, &having(|of| of.hz), mistakes);
        let share = Allowed::between(0.0, 1.0);
        table.check("lost_share", self.lost_share, share, &having(|of| of.lost), mistakes);
        let late = Allowed::NOT_NEGATIVE;
        table.check("delay_s", self.delay_s, late, &having(|of| of.delay_s), mistakes);
    }
}

/// A table whose numbers depend on its kind.
#[derive(Clone, Copy)]
struct Table {
    name: &'static str,
    kind: &'static str,
}

impl Table {
    /// Finds what is not possible of a number that only some `kinds` have.
    fn check(
        self,
        key: &str,
        value: Option<f64>,
        allowed: Allowed,
        kinds: &[&str],
        mistakes: &mut Mistakes,
    ) {
        let Some(value) = value else { return };
        let Self { name, kind } = self;
        let path = format!("{name}.{key}");
        if kinds.contains(&kind) {
            mistakes.number(&path, value, allowed);
        } else {
            let kinds: Vec<_> = kinds.iter().map(|kind| format!("\"{kind}\"")).collect();
            let allowed = format!("nothing, unless kind = {}", kinds.join(" or "));
            mistakes.add(
                Mistake::value(path, value, allowed)
                    .help("remove it, or set another kind")
                    .because_of(&format!("{name}.kind")),
            );
        }
    }
}

#[cfg(test)]
mod tests {
    use steerguard_world::FaultKind;

    use super::*;

    fn read<T: serde::de::DeserializeOwned>(text: &str) -> T {
        toml::from_str(text).unwrap()
    }

    #[test]
    fn manoeuvres_have_the_numbers_of_their_tables() {
        let table: ManoeuvreTable = read(
            "kind = 'stop and go'\nlateral_acceleration_m_per_s2 = -1.25\nstart_s = 3\npause_s = 4\n\
             lowest_speed_m_per_s = 1\nlongitudinal_acceleration_m_per_s2 = 2.5",
        );
        let expected = Plan {
            manoeuvre: Manoeuvre::StopAndGo {
                lowest_speed_m_per_s: 1.0,
                longitudinal_acceleration_m_per_s2: 2.5,
            },
            speed_m_per_s: 12.0,
            lateral_acceleration_m_per_s2: -1.25,
            start_s: 3.0,
            pause_s: 4.0,
        };
        assert_eq!(table.plan(12.0), expected);
        let table: ManoeuvreTable = read("kind = 'roundabout'\nradius_m = 15");
        assert_eq!(table.manoeuvre(), Manoeuvre::Roundabout { radius_m: 15.0 });
        for &kind in ManoeuvreName::ALL {
            let table = ManoeuvreTable { kind, ..table };
            assert_eq!(ManoeuvreName::of(&table.manoeuvre()), kind);
        }
    }

    #[test]
    fn the_steering_is_no_faster_than_stated() {
        let fastest = |rate: f64| {
            let text = format!("kind = 'step steer'\nsteering_rate_rad_per_s = {rate}");
            let course = read::<ManoeuvreTable>(&text).course(&Vehicle::PAPER, 10.0);
            let turned = |k: i32| {
                course.steering_rad(0.001 * f64::from(k + 1))
                    - course.steering_rad(0.001 * f64::from(k))
            };
            (0..4000).map(turned).fold(0.0, f64::max) / 0.001
        };
        for rate in [0.1, 0.3] {
            assert!((fastest(rate) - rate).abs() < 1e-9, "{}", fastest(rate));
        }
    }

    #[test]
    fn faults_have_the_numbers_of_their_tables() {
        let angle_rad = 3.0_f64.to_radians();
        for (text, expected) in [
            ("kind = 'bias'\nangle_deg = 3", FaultKind::Bias { angle_rad }),
            (
                "kind = 'drift'\nangle_deg = 3\nrise_s = 2",
                FaultKind::Drift { angle_rad, rise_s: 2.0 },
            ),
            ("kind = 'stuck'", FaultKind::Stuck),
            (
                "kind = 'loss of effectiveness'\nlost_share = 0.25",
                FaultKind::LossOfEffectiveness { lost: 0.25 },
            ),
            (
                "kind = 'oscillation'\nangle_deg = 3\nfrequency_hz = 2",
                FaultKind::Oscillation { angle_rad, hz: 2.0 },
            ),
            ("kind = 'delay'\ndelay_s = 0.1", FaultKind::Delay { delay_s: 0.1 }),
        ] {
            let fault = read::<FaultTable>(&format!("start_s = 7\n{text}")).fault();
            assert_eq!(fault, Some(Fault { onset_s: 7.0, kind: expected }));
            let name = FaultName::of(fault.as_ref()).name();
            assert!(text.contains(&format!("'{name}'")), "{text}: {name}");
        }
        assert_eq!(read::<FaultTable>("kind = 'none'").fault(), None);
    }
}
