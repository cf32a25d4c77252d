//! The packaged FMUs, as an importer finds them.

#![allow(clippy::unwrap_used)]

mod common;
#[path = "common/fmu.rs"]
mod fmu;

use std::collections::BTreeSet;
use std::io::{Cursor, Read};

use object::{Object as _, ObjectSymbol as _};
use steerguard::drive::cosimulation;
use steerguard::drive::detection::Detection;
use steerguard::drive::scenario::{Scenario, SensorNoise};
use steerguard::fmu::package::{detector_fmu, plant_fmu};
use steerguard::fmu::runtime::Runtimes;
use steerguard::importer::Type;
use steerguard::platform::Platform;
use steerguard::report::design_summary::Record;
use steerguard_fmi2::Function;
use steerguard_model_description::{names, xml};

use fmu::open;

/// Symbols of the C library that the runtimes may use.
const ALLOWED: [&str; 12] = [
    "calloc",
    "free",
    "memcpy",
    "memmove",
    "memset",
    "memcmp",
    "bcmp",
    "strlen",
    "__cxa_finalize",
    "__gmon_start__",
    "_ITM_deregisterTMCloneTable",
    "_ITM_registerTMCloneTable",
];

fn detector() -> Vec<u8> {
    detector_fmu(&common::design(), &Record::default(), &Runtimes::detector()).unwrap()
}

fn plant() -> Vec<u8> {
    plant_fmu(&Runtimes::plant()).unwrap()
}

fn entry(fmu: &[u8], name: &str) -> Vec<u8> {
    let mut zip = zip::ZipArchive::new(Cursor::new(fmu)).unwrap();
    let mut bytes = Vec::new();
    zip.by_name(name).unwrap().read_to_end(&mut bytes).unwrap();
    bytes
}

#[test]
fn packaging_twice_gives_the_same_bytes() {
    assert_eq!(detector(), detector());
    assert_eq!(plant(), plant());
}

#[test]
fn another_design_is_another_guid() {
    let mut other = common::design();
    other.configuration.gains.n[2][1][1] *= 1.0 + f64::EPSILON;
    other.hash[0] = b'f';
    let other = detector_fmu(&other, &Record::default(), &Runtimes::detector()).unwrap();
    let guid = |fmu: &[u8]| open(fmu).description().guid.clone();
    assert_ne!(guid(&detector()), guid(&other));
}

#[test]
fn the_archive_holds_what_an_fmu_holds() {
    for (fmu, identifier) in [(detector(), names::DETECTOR), (plant(), names::PLANT)] {
        let zip = zip::ZipArchive::new(Cursor::new(&fmu)).unwrap();
        let names: Vec<_> = zip.file_names().map(|name| name.unwrap().into_owned()).collect();
        assert_eq!(
            names,
            [
                "modelDescription.xml",
                &Platform::HOST.unwrap().library_path(identifier),
                "documentation/index.html",
                "documentation/licenses/LICENSE-APACHE",
                "documentation/licenses/LICENSE-MIT",
                "documentation/licenses/crc.txt",
                "documentation/licenses/libm.txt",
                "documentation/sbom.cdx.json",
                &format!("extra/{identifier}_in.csv"),
                &format!("extra/{identifier}_ref.csv"),
                "model.png",
            ]
        );
        let icon = entry(&fmu, "model.png");
        let side = |at: usize| u32::from_be_bytes(icon[at..at + 4].try_into().unwrap());
        assert!(side(16) >= 200 && side(20) >= 200, "size of the icon");
        let page = String::from_utf8(entry(&fmu, "documentation/index.html")).unwrap();
        assert!(page.contains(identifier) && !page.contains("http"), "page is self-contained");
    }
}

#[test]
fn the_descriptions_have_no_finding() {
    for fmu in [detector(), plant()] {
        let text = String::from_utf8(entry(&fmu, "modelDescription.xml")).unwrap();
        assert_eq!(xml::lint(&text), []);
    }
}

#[test]
#[cfg(target_os = "linux")]
fn the_libraries_export_fmi2_and_need_next_to_nothing() {
    for (fmu, identifier) in [(detector(), names::DETECTOR), (plant(), names::PLANT)] {
        let library = entry(&fmu, &Platform::HOST.unwrap().library_path(identifier));
        assert!(library.len() < 160_000, "{identifier}: {} bytes", library.len());
        let text = String::from_utf8_lossy(&library);
        assert!(!text.contains("panic"), "{identifier}: panic machinery");

        let file = object::File::parse(&*library).unwrap();
        let names = |defined: bool| -> BTreeSet<String> {
            file.dynamic_symbols()
                .filter(|symbol| symbol.is_undefined() != defined)
                .map(|symbol| symbol.name().unwrap().to_owned())
                .filter(|name| !name.is_empty())
                .collect()
        };
        let functions = Function::ALL.iter().map(|function| function.name().to_owned()).collect();
        assert_eq!(names(true), functions, "{identifier}: exported symbols");
        let allowed = ALLOWED.map(String::from).into();
        let needed = names(false);
        assert!(needed.is_subset(&allowed), "{identifier}: {:?}", needed.difference(&allowed));

        let libraries: Vec<String> = needed_libraries(&library);
        assert!(
            libraries.iter().all(|name| name == "libc.so.6" || name == "libm.so.6"),
            "{identifier}: {libraries:?}"
        );
    }
}

