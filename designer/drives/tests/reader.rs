//! Files as loggers write them: what is read of them, and what is said.

#![allow(clippy::unwrap_used)]

use std::fs;
use std::path::PathBuf;
use std::sync::Arc;

use parquet::basic::{Compression, LogicalType, Repetition, TimeUnit, Type as Physical, ZstdLevel};
use parquet::data_type::{DoubleType, FloatType, Int32Type, Int64Type};
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::Type;
use steerguard_drives::{Cause, Columns, DriveError, Finding, Reader, Row, Signal, Wanted};
use tempfile::TempDir;

/// A file with `bytes` in a folder of its own.
fn file(bytes: &[u8]) -> (TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("drive");
    fs::write(&path, bytes).unwrap();
    (folder, path)
}

/// Rows and findings.
fn read(bytes: &[u8], columns: &Columns) -> Result<(Vec<Row>, Vec<Finding>), DriveError> {
    let (_folder, path) = file(bytes);
    let mut reader = Reader::open(&path, columns, Wanted::ALL)?;
    let rows = reader.by_ref().collect::<Result<_, _>>()?;
    Ok((rows, reader.findings()))
}

/// A drive of `rows` rows at 100 Hz with a header.
fn drive(rows: u32, row: impl Fn(u32) -> String) -> String {
    let rows = (0..rows).map(|k| row(k) + "\n");
    "t,v [m/s],r [rad/s],hw [rad]\n".chars().map(String::from).chain(rows).collect()
}

fn usual(k: u32) -> String {
    let t = f64::from(k) * 0.01;
    format!("{t:.2},{:.3},{:.4},{:.4}", 10.0 + t.sin(), 0.1 * t.cos(), 0.3 * t.cos())
}

#[test]
fn cells_come_in_si_and_turned() {
    let mut columns = Columns::default();
    columns.tell(Signal::YawRate, "r:-deg/s").unwrap();
    columns.tell_delay("steering=0.03").unwrap();
    let text =
        "\u{feff}Logger;7\n\nt;v;r;SWA;a_y\nms;km/h;;deg;g\n10;36;90;-180;1\n20,5;72,0;;0;\n";
    let (_folder, path) = file(text.as_bytes());
    let mut reader = Reader::open(&path, &columns, Wanted::ALL).unwrap();
    assert_eq!(reader.reading(), "CSV, delimiter `;`, decimal mark `,`");
    let lines: Vec<_> = reader.chosen().choices().map(ToString::to_string).collect();
    assert_eq!(
        lines,
        [
            "time: column \"t\", ms -> s (guessed)",
            "speed: column \"v\", km/h -> m/s (guessed)",
            "yaw rate: column \"r\", -deg/s -> rad/s",
            "steering: column \"SWA\", deg -> rad, 0.03 s late (guessed)",
            "lateral acceleration: column \"a_y\", g -> m/s^2 (guessed)",
        ]
    );
    let layout = reader.layout();
    assert_eq!(layout.present, [true, true, true, true, false]);
    assert_eq!(layout.delays_s[2], 0.03);
    let rows: Vec<_> = reader.by_ref().map(Result::unwrap).collect();
    let pi = std::f64::consts::PI;
    let Row { line, time_s, values } = rows[0];
    assert_eq!((line, time_s), (5, 0.01));
    for (value, expected) in values.iter().zip([10.0, -pi / 2.0, -pi, 9.80665]) {
        assert!((value - expected).abs() < 1e-12, "{values:?}");
    }
    assert_eq!((rows[1].line, rows[1].values[0]), (6, 20.0));
    assert!(rows[1].values[1].is_nan() && rows[1].values[3].is_nan());
}

