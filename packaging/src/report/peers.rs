//! What a comparison with other detectors adds to a page: the file that tests/peers writes with `--output`.

use serde::Deserialize;

use super::html::{Cells, paragraph, table};

/// The comparison.
#[derive(Clone, Debug, Deserialize, PartialEq)]
pub struct Peers {
    conditions: Vec<Condition>,
}

#[derive(Clone, Debug, Deserialize, PartialEq)]
struct Condition {
    driven: String,
    set_on: String,
    fault_free_hours: f64,
    detectors: Vec<Detector>,
}

#[derive(Clone, Debug, Deserialize, PartialEq)]
struct Detector {
    detector: String,
    detected: u64,
    missed: u64,
    largest_missed_deg: Option<f64>,
    one_degree_delay_median_s: Option<f64>,
    one_degree_delay_95_s: Option<f64>,
    half_a_degree_delay_median_s: Option<f64>,
    half_a_degree_delay_95_s: Option<f64>,
}

impl Peers {
    /// What the page says of it.
    pub fn html(&self) -> String {
        let number = |x: Option<f64>| x.map_or("-".into(), |x| format!("{x:.2}"));
        let both = |median, late| format!("{} / {}", number(median), number(late));
        let mut html = paragraph(
            "Other detectors on the same drives, thresholds at the same rate of false alarms but for steerguard as shipped. \
             Delays are the median and 95 of 100, s.",
        );
        for condition in &self.conditions {
            let head = ["detector", "detected", "missed", "largest missed deg", "1 deg", "0.5 deg"];
            let rows = condition.detectors.iter().map(|x| {
                vec![
                    x.detector.clone(),
                    x.detected.to_string(),
                    x.missed.to_string(),
                    number(x.largest_missed_deg),
                    both(x.one_degree_delay_median_s, x.one_degree_delay_95_s),
                    both(x.half_a_degree_delay_median_s, x.half_a_degree_delay_95_s),
                ]
            });
            let rows: Vec<Vec<String>> =
                std::iter::once(head.map(String::from).to_vec()).chain(rows).collect();
            let caption = format!(
                "Vehicles {}, thresholds set on {} vehicles, {:.1} h without a fault",
                condition.driven, condition.set_on, condition.fault_free_hours
            );
            html += &table(&caption, Cells::Figures, &rows);
        }
        html
    }
}
