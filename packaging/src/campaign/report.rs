//! The figures of a campaign: false alarms, detections, delays, the smallest fault surely detected.
//!
//! # Conventions
//! - Intervals are two-sided, 95 %, exact: Garwood's for rates, Clopper and Pearson's for
//!   probabilities. False alarms are counted an hour that the detector monitored without a fault.
//! - Detections are counted among the faults detected or missed, see [`super::outcome`]. The size of any fault is the
//!   largest angle that it added while the detector monitored, so that kinds compare.
//! - Delays count from exposure, and a missed fault has an endless one.
//! - A size s is *surely detected* if of the faults next above it, at least 299 and a quarter of all of
//!   their group, 99 % are detected at 95 % confidence. (With 299 none may be missed.) Sizes are tested
//!   from the largest down until one fails: a fixed sequence, so that the confidence holds for all at
//!   once.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use steerguard_detector::Interval;

use super::names::{FaultName, ManoeuvreName};
use super::outcome::Verdict;
use super::statistics::{
    CONFIDENCE, Estimate, probability, probability_at_least, quantile, rate_per_hour,
};
use super::table::Row;
use crate::output::table::aligned;

/// Share of the faults that has to be detected.
const SURE: f64 = 0.99;
/// Fewest faults that can show it: 0.99^299 < 0.05.
const FEWEST: usize = 299;
/// Ends of the size classes, deg.
const SIZE_CLASSES_DEG: [f64; 11] = [0.0, 0.1, 0.2, 0.3, 0.5, 0.7, 1.0, 1.5, 2.0, 3.0, 5.0];
/// Number of speed bands.
const SPEED_BANDS: u32 = 3;

/// Figures of a campaign.
#[derive(Clone, Debug, PartialEq, JsonSchema, Serialize, Deserialize)]
pub struct Report {
    /// Number of drives.
    pub drives: usize,
    /// Length of all drives.
    pub driven_h: f64,
    /// Time that the detector monitored.
    pub monitored_h: f64,
    /// Share of the samples at which it was out of range.
    pub out_of_range_share: f64,
    /// The same for v_x, for v_y_hat and for r.
    pub out_of_range_by_cause: [f64; 3],
    /// Share of the samples at which its input was invalid.
    pub invalid_input_share: f64,
    /// Share of the time monitored at which the smallest fault of interest could not be seen.
    pub not_excited_share: f64,
    /// Confidence of intervals and bounds.
    pub confidence: f64,
    /// False alarms: of all drives, by speed, by manoeuvre.
    pub false_alarms: Vec<FalseAlarms>,
    /// Detections by kind of fault, then by kind and speed.
    pub detections: Vec<Detections>,
    /// Detections by kind and size.
    pub detections_by_size: Vec<Detections>,
}

/// False alarms of a group of drives.
#[derive(Clone, Debug, PartialEq, JsonSchema, Serialize, Deserialize)]
pub struct FalseAlarms {
    /// Which drives.
    pub group: String,
    /// Number of drives in which the detector monitored without a fault.
    pub drives: u64,
    /// Time that it did.
    pub hours: f64,
    /// Episodes.
    pub episodes: u64,
    /// Episodes an hour.
    pub per_hour: Option<Estimate>,
    /// Drives with an episode.
    pub drives_with_episodes: u64,
    /// Probability of an episode in a drive.
    pub per_drive: Option<Estimate>,
    /// Largest J/J_th.
    pub largest_ratio: Option<f64>,
}

/// Detections among a group of faults.
#[derive(Clone, Debug, PartialEq, JsonSchema, Serialize, Deserialize)]
pub struct Detections {
    /// Kind of the faults.
    pub kind: FaultName,
    /// Which of them.
    pub group: String,
    /// Number of faults.
    pub faults: u64,
    /// Those that never acted while the detector monitored.
    pub not_exposed: u64,
    /// Those that a false alarm masked.
    pub masked: u64,
    /// Those detected.
    pub detected: u64,
    /// Those of them whose alarm did not last until the end of the drive.
    pub interrupted: u64,
    /// Those missed.
    pub missed: u64,
    /// Probability of detection of a fault that is neither masked nor not exposed.
    pub probability: Option<Estimate>,
    /// Median of the delay.
    pub delay_median_s: Option<f64>,
    /// 95th percentile of the delay.
    pub delay_95_s: Option<f64>,
    /// Smallest size surely detected; of no use among faults of one size class.
    pub surely_detected_deg: Option<f64>,
}

