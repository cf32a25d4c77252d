//! Which column a signal is taken from: as told, or else guessed where only one column can be it and its
//! unit is known.

use std::fmt;

use crate::columns::Columns;
use crate::error::Cause;
use crate::names::{Named, in_fmu, is_usual, taken_apart};
use crate::signal::{Signal, Wanted};
use crate::stamp::StampForm;
use crate::steering::SteeringTable;
use crate::table::Header;
use crate::unit::Unit;

/// The column that a signal is taken from.
#[derive(Clone, Debug, PartialEq)]
pub struct Choice {
    /// The signal.
    pub signal: Signal,
    /// Index of the column, from 0.
    pub column: usize,
    /// Its name.
    pub name: String,
    /// Its unit; s of time stamps.
    pub unit: Unit,
    /// Of the time: how stamps are written, where the column holds some instead of numbers.
    pub stamps: Option<StampForm>,
    /// Whether its axis is turned.
    pub turned: bool,
    /// How late it is, s.
    pub delay_s: f64,
    /// Of the steering: from the hand wheel, which the column then has, to the road wheel.
    pub table: Option<SteeringTable>,
    /// Whether the column was guessed by its name.
    pub guessed: bool,
    /// Whether the unit is what files usually have, and nothing says so.
    pub unit_assumed: bool,
}

impl Choice {
    /// A cell of the column in SI.
    pub(crate) fn in_si(&self, cell: f64) -> f64 {
        let si = cell * self.unit.in_si;
        let si = if self.turned { -si } else { si };
        self.table.as_ref().map_or(si, |table| table.road_wheel_rad(si))
    }
}

impl fmt::Display for Choice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let sign = if self.turned { "-" } else { "" };
        let Self { signal, name, unit, .. } = self;
        write!(f, "{signal}: column \"{name}\", {sign}")?;
        match self.stamps {
            Some(form) => write!(f, "stamps of {form} -> s since the midnight before the first")?,
            None => write!(f, "{unit} -> {}", signal.quantity().si())?,
        }
        if self.delay_s != 0.0 {
            write!(f, ", {} s late", self.delay_s)?;
        }
        if let Some(table) = &self.table {
            write!(f, ", to the road wheel by {} points", table.points())?;
        }
        match (self.guessed, self.unit_assumed) {
            (true, _) => write!(f, " (guessed)"),
            (false, true) => write!(f, " (unit guessed)"),
            (false, false) => Ok(()),
        }
    }
}

/// The columns that a drive is read from.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Chosen {
    choices: [Option<Choice>; Signal::ALL.len()],
    /// What was not taken, and why.
    pub left: Vec<String>,
}

impl Chosen {
    /// Where `signal` is.
    pub fn of(&self, signal: Signal) -> Option<&Choice> {
        self.choices[signal.index()].as_ref()
    }

    /// All, in the order of [`Signal::ALL`].
    pub fn choices(&self) -> impl Iterator<Item = &Choice> {
        self.choices.iter().flatten()
    }

    /// Chooses among columns with `headers`.
    pub(crate) fn choose(
        headers: &[Header],
        columns: &Columns,
        wanted: Wanted,
    ) -> Result<Self, Cause> {
        let mut chosen = Self::default();
        let mut taken: Vec<(usize, Signal)> = Vec::new();
        for signal in Signal::ALL {
            let Some(told) = columns.told(signal) else { continue };
            let column = find(headers, signal, &told.name)?;
            if let Some(&(_, other)) = taken.iter().find(|(other, _)| *other == column) {
                return Err(Cause::Twice { signal, other, name: told.name.clone() });
            }
            taken.push((column, signal));
            let stamps = headers[column].stamps;
            let (unit, unit_assumed) = match (told.unit, stamps) {
                (None, Some(_)) if signal == Signal::Time => (Unit::SECOND, false),
                (unit, Some(form)) => {
                    let name = headers[column].name.clone();
                    return Err(Cause::Stamps { signal, name, form, unit });
                }
                (Some(unit), None) => (unit, false),
                (None, None) => unit_of(headers, column, signal)?,
            };
            let (turned, delay_s) = (told.turned, columns.delay_s(signal));
            let name = headers[column].name.clone();
            chosen.choices[signal.index()] = Some(Choice {
                signal,
                column,
                name,
                unit,
                stamps,
                turned,
                delay_s,
                table: None,
                guessed: false,
                unit_assumed,
            });
        }
        for signal in Signal::ALL {
            if chosen.of(signal).is_some() || !wanted.takes(signal) {
                continue;
            }
            match guess(headers, signal, &taken, columns.delay_s(signal)) {
                Ok(choice) => {
                    taken.push((choice.column, signal));
                    chosen.choices[signal.index()] = Some(choice);
                }
                Err(cause) if signal.is_needed() => return Err(cause),
                Err(Cause::NotFound { .. }) => {}
                Err(cause) => {
                    let help = cause.help().map_or(String::new(), |help| format!(" ({help})"));
                    chosen.left.push(format!("{cause}; not taken{help}"));
                }
            }
        }
        if let Some(steering) = &mut chosen.choices[Signal::Steering.index()] {
            steering.table.clone_from(&columns.steering_table);
        }
        Ok(chosen)
    }
}

