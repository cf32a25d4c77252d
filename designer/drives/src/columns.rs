//! What the user tells of a file's columns: by flags, or by a small TOML file.

use serde::Deserialize;

use crate::signal::Signal;
use crate::steering::{SteeringTable, SteeringTableError};
use crate::unit::Unit;

/// A column that a signal is in.
#[derive(Clone, Debug, PartialEq)]
pub struct Column {
    /// Its name, or its number from 1.
    pub name: String,
    /// Its unit; none where its name or the file says so.
    pub unit: Option<Unit>,
    /// Whether its axis points the other way.
    pub turned: bool,
}

/// What is told of the columns of a file, and of the file as text. The rest is guessed.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Columns {
    told: [Option<Column>; Signal::ALL.len()],
    delays_s: [Option<f64>; Signal::ALL.len()],
    /// From the hand wheel, which the steering then is, to the road wheel.
    pub steering_table: Option<SteeringTable>,
    /// What stands between cells.
    pub delimiter: Option<u8>,
    /// What stands before the decimals: `.` or `,`.
    pub decimal_mark: Option<u8>,
}

/// What is told of columns makes no sense.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ColumnError {
    /// Not a column.
    #[error("`{text}` names no column: expected NAME or NAME:[-]UNIT")]
    NoName {
        /// What is written.
        text: String,
    },
    /// A unit of something else.
    #[error("{signal}: `{unit}` is no unit of it; known are {}", known(*signal))]
    Unit {
        /// Of what.
        signal: Signal,
        /// What is written.
        unit: String,
    },
    /// A sign that is none.
    #[error("{signal}: the sign is {sign}; it is 1, or -1 for a turned axis")]
    Sign {
        /// Of what.
        signal: Signal,
        /// What is written.
        sign: f64,
    },
    /// A delay that no log has.
    #[error("{signal}: a delay of {delay_s} s; it is from {} to {} s", -MAX_DELAY_S, MAX_DELAY_S)]
    Delay {
        /// Of what.
        signal: Signal,
        /// What is written.
        delay_s: f64,
    },
    /// Not SIGNAL=S.
    #[error("`{text}` is no delay: expected SIGNAL=S, such as steering=0.03, of {}", flags())]
    NoDelay {
        /// What is written.
        text: String,
    },
    /// A text that is no delimiter.
    #[error("`{text}` is no delimiter: expected one character, or tab")]
    Delimiter {
        /// What is written.
        text: String,
    },
    /// A text that is no decimal mark.
    #[error("`{text}` is no decimal mark: expected `.` or `,`")]
    DecimalMark {
        /// What is written.
        text: String,
    },
    /// A table of the steering that is none.
    #[error("steering.road_wheel_deg: {0}")]
    SteeringTable(#[from] SteeringTableError),
    /// A table of the steering at another signal.
    #[error("{signal}: `road_wheel_deg` belongs to the steering alone")]
    NoSteering {
        /// Of what.
        signal: Signal,
    },
    /// The file of columns is not what it should be.
    #[error("line {line}: {message}")]
    Toml {
        /// The line, from 1.
        line: usize,
        /// What is wrong there.
        message: String,
    },
}

/// Longest delay of a signal either way, s.
pub const MAX_DELAY_S: f64 = 5.0;

fn known(signal: Signal) -> String {
    signal.quantity().units().collect::<Vec<_>>().join(", ")
}

fn flags() -> String {
    Signal::MEASURED.map(Signal::flag).join(", ")
}

impl Columns {
    /// What is told of `signal`.
    pub fn told(&self, signal: Signal) -> Option<&Column> {
        self.told[signal.index()].as_ref()
    }

    /// How late `signal` is in the file, s.
    pub fn delay_s(&self, signal: Signal) -> f64 {
        self.delays_s[signal.index()].unwrap_or(0.0)
    }

    /// Tells where `signal` is: `NAME[:[-]UNIT]`. A minus turns the axis.
    ///
    /// # Errors
    /// [`ColumnError`] for a text without a name, and a unit that is none of the signal's.
    pub fn tell(&mut self, signal: Signal, text: &str) -> Result<(), ColumnError> {
        let (name, unit) = match text.rsplit_once(':') {
            // A name may have colons: what follows the last one counts where it can be a unit.
            Some((name, unit)) if !name.trim().is_empty() && may_be_unit(unit) => (name, unit),
            _ => (text, ""),
        };
        let name = name.trim().to_owned();
        if name.is_empty() {
            return Err(ColumnError::NoName { text: text.to_owned() });
        }
        let unit = unit.trim();
        let turned = unit.starts_with(['-', '\u{2212}']);
        let unit = unit.trim_start_matches(['-', '\u{2212}']);
        let unit = if unit.is_empty() { None } else { Some(unit_of(signal, unit)?) };
        self.told[signal.index()] = Some(Column { name, unit, turned });
        Ok(())
    }