impl Report {
    /// The figures of `rows`; `armed_v_x` is divided into speed bands.
    pub fn of(rows: &[Row], armed_v_x: Interval) -> Self {
        let all: Vec<&Row> = rows.iter().collect();
        let hours = |time_s: fn(&Row) -> f64| rows.iter().map(time_s).sum::<f64>() / 3600.0;
        let (driven_h, monitored_h) =
            (hours(|row| row.drive.duration_s), hours(|row| row.outcome.monitored_s));
        let share =
            |part_s: fn(&Row) -> f64, of_h| if of_h > 0.0 { hours(part_s) / of_h } else { 0.0 };
        let bands = speed_bands(armed_v_x);

        let mut false_alarms = vec![FalseAlarms::of("all drives".into(), &all)];
        for band in &bands {
            false_alarms.push(FalseAlarms::of(band.name(), &band.select(&all)));
        }
        for manoeuvre in ManoeuvreName::ALL {
            let rows = filtered(&all, |row| row.drive.manoeuvre == *manoeuvre);
            false_alarms.push(FalseAlarms::of(manoeuvre.name().into(), &rows));
        }
        false_alarms.retain(|group| group.drives > 0);

        let (mut detections, mut detections_by_speed, mut detections_by_size) =
            (Vec::new(), Vec::new(), Vec::new());
        for kind in FaultName::ALL.iter().filter(|kind| **kind != FaultName::None) {
            let faults = filtered(&all, |row| row.drive.fault == *kind);
            detections.push(Detections::of(*kind, "all".into(), &faults));
            for band in &bands {
                let faults = band.select(&faults);
                detections_by_speed.push(Detections::of(*kind, band.name(), &faults));
            }
            for class in size_classes() {
                let faults = filtered(&faults, |row| {
                    row.outcome.peak_fault_deg.is_some_and(|size| class.contains(size))
                });
                detections_by_size.push(Detections::of(*kind, class.name(), &faults));
            }
        }
        detections.append(&mut detections_by_speed);
        for groups in [&mut detections, &mut detections_by_size] {
            groups.retain(|group| group.faults > 0);
        }

        Self {
            drives: rows.len(),
            driven_h,
            monitored_h,
            out_of_range_share: share(
                |row| row.outcome.out_of_range_share * row.drive.duration_s,
                driven_h,
            ),
            out_of_range_by_cause: [
                share(|row| row.outcome.out_of_range_v_x_share * row.drive.duration_s, driven_h),
                share(|row| row.outcome.out_of_range_v_y_share * row.drive.duration_s, driven_h),
                share(|row| row.outcome.out_of_range_r_share * row.drive.duration_s, driven_h),
            ],
            invalid_input_share: share(
                |row| row.outcome.invalid_input_share * row.drive.duration_s,
                driven_h,
            ),
            not_excited_share: share(
                |row| row.outcome.not_excited_share * row.outcome.monitored_s,
                monitored_h,
            ),
            confidence: CONFIDENCE,
            false_alarms,
            detections,
            detections_by_size,
        }
    }

    /// Tables for people.
    pub fn text(&self) -> String {
        let [v_x, v_y, r] = self.out_of_range_by_cause.map(|share| 100.0 * share);
        let mut text = format!(
            "{} drives, {:.3} h driven, {:.3} h monitored, {:.1} % out of range: {v_x:.1} % for v_x, \
             {v_y:.1} % for v_y_hat, {r:.1} % for r\n",
            self.drives,
            self.driven_h,
            self.monitored_h,
            100.0 * self.out_of_range_share
        );
        text += &format!(
            "Could not have seen the smallest fault of interest in {:.1} % of the time monitored\n",
            100.0 * self.not_excited_share
        );
        if self.invalid_input_share > 0.0 {
            text += &format!("Invalid input: {:.1} %\n", 100.0 * self.invalid_input_share);
        }
        text += "\nFalse alarms, with 95 % intervals\n";
        text += &table(FALSE_ALARMS_HEAD, self.false_alarms.iter().map(FalseAlarms::cells));
        if !self.detections.is_empty() {
            text += "\nDetections, with 95 % intervals; delays from the first monitored sample\n";
            text += &table(DETECTIONS_HEAD, self.detections.iter().map(Detections::cells));
            text += &format!(
                "Sure: {} % detected at {} % confidence; this takes {FEWEST} faults or more\n",
                100.0 * SURE,
                100.0 * CONFIDENCE
            );
        }
        if !self.detections_by_size.is_empty() {
            text += "\nDetections by largest angle that the fault added\n";
            let but_last = |detections: &Detections| {
                let [cells @ .., _] = detections.cells();
                cells
            };
            let [head @ .., _] = DETECTIONS_HEAD;
            text += &table(head, self.detections_by_size.iter().map(but_last));
        }
        text
    }
}

