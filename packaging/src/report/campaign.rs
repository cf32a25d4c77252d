//! What a campaign's folder adds to a page: detections by size, delays, false alarms.

use serde::Deserialize;

use super::chart::{Chart, Dash, Line, Scale};
use super::html::{Cells, paragraph, table};
use crate::campaign::names::FaultName;
use crate::campaign::report::{Detections, FalseAlarms, Report, number};
use crate::campaign::statistics::Estimate;
use crate::drive::figure::PlotError;

/// What `campaign.json` says of the drives.
#[derive(Clone, Debug, Deserialize, PartialEq)]
pub struct Settings {
    /// Hash of the design that was driven.
    pub design: String,
    /// Seed.
    pub seed: u64,
    /// Number of drives.
    pub drives: u64,
    /// Length of each, s.
    pub duration_s: f64,
    /// Mix of manoeuvres and faults.
    pub mix: String,
    /// Kinds of faults.
    pub faults: String,
}

/// A campaign.
#[derive(Clone, Debug, PartialEq)]
pub struct Campaign {
    /// Where it lies.
    pub folder: String,
    /// Its drives.
    pub settings: Settings,
    /// Its figures.
    pub figures: Report,
}

impl Campaign {
    /// What the page says of it.
    ///
    /// # Errors
    /// [`PlotError`] if the drawing library refuses.
    pub fn html(&self) -> Result<String, PlotError> {
        let Self { settings, figures, .. } = self;
        let mut html = paragraph(&format!(
            "{} random drives of {} s through the packaged FMUs (seed {}, mix {}, faults {}): {:.2} h driven, {:.2} h \
             monitored. In {:.1} % of the time monitored the smallest fault of interest could not have been seen. \
             Intervals are exact, 95 %.",
            settings.drives,
            settings.duration_s,
            settings.seed,
            settings.mix,
            settings.faults,
            figures.driven_h,
            figures.monitored_h,
            100.0 * figures.not_excited_share
        ));
        let sizes = bins(&figures.detections_by_size);
        if sizes.len() > 1 {
            html += "<div class=\"charts\">\n";
            html += &probability(&sizes).figure()?;
            html += &delay(&sizes).figure()?;
            html += "</div>\n";
        }
        html += &table("False alarms", Cells::Figures, &false_alarms(&figures.false_alarms));
        let all: Vec<&Detections> =
            figures.detections.iter().filter(|x| x.group == "all").collect();
        if !all.is_empty() {
            html += &table("Faults by kind", Cells::Figures, &detections(&all));
        }
        let by_size: Vec<&Detections> = figures.detections_by_size.iter().collect();
        if !by_size.is_empty() {
            html += &table("Faults by kind and size", Cells::Figures, &detections(&by_size));
        }
        Ok(html)
    }
}

/// A size class of biases.
struct Bin<'a> {
    middle_deg: f64,
    of: &'a Detections,
}

fn bins(by_size: &[Detections]) -> Vec<Bin<'_>> {
    let biases = by_size.iter().filter(|x| x.kind == FaultName::Bias);
    biases.filter_map(|of| Some(Bin { middle_deg: middle_deg(&of.group)?, of })).collect()
}

/// Of a group such as `0.3 to 0.5 deg`.
fn middle_deg(group: &str) -> Option<f64> {
    let mut numbers = group.split_whitespace().filter_map(|word| word.parse::<f64>().ok());
    Some(0.5 * (numbers.next()? + numbers.next()?))
}

fn probability(bins: &[Bin<'_>]) -> Chart {
    let line = |name: &str, dash, of: fn(&Estimate) -> f64| Line {
        name: name.into(),
        points: bins
            .iter()
            .filter_map(|bin| Some((bin.middle_deg, of(bin.of.probability.as_ref()?))))
            .collect(),
        color: 0,
        dash,
    };
    Chart {
        title: "Biases: probability of detection by size".into(),
        alt: "Probability of detection over the size of a bias with its 95 % interval; the table below has the figures"
            .into(),
        x: sizes(bins),
        y: Scale::linear("probability", 0.0..1.0),
        areas: Vec::new(),
        lines: vec![
            line("detected", Dash::Solid, |x| x.value),
            line("95 % interval", Dash::Dotted, |x| x.lower),
            line("", Dash::Dotted, |x| x.upper),
        ],
        shades: None,
    }
}

fn delay(bins: &[Bin<'_>]) -> Chart {
    let line = |name: &str, color, dash, of: fn(&Detections) -> Option<f64>| Line {
        name: name.into(),
        points: bins.iter().filter_map(|bin| Some((bin.middle_deg, of(bin.of)?))).collect(),
        color,
        dash,
    };
    let lines = vec![
        line("median", 0, Dash::Solid, |x| x.delay_median_s),
        line("95 of 100", 1, Dash::Dashed, |x| x.delay_95_s),
    ];
    let most = lines.iter().flat_map(|x| &x.points).map(|(_, y)| *y).fold(0.0, f64::max);
    Chart {
        title: "Biases: delay by size".into(),
        alt: "Delay from the fault to the alarm over the size of a bias; the table below has the figures".into(),
        x: sizes(bins),
        y: Scale::linear("delay [s]", 0.0..(1.1 * most).max(0.1)),
        areas: Vec::new(),
        lines,
        shades: None,
    }
}

fn sizes(bins: &[Bin<'_>]) -> Scale {
    let most = bins.iter().map(|bin| bin.middle_deg).fold(0.1, f64::max);
    Scale::linear("size [deg]", 0.0..most)
}

fn interval(estimate: Option<Estimate>, decimals: usize) -> String {
    estimate.map_or("-".into(), |Estimate { value, lower, upper }| {
        format!("{value:.decimals$} ({lower:.decimals$} to {upper:.decimals$})")
    })
}

fn false_alarms(groups: &[FalseAlarms]) -> Vec<Vec<String>> {
    let head = ["drives", "number", "h monitored", "episodes", "an hour", "largest J/J_th"];
    let rows = groups.iter().map(|x| {
        vec![
            x.group.clone(),
            x.drives.to_string(),
            format!("{:.2}", x.hours),
            x.episodes.to_string(),
            interval(x.per_hour, 2),
            number(x.largest_ratio, 2),
        ]
    });
    std::iter::once(head.map(String::from).to_vec()).chain(rows).collect()
}

fn detections(groups: &[&Detections]) -> Vec<Vec<String>> {
    let head = [
        "fault",
        "which",
        "detected",
        "missed",
        "probability",
        "median s",
        "95 % s",
        "surely from deg",
    ];
    let rows = groups.iter().map(|x| {
        vec![
            x.kind.name().into(),
            x.group.clone(),
            x.detected.to_string(),
            x.missed.to_string(),
            interval(x.probability, 3),
            number(x.delay_median_s, 2),
            number(x.delay_95_s, 2),
            number(x.surely_detected_deg, 2),
        ]
    });
    std::iter::once(head.map(String::from).to_vec()).chain(rows).collect()
}