#[test]
fn parquet_is_read_by_its_content_whatever_its_compression() {
    let schema = {
        let field = |name, physical, repetition| {
            let field = Type::primitive_type_builder(name, physical).with_repetition(repetition);
            Arc::new(field.build().unwrap())
        };
        let fields = vec![
            field("time_s", Physical::DOUBLE, Repetition::REQUIRED),
            field("hw [deg]", Physical::FLOAT, Repetition::REQUIRED),
            field("speed_kmh", Physical::DOUBLE, Repetition::OPTIONAL),
            field("yaw_rate_rad_s", Physical::DOUBLE, Repetition::REQUIRED),
        ];
        Arc::new(Type::group_type_builder("drive").with_fields(fields).build().unwrap())
    };
    for compression in
        [Compression::UNCOMPRESSED, Compression::SNAPPY, Compression::ZSTD(ZstdLevel::default())]
    {
        let properties = WriterProperties::builder().set_compression(compression).build();
        let mut writer =
            SerializedFileWriter::new(Vec::new(), schema.clone(), Arc::new(properties)).unwrap();
        for group in 0..3 {
            let times: Vec<f64> = (0..5000).map(|k| f64::from(5000 * group + k) * 0.01).collect();
            let speeds: Vec<f64> = times[1..].iter().map(|t| 36.0 + t).collect();
            let yaw_rates: Vec<f64> = times.iter().map(|t| 0.001 * t).collect();
            let present: Vec<i16> = (0..5000).map(|k| i16::from(k > 0)).collect();
            let mut rows = writer.next_row_group().unwrap();
            let mut column = rows.next_column().unwrap().unwrap();
            column.typed::<DoubleType>().write_batch(&times, None, None).unwrap();
            column.close().unwrap();
            let mut column = rows.next_column().unwrap().unwrap();
            column.typed::<FloatType>().write_batch(&[90.0; 5000], None, None).unwrap();
            column.close().unwrap();
            let mut column = rows.next_column().unwrap().unwrap();
            column.typed::<DoubleType>().write_batch(&speeds, Some(&present), None).unwrap();
            column.close().unwrap();
            let mut column = rows.next_column().unwrap().unwrap();
            column.typed::<DoubleType>().write_batch(&yaw_rates, None, None).unwrap();
            column.close().unwrap();
            rows.close().unwrap();
        }
        let (rows, findings) = read(&writer.into_inner().unwrap(), &Columns::default()).unwrap();
        assert_eq!(rows.len(), 15_000);
        assert!(rows[5000].values[0].is_nan());
        assert!((rows[9999].values[0] - (36.0 + 99.99) / 3.6).abs() < 1e-12);
        assert_eq!((rows[9999].line, rows[9999].time_s), (10_000, 9999.0 * 0.01));
        assert!((rows[9999].values[2] - std::f64::consts::FRAC_PI_2).abs() < 1e-6);
        let findings: Vec<_> = findings.iter().map(ToString::to_string).collect();
        assert_eq!(findings.len(), 2, "{findings:?}");
        assert!(findings[0].contains("3 cells of `speed_kmh` without a number"), "{findings:?}");
        assert!(findings[1].contains("`hw [deg]` never changes"), "{findings:?}");
    }
}

/// A drive whose time column holds `stamps`.
fn stamped(name: &str, stamps: &[String]) -> String {
    let rows = stamps.iter().zip(0..).map(|(stamp, k)| format!("{stamp};{}\n", values(k)));
    format!("{name};v [m/s];r [rad/s];hw [rad]\n{}", rows.collect::<String>())
}

/// Cells of a row, with a decimal comma.
fn values(k: u32) -> String {
    format!("10,5;0,{k:05};0,3")
}

/// The clock `hundredths` after a midnight.
fn clock(hundredths: u32) -> String {
    let (seconds, rest) = (hundredths / 100, hundredths % 100);
    format!("{:02}:{:02}:{:02}.{rest:02}", seconds / 3600 % 24, seconds / 60 % 60, seconds % 60)
}

/// Hundredths of a second in a day, and the first row of drives that pass midnight.
const DAY: u32 = 8_640_000;
const BEGIN: u32 = DAY - 150;

/// Name of a column, what is said of its stamps, and the stamp hundredths after a midnight.
type Stamped<'a> = (&'a str, &'a str, &'a dyn Fn(u32) -> String);

#[test]
fn stamps_of_date_and_clock_are_times_since_the_midnight_before_the_first() {
    let date = |k| if k < DAY { "2026-02-28" } else { "2026-03-01" };
    let written: [Stamped<'_>; 4] = [
        ("t", "clock", &clock),
        ("Date/Time", "date and clock", &|k| format!("{} {}", date(k), clock(k))),
        ("recorded", "date, clock and zone", &|k| format!("{}T{}0000+01:00", date(k), clock(k))),
        ("", "date and clock", &|k| format!("{}T{}", date(k), clock(k).replace('.', ","))),
    ];
    for (name, form, stamp) in written {
        let stamps: Vec<_> = (BEGIN..BEGIN + 300).map(stamp).collect();
        let (_folder, path) = file(stamped(name, &stamps).as_bytes());
        let mut reader = Reader::open(&path, &Columns::default(), Wanted::ALL).unwrap();
        assert_eq!(
            reader.chosen().of(Signal::Time).unwrap().to_string(),
            format!(
                "time: column \"{}\", stamps of {form} -> s since the midnight before the first (guessed)",
                if name.is_empty() { "1" } else { name }
            )
        );
        let rows: Vec<_> = reader.by_ref().map(Result::unwrap).collect();
        let times: Vec<_> = rows.iter().map(|row| row.time_s).collect();
        let expected: Vec<_> = (BEGIN..BEGIN + 300).map(|k| f64::from(k) / 100.0).collect();
        assert_eq!(times, expected);
        assert_eq!((rows[7].line, rows[7].values[0]), (9, 10.5));
        assert_eq!(reader.findings().len(), 2, "speed and steering never change");
    }
}

