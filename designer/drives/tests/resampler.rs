//! Samples on a grid from rows of any times.

#![allow(clippy::unwrap_used)]

use std::f64::consts::TAU;

use proptest::prelude::*;
use steerguard_drives::{
    Cause, Columns, DriveError, Layout, Piece, Reader, Resampled, Resampler, Row, Sample, Spacing,
    Wanted, pieces,
};

const PERIOD_S: f64 = 0.01;
const LAYOUT: Layout = Layout { present: [true, true, true, true, false], delays_s: [0.0; 5] };

fn resampled(rows: Vec<Row>, layout: Layout, spacing: Spacing) -> Vec<Resampled> {
    let rows = rows.into_iter().map(Ok::<_, DriveError>);
    Resampler::new(rows, layout, spacing).map(Result::unwrap).collect()
}

fn row(time_s: f64, value: f64) -> Row {
    Row { line: 0, time_s, values: [value, value, value, value, f64::NAN] }
}

/// Numbers of samples of each piece.
fn lengths(samples: &[Resampled]) -> Vec<usize> {
    samples.chunk_by(|a, b| a.piece == b.piece).map(<[_]>::len).collect()
}

#[test]
fn rows_on_the_grid_stay_what_they_are() {
    let rows: Vec<_> = (0..1000).map(|k| row(5.0 + f64::from(k) * 0.01, f64::from(k))).collect();
    let samples = resampled(rows, LAYOUT, Spacing::of_period(PERIOD_S));
    assert_eq!(samples.len(), 1000);
    for (k, Resampled { piece, sample }) in samples.into_iter().enumerate() {
        assert_eq!((piece, sample.speed_m_per_s), (0, k as f64));
        assert_eq!(sample.lateral_acceleration_m_per_s2, Some(k as f64));
        assert_eq!(sample.drive_torque_n_m, None);
    }
}

#[test]
fn a_gap_ends_a_piece_and_a_short_one_is_bridged() {
    let times = (0..100).map(|k| f64::from(k) * 0.01).filter(|t| !(0.3..0.54).contains(t));
    let times = times.chain((0..100).map(|k| 1.5 + f64::from(k) * 0.01)).chain([9.0]);
    let samples =
        resampled(times.map(|t| row(t, t)).collect(), LAYOUT, Spacing::of_period(PERIOD_S));
    assert_eq!(lengths(&samples), [100, 100, 1]);
    for Resampled { sample, .. } in &samples {
        assert!((sample.speed_m_per_s - sample.time_s).abs() < 1e-12);
    }
    assert!((samples[100].sample.time_s - 1.5).abs() < 1e-9);
}

#[test]
fn a_signal_of_its_own_rows_and_one_that_falls_silent() {
    // Speed each 40 ms, torque only until 2 s, everything else in rows of its own.
    let mut rows = Vec::new();
    for k in 0..400_u32 {
        let time_s = f64::from(k) * 0.01;
        let nan = f64::NAN;
        let mut values = [nan, time_s, 2.0 * time_s, nan, nan];
        rows.push(Row { line: 0, time_s, values });
        values = [if k % 4 == 0 { time_s } else { nan }, nan, nan, nan, nan];
        values[4] = if k <= 200 { 7.0 } else { nan };
        rows.push(Row { line: 0, time_s, values });
    }
    let layout = Layout { present: [true, true, true, false, true], ..LAYOUT };
    let samples = resampled(rows, layout, Spacing::of_period(PERIOD_S));
    assert_eq!(lengths(&samples), [397]);
    for Resampled { sample, .. } in samples {
        assert!((sample.speed_m_per_s - sample.time_s).abs() < 1e-12);
        assert!((sample.steering_rad - 2.0 * sample.time_s).abs() < 1e-12);
        assert_eq!(sample.drive_torque_n_m, (sample.time_s < 2.005).then_some(7.0));
    }
}

