//! Method "gap" against method "paper" in the co-simulation, with sensor noise.

#![allow(clippy::unwrap_used)]

#[path = "../../designer/tests/common/designed.rs"]
mod designed;
#[path = "common/fmu.rs"]
mod fmu;

use steerguard::drive::cosimulation::{self, Sample};
use steerguard::drive::scenario::{Scenario, Signal};
use steerguard::fmu::package::{detector_fmu, plant_fmu};
use steerguard::fmu::runtime::Runtimes;
use steerguard::report::design_summary::{Record, baked};
use steerguard_designer::{Design, DesignStatus, Spec};
use steerguard_test_support::cases::ReferenceCase;

use designed::designed;
use fmu::open;

/// Few drives in the calibration.
const FEW_DRIVES: &str = r#"
    [evaluation.calibration]
    speeds = 2
    manoeuvres = ["straight"]
    disturbance_frequencies = 2
    disturbance_phases = 2
    initial_v_y_m_per_s = [0]
    search_drives = 0
"#;

fn designed_by(method: &str) -> Design {
    let [s1, s2] = ["s1", "s2"].map(|case| ReferenceCase::read(case).spec);
    let text = format!("design.method = \"{method}\"\n{s1}{s2}{FEW_DRIVES}");
    designed(&Spec::from_toml(&text).unwrap()).unwrap()
}

/// J without and with a fault of 1 degree, both without their transients: the largest, the smallest.
fn levels(design: &Design, speed: f64) -> (f64, f64) {
    let detector = open(
        &detector_fmu(&baked(design).unwrap(), &Record::default(), &Runtimes::detector()).unwrap(),
    );
    let plant = open(&plant_fmu(&Runtimes::plant()).unwrap());
    let scenario = Scenario {
        steering_fault_deg: Signal { offset: 1.0, start_s: 10.0, ..Signal::default() },
        ..Scenario::default()
    };
    let run = cosimulation::run(&detector, &plant, &scenario, speed).unwrap();
    let j = |from: f64, to: f64| {
        let within = move |sample: &&Sample| from <= sample.time && sample.time < to;
        run.samples.iter().filter(within).map(|sample| sample.j_rms)
    };
    (j(3.0, 10.0).fold(0.0, f64::max), j(12.0, 20.0).fold(f64::INFINITY, f64::min))
}

#[test]
fn the_fault_stands_out_of_noise_by_method_gap_and_drowns_by_method_paper() {
    let [gap, paper] = ["gap", "paper"].map(designed_by);
    assert_eq!(gap.synthesis.status, DesignStatus::Certified);
    let reference = ReferenceCase::read("s2");
    reference.check("detection_ratio_by_search", gap.performance.detection_ratio);
    reference.check("detection_ratio_by_papers_constants", paper.performance.detection_ratio);
    for speed in [10.0, 25.0] {
        let [(quiet, faulty), (papers_quiet, papers_faulty)] =
            [&gap, &paper].map(|design| levels(design, speed));
        println!(
            "{speed} m/s: gap J {quiet:.6} without, {faulty:.6} with the fault ({:.2}); paper J \
             {papers_quiet:.6}, {papers_faulty:.6} ({:.2})",
            faulty / quiet,
            papers_faulty / papers_quiet,
        );
        assert!(faulty > 5.0 * quiet, "{speed} m/s: {faulty}, {quiet}");
        assert!(faulty / quiet > 2.0 * papers_faulty / papers_quiet, "{speed} m/s");
    }
}