#[test]
fn a_row_a_message_may_be_stamped() {
    let rows = (0..300).map(|k| {
        let cells = [",10,,", ",,0.1,", ",,,0.3"][k as usize % 3];
        format!("2026-03-01 {}{cells}\n", clock(k))
    });
    let text = format!("t,v [m/s],r [rad/s],hw [rad]\n{}", rows.collect::<String>());
    let (rows, _) = read(text.as_bytes(), &Columns::default()).unwrap();
    assert_eq!((rows.len(), rows[299].time_s, rows[299].values[2]), (300, 2.99, 0.3));
}

#[test]
fn stamps_that_cannot_be_are_said_with_their_line() {
    let with = |line: usize, stamp: &str| {
        let mut stamps: Vec<_> = (0..300).map(|k| format!("2026-03-01T{}Z", clock(k))).collect();
        stamps[line - 2] = stamp.into();
        stamped("t", &stamps)
    };
    let told = |signal, text: &str| {
        let mut columns = Columns::default();
        columns.tell(signal, text).unwrap();
        columns
    };
    let daily: Vec<_> = (1..29).map(|k| format!("2026-02-{k:02} 12:00:00")).collect();
    for (text, columns, line, part, help) in [
        (
            with(300, "2026-03-01T00:00:02.98"),
            Columns::default(),
            Some(300),
            "time: `2026-03-01T00:00:02.98` in column `t` is no stamp of date, clock and zone",
            "2026-03-01T12:00:00.010+01:00",
        ),
        (with(2, "1.5"), Columns::default(), Some(3), "is no number", "2026-03-01T12:00:00.010"),
        (with(299, "2026-02-30T00:00:02Z"), Columns::default(), Some(299), "is no stamp", ""),
        (with(300, ""), Columns::default(), Some(300), "the time stamp is missing", ""),
        (
            with(300, "2026-03-01T00:00:02.98+00:30"),
            Columns::default(),
            Some(300),
            "time runs back, from 2.97 s to -1797.02 s",
            "",
        ),
        (
            with(300, "2026-03-01T00:00:02.98Z"),
            told(Signal::Time, "t:ms"),
            None,
            "time: column `t` holds stamps of date, clock and zone, not numbers in ms",
            "--time 't' without a unit",
        ),
        (
            with(300, "2026-03-01T00:00:02.98Z"),
            told(Signal::Speed, "t"),
            None,
            "speed: column `t` holds stamps of date, clock and zone, which are the time",
            "--speed names another column",
        ),
        (
            stamped("t", &daily),
            Columns::default(),
            Some(2),
            "86400 s a row, read in s: it is no",
            "",
        ),
    ] {
        let error = read(text.as_bytes(), &columns).unwrap_err();
        assert!(error.to_string().contains(part), "`{part}` is missing in: {error}");
        assert_eq!(error.line, line, "{error}");
        let said = error.cause.help().unwrap_or_default();
        assert!(said.contains(help), "`{help}` is missing in: {said}");
    }
}

