//! What a replay's folder adds to a page: recorded drives, as they are and with injected faults.

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
    injected: Vec<serde::de::IgnoredAny>,
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
                " Of {} injected faults {} were seen",
                total.injected, total.injected_seen
            );
            if let Some(deg) = total.smallest_seen_deg {
                text += &format!(", the smallest of {:.2} degrees", deg.abs());
            }
            text += ".";
        }
        let head = ["drive", "s", "monitored %", "alarms", "largest J/J_th", "faults injected"];
        let rows = drives.iter().map(|x| {
            vec![
                x.file.clone(),
                format!("{:.1}", x.driven_s),
                format!("{:.1}", 100.0 * x.monitored_share),
                x.alarms.len().to_string(),
                x.largest_ratio.map_or("-".into(), |ratio| format!("{ratio:.2}")),
                x.injected.len().to_string(),
            ]
        });
        let rows: Vec<Vec<String>> =
            std::iter::once(head.map(String::from).to_vec()).chain(rows).collect();
        paragraph(&text) + &table("Recorded drives", Cells::Figures, &rows)
    }
}