const FALSE_ALARMS_HEAD: [&str; 8] =
    ["drives", "number", "h", "episodes", "per h", "drives with", "per drive", "largest J/J_th"];

const DETECTIONS_HEAD: [&str; 12] = [
    "fault",
    "which",
    "number",
    "not exposed",
    "masked",
    "detected",
    "did not last",
    "missed",
    "probability",
    "delay median s",
    "95 % s",
    "sure from deg",
];

fn table<const N: usize>(head: [&str; N], rows: impl Iterator<Item = [String; N]>) -> String {
    let head = std::iter::once(head.map(String::from));
    aligned(&head.chain(rows).map(Vec::from).collect::<Vec<_>>(), "  ")
}

impl FalseAlarms {
    fn of(group: String, rows: &[&Row]) -> Self {
        let rows = filtered(rows, |row| row.outcome.monitored_fault_free_s > 0.0);
        let drives = rows.len() as u64;
        let hours = rows.iter().map(|row| row.outcome.monitored_fault_free_s).sum::<f64>() / 3600.0;
        let episodes = rows.iter().map(|row| u64::from(row.outcome.false_alarms)).sum();
        let drives_with_episodes = count(&rows, |row| row.outcome.false_alarms > 0);
        Self {
            group,
            drives,
            hours,
            episodes,
            per_hour: rate_per_hour(episodes, hours),
            drives_with_episodes,
            per_drive: probability(drives_with_episodes, drives),
            largest_ratio: rows
                .iter()
                .filter_map(|row| row.outcome.peak_ratio_before)
                .reduce(f64::max),
        }
    }

    fn cells(&self) -> [String; 8] {
        [
            self.group.clone(),
            self.drives.to_string(),
            format!("{:.3}", self.hours),
            self.episodes.to_string(),
            estimate(self.per_hour),
            self.drives_with_episodes.to_string(),
            estimate(self.per_drive),
            number(self.largest_ratio, 3),
        ]
    }
}

impl Detections {
    fn of(kind: FaultName, group: String, faults: &[&Row]) -> Self {
        let is = |verdict| move |row: &Row| row.outcome.verdict == verdict;
        let tried = filtered(faults, |row| is(Verdict::Detected)(row) || is(Verdict::Missed)(row));
        let detected = count(&tried, is(Verdict::Detected));
        let mut delays: Vec<_> = tried.iter().map(|row| row.outcome.delay_s).collect();
        let sizes = tried
            .iter()
            .filter_map(|row| Some((row.outcome.peak_fault_deg?, is(Verdict::Detected)(row))))
            .collect();
        Self {
            kind,
            group,
            faults: faults.len() as u64,
            not_exposed: count(faults, is(Verdict::NotExposed)),
            masked: count(faults, is(Verdict::Masked)),
            detected,
            interrupted: count(&tried, |row| row.outcome.interrupted_s.is_some_and(|s| s > 0.0)),
            missed: count(&tried, is(Verdict::Missed)),
            probability: probability(detected, tried.len() as u64),
            delay_median_s: quantile(&mut delays, 0.5),
            delay_95_s: quantile(&mut delays, 0.95),
            surely_detected_deg: surely_detected(sizes),
        }
    }

    fn cells(&self) -> [String; 12] {
        [
            self.kind.name().into(),
            self.group.clone(),
            self.faults.to_string(),
            self.not_exposed.to_string(),
            self.masked.to_string(),
            self.detected.to_string(),
            self.interrupted.to_string(),
            self.missed.to_string(),
            estimate(self.probability),
            number(self.delay_median_s, 2),
            number(self.delay_95_s, 2),
            number(self.surely_detected_deg, 2),
        ]
    }
}

