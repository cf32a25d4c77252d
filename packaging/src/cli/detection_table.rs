//! The detection table for people.

use crate::drive::detection::Detection;
use crate::output::table::aligned;

/// One line for each run, and remarks below.
pub fn detection_table<'a>(detections: impl Iterator<Item = &'a Detection>) -> String {
    let head = [
        ["v_x(0)", "fault", "alarm", "delay", "false", "largest J", "after", "J_th", "largest J"],
        ["m/s", "s", "s", "s", "alarms", "no fault", "2 s", "", "fault"],
    ];
    let mut rows: Vec<Vec<String>> = head.map(|row| row.map(String::from).to_vec()).to_vec();
    let mut remarks = String::new();
    for d in detections {
        let j = |j: f64| {
            if d.monitored_share > 0.0 { format!("{j:.6}") } else { "-".to_owned() }
        };
        rows.push(vec![
            d.initial_speed_m_per_s.to_string(),
            seconds(d.fault_onset_s),
            seconds(d.alarm_s),
            seconds(d.delay_s),
            d.false_alarms.to_string(),
            j(d.largest_fault_free_j),
            j(d.largest_fault_free_j_after_start_up),
            j(d.threshold),
            j(d.largest_faulty_j),
        ]);
        if let Some(ratio) = d.largest_fault_free_ratio.filter(|&ratio| ratio >= 1.0) {
            remarks += &format!(
                "  At {} m/s J/J_th came to {ratio:.4} without a fault.\n",
                d.initial_speed_m_per_s
            );
        }
        if d.monitored_share < 1.0 {
            remarks += &format!(
                "  At {} m/s the vehicle was outside the armed range in {:.1} % of the samples: \
                 alarm withheld.\n",
                d.initial_speed_m_per_s,
                100.0 * (1.0 - d.monitored_share)
            );
        }
    }
    aligned(&rows, "  ") + &remarks
}

fn seconds(time_s: Option<f64>) -> String {
    time_s.map_or("-".to_owned(), |time_s| format!("{time_s:.2}"))
}
