//! The connected system: reproducible, and its FMUs are the packaged ones.

#![allow(clippy::unwrap_used)]

mod common;

use std::io::{Cursor, Read};

use steerguard::check::check;
use steerguard::fmu::package::{detector_fmu, plant_fmu};
use steerguard::fmu::runtime::Runtimes;
use steerguard::fmu::system::system_ssp;
use steerguard::report::design_summary::Record;
use steerguard_fmu::BakedDesign;

fn system(design: &BakedDesign) -> Vec<u8> {
    system_ssp(design, &Record::default(), &Runtimes::detector(), &Runtimes::plant()).unwrap()
}

fn entry(ssp: &[u8], name: &str) -> Vec<u8> {
    let mut zip = zip::ZipArchive::new(Cursor::new(ssp)).unwrap();
    let mut bytes = Vec::new();
    zip.by_name(name).unwrap().read_to_end(&mut bytes).unwrap();
    bytes
}

#[test]
fn packaging_twice_gives_the_same_bytes() {
    assert_eq!(system(&common::design()), system(&common::design()));
}

#[test]
fn the_fmus_are_the_packaged_ones() {
    let ssp = system(&common::design());
    let detector = entry(&ssp, "resources/SteeringFaultDetector.fmu");
    assert_eq!(
        detector,
        detector_fmu(&common::design(), &Record::default(), &Runtimes::detector()).unwrap()
    );
    let plant = entry(&ssp, "resources/VehiclePlant.fmu");
    assert_eq!(plant, plant_fmu(&Runtimes::plant()).unwrap());
    for fmu in [detector, plant] {
        assert_eq!(check(Cursor::new(fmu), "inner").unwrap(), []);
    }
}

#[test]
fn parameters_follow_the_design() {
    let mut heavy = common::design();
    heavy.configuration.model.vehicle.mass_kg = 3500.25;
    heavy.configuration.model.range.v_x.max = 25.0;
    let text = |design| {
        String::from_utf8(entry(&system(design), "resources/SteeringFaultSystem.ssv")).unwrap()
    };
    let (paper, heavy) = (text(&common::design()), text(&heavy));
    let value = |text: &str, name: &str| {
        let rest = text.split_once(&format!("name=\"{name}\">")).unwrap().1;
        let value = rest.split_once("value=\"").unwrap().1.split_once('"').unwrap().0;
        value.parse::<f64>().unwrap()
    };
    assert_eq!(value(&paper, "plant.vehicle.M_v"), 1476.0);
    assert_eq!(value(&heavy, "plant.vehicle.M_v"), 3500.25);
    // The middle of the design range, and the torque that holds it.
    assert_eq!(value(&paper, "plant.initial.v_x"), 17.5);
    assert_eq!(value(&heavy, "plant.initial.v_x"), 15.0);
    assert_eq!(value(&heavy, "u_T_eng"), 0.35 * 15.0 * 15.0);
}