#[test]
fn stamps_of_parquet_are_exact_to_the_microsecond() {
    // 2026-03-01 in days since 1970.
    const DATE: i64 = 20_513;
    let dated = |utc, unit| LogicalType::timestamp(utc, unit);
    for (logical, physical, form, unit_per_s) in [
        (dated(true, TimeUnit::NANOS), Physical::INT64, "date, clock and zone", 1_000_000_000),
        (dated(false, TimeUnit::MICROS), Physical::INT64, "date and clock", 1_000_000),
        (LogicalType::time(false, TimeUnit::MICROS), Physical::INT64, "clock", 1_000_000),
        (LogicalType::time(false, TimeUnit::MILLIS), Physical::INT32, "clock", 1000),
    ] {
        let number = |name| {
            let field = Type::primitive_type_builder(name, Physical::DOUBLE);
            Arc::new(field.with_repetition(Repetition::REQUIRED).build().unwrap())
        };
        let time = Type::primitive_type_builder("index", physical)
            .with_repetition(Repetition::REQUIRED)
            .with_logical_type(Some(logical));
        let fields = vec![
            Arc::new(time.build().unwrap()),
            number("v_m_per_s"),
            number("yaw_rate_rad_s"),
            number("hw_deg"),
        ];
        let schema = Type::group_type_builder("drive").with_fields(fields).build().unwrap();
        let mut writer =
            SerializedFileWriter::new(Vec::new(), Arc::new(schema), Arc::default()).unwrap();
        let mut group = writer.next_row_group().unwrap();
        let count = |k: u32| {
            // Odd microseconds, or of coarser units what is nearest.
            let us = i64::from(k) * 10_000 + i64::from(k % 7);
            let (day_us, of_clock) = (86_400_000_000, form == "clock");
            let us = if of_clock { us % day_us } else { us + DATE * day_us };
            if unit_per_s < 1_000_000 { us / 1000 } else { us * (unit_per_s / 1_000_000) }
        };
        let counts: Vec<_> = (BEGIN..BEGIN + 300).map(count).collect();
        let mut column = group.next_column().unwrap().unwrap();
        if physical == Physical::INT64 {
            column.typed::<Int64Type>().write_batch(&counts, None, None).unwrap();
        } else {
            let counts: Vec<_> = counts.iter().map(|&count| count as i32).collect();
            column.typed::<Int32Type>().write_batch(&counts, None, None).unwrap();
        }
        column.close().unwrap();
        while let Some(mut column) = group.next_column().unwrap() {
            column.typed::<DoubleType>().write_batch(&[0.1; 300], None, None).unwrap();
            column.close().unwrap();
        }
        group.close().unwrap();
        let (_folder, path) = file(&writer.into_inner().unwrap());
        let mut reader = Reader::open(&path, &Columns::default(), Wanted::ALL).unwrap();
        let said = reader.chosen().of(Signal::Time).unwrap().to_string();
        assert!(said.contains(&format!("column \"index\", stamps of {form} -> s since")), "{said}");
        let times: Vec<_> = reader.by_ref().map(|row| row.unwrap().time_s).collect();
        assert_eq!(times.len(), 300);
        for (time_s, k) in times.iter().zip(BEGIN..) {
            let us =
                i64::from(k) * 10_000 + i64::from(if unit_per_s < 1_000_000 { 0 } else { k % 7 });
            assert_eq!(*time_s, us as f64 / 1e6, "{said}");
        }
    }
}

#[test]
fn what_cannot_be_is_said_with_its_line() {
    let usual_drive = drive(500, usual);
    let with = |line: usize, text: &str| {
        let mut lines: Vec<_> = usual_drive.lines().collect();
        lines[line - 1] = text;
        lines.join("\n")
    };
    for (text, line, part) in [
        (String::new(), None, "is empty"),
        ("\n".into(), None, "is empty"),
        ("t\n1\n2\n".into(), None, "a single column, `t`"),
        (usual_drive.lines().next().unwrap().to_owned(), None, "no rows"),
        (
            with(100, "0.98,fast,0.1,0.3"),
            Some(100),
            "speed: `fast` in column `v [m/s]` is no number",
        ),
        (with(400, "3.98,10,0.1,1e"), Some(400), "steering: `1e` in column `hw [rad]`"),
        (with(300, "0.5,10,0.1,0.3"), Some(300), "time runs back, from 2.97 s to 0.5 s"),
        (with(300, ",10,0.1,0.3"), Some(300), "the time stamp is missing"),
        (
            with(300, "2.98,300,0.1,0.3"),
            Some(300),
            "speed: 300 m/s is not possible: it looks like km/h",
        ),
        (
            with(300, "2.98,10,0.1,40"),
            Some(300),
            "steering: 40 rad is not possible: it looks like deg",
        ),
        (with(300, "2.98,10,12,0.3"), Some(300), "12 rad/s is not possible: it looks like deg/s"),
        (
            drive(500, |k| format!("{k}0,10,0.{k},0.3")),
            Some(2),
            "time goes by 10 s a row, read in s: it looks like ms",
        ),
        (drive(500, |_| "7,10,0.1,0.3".into()), Some(2), "time never changes from 7 s"),
        (with(300, "9e99,10,0.1,0.3"), Some(300), "time: 9"),
        (
            with(300, "12:30:01,10,0.1,0.3"),
            Some(300),
            "time: `12:30:01` in column `t` is no number",
        ),
        (with(300, "\"2.98,10,0.1,0.3"), Some(300), "`\"2.98` in column `t` is no number"),
        (
            drive(500, |k| format!("{k}e-2,,0.{k},0.3")),
            None,
            "column `v [m/s]` has no number at all",
        ),
        (
            // 3 deg/s at 20 m/s.
            drive(500, |k| format!("{k}e-2,20,3,0.{k}")),
            Some(102),
            "60 m/s^2 to the side for a second: one of their units is wrong: it looks like deg/s",
        ),
        ("MDF     4.10".into(), None, "is an MDF file, not CSV or Parquet"),
        ("PAR1PAR1".into(), None, "no Parquet file that can be read"),
        ("a,b\0".into(), None, "is a binary file"),
    ] {
        let error = read(text.as_bytes(), &Columns::default()).unwrap_err();
        assert!(error.to_string().contains(part), "`{part}` is missing in: {error}");
        assert_eq!(error.line, line, "{error}");
    }
    let missing = Reader::open("missing.csv".as_ref(), &Columns::default(), Wanted::ALL);
    assert!(matches!(*missing.err().unwrap().cause, Cause::Read(_)));
}