    /// Tells how late a signal is: `SIGNAL=S`, by the signal's flag.
    ///
    /// # Errors
    /// [`ColumnError`] for another text, and a delay that no log has.
    pub fn tell_delay(&mut self, text: &str) -> Result<(), ColumnError> {
        let parse = || {
            let (name, delay_s) = text.split_once('=')?;
            let delay_s = delay_s.trim().trim_end_matches('s').trim();
            let signal =
                Signal::MEASURED.into_iter().find(|signal| signal.flag() == name.trim())?;
            Some((signal, delay_s.parse::<f64>().ok()?))
        };
        let no_delay = || ColumnError::NoDelay { text: text.to_owned() };
        let (signal, delay_s) = parse().ok_or_else(no_delay)?;
        self.set_delay(signal, delay_s)
    }

    /// Tells that `signal` is `delay_s` late in the file.
    ///
    /// # Errors
    /// [`ColumnError::Delay`].
    pub fn set_delay(&mut self, signal: Signal, delay_s: f64) -> Result<(), ColumnError> {
        if !(-MAX_DELAY_S..=MAX_DELAY_S).contains(&delay_s) {
            return Err(ColumnError::Delay { signal, delay_s });
        }
        self.delays_s[signal.index()] = Some(delay_s);
        Ok(())
    }

    /// Tells the delimiter: one character, or `tab`.
    ///
    /// # Errors
    /// [`ColumnError::Delimiter`].
    pub fn tell_delimiter(&mut self, text: &str) -> Result<(), ColumnError> {
        self.delimiter = Some(match text.as_bytes() {
            b"tab" | b"\\t" => b'\t',
            [byte] if byte.is_ascii() && !byte.is_ascii_alphanumeric() && *byte != b'"' => *byte,
            _ => return Err(ColumnError::Delimiter { text: text.to_owned() }),
        });
        Ok(())
    }

    /// Tells the decimal mark: `.` or `,`.
    ///
    /// # Errors
    /// [`ColumnError::DecimalMark`].
    pub fn tell_decimal_mark(&mut self, text: &str) -> Result<(), ColumnError> {
        self.decimal_mark = Some(match text {
            "." => b'.',
            "," => b',',
            _ => return Err(ColumnError::DecimalMark { text: text.to_owned() }),
        });
        Ok(())
    }

    /// Reads a file of columns: a table a signal, with `column`, `unit`, `sign` and `delay_s`, that of the
    /// steering with `road_wheel_deg`, points of a [`SteeringTable`]; beside them `delimiter` and
    /// `decimal_mark`.
    ///
    /// # Errors
    /// [`ColumnError`].
    pub fn from_toml(text: &str) -> Result<Self, ColumnError> {
        let file: File = toml::from_str(text).map_err(|error| {
            let before = error.span().and_then(|span| text.get(..span.start)).unwrap_or_default();
            ColumnError::Toml {
                line: before.matches('\n').count() + 1,
                message: error.message().to_owned(),
            }
        })?;
        let mut columns = Self::default();
        for (signal, table) in [
            (Signal::Time, file.time),
            (Signal::Speed, file.speed),
            (Signal::YawRate, file.yaw_rate),
            (Signal::Steering, file.steering),
            (Signal::LateralAcceleration, file.lateral_acceleration),
            (Signal::DriveTorque, file.drive_torque),
        ] {
            let Some(table) = table else { continue };
            if table.sign != 1.0 && table.sign != -1.0 {
                return Err(ColumnError::Sign { signal, sign: table.sign });
            }
            if let Some(name) = table.column {
                let unit = table.unit.map(|unit| unit_of(signal, &unit)).transpose()?;
                let column = Column { name, unit, turned: table.sign < 0.0 };
                columns.told[signal.index()] = Some(column);
            }
            if let Some(delay_s) = table.delay_s {
                columns.set_delay(signal, delay_s)?;
            }
            if let Some(points) = table.road_wheel_deg {
                if signal != Signal::Steering {
                    return Err(ColumnError::NoSteering { signal });
                }
                columns.steering_table = Some(SteeringTable::of_degrees(&points)?);
            }
        }
        file.delimiter.map_or(Ok(()), |text| columns.tell_delimiter(&text))?;
        file.decimal_mark.map_or(Ok(()), |text| columns.tell_decimal_mark(&text))?;
        Ok(columns)
    }
}

