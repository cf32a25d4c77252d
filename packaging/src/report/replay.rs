//! What a replay's folder adds to a page: recorded drives, as they are and with injected faults.

use std::path::Path;

use serde::Deserialize;

use super::html::{Cells, paragraph, table};

/// What `summary.json` says, as far as the page tells it.
#[derive(Clone, Debug, Deserialize, PartialEq)]
pub struct Summary {
    /// Hash of the design that was driven.
    pub design: String,
    fault_free: bool,
    total: Total,
    drives: Vec<Drive>,
}

#[derive(Clone, Debug, Deserialize, PartialEq)]
struct Total {
    drives: usize,
    driven_s: f64,
    monitored_share: f64,
    alarms: u64,
    largest_ratio: Option<f64>,
    injected: usize,
    injected_exposed: usize,
    injected_seen: usize,
    smallest_seen_deg: Option<f64>,
}

#[derive(Clone, Debug, Deserialize, PartialEq)]
struct Drive {
    file: String,
    driven_s: f64,
    monitored_share: f64,
    alarms: Vec<serde::de::IgnoredAny>,
    largest_ratio: Option<f64>,
    injected: Vec<Injected>,
}

impl Drive {
    /// Its file, without the folders.
    fn name(&self) -> String {
        let path = Path::new(&self.file);
        path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned()
    }
}

/// An injected fault.
#[derive(Clone, Debug, Deserialize, PartialEq)]
struct Injected {
    kind: String,
    angle_deg: Option<f64>,
    lost_share: Option<f64>,
    onset_s: f64,
    verdict: String,
    delay_s: Option<f64>,
    cause: Option<String>,
    largest_ratio: Option<f64>,
}

impl Injected {
    /// What is looked for first: a phone shows no more than that.
    fn row(&self, drive: &Drive) -> Vec<String> {
        let size = match (self.angle_deg, self.lost_share) {
            (Some(angle_deg), _) => format!("{angle_deg:+} deg"),
            (None, share) => format!("{:.0} %", 100.0 * share.unwrap_or_default()),
        };
        vec![
            self.kind.clone(),
            size,
            self.verdict.clone(),
            or_none(self.delay_s),
            self.cause.clone().unwrap_or("-".into()),
            format!("{:.1}", self.onset_s),
            or_none(self.largest_ratio),
            drive.name(),
        ]
    }
}

fn or_none(number: Option<f64>) -> String {
    number.map_or("-".into(), |number| format!("{number:.2}"))
}

/// A table with this head.
fn headed<const N: usize>(
    caption: &str,
    head: [&str; N],
    rows: impl Iterator<Item = Vec<String>>,
) -> String {
    let head = head.map(String::from).to_vec();
    let rows: Vec<Vec<String>> = std::iter::once(head).chain(rows).collect();
    table(caption, Cells::Figures, &rows)
}

/// A replay.
#[derive(Clone, Debug, PartialEq)]
pub struct Replay {
    /// Where it lies.
    pub folder: String,
    /// What it showed.
    pub summary: Summary,
}

impl Replay {
    /// What the page says of it.
    pub fn html(&self) -> String {
        let Summary { fault_free, total, drives, .. } = &self.summary;
        let said = if *fault_free { ", said to be without a fault" } else { "" };
        let mut text = format!(
            "{} recorded {}{said}, {:.1} minutes, through the packaged FMU: monitored {:.1} %, {} alarms",
            total.drives,
            if total.drives == 1 { "drive" } else { "drives" },
            total.driven_s / 60.0,
            100.0 * total.monitored_share,
            total.alarms
        );
        if let Some(ratio) = total.largest_ratio {
            text += &format!(", largest J/J_th {ratio:.2}");
        }
        text += ".";
        if total.injected > 0 {
            text += &format!(
                " Of {} injected faults {} acted while it monitored and no alarm stood; of these {} were seen",
                total.injected, total.injected_exposed, total.injected_seen
            );
            if let Some(deg) = total.smallest_seen_deg {
                text += &format!(", the smallest of {:.2} degrees", deg.abs());
            }
            text += ".";
        }
        let recorded = drives.iter().map(|x| {
            vec![
                x.name(),
                format!("{:.1}", x.driven_s),
                format!("{:.1}", 100.0 * x.monitored_share),
                x.alarms.len().to_string(),
                or_none(x.largest_ratio),
            ]
        });
        let head = ["drive", "s", "monitored %", "alarms", "largest J/J_th"];
        let mut html = paragraph(&text) + &headed("Recorded drives", head, recorded);
        if total.injected > 0 {
            let injected = drives.iter().flat_map(|x| x.injected.iter().map(|fault| fault.row(x)));
            let head =
                ["fault", "size", "verdict", "delay s", "by", "from s", "largest J/J_th", "drive"];
            html += &headed("Injected faults", head, injected);
        }
        html
    }
}