#[test]
fn what_looks_wrong_is_found_with_its_line() {
    let (rows, findings) = read(drive(1000, usual).as_bytes(), &Columns::default()).unwrap();
    assert_eq!((rows.len(), findings), (1000, vec![]));

    let cut = |k: u32| {
        let t = f64::from(k) * 0.01;
        format!(
            "{t:.2},{},{:.4},{:.4}",
            9,
            (0.3 * t.cos()).min(0.2),
            if k == 7 { f64::NAN } else { t }
        )
    };
    let (_, findings) = read(drive(1000, cut).as_bytes(), &Columns::default()).unwrap();
    let findings: Vec<_> = findings.iter().map(ToString::to_string).collect();
    assert_eq!(
        findings,
        [
            "line 2: speed: `v [m/s]` never changes from 9 m/s",
            "line 2: yaw rate: `r [rad/s]` stays at its extreme 0.2000 rad/s for 1.7 s: saturated?",
            "line 9: steering: 1 cells of `hw [rad]` without a number, the first here",
        ]
    );

    let (rows, findings) =
        read((drive(1000, usual) + "  \n,,,\n").as_bytes(), &Columns::default()).unwrap();
    assert_eq!((rows.len(), findings), (1000, vec![]));

    let twice = drive(100, |k| usual(k / 2 * 2));
    let (_, findings) = read(twice.as_bytes(), &Columns::default()).unwrap();
    assert_eq!(
        findings[0].to_string(),
        "line 3: 50 rows have the time of the row before, the first here"
    );
}

#[test]
fn the_file_of_columns_in_the_documentation_is_read() {
    let page = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/drive-files.md");
    let page = fs::read_to_string(page).unwrap();
    let (_, rest) = page.split_once("```toml\n").unwrap();
    let columns = Columns::from_toml(rest.split_once("```").unwrap().0).unwrap();
    let yaw_rate = columns.told(Signal::YawRate).unwrap();
    assert!(yaw_rate.turned && yaw_rate.name == "r_deg");
    assert_eq!((columns.delimiter, columns.delay_s(Signal::Steering)), (Some(b';'), 0.03));
}

#[test]
fn a_row_without_end_is_refused() {
    let begin = drive(3, usual);
    let said = |text: String| read(text.as_bytes(), &Columns::default()).unwrap_err();
    // A line without end, be it the first; a quotation mark that nothing closes; a comment without end.
    for (text, line, bytes) in [
        ("1,".repeat(600_000), 1, 131_072),
        (format!("{begin}{}", "1,".repeat(600_000)), 5, 1_048_576),
        (format!("{begin}\"{}", drive(60_000, usual)), 5, 1_048_576),
        (format!("{begin}#{}", "1".repeat(1_200_000)), 5, 1_048_576),
    ] {
        let error = said(text).to_string();
        let expected = format!("more than {bytes} bytes in the row from line {line} ");
        assert!(error.contains(&expected), "{error}");
    }
    // Only what a row takes counts, not all of them.
    let (rows, _) = read(drive(60_000, usual).as_bytes(), &Columns::default()).unwrap();
    assert_eq!(rows.len(), 60_000);
}

#[test]
fn what_is_no_file_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let said = |path: &std::path::Path| {
        Reader::open(path, &Columns::default(), Wanted::ALL).err().unwrap().to_string()
    };
    assert!(said(folder.path()).ends_with(": is a folder"));
    if cfg!(unix) {
        assert_eq!(said("/dev/zero".as_ref()), "`/dev/zero`: is a pipe or a device");
    }
}
