//! The detection table for people.

use crate::detection::Detection;
use crate::table::aligned;

/// One line for each run, and remarks below.
pub fn detection_table<'a>(detections: impl Iterator<Item = &'a Detection>) -> String {
    let head = [
        ["v_x(0)", "fault", "alarm", "delay", "J without fault", "threshold", "J with", "false"],
        ["m/s", "s", "s", "s", "after 2 s", "J_th", "fault", "alarms"],
    ];
    let mut rows: Vec<Vec<String>> = head.map(|row| row.map(String::from).to_vec()).to_vec();
    let mut remarks = String::new();
    for d in detections {
        rows.push(vec![
            d.initial_speed_m_per_s.to_string(),
            seconds(d.fault_onset_s),
            seconds(d.alarm_s),
            seconds(d.delay_s),
            format!("{:.6}", d.largest_fault_free_j_after_start_up),
            format!("{:.6}", d.threshold),
            format!("{:.6}", d.largest_faulty_j),
            d.false_alarms.to_string(),
        ]);
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
