//! What the command prints for people.

use crate::detection::Detection;
use crate::table::aligned;

/// Detection table: one line for each run.
pub fn detection_table<'a>(detections: impl Iterator<Item = &'a Detection>) -> String {
    let head = [
        ["v_x(0)", "fault", "alarm", "delay", "J without fault", "threshold", "J with", "false"],
        ["m/s", "s", "s", "s", "all   > 2 s", "J_th", "fault", "alarms"],
    ];
    let mut rows: Vec<Vec<String>> = head.map(|row| row.map(String::from).to_vec()).to_vec();
    let time = |time: Option<f64>| time.map_or("-".to_owned(), |time| format!("{time:.2}"));
    let mut remarks = String::new();
    for d in detections {
        rows.push(vec![
            d.initial_speed_m_per_s.to_string(),
            time(d.fault_onset_s),
            time(d.alarm_s),
            time(d.delay_s),
            format!("{:.5} {:.5}", d.largest_fault_free_j, d.largest_fault_free_j_after_start_up),
            format!("{:.5}", d.threshold),
            format!("{:.5}", d.largest_faulty_j),
            d.false_alarms.to_string(),
        ]);
        if d.monitored_share < 1.0 {
            remarks += &format!(
                "  {} m/s: outside the range of the design at {:.1} % of the samples, alarm withheld\n",
                d.initial_speed_m_per_s,
                100.0 * (1.0 - d.monitored_share)
            );
        }
    }
    aligned(&rows, "  ", false) + &remarks
}
