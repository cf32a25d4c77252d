//! Time stamps of date and clock.
//!
//! # Conventions
//! - Read are stamps of ISO 8601 with `T` or a blank between date and clock, with or without a fraction of the
//!   second (after `.` or `,`) and a zone (`Z`, `+01`, `+0100`, `+01:00`), and a clock alone. All stamps of a
//!   file are of one form.
//! - Times count in seconds from the midnight before the first stamp, in its zone: a double then holds the
//!   nanoseconds of three months, which it would not since 1970.
//! - A clock alone is of the day on which it is nearest to the stamp before, and so passes midnight.

use std::fmt;

use chrono::{DateTime, NaiveDateTime, NaiveTime, Timelike as _, Utc};

/// How stamps are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StampForm {
    /// Date, clock and zone: instants.
    Zoned,
    /// Date and clock.
    Dated,
    /// A clock alone.
    Clock,
}

impl fmt::Display for StampForm {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Zoned => "date, clock and zone",
            Self::Dated => "date and clock",
            Self::Clock => "clock",
        })
    }
}

/// Nanoseconds of a second, and of a day.
const SECOND_NS: i64 = 1_000_000_000;
const DAY_NS: i64 = 86_400 * SECOND_NS;
/// Longer than any stamp: date, clock, decimals, zone.
const LONGEST: usize = 48;
const DATED: &str = "%Y-%m-%d %H:%M:%S%.f";
const ZONED: &str = "%Y-%m-%d %H:%M:%S%.f%#z";
const CLOCK: &str = "%H:%M:%S%.f";

/// A stamp.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Stamp {
    pub form: StampForm,
    /// Since 1970, where there is a zone of UTC; of a clock alone since midnight.
    ns: i64,
    /// How far the zone is ahead.
    zone_ns: i64,
}

impl Stamp {
    /// The stamp at `ns` since 1970, or of a clock alone since midnight.
    pub fn of_ns(form: StampForm, ns: i64) -> Self {
        Self { form, ns, zone_ns: 0 }
    }

    /// Reads a stamp.
    pub fn parse(cell: &[u8]) -> Option<Self> {
        let cell = cell.trim_ascii();
        // Most cells are numbers, which have no colon.
        let colon = cell.iter().position(|&byte| byte == b':')?;
        let mut buffer = [0; LONGEST];
        let text = buffer.get_mut(..cell.len())?;
        text.copy_from_slice(cell);
        text.iter_mut().filter(|byte| **byte == b',').for_each(|byte| *byte = b'.');
        if colon < 3 {
            let clock = NaiveTime::parse_from_str(std::str::from_utf8(text).ok()?, CLOCK).ok()?;
            let seconds = i64::from(clock.num_seconds_from_midnight());
            // Those of a leap second go beyond a second.
            let ns = seconds * SECOND_NS + i64::from(clock.nanosecond());
            return Some(Self::of_ns(StampForm::Clock, ns));
        }
        if text.get(10) == Some(&b'T') {
            text[10] = b' ';
        }
        let has_zone = text.get(11..)?.iter().any(|byte| b"Zz+-".contains(byte));
        let text = std::str::from_utf8(text).ok()?;
        let ns = |utc: DateTime<Utc>| {
            let ns = utc.timestamp().checked_mul(SECOND_NS)?;
            ns.checked_add(i64::from(utc.timestamp_subsec_nanos()))
        };
        if has_zone {
            let stamp = DateTime::parse_from_str(text, ZONED).ok()?;
            let zone_ns = i64::from(stamp.offset().local_minus_utc()) * SECOND_NS;
            return Some(Self { form: StampForm::Zoned, ns: ns(stamp.to_utc())?, zone_ns });
        }
        let stamp = NaiveDateTime::parse_from_str(text, DATED).ok()?;
        Some(Self::of_ns(StampForm::Dated, ns(stamp.and_utc())?))
    }
}

/// Stamps of a file, one after the other.
#[derive(Clone, Debug)]
pub(crate) struct Stamps {
    form: StampForm,
    /// The midnight before the first stamp, and the last stamp since then; none before the first.
    seen_ns: Option<(i64, i64)>,
}

impl Stamps {
    /// Of stamps in `form`.
    pub fn new(form: StampForm) -> Self {
        Self { form, seen_ns: None }
    }

