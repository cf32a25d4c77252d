//! Units of columns, and what they are in SI.

use std::fmt;

/// What a column measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// Time.
    Time,
    /// Speed.
    Speed,
    /// Angle by time.
    AngularRate,
    /// Angle.
    Angle,
    /// Acceleration.
    Acceleration,
    /// Torque.
    Torque,
}

/// A unit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unit {
    /// What it measures.
    pub quantity: Quantity,
    /// How it is written.
    pub symbol: &'static str,
    /// One of it in SI.
    pub in_si: f64,
}

/// Standard gravity, m/s^2.
const GRAVITY_M_PER_S2: f64 = 9.80665;
/// One degree, rad.
const DEGREE: f64 = std::f64::consts::PI / 180.0;

/// A row a unit: the unit, and how else it is written, in small letters and without blanks. The first of a
/// quantity is the one of SI.
const UNITS: [(Unit, &[&str]); 15] = [
    unit(Quantity::Time, "s", 1.0, &["sec", "secs", "second", "seconds"]),
    unit(Quantity::Time, "ms", 1e-3, &["msec", "millis", "millisecond", "milliseconds"]),
    unit(Quantity::Time, "us", 1e-6, &["\u{b5}s", "\u{3bc}s", "usec", "micros", "microseconds"]),
    unit(Quantity::Time, "ns", 1e-9, &["nsec", "nanos", "nanoseconds"]),
    unit(
        Quantity::Speed,
        "m/s",
        1.0,
        &["mps", "m_s", "m_per_s", "m/sec", "ms^-1", "meters_per_second"],
    ),
    unit(Quantity::Speed, "km/h", 1.0 / 3.6, &["kmh", "kph", "kmph", "km_h", "km_per_h", "km/hr"]),
    unit(Quantity::Speed, "mph", 0.44704, &["mi/h", "mi_per_h"]),
    unit(Quantity::Speed, "kn", 1852.0 / 3600.0, &["kt", "kts", "knot", "knots"]),
    unit(Quantity::AngularRate, "rad/s", 1.0, &["rad_s", "radps", "rps", "rad_per_s", "rad/sec"]),
    unit(
        Quantity::AngularRate,
        "deg/s",
        DEGREE,
        &["deg_s", "degps", "dps", "deg_per_s", "deg/sec"],
    ),
    unit(Quantity::Angle, "rad", 1.0, &["rads", "radian", "radians"]),
    unit(Quantity::Angle, "deg", DEGREE, &["degs", "degree", "degrees"]),
    unit(
        Quantity::Acceleration,
        "m/s^2",
        1.0,
        &["m/s2", "m/s/s", "mps2", "m_s2", "m_per_s2", "m/s**2"],
    ),
    unit(Quantity::Acceleration, "g", GRAVITY_M_PER_S2, &["gravity"]),
    unit(Quantity::Torque, "N m", 1.0, &["nm", "n_m", "n.m", "n*m"]),
];

const fn unit(
    quantity: Quantity,
    symbol: &'static str,
    in_si: f64,
    others: &'static [&'static str],
) -> (Unit, &'static [&'static str]) {
    (Unit { quantity, symbol, in_si }, others)
}

impl Unit {
    /// Second.
    pub const SECOND: Self = UNITS[0].0;

    /// The unit that `text` names, whatever it measures.
    pub fn parse(text: &str) -> Option<Self> {
        let text = plain(text);
        let named = |(unit, others): &&(Self, &[&str])| {
            plain(unit.symbol) == text || others.contains(&text.as_str())
        };
        UNITS.iter().find(named).map(|(unit, _)| *unit)
    }
}

/// `text` in small letters, without blanks, and with the signs that have words.
fn plain(text: &str) -> String {
    let text = text.trim().to_lowercase().replace('°', "deg").replace('²', "^2");
    text.chars().filter(|c| !c.is_whitespace() && *c != '\u{b7}').collect()
}

impl fmt::Display for Unit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.symbol)
    }
}

impl Quantity {
    /// Its unit in SI.
    pub fn si(self) -> &'static str {
        self.units().next().unwrap_or_default()
    }

    /// How its units are written, that of SI first.
    pub fn units(self) -> impl Iterator<Item = &'static str> {
        UNITS.iter().filter(move |(unit, _)| unit.quantity == self).map(|(unit, _)| unit.symbol)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_are_read_as_people_write_them() {
        for (text, symbol) in [
            ("km/h", "km/h"),
            ("KPH", "km/h"),
            ("m / s", "m/s"),
            ("°/s", "deg/s"),
            ("°", "deg"),
            ("m/s²", "m/s^2"),
            ("G", "g"),
            ("N·m", "N m"),
            ("Nm", "N m"),
            ("µs", "us"),
            ("ms", "ms"),
        ] {
            assert_eq!(Unit::parse(text).map(|unit| unit.symbol), Some(symbol), "{text}");
        }
        assert_eq!(Unit::parse("furlong"), None);
        assert_eq!(Quantity::Speed.units().collect::<Vec<_>>(), ["m/s", "km/h", "mph", "kn"]);
    }

    #[test]
    fn every_unit_is_found_by_each_of_its_names_alone() {
        for (unit, others) in UNITS {
            for name in [&[unit.symbol], others].concat() {
                assert_eq!(Unit::parse(name), Some(unit), "{name}");
            }
        }
    }
}