/// Whether a text is a unit with or without sign, or the sign alone.
fn may_be_unit(text: &str) -> bool {
    let text = text.trim();
    let unit = text.trim_start_matches(['-', '\u{2212}']);
    Unit::parse(unit).is_some() || unit.is_empty() || unit.len() < text.len()
}

fn unit_of(signal: Signal, text: &str) -> Result<Unit, ColumnError> {
    Unit::parse(text)
        .filter(|unit| unit.quantity == signal.quantity())
        .ok_or_else(|| ColumnError::Unit { signal, unit: text.to_owned() })
}

/// The file of columns.
#[derive(Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
struct File {
    delimiter: Option<String>,
    decimal_mark: Option<String>,
    time: Option<Table>,
    speed: Option<Table>,
    yaw_rate: Option<Table>,
    steering: Option<Table>,
    lateral_acceleration: Option<Table>,
    drive_torque: Option<Table>,
}

/// A signal in it. Without `column` the column is guessed.
#[derive(Deserialize)]
#[serde(default, deny_unknown_fields)]
struct Table {
    column: Option<String>,
    unit: Option<String>,
    sign: f64,
    delay_s: Option<f64>,
    road_wheel_deg: Option<Vec<[f64; 2]>>,
}

impl Default for Table {
    fn default() -> Self {
        Self { column: None, unit: None, sign: 1.0, delay_s: None, road_wheel_deg: None }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn told(
        signal: Signal,
        text: &str,
    ) -> Result<(String, Option<&'static str>, bool), ColumnError> {
        let mut columns = Columns::default();
        columns.tell(signal, text)?;
        let column = columns.told(signal).unwrap().clone();
        Ok((column.name, column.unit.map(|unit| unit.symbol), column.turned))
    }

    #[test]
    fn a_flag_names_a_column_its_unit_and_its_sign() {
        for (text, name, unit, turned) in [
            ("r_deg:-deg/s", "r_deg", Some("deg/s"), true),
            ("r:rad/s", "r", Some("rad/s"), false),
            ("r", "r", None, false),
            ("r:-", "r", None, true),
            ("bus:r", "bus:r", None, false),
            ("bus:r:deg/s", "bus:r", Some("deg/s"), false),
            ("r [deg/s]", "r [deg/s]", None, false),
            ("3:deg/s", "3", Some("deg/s"), false),
        ] {
            assert_eq!(told(Signal::YawRate, text).unwrap(), (name.into(), unit, turned), "{text}");
        }
        for text in ["", " ", "r:km/h", "r:-furlong"] {
            assert!(told(Signal::YawRate, text).is_err(), "{text}");
        }
    }

    #[test]
    fn a_file_tells_the_same_as_flags() {
        let file = Columns::from_toml(
            "delimiter = \";\"\ndecimal_mark = \",\"\n[speed]\ncolumn = \"v\"\nunit = \"km/h\"\n\
             [yaw_rate]\ncolumn = \"r\"\nunit = \"deg/s\"\nsign = -1\n[steering]\ndelay_s = 0.03\n",
        )
        .unwrap();
        let mut flags = Columns::default();
        flags.tell(Signal::Speed, "v:km/h").unwrap();
        flags.tell(Signal::YawRate, "r:-deg/s").unwrap();
        flags.tell_delay("steering=0.03s").unwrap();
        flags.tell_delimiter(";").unwrap();
        flags.tell_decimal_mark(",").unwrap();
        assert_eq!(file, flags);
    }

    #[test]
    fn a_file_that_makes_no_sense_is_refused() {
        for (text, part) in [
            ("[speed]\nunit = 3", "invalid type"),
            ("\n[sped]", "line 2: unknown field `sped`"),
            ("[speed]\ncolumn = \"v\"\nunit = \"rad\"", "known are m/s, km/h, mph, kn"),
            ("[speed]\nsign = 2", "the sign is 2"),
            ("[speed]\ndelay_s = 9", "a delay of 9 s"),
            ("delimiter = \"ab\"", "`ab` is no delimiter"),
            ("[speed]\nroad_wheel_deg = [[0, 0], [90, 5]]", "belongs to the steering alone"),
            ("[steering]\nroad_wheel_deg = [[0, 0]]", "steering.road_wheel_deg: 1 points"),
        ] {
            let error = Columns::from_toml(text).unwrap_err().to_string();
            assert!(error.contains(part), "{text}: {error}");
        }
    }
}