/// The column called `name`: as it stands, in other letters, without its unit, or by its number.
fn find(headers: &[Header], signal: Signal, name: &str) -> Result<usize, Cause> {
    let by = |matches: &dyn Fn(&str) -> bool| {
        let mut found = headers.iter().enumerate().filter(|(_, header)| matches(&header.name));
        match (found.next(), found.next()) {
            (Some((column, _)), None) => Some(column),
            _ => None,
        }
    };
    let base = |text: &str| taken_apart(text, signal).base;
    let number = name.parse::<usize>().ok().and_then(|number| number.checked_sub(1));
    by(&|other| other == name)
        .or_else(|| by(&|other| other.trim().eq_ignore_ascii_case(name)))
        .or_else(|| by(&|other| base(other) == base(name)))
        .or(number.filter(|&column| column < headers.len()))
        .ok_or_else(|| Cause::NoColumn { signal, name: name.to_owned(), columns: names(headers) })
}

fn names(headers: &[Header]) -> Vec<String> {
    headers.iter().map(|header| header.name.clone()).collect()
}

/// The unit of a column, and whether it is only what files usually have.
fn unit_of(headers: &[Header], column: usize, signal: Signal) -> Result<(Unit, bool), Cause> {
    let header = &headers[column];
    let Named { unit: of_name, .. } = taken_apart(&header.name, signal);
    if let Some(unit) = header.unit.or(of_name) {
        if unit.quantity != signal.quantity() {
            return Err(Cause::OtherUnit { signal, name: header.name.clone(), unit });
        }
        return Ok((unit, false));
    }
    let has = |name: &str| headers.iter().any(|header| header.name == name);
    // Results of this project: all three, as each name alone may be anything.
    let of_fmu = has("v_x") && has("r") && has("u.delta");
    if of_fmu && in_fmu(signal) == Some(header.name.as_str()) {
        let si = Unit::parse(signal.quantity().si());
        return si
            .map(|unit| (unit, false))
            .ok_or_else(|| Cause::NoUnit { signal, name: header.name.clone() });
    }
    if signal == Signal::Time {
        return Ok((Unit::SECOND, true));
    }
    Err(Cause::NoUnit { signal, name: header.name.clone() })
}