/// The smallest size surely detected among faults (size in deg, detected).
fn surely_detected(mut faults: Vec<(f64, bool)>) -> Option<f64> {
    faults.sort_by(|(a, _), (b, _)| a.total_cmp(b));
    let together = FEWEST.max(faults.len() / 4);
    let missed_at_most = (1..=together)
        .take_while(|missed| is_sure((together - missed) as u64, together as u64))
        .count();
    // Number of missed faults before each one, and in all.
    let missed: Vec<usize> = std::iter::once(0)
        .chain(faults.iter().scan(0, |missed, (_, detected)| {
            *missed += usize::from(!detected);
            Some(*missed)
        }))
        .collect();
    let windows = faults.iter().zip(missed.iter().zip(missed.iter().skip(together)));
    windows
        .rev()
        .take_while(|(_, (before, after))| *after - *before <= missed_at_most)
        .last()
        .map(|((size, _), _)| *size)
}

/// Whether `detected` of `faults` show a probability of [`SURE`] at [`CONFIDENCE`].
fn is_sure(detected: u64, faults: u64) -> bool {
    probability_at_least(detected, faults) >= SURE
}

/// A class `[from, to)` of a quantity.
struct Class {
    from: f64,
    to: f64,
    unit: &'static str,
}

impl Class {
    fn contains(&self, value: f64) -> bool {
        self.from <= value && value < self.to
    }

    fn name(&self) -> String {
        let Self { from, to, unit } = self;
        if to.is_finite() {
            format!("{from:.1} to {to:.1} {unit}")
        } else {
            format!("from {from:.1} {unit}")
        }
    }

    /// The drives with a set speed in it.
    fn select<'a>(&self, rows: &[&'a Row]) -> Vec<&'a Row> {
        filtered(rows, |row| self.contains(row.drive.speed_m_per_s))
    }
}

fn size_classes() -> impl Iterator<Item = Class> {
    let ends = SIZE_CLASSES_DEG.into_iter().skip(1).chain([f64::INFINITY]);
    SIZE_CLASSES_DEG.into_iter().zip(ends).map(|(from, to)| Class { from, to, unit: "deg" })
}

/// Bands of equal width; the last one is open, since the highest speed belongs to it.
fn speed_bands(armed_v_x: Interval) -> Vec<Class> {
    let width = (armed_v_x.max - armed_v_x.min) / f64::from(SPEED_BANDS);
    let end = |band: u32| armed_v_x.min + f64::from(band) * width;
    let to = |band| if band < SPEED_BANDS { end(band) } else { f64::INFINITY };
    (0..SPEED_BANDS).map(|b| Class { from: end(b), to: to(b + 1), unit: "m/s" }).collect()
}

fn filtered<'a>(rows: &[&'a Row], keep: impl Fn(&Row) -> bool) -> Vec<&'a Row> {
    rows.iter().copied().filter(|row| keep(row)).collect()
}

fn count(rows: &[&Row], is: impl Fn(&Row) -> bool) -> u64 {
    rows.iter().filter(|row| is(row)).count() as u64
}

/// A number with so many digits behind the point, or a dash.
pub(crate) fn number(value: Option<f64>, digits: usize) -> String {
    value.map_or("-".into(), |value| format!("{value:.digits$}"))
}