#[test]
fn a_delay_moves_a_signal_back_in_time() {
    let rows = (0..500).map(|k| row(f64::from(k) * 0.01, f64::from(k) * 0.01)).collect();
    let delays_s = [0.0, -0.02, 0.035, 0.0, 0.0];
    let samples = resampled(rows, Layout { delays_s, ..LAYOUT }, Spacing::of_period(PERIOD_S));
    // From 0.02 s, where the yaw rate begins, to 4.95 s, where the steering ends.
    assert_eq!(samples.len(), 494);
    for Resampled { sample, .. } in samples {
        let Sample { time_s, speed_m_per_s, yaw_rate_rad_per_s, steering_rad, .. } = sample;
        assert!((speed_m_per_s - time_s).abs() < 1e-12);
        assert!((yaw_rate_rad_per_s - (time_s - 0.02)).abs() < 1e-12);
        assert!((steering_rad - (time_s + 0.035)).abs() < 1e-12);
    }
}

/// Sines below `hz`.
#[derive(Clone, Debug)]
struct Signal(Vec<[f64; 3]>);

impl Signal {
    fn at(&self, t: f64) -> f64 {
        self.0.iter().map(|[amplitude, hz, phase]| amplitude * (TAU * hz * t + phase).sin()).sum()
    }

    /// Largest second derivative.
    fn curvature(&self) -> f64 {
        self.0.iter().map(|[amplitude, hz, _]| amplitude.abs() * (TAU * hz).powi(2)).sum()
    }
}

fn signal() -> impl Strategy<Value = Signal> {
    let sine = [0.1..1.0_f64, 0.1..3.0_f64, 0.0..TAU];
    prop::collection::vec(sine, 1..5).prop_map(Signal)
}

/// Time stamps of a logger at 100 Hz with jitter of 4 ms, of which 5 % are lost and 5 % come twice.
fn times() -> impl Strategy<Value = Vec<f64>> {
    let stamp = (-0.004..0.004_f64, 0..20_u32);
    prop::collection::vec(stamp, 50..400).prop_map(|stamps| {
        let stamps = stamps.into_iter().enumerate().flat_map(|(k, (jitter_s, fate))| {
            let number = [0, 2].get(fate as usize).copied().unwrap_or(1);
            vec![k as f64 * 0.01 + jitter_s; number]
        });
        stamps.collect()
    })
}

/// A table of a drive as text, in some dialect and order of columns.
fn table(rows: &[[f64; 4]], delimiter: char, mark: char, order: &[usize]) -> String {
    let names = ["t [s]", "v [m/s]", "r [rad/s]", "delta [rad]"].map(String::from);
    let cell = |x: f64| format!("{x}").replace('.', &mark.to_string());
    let line = |cells: &[String; 4]| {
        let cells: Vec<_> = order.iter().map(|&column| cells[column].as_str()).collect();
        cells.join(&delimiter.to_string()) + "\n"
    };
    line(&names) + &rows.iter().map(|row| line(&row.map(cell))).collect::<String>()
}

fn read(text: &str) -> Vec<Piece> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("drive.csv");
    std::fs::write(&path, text).unwrap();
    let mut reader = Reader::open(&path, &Columns::default(), Wanted::ALL).unwrap();
    pieces(&mut reader, Spacing::of_period(PERIOD_S), 1e6).unwrap()
}

#[test]
fn more_than_is_taken_at_once_is_refused_before_it_is_there() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("drive.csv");
    let rows: Vec<[f64; 4]> = (0..1000).map(|k| [0.01 * f64::from(k), 10.0, 0.1, 0.01]).collect();
    std::fs::write(&path, table(&rows, ',', '.', &[0, 1, 2, 3])).unwrap();
    let mut reader = Reader::open(&path, &Columns::default(), Wanted::ALL).unwrap();
    let error = pieces(&mut reader, Spacing::of_period(PERIOD_S), 3.0).unwrap_err();
    assert!(matches!(*error.cause, Cause::TooLong { longest_s: 3.0 }), "{error}");
    assert!(reader.rows() < 500, "{}", reader.rows());
}

