//! What many drives showed together, for machines and for people.

use schemars::JsonSchema;
use serde::Serialize;
use steerguard_designer::DesignStatus;

use super::run::{DriveReport, InjectedRun};
use super::tally::Outcome;
use crate::campaign::outcome::Verdict;
use crate::campaign::statistics::{CONFIDENCE, Estimate, rate_per_hour};
use crate::output::table::aligned;

/// What the drives showed.
#[derive(Clone, Debug, PartialEq, JsonSchema, Serialize)]
pub struct Summary {
    /// What the design may be called.
    pub status: DesignStatus,
    /// Hash of the design.
    pub design: String,
    /// Whether the drives are said to be without a fault.
    pub fault_free: bool,
    /// All together.
    pub total: Total,
    /// Each.
    pub drives: Vec<DriveReport>,
}

/// All recorded drives together, and all injected faults.
#[derive(Clone, Debug, PartialEq, JsonSchema, Serialize)]
pub struct Total {
    /// Number of drives.
    pub drives: usize,
    /// Time driven, s.
    pub driven_s: f64,
    /// Time monitored, s.
    pub monitored_s: f64,
    /// Its share, 0 to 1.
    pub monitored_share: f64,
    /// Alarms of the recorded drives: false ones where these are without a fault.
    pub alarms: u64,
    /// The same an hour monitored, with Garwood's interval.
    pub alarms_per_hour: Option<Estimate>,
    /// Drives with an alarm.
    pub drives_with_alarms: usize,
    /// Largest J/J_th while it was monitoring.
    pub largest_ratio: Option<f64>,
    /// Injected runs.
    pub injected: usize,
    /// Those in which the fault acted while the detector monitored, and no alarm stood.
    pub injected_exposed: usize,
    /// Those of them that were seen.
    pub injected_seen: usize,
    /// The smallest angle that was seen, deg, left positive.
    pub smallest_seen_deg: Option<f64>,
    /// From its exposure to its alarm, s.
    pub smallest_seen_delay_s: Option<f64>,
}

impl Total {
    fn of(drives: &[DriveReport]) -> Self {
        let sum = |of: fn(&Outcome) -> f64| drives.iter().map(|drive| of(&drive.outcome)).sum();
        let (driven_s, monitored_s): (f64, f64) = (sum(|o| o.driven_s), sum(|o| o.monitored_s));
        let alarms = drives.iter().map(|drive| drive.outcome.alarms.len() as u64).sum();
        let injected = || drives.iter().flat_map(|drive| &drive.injected);
        let exposed =
            |run: &&InjectedRun| matches!(run.verdict, Verdict::Detected | Verdict::Missed);
        let seen = || injected().filter(|run| run.verdict == Verdict::Detected);
        let smallest = seen().filter(|run| run.fault.angle_deg.is_some()).min_by(|a, b| {
            let size = |run: &InjectedRun| run.fault.angle_deg.unwrap_or_default().abs();
            let delay = |run: &InjectedRun| run.delay_s.unwrap_or_default();
            // Of the same size the slowest, as what is stated shall hold of all.
            size(a).total_cmp(&size(b)).then(delay(b).total_cmp(&delay(a)))
        });
        Self {
            drives: drives.len(),
            driven_s,
            monitored_s,
            monitored_share: if driven_s > 0.0 { monitored_s / driven_s } else { 0.0 },
            alarms,
            alarms_per_hour: rate_per_hour(alarms, monitored_s / 3600.0),
            drives_with_alarms: drives.iter().filter(|d| !d.outcome.alarms.is_empty()).count(),
            largest_ratio: drives.iter().filter_map(|d| d.outcome.largest_ratio).reduce(f64::max),
            injected: injected().count(),
            injected_exposed: injected().filter(exposed).count(),
            injected_seen: seen().count(),
            smallest_seen_deg: smallest.and_then(|run| run.fault.angle_deg),
            smallest_seen_delay_s: smallest.and_then(|run| run.delay_s),
        }
    }
}