/// The column that `signal` surely is in.
fn guess(
    headers: &[Header],
    signal: Signal,
    taken: &[(usize, Signal)],
    delay_s: f64,
) -> Result<Choice, Cause> {
    let fits = |&(column, header): &(usize, &Header)| {
        let Named { base, unit } = taken_apart(&header.name, signal);
        let unit = header.unit.or(unit);
        is_usual(&base, signal)
            && (header.stamps.is_none() || signal == Signal::Time)
            && unit.is_none_or(|unit| unit.quantity == signal.quantity())
            && taken.iter().all(|(other, _)| *other != column)
    };
    let mut found: Vec<_> = headers.iter().enumerate().filter(fits).collect();
    if found.is_empty() && signal == Signal::Time {
        // Stamps are times whatever they are called.
        found = headers.iter().enumerate().filter(|(_, header)| header.stamps.is_some()).collect();
    }
    let &[(column, header)] = found.as_slice() else {
        return Err(if found.is_empty() {
            Cause::NotFound { signal, columns: names(headers) }
        } else {
            let columns = found.iter().map(|(_, header)| header.name.clone()).collect();
            Cause::Ambiguous { signal, columns }
        });
    };
    let (unit, unit_assumed) = match header.stamps {
        Some(_) => (Unit::SECOND, false),
        None => unit_of(headers, column, signal)?,
    };
    let (name, stamps) = (header.name.clone(), header.stamps);
    let (turned, guessed, table) = (false, true, None);
    Ok(Choice { signal, column, name, unit, stamps, turned, delay_s, table, guessed, unit_assumed })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn headers(names: &[&str]) -> Vec<Header> {
        names.iter().map(|name| Header { name: (*name).into(), unit: None, stamps: None }).collect()
    }

    fn lines(names: &[&str], told: &[(Signal, &str)]) -> Result<Vec<String>, Cause> {
        let mut columns = Columns::default();
        for (signal, text) in told {
            columns.tell(*signal, text).unwrap();
        }
        let chosen = Chosen::choose(&headers(names), &columns, Wanted::ALL)?;
        Ok(chosen.choices().map(ToString::to_string).chain(chosen.left.clone()).collect())
    }

    #[test]
    fn what_is_unambiguous_is_guessed() {
        let names = ["t", "v [km/h]", "yaw_rate_deg_s", "steering_wheel_deg", "a_y", "gear"];
        assert_eq!(
            lines(&names, &[]).unwrap(),
            [
                "time: column \"t\", s -> s (guessed)",
                "speed: column \"v [km/h]\", km/h -> m/s (guessed)",
                "yaw rate: column \"yaw_rate_deg_s\", deg/s -> rad/s (guessed)",
                "steering: column \"steering_wheel_deg\", deg -> rad (guessed)",
                "lateral acceleration: nothing says the unit of column `a_y`; not taken \
                 (--lateral-acceleration 'a_y:UNIT', with one of m/s^2, g)",
            ]
        );
        let ours = ["time", "v_x", "r", "u.T_eng", "u.delta", "J_rms"];
        assert_eq!(lines(&ours, &[]).unwrap().len(), 5);
    }

    #[test]
    fn what_is_told_comes_first() {
        let names = ["t", "v", "r_deg", "hw", "speed_kmh"];
        let told = [
            (Signal::Speed, "V:km/h"),
            (Signal::YawRate, "r_deg:-deg/s"),
            (Signal::Steering, "4:deg"),
        ];
        let lines = lines(&names, &told).unwrap();
        assert_eq!(lines[1], "speed: column \"v\", km/h -> m/s");
        assert_eq!(lines[2], "yaw rate: column \"r_deg\", -deg/s -> rad/s");
        assert_eq!(lines[3], "steering: column \"hw\", deg -> rad");
    }

    #[test]
    fn what_is_not_sure_is_an_error_with_its_flag() {
        let all = ["t", "v_kmh", "r_deg_s", "hw_deg"];
        for (names, told, part, flag) in [
            (&["t", "v", "r_deg_s", "hw_deg"][..], vec![], "the unit of column `v`", "--speed"),
            (&["t", "v_kmh", "x", "hw_deg"], vec![], "yaw rate: no column", "--yaw 'NAME:UNIT'"),
            (&["t", "v_kmh", "vx_mps", "r_deg_s", "hw_deg"], vec![], "any of", "--speed"),
            (&all, vec![(Signal::Speed, "v_kmh2")], "no column `v_kmh2`", "--speed 'v_kmh'?"),
            (&all, vec![(Signal::Speed, "hw_deg")], "the unit of column `hw_deg`", "--speed"),
            (
                &all,
                vec![(Signal::Speed, "2:m/s"), (Signal::YawRate, "2:rad/s")],
                "told to be the same",
                "--yaw",
            ),
        ] {
            let cause = lines(names, &told).unwrap_err();
            assert!(cause.to_string().contains(part), "{cause}");
            assert!(cause.help().unwrap().contains(flag), "{cause}: {:?}", cause.help());
        }
    }
}
