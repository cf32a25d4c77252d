//! What looks wrong with the signals of a drive, found while its rows go by.
//!
//! # Conventions
//! - What no car can do stops the reading with its line. What a car may do, but logs do more often, is a
//!   [`Finding`] at the end.

use std::fmt;

use crate::choose::Choice;
use crate::error::Cause;
use crate::signal::Signal;

/// Something that looks wrong, but need not be.
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
    /// Line where it begins; of a Parquet file the row.
    pub line: u64,
    /// What it is.
    pub what: String,
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "line {}: {}", self.line, self.what)
    }
}

/// Sideways acceleration v_x r that tyres do not hold, m/s^2.
const SIDEWAYS_M_PER_S2: f64 = 25.0;
/// For so long all in all it is no disturbed row, s.
const SIDEWAYS_S: f64 = 1.0;
/// A signal at its extreme for longer at a time, s, and for longer all in all, s, and not only once as a wheel
/// that is held, is cut off there.
const SATURATED_S: [f64; 2] = [1.0, 2.0];

/// What is seen of a signal.
#[derive(Clone, Debug)]
pub(crate) struct Watch {
    choice: Choice,
    numbers: u64,
    missing: u64,
    first_missing: u64,
    first_line: u64,
    last: f64,
    extremes: [Extreme; 2],
}

/// The largest or smallest value of a signal.
#[derive(Clone, Copy, Debug)]
struct Extreme {
    value: f64,
    line: u64,
    /// Since when the signal has been there without a break, s.
    since_s: Option<f64>,
    /// How often it came there.
    visits: u64,
    longest_s: f64,
    all_s: f64,
    last_s: f64,
}

impl Extreme {
    /// Follows the signal whose extreme is above, or below for a `side` of -1.
    fn follow(&mut self, side: f64, time_s: f64, line: u64, value: f64) {
        if self.value.is_nan() || side * value > side * self.value {
            *self = Self {
                value,
                line,
                since_s: Some(time_s),
                visits: 1,
                longest_s: 0.0,
                all_s: 0.0,
                last_s: time_s,
            };
        } else if value == self.value {
            match self.since_s {
                Some(since_s) => {
                    self.all_s += time_s - self.last_s;
                    self.longest_s = self.longest_s.max(time_s - since_s);
                }
                None => {
                    self.since_s = Some(time_s);
                    self.visits += 1;
                }
            }
            self.last_s = time_s;
        } else {
            self.since_s = None;
        }
    }
}

impl Watch {
    pub fn new(choice: &Choice) -> Self {
        let none = Extreme {
            value: f64::NAN,
            line: 0,
            since_s: None,
            visits: 0,
            longest_s: 0.0,
            all_s: 0.0,
            last_s: 0.0,
        };
        Self {
            choice: choice.clone(),
            numbers: 0,
            missing: 0,
            first_missing: 0,
            first_line: 0,
            last: f64::NAN,
            extremes: [none; 2],
        }
    }

    /// Follows the signal; NaN where there is no number.
    pub fn follow(&mut self, time_s: f64, line: u64, value: f64) -> Result<(), Cause> {
        if value.is_nan() {
            self.first_missing = if self.missing == 0 { line } else { self.first_missing };
            self.missing += 1;
            return Ok(());
        }
        if value.abs() > largest(self.choice.signal) {
            let Choice { signal, .. } = self.choice;
            return Err(Cause::Impossible { signal, value, hint: self.hint(value) });
        }
        self.first_line = if self.numbers == 0 { line } else { self.first_line };
        self.numbers += 1;
        self.last = value;
        for (extreme, side) in self.extremes.iter_mut().zip([1.0, -1.0]) {
            extreme.follow(side, time_s, line, value);
        }
        Ok(())
    }

    /// What a value that cannot be may be.
    fn hint(&self, value: f64) -> String {
        let Choice { signal, unit, .. } = &self.choice;
        let written = value / unit.in_si;
        let likely = match (signal, unit.symbol) {
            (Signal::Speed, "m/s") => "km/h",
            (Signal::YawRate, "rad/s") => "deg/s",
            (Signal::Steering, "rad") => "deg",
            (Signal::LateralAcceleration, "g") => "m/s^2",
            _ => return format!(": {} {unit} are written", written.abs()),
        };
        format!(": it looks like {likely} read as {unit}")
    }

    /// Whether there was no number at all.
    pub fn is_empty(&self) -> bool {
        self.numbers == 0
    }

    /// The column.
    pub fn choice(&self) -> &Choice {
        &self.choice
    }

    /// What looks wrong, once the drive is over.
    pub fn findings(&self) -> Vec<Finding> {
        let Choice { signal, name, .. } = &self.choice;
        let mut findings = Vec::new();
        let mut find = |line, what| findings.push(Finding { line, what });
        // Of files with a row a message, most cells of a signal are empty.
        if self.missing > 0 && self.missing < self.numbers {
            find(
                self.first_missing,
                format!(
                    "{signal}: {} cells of `{name}` without a number, the first here",
                    self.missing
                ),
            );
        }
        let [highest, lowest] = self.extremes;
        if self.numbers > 1 && highest.value == lowest.value {
            let (value, si) = (highest.value, signal.quantity().si());
            find(self.first_line, format!("{signal}: `{name}` never changes from {value} {si}"));
            return findings;
        }
        let [longest_s, all_s] = SATURATED_S;
        for extreme in [highest, lowest] {
            let cut =
                extreme.visits > 1 && extreme.longest_s >= longest_s && extreme.all_s >= all_s;
            // Standing still is no saturation, and neither is rolling without torque.
            if cut && extreme.value != 0.0 {
                find(
                    extreme.line,
                    format!(
                        "{signal}: `{name}` stays at its extreme {:.4} {} for {:.1} s: saturated?",
                        extreme.value,
                        signal.quantity().si(),
                        extreme.longest_s
                    ),
                );
            }
        }
        findings
    }
}

/// No car shows more, in SI.
fn largest(signal: Signal) -> f64 {
    match signal {
        Signal::Time => f64::INFINITY,
        Signal::Speed => 100.0,
        Signal::YawRate => 10.0,
        // Three turns of a hand wheel.
        Signal::Steering => 20.0,
        Signal::LateralAcceleration => 60.0,
        // The detector takes no more.
        Signal::DriveTorque => 1e6,
    }
}

/// Whether speed and yaw rate belong together.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Sideways {
    last_s: Option<f64>,
    all_s: f64,
}

impl Sideways {
    /// Follows both.
    pub fn follow(&mut self, time_s: f64, speed: &Watch, yaw_rate: &Watch) -> Result<(), Cause> {
        let acceleration_m_per_s2 = (speed.last * yaw_rate.last).abs();
        let step_s = self.last_s.replace(time_s).map_or(0.0, |last_s| time_s - last_s);
        if acceleration_m_per_s2 > SIDEWAYS_M_PER_S2 {
            self.all_s += step_s.min(0.1);
        }
        if self.all_s < SIDEWAYS_S {
            return Ok(());
        }
        let units = (speed.choice.unit.symbol, yaw_rate.choice.unit.symbol);
        let hint = match units {
            (_, "rad/s") => ": it looks like deg/s read as rad/s",
            ("m/s", _) => ": it looks like km/h read as m/s",
            _ => "",
        };
        Err(Cause::Sideways { acceleration_m_per_s2, hint: hint.into() })
    }
}