proptest! {
    /// A straight line between samples h apart is off by at most h^2/8 of the largest second derivative.
    #[test]
    fn jitter_losses_and_repeated_rows_cost_what_interpolation_does(
        signal in signal(), times in times(), delay_s in -0.05..0.05_f64,
    ) {
        let rows = times.iter().map(|&t| row(t, signal.at(t - delay_s))).collect();
        let spacing = Spacing::of_period(PERIOD_S);
        let samples = resampled(rows, Layout { delays_s: [delay_s; 5], ..LAYOUT }, spacing);
        let steps = times.windows(2).map(|pair| pair[1] - pair[0]);
        let longest_s = steps.filter(|&h| h <= spacing.gap_s).fold(0.0, f64::max);
        let bound = longest_s.powi(2) / 8.0 * signal.curvature() + 1e-9;
        for Resampled { sample, .. } in &samples {
            let error = sample.speed_m_per_s - signal.at(sample.time_s);
            prop_assert!(error.abs() <= bound, "{error} at {}, bound {bound}", sample.time_s);
        }
        // Nothing but gaps is left out.
        let length_s = times.last().unwrap() - times[0];
        let gaps_s: f64 = times.windows(2).map(|w| w[1] - w[0]).filter(|&h| h > spacing.gap_s).sum();
        prop_assert!(samples.len() as f64 >= (length_s - gaps_s) / PERIOD_S - 2.0);
    }

    /// Whatever is in a file, it is read, or refused with an error.
    #[test]
    fn no_text_makes_the_reader_panic(
        lines in prop::collection::vec("[-+0-9.,;\t\"#eainf ]{0,40}", 0..20),
        header in prop::sample::select(vec!["", "t [s],v [m/s],r [rad/s],hw [rad]\n", "t;v;r;hw\ns;m/s;rad/s;rad\n"]),
    ) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("drive.csv");
        std::fs::write(&path, format!("{header}{}", lines.join("\n"))).unwrap();
        if let Ok(mut reader) = Reader::open(&path, &Columns::default(), Wanted::ALL) {
            let _ = pieces(&mut reader, Spacing::of_period(PERIOD_S), 1e6);
            reader.findings();
        }
    }

    /// The same of rows of numbers, which come further.
    #[test]
    fn no_numbers_make_the_resampler_panic(
        rows in prop::collection::vec((-0.1..2.0_f64, [-30.0..30.0_f64, -1.0..1.0, -2.0..2.0], 0..8_usize), 1..80),
    ) {
        let mut time_s = 0.0;
        let rows = rows.into_iter().map(|(step_s, values, fate)| {
            // Some steps are short, some rows lack a signal, some stand at the same time.
            time_s += if fate > 2 { 0.01 * step_s.abs() } else { step_s.max(0.0) };
            let mut row = Row { line: 0, time_s, values: [values[0], values[1], values[2], f64::NAN, 1.0] };
            if let Some(value) = row.values.get_mut(fate) {
                *value = f64::NAN;
            }
            row
        });
        let layout = Layout { present: [true; 5], delays_s: [0.0, 0.03, -0.02, 0.0, 0.0] };
        let samples = resampled(rows.collect(), layout, Spacing::of_period(PERIOD_S));
        let ordered = samples.windows(2).all(|pair| {
            let step_s = pair[1].sample.time_s - pair[0].sample.time_s;
            let same = pair[0].piece == pair[1].piece;
            if same { (step_s - PERIOD_S).abs() < 1e-9 } else { step_s > PERIOD_S - 1e-9 }
        });
        prop_assert!(ordered);
    }

    #[test]
    fn delimiter_decimal_mark_and_order_of_columns_do_not_matter(
        numbers in prop::collection::vec([0.0..50.0_f64, -0.4..0.4_f64, -0.5..0.5_f64], 3..60),
        dialect in prop::sample::select(vec![(',', '.'), (';', '.'), (';', ','), ('\t', ','), ('\t', '.'), ('|', ',')]),
        order in Just(vec![0, 1, 2, 3]).prop_shuffle(),
    ) {
        let rows: Vec<_> = numbers
            .iter()
            .enumerate()
            .map(|(k, &[v, r, delta])| [k as f64 / 100.0, v, r, delta])
            .collect();
        let expected = read(&table(&rows, ',', '.', &[0, 1, 2, 3]));
        prop_assert_eq!(expected[0].samples.len(), rows.len());
        prop_assert_eq!(read(&table(&rows, dialect.0, dialect.1, &order)), expected);
    }
}