/// Alarms of a drive that are printed.
const PRINTED_ALARMS: usize = 10;

impl Summary {
    /// What `drives` showed.
    pub fn new(
        status: DesignStatus,
        design: String,
        fault_free: bool,
        drives: Vec<DriveReport>,
    ) -> Self {
        Self { status, design, fault_free, total: Total::of(&drives), drives }
    }

    /// Whether a drive that is said to be without a fault alarms.
    pub fn has_false_alarms(&self) -> bool {
        self.fault_free && self.total.alarms > 0
    }

    /// The same for people.
    pub fn text(&self) -> String {
        let mut text = String::new();
        for drive in &self.drives {
            text += &self.of_drive(drive);
            text.push('\n');
        }
        if self.drives.len() > 1 {
            text += &self.table();
            text.push('\n');
        }
        if self.total.injected > 0 {
            text += &self.injected();
            text.push('\n');
        }
        text + &self.of_all()
    }

    /// A drive: how it was read, and what it showed.
    fn of_drive(&self, drive: &DriveReport) -> String {
        let DriveReport { outcome, .. } = drive;
        let pieces = if drive.pieces == 1 { "" } else { "s, the detector starts anew in each" };
        let mut text = format!(
            "{}\n  {}; {} rows, {} piece{pieces}\n",
            drive.file.display(),
            drive.reading,
            drive.rows,
            drive.pieces
        );
        if drive.start_s.abs() >= 1.0 {
            text += &format!("  times count from {:.3} s of the file on\n", drive.start_s);
        }
        for line in &drive.columns {
            text += &format!("  {line}\n");
        }
        for warning in &drive.warnings {
            text += &format!("  warning: {warning}\n");
        }
        text += &format!(
            "  monitored {:.1} s of {:.1} s ({:.1} %)",
            outcome.monitored_s,
            outcome.driven_s,
            100.0 * outcome.monitored_share
        );
        for state in outcome.states.iter().filter(|state| state.state != "Monitoring") {
            let cause = if state.cause == "Nothing" { "" } else { state.cause };
            let cause = if cause.is_empty() { String::new() } else { format!(" by {cause}") };
            text += &format!("; {}{cause} {:.1} s", state.state, state.time_s);
        }
        text.push('\n');
        if outcome.not_excited_share > 0.0 {
            text += &format!(
                "  could not have seen the smallest fault of interest in {:.1} % of the time monitored\n",
                100.0 * outcome.not_excited_share
            );
        }
        if let Some((ratio, time_s)) = outcome.largest_ratio.zip(outcome.largest_ratio_s) {
            text += &format!("  largest J/J_th {ratio:.3} at {time_s:.2} s\n");
        }
        text += &alarms(outcome);
        for remark in &drive.remarks {
            text += &format!("  look: {remark}\n");
        }
        text
    }

    /// A line a drive.
    fn table(&self) -> String {
        let head = [
            ["drive", "driven", "monitored", "", "alarms", "first", "largest"],
            ["", "s", "s", "%", "", "s", "J/J_th"],
        ];
        let mut rows: Vec<Vec<String>> = head.map(|row| row.map(String::from).to_vec()).to_vec();
        for DriveReport { file, outcome, .. } in &self.drives {
            let or_none = |number: Option<String>| number.unwrap_or("-".into());
            rows.push(vec![
                file.file_name().unwrap_or_default().to_string_lossy().into_owned(),
                format!("{:.1}", outcome.driven_s),
                format!("{:.1}", outcome.monitored_s),
                format!("{:.1}", 100.0 * outcome.monitored_share),
                outcome.alarms.len().to_string(),
                or_none(outcome.alarms.first().map(|alarm| format!("{:.2}", alarm.time_s))),
                or_none(outcome.largest_ratio.map(|ratio| format!("{ratio:.3}"))),
            ]);
        }
        format!("Drives as recorded\n{}", aligned(&rows, "  "))
    }

