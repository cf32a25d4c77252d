//! The detector alone, without FMI: a design and a table of signals, and when it raises its alarm.
//!
//! `cargo run --release -p steerguard-detector --features serde --example alarm -- design.json drive.csv`
//!
//! The table has a header and four columns, a row each sampling period: v_x (m/s), yaw rate (rad/s), drive torque
//! at the wheels (N m), steering angle at the road wheel (rad).

use std::error::Error;
use std::fs;

use steerguard_detector::{Configuration, Detector, Input, Measurement};

/// Indices of the samples at which alarms are raised.
pub fn alarms(design: &str, table: &str) -> Result<Vec<usize>, Box<dyn Error>> {
    // All that the detector needs is the design's key `detector`.
    let mut design: serde_json::Value = serde_json::from_str(design)?;
    let configuration: Configuration = serde_json::from_value(design["detector"].take())?;
    let mut detector = Detector::new(&configuration)?;

    let mut raised = Vec::new();
    let mut stands = false;
    for (k, line) in table.lines().skip(1).enumerate() {
        let row = line.split(',').map(str::parse).collect::<Result<Vec<f64>, _>>()?;
        let &[v_x_m_per_s, r_rad_per_s, t_eng_n_m, delta_rad] = row.as_slice() else {
            return Err(format!("line {}: {} columns instead of 4", k + 2, row.len()).into());
        };
        let y = Measurement { v_x_m_per_s, r_rad_per_s };
        let alarm = detector.sample(y, Input { t_eng_n_m, delta_rad }).alarm;
        if alarm && !stands {
            raised.push(k);
        }
        stands = alarm;
    }
    Ok(raised)
}

#[allow(dead_code)] // where a test includes this file
fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [design, table] = arguments.as_slice() else {
        return Err("usage: alarm design.json drive.csv".into());
    };
    let raised = alarms(&fs::read_to_string(design)?, &fs::read_to_string(table)?)?;
    match raised.first() {
        Some(first) => println!("{} alarms, the first at sample {first}", raised.len()),
        None => println!("no alarm"),
    }
    Ok(())
}