/// DT_NEEDED entries of an ELF file.
#[cfg(target_os = "linux")]
fn needed_libraries(library: &[u8]) -> Vec<String> {
    use object::elf::DT_NEEDED;
    use object::read::elf::{Dyn as _, ElfFile64};
    let file: ElfFile64<'_> = ElfFile64::parse(library).unwrap();
    let (endian, sections) = (file.endian(), file.elf_section_table());
    let (entries, link) = sections.dynamic(endian, library).unwrap().unwrap();
    let strings = sections.strings(endian, library, link).unwrap();
    entries
        .iter()
        .filter(|entry| entry.tag(endian) == DT_NEEDED)
        .map(|entry| String::from_utf8(entry.string(endian, strings).unwrap().to_vec()).unwrap())
        .collect()
}

#[test]
fn a_wrong_guid_is_refused_with_a_reason() {
    let fmu = open(&detector());
    let error = fmu.instantiate_with_guid("wrong", "{00000000}").err().unwrap();
    assert_eq!((error.function, error.status), ("fmi2Instantiate", None));
    assert!(error.to_string().contains("GUID"), "{error}");
}

#[test]
fn an_unbaked_library_is_refused_with_a_reason() {
    let mut archive =
        steerguard::fmu::archive::Archive::new(entry(&detector(), "modelDescription.xml"));
    let platform = Platform::HOST.unwrap();
    let library = Runtimes::detector().0.remove(&platform).unwrap();
    archive.insert(platform.library_path(names::DETECTOR), library);
    let error = open(&archive.to_bytes().unwrap()).instantiate("unbaked").err().unwrap();
    assert!(error.to_string().contains("no design is baked"), "{error}");
}

#[test]
fn not_a_number_is_held_and_reported() {
    let fmu = open(&detector());
    let mut instance = fmu.instantiate("detector").unwrap();
    instance.setup_experiment(1.0).unwrap();
    instance.enter_initialization_mode().unwrap();
    instance.exit_initialization_mode().unwrap();
    let inputs = fmu.reals(["v_x", "r", "u.T_eng", "u.delta"]).unwrap();
    let j_rms = fmu.reals(["J_rms"]).unwrap();
    let state = fmu.variable("state", Type::Enumeration).unwrap();

    instance.set_real(inputs, [15.0, 0.01, 78.75, 0.0]).unwrap();
    instance.do_step(0.0, 0.1).unwrap();
    let before = instance.get_real(j_rms).unwrap();
    instance.take_log();
    instance.set_real(inputs, [15.0, f64::NAN, 78.75, 0.0]).unwrap();
    instance.do_step(0.1, 0.1).unwrap();
    assert_eq!(instance.get_real(j_rms).unwrap(), before);
    assert_eq!(instance.get_integer([state]).unwrap(), [4]);
    let log = instance.take_log();
    assert_eq!(log.len(), 1, "one warning for each episode: {log:?}");
}

#[test]
fn a_design_is_found_again_in_the_fmu() {
    let fmu = open(&detector());
    let instance = fmu.instantiate("detector").unwrap();
    let hash = instance.get_string(fmu.variable("design.hash", Type::String).unwrap()).unwrap();
    assert_eq!(hash.as_bytes(), common::design().hash);
    let [mass] = instance.get_real(fmu.reals(["vehicle.M_v"]).unwrap()).unwrap();
    assert_eq!(mass, 1476.0);
    let error = fmu.variable("no.such", Type::Real).unwrap_err();
    assert!(error.to_string().contains("no variable `no.such` of type Real"), "{error}");
}

#[test]
fn both_fmus_run_together() {
    let (detector, plant) = (open(&detector()), open(&plant()));
    // Without noise: what the test's own gains make of it says nothing.
    let sensor_noise = SensorNoise::default();
    let scenario = Scenario { duration_s: 8.0, sensor_noise, ..Scenario::default() };
    let run = cosimulation::run(&detector, &plant, &scenario, 15.0).unwrap();
    assert_eq!(run.samples.len(), 800);
    let detection = Detection::of(&run);
    assert_eq!(detection.fault_onset_s, Some(5.0));
    assert!(detection.largest_faulty_j > detection.largest_fault_free_j_after_start_up);
    let held = run.samples.iter().all(|sample| (sample.v_x - 15.0).abs() < 1.0);
    assert!(held, "the drive torque holds the speed");
    // A second run starts afresh.
    assert_eq!(cosimulation::run(&detector, &plant, &scenario, 15.0).unwrap(), run);
}