    /// A line an injected fault.
    fn injected(&self) -> String {
        let head = [
            ["drive", "fault", "size", "from", "verdict", "delay", "by", "largest"],
            ["", "", "", "s", "", "s", "", "J/J_th"],
        ];
        let mut rows: Vec<Vec<String>> = head.map(|row| row.map(String::from).to_vec()).to_vec();
        for drive in &self.drives {
            for run in &drive.injected {
                let size = match (run.fault.angle_deg, run.fault.lost_share) {
                    (Some(angle_deg), _) => format!("{angle_deg:+} deg"),
                    (None, share) => format!("{:.0} %", 100.0 * share.unwrap_or_default()),
                };
                let or_none = |number: Option<String>| number.unwrap_or("-".into());
                rows.push(vec![
                    drive.file.file_name().unwrap_or_default().to_string_lossy().into_owned(),
                    run.fault.kind.name().into(),
                    size,
                    format!("{:.2}", run.fault.onset_s),
                    run.verdict.name().into(),
                    or_none(run.delay_s.map(|delay_s| format!("{delay_s:.2}"))),
                    or_none(run.cause.map(String::from)),
                    or_none(run.largest_ratio.map(|ratio| format!("{ratio:.2}"))),
                ]);
            }
        }
        format!(
            "Injected faults: actual less commanded angle at the road wheel, left positive; delays from the \
             first monitored sample\n{}",
            aligned(&rows, "  ")
        )
    }

    /// All drives together.
    fn of_all(&self) -> String {
        let total = &self.total;
        let plural = |number: u64| if number == 1 { "" } else { "s" };
        let mut text = format!(
            "{} drive{}, {:.3} h driven, {:.3} h monitored ({:.1} %)\n",
            total.drives,
            plural(total.drives as u64),
            total.driven_s / 3600.0,
            total.monitored_s / 3600.0,
            100.0 * total.monitored_share
        );
        let what = if self.fault_free { "false alarm" } else { "alarm" };
        let (alarms, with) = (total.alarms, total.drives_with_alarms);
        text += &format!("{alarms} {what}{}", plural(alarms));
        if with > 0 {
            text += &format!(" in {with} drive{}", plural(with as u64));
        }
        if let Some(Estimate { value, lower, upper }) = total.alarms_per_hour {
            text += &format!(
                ": {value:.2} an hour monitored, {:.0} % interval {lower:.2} to {upper:.2}",
                100.0 * CONFIDENCE
            );
        }
        text.push('\n');
        if let Some(ratio) = total.largest_ratio {
            text += &format!("largest J/J_th {ratio:.3}\n");
        }
        if total.injected > 0 {
            text += &format!(
                "{} of {} injected faults seen",
                total.injected_seen, total.injected_exposed
            );
            let hidden = total.injected - total.injected_exposed;
            if hidden > 0 {
                text += &format!(" ({hidden} more never acted while monitored, or an alarm stood)");
            }
            if let (Some(deg), Some(delay_s)) =
                (total.smallest_seen_deg, total.smallest_seen_delay_s)
            {
                text += &format!("; the smallest, {deg:+} deg, after {delay_s:.2} s");
            }
            text.push('\n');
        }
        text
    }
}

/// The alarms of a drive, a line each.
fn alarms(outcome: &Outcome) -> String {
    let mut text = String::new();
    for alarm in outcome.alarms.iter().take(PRINTED_ALARMS) {
        text += &format!(
            "  alarm at {:.2} s for {:.2} s by {} at {:.1} m/s: {:.2} times its threshold, at most {:.2}\n",
            alarm.time_s,
            alarm.duration_s,
            alarm.cause,
            alarm.v_x_m_per_s,
            alarm.size,
            alarm.largest_size
        );
    }
    match outcome.alarms.len().saturating_sub(PRINTED_ALARMS) {
        0 if outcome.alarms.is_empty() => text + "  no alarm\n",
        0 => text,
        more => text + &format!("  and {more} alarms more: summary.json has them\n"),
    }
}