fn estimate(estimate: Option<Estimate>) -> String {
    estimate.map_or("-".into(), |Estimate { value, lower, upper }| {
        format!("{value:.3} [{lower:.3}, {upper:.3}]")
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::campaign::drive::Drive;
    use crate::campaign::drive_record::DriveRecord;
    use crate::campaign::outcome::Outcome;
    use crate::campaign::settings::tests::{PAPER, SETTINGS};

    /// A straight drive at 10 m/s, monitored for half an hour before any fault.
    fn row(fault: FaultName, verdict: Verdict, false_alarms: u32, delay_s: Option<f64>) -> Row {
        let drive = DriveRecord::from(&Drive::draw(&SETTINGS, &PAPER, 0));
        let manoeuvre = ManoeuvreName::Straight;
        let exposed_s = delay_s.map(|_| 1800.0);
        Row {
            drive: DriveRecord {
                fault,
                manoeuvre,
                speed_m_per_s: 10.0,
                duration_s: 3600.0,
                ..drive
            },
            outcome: Outcome {
                verdict,
                false_alarms,
                monitored_s: 1800.0,
                monitored_fault_free_s: 1800.0,
                out_of_range_share: 0.5,
                out_of_range_v_x_share: 0.25,
                out_of_range_v_y_share: 0.0,
                out_of_range_r_share: 0.25,
                invalid_input_share: 0.0,
                not_excited_share: 0.25,
                acting_s: exposed_s,
                exposed_s,
                alarm_s: None,
                interrupted_s: delay_s.map(|_| 0.0),
                delay_s,
                onset_delay_s: None,
                peak_fault_deg: Some(0.6),
                peak_ratio_before: Some(f64::from(false_alarms)),
                peak_ratio_after: None,
                peak_second_ratio_before: None,
                estimate_error_deg: None,
                estimate_bound_deg: None,
                false_alarms_by_second: 0,
                residual_delay_s: None,
                detected_by_second: None,
            },
        }
    }

    #[test]
    fn every_drive_is_counted_where_it_belongs() {
        let rows = [
            row(FaultName::None, Verdict::FaultFree, 3, None),
            row(FaultName::Bias, Verdict::Detected, 0, Some(0.2)),
            row(FaultName::Bias, Verdict::Missed, 0, None),
            row(FaultName::Bias, Verdict::Masked, 1, None),
            row(FaultName::Stuck, Verdict::NotExposed, 0, None),
        ];
        let report = Report::of(&rows, PAPER.armed_v_x);
        assert_eq!((report.drives, report.driven_h, report.monitored_h), (5, 5.0, 2.5));
        assert_eq!((report.out_of_range_share, report.not_excited_share), (0.5, 0.25));

        let groups: Vec<_> = report.false_alarms.iter().map(|g| g.group.as_str()).collect();
        assert_eq!(groups, ["all drives", "5.5 to 13.5 m/s", "straight"]);
        for group in &report.false_alarms {
            assert_eq!((group.drives, group.hours, group.episodes), (5, 2.5, 4));
            assert_eq!((group.drives_with_episodes, group.largest_ratio), (2, Some(3.0)));
        }

        let [bias, stuck, ..] = report.detections.as_slice() else { panic!() };
        assert_eq!(
            (bias.kind.name(), bias.faults, bias.not_exposed, bias.masked),
            ("bias", 3, 0, 1)
        );
        assert_eq!((bias.detected, bias.missed), (1, 1));
        assert_eq!(bias.probability, probability(1, 2));
        assert_eq!((bias.delay_median_s, bias.delay_95_s), (Some(0.2), None));
        assert_eq!((stuck.kind.name(), stuck.not_exposed, stuck.probability), ("stuck", 1, None));
        assert_eq!(report.detections_by_size.len(), 2);
        assert_eq!(report.detections_by_size[0].group, "0.5 to 0.7 deg");
        assert!(report.text().contains("masked"));
    }

    #[test]
    fn sure_sizes_lie_above_the_largest_miss() {
        let faults = |missed: &[usize]| -> Vec<_> {
            (0..1000).rev().map(|k| (k as f64 * 1e-3, !missed.contains(&k))).collect()
        };
        assert_eq!(surely_detected(faults(&[])), Some(0.0));
        assert_eq!(surely_detected(faults(&[])[..298].to_vec()), None);
        assert_eq!(surely_detected(faults(&[3, 500])), Some(0.501));
        // Missed among the 299 largest: the sequence ends before it begins.
        assert_eq!(surely_detected(faults(&[990])), None);
    }

    #[test]
    fn many_faults_make_room_for_a_rare_miss() {
        let faults = (0..10_000).map(|k| (k as f64 * 1e-4, k > 3000 && k % 1000 != 0));
        let size = surely_detected(faults.collect()).unwrap();
        assert!((0.298..=0.301).contains(&size), "{size}");
    }

    #[test]
    fn classes_cover_every_value_once() {
        let sizes: Vec<_> = size_classes().collect();
        let bands = speed_bands(Interval::new(5.5, 29.5));
        for value in [5.5, 13.5, 21.5, 29.5] {
            assert_eq!(bands.iter().filter(|band| band.contains(value)).count(), 1, "{value}");
        }
        for value in [0.0, 0.05, 0.1, 5.0, 100.0] {
            assert_eq!(sizes.iter().filter(|class| class.contains(value)).count(), 1, "{value}");
        }
    }
}