    /// The time of the next stamp, s; `None` for one of another form.
    pub fn seconds(&mut self, stamp: Stamp) -> Option<f64> {
        if stamp.form != self.form {
            return None;
        }
        let (midnight_ns, last_ns) = self.seen_ns.unwrap_or_else(|| {
            let local_ns = stamp.ns.saturating_add(stamp.zone_ns).rem_euclid(DAY_NS);
            (stamp.ns.saturating_sub(local_ns), local_ns)
        });
        let mut ns = stamp.ns.saturating_sub(midnight_ns);
        if self.form == StampForm::Clock {
            let days = last_ns.saturating_sub(ns).saturating_add(DAY_NS / 2).div_euclid(DAY_NS);
            ns = ns.saturating_add(days.saturating_mul(DAY_NS));
        }
        self.seen_ns = Some((midnight_ns, ns));
        Some(ns as f64 / SECOND_NS as f64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Times of a file with these stamps.
    fn times(cells: &[&str]) -> Vec<f64> {
        let stamps = cells.iter().map(|cell| Stamp::parse(cell.as_bytes()).expect(cell));
        let mut read: Option<Stamps> = None;
        let second = |stamp: Stamp| {
            read.get_or_insert_with(|| Stamps::new(stamp.form)).seconds(stamp).unwrap()
        };
        stamps.map(second).collect()
    }

    #[test]
    fn stamps_are_read_as_iso_8601_writes_them() {
        for (cell, form, time_s) in [
            ("2026-03-01T12:00:00", StampForm::Dated, 43_200.0),
            ("2026-03-01 12:00:00.010", StampForm::Dated, 43_200.010),
            (" 2026-03-01 12:00:00,010 ", StampForm::Dated, 43_200.010),
            ("2026-03-01T12:00:00.000001Z", StampForm::Zoned, 43_200.000_001),
            ("2026-03-01 12:00:00.123456789 +0100", StampForm::Zoned, 43_200.123_456_789),
            ("2026-03-01T00:30:00-05:30", StampForm::Zoned, 1800.0),
            ("1969-12-31T23:59:59.5+01", StampForm::Zoned, 86_399.5),
            ("12:00:00.010", StampForm::Clock, 43_200.010),
            ("0:00:01", StampForm::Clock, 1.0),
        ] {
            assert_eq!(Stamp::parse(cell.as_bytes()).map(|stamp| stamp.form), Some(form), "{cell}");
            assert_eq!(times(&[cell]), [time_s], "{cell}");
        }
        for cell in [
            "",
            ":",
            "12",
            "12:00",
            "12.00.00",
            "24:00:00",
            "2026-03-01",
            "2026-02-29 12:00:00",
            "01.03.2026 12:00:00",
            "03/01/2026 12:00:00",
            "2026-03-01T12:00:00.0 CET",
            "2026-03-01T12:00:00+1",
            "2026-03-01\u{e9}12:00:00",
            "9999999-03-01 12:00:00",
            "2026-03-01T12:00:00.00000000000000000000000000000000000Z",
        ] {
            assert_eq!(Stamp::parse(cell.as_bytes()), None, "{cell}");
        }
    }

    #[test]
    fn times_are_exact_over_midnights_and_zones() {
        // Every microsecond of a date far from 1970 is told from the next one.
        let second = times(&["2026-03-01 23:59:59.999998", "2026-03-01 23:59:59.999999"]);
        assert_eq!(second, [86_399.999_998, 86_399.999_999]);
        assert_eq!(
            times(&["2026-12-31 23:59:59.99", "2027-01-01 00:00:00.00"]),
            [86_399.99, 86_400.0]
        );
        // A leap second.
        assert_eq!(
            times(&["2016-12-31T23:59:59Z", "2016-12-31T23:59:60.25Z"]),
            [86_399.0, 86_400.25]
        );
        // The end of summer time.
        assert_eq!(
            times(&["2026-10-25T02:59:59.99+02:00", "2026-10-25T02:00:00.00+01:00"]),
            [10_799.99, 10_800.0]
        );
        assert_eq!(
            times(&[
                "23:59:59.99",
                "00:00:00.00",
                "12:00:00",
                "23:59:59.99",
                "00:00:00",
                "23:59:59"
            ]),
            [86_399.99, 86_400.0, 129_600.0, 172_799.99, 172_800.0, 172_799.0]
        );
        let mut dated = Stamps::new(StampForm::Dated);
        assert_eq!(dated.seconds(Stamp::parse(b"12:00:00").unwrap()), None);
    }
}
