//! From a specification to a running detector: designed, proven by another crate, and run a sample.
//!
//!     cargo run --release -p steerguard-designer --example design

use std::error::Error;

use steerguard_designer::{Spec, design};
use steerguard_detector::{Detector, Input, Measurement};
use steerguard_verify::verify;

/// Whatever is left out has its default; the calibration is short.
const SPECIFICATION: &str = r#"
[vehicle]
mass_kg = 1476.0

[[fault]]
channel = "steering"
smallest_deg = 1.0

[design]
method = "paper"

[evaluation.calibration]
speeds = 2
manoeuvres = ["straight", "step_steer"]
"#;

fn main() -> Result<(), Box<dyn Error>> {
    let spec = Spec::from_toml(SPECIFICATION)?;
    let design = design(&spec, &mut |_| {})?;

    // What anyone can do who has the file.
    let verdict = verify(&design.to_json()?)?;
    println!("{verdict}");

    let mut detector = Detector::new(&design.configuration())?;
    let y = Measurement { v_x_m_per_s: 15.0, r_rad_per_s: 0.02 };
    let u = Input { t_eng_n_m: 80.0, delta_rad: 0.004 };
    let output = detector.sample(y, u);
    println!("J {:.6}, threshold {:.6}, alarm {}", output.j_rms, output.j_th, output.alarm);
    Ok(())
}
