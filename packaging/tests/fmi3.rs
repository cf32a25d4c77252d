//! The detector packaged in FMI 3.0: its archive, what `check` finds wrong with others, the command.

#![allow(clippy::unwrap_used)]

#[path = "common/command.rs"]
mod command;
mod common;

use std::collections::{BTreeMap, BTreeSet};
use std::io::{Cursor, Read, Write};
use std::path::Path;
use std::sync::LazyLock;

use steerguard::check::check;
use steerguard::fmu::package::{PackageError, detector_fmi3, detector_fmu};
use steerguard::fmu::runtime::{Runtimes, is_for_fmi3};
use steerguard::importer::Fmu;
use steerguard::platform::Platform;
use steerguard::report::design_summary::Record;
use steerguard_model_description::names;
use steerguard_model_description::xml::{Finding, header};
use zip::write::SimpleFileOptions;
use zip::{ZipArchive, ZipWriter};

use command::{failure, success};

type Entries = BTreeMap<String, Vec<u8>>;

static FMU: LazyLock<Vec<u8>> = LazyLock::new(package);

const DESCRIPTION: &str = "modelDescription.xml";
const TERMINALS: &str = "terminalsAndIcons/terminalsAndIcons.xml";

fn package() -> Vec<u8> {
    detector_fmi3(&common::design(), &Record::default(), &Runtimes::detector_fmi3()).unwrap()
}

fn platform() -> Platform {
    Platform::HOST.unwrap().of_fmi3()[0]
}

fn entries(fmu: &[u8]) -> Entries {
    let mut zip = ZipArchive::new(Cursor::new(fmu)).unwrap();
    let count = zip.len();
    let entry = |index| {
        let mut entry = zip.by_index(index).unwrap();
        let mut bytes = Vec::new();
        entry.read_to_end(&mut bytes).unwrap();
        (entry.name().unwrap().into_owned(), bytes)
    };
    (0..count).map(entry).collect()
}

/// What is found in the FMU with its entries changed.
fn findings(change: impl FnOnce(&mut Entries)) -> Vec<Finding> {
    let mut entries = entries(&FMU);
    change(&mut entries);
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    let first = entries.remove_entry(DESCRIPTION);
    for (name, bytes) in first.into_iter().chain(entries) {
        zip.start_file(name, SimpleFileOptions::default()).unwrap();
        zip.write_all(&bytes).unwrap();
    }
    check(Cursor::new(zip.finish().unwrap().into_inner()), "X.fmu").unwrap()
}

fn assert_found(expected: &str, change: impl FnOnce(&mut Entries)) {
    let findings = findings(change);
    let found: BTreeSet<String> =
        findings.iter().map(|f| format!("{} {}", f.level.name(), f.code)).collect();
    let expected: BTreeSet<String> =
        expected.split(", ").filter(|one| !one.is_empty()).map(str::to_owned).collect();
    assert_eq!(found, expected, "{findings:#?}");
}

/// An entry with `from` replaced by `to`.
fn edit(entries: &mut Entries, name: &str, from: &[u8], to: &[u8]) {
    let bytes = entries.get_mut(name).unwrap();
    let at = (0..bytes.len()).find(|&at| bytes[at..].starts_with(from)).unwrap();
    bytes.splice(at..at + from.len(), to.iter().copied());
}

#[test]
fn the_same_design_gives_the_same_bytes_and_no_finding() {
    assert!(*FMU == package());
    assert_found("", |_| {});
    let expected = [
        format!("binaries/{}/{}.{}", platform().folder(), names::DETECTOR, platform().extension()),
        "documentation/index.html".into(),
        "documentation/licenses/LICENSE-APACHE".into(),
        "documentation/licenses/LICENSE-MIT".into(),
        "documentation/licenses/crc.txt".into(),
        "documentation/licenses/libm.txt".into(),
        "documentation/sbom.cdx.json".into(),
        "extra/SteeringFaultDetector_in.csv".into(),
        "extra/SteeringFaultDetector_ref.csv".into(),
        DESCRIPTION.into(),
        "terminalsAndIcons/icon.png".into(),
        TERMINALS.into(),
    ];
    assert_eq!(entries(&FMU).into_keys().collect::<Vec<_>>(), expected);
}

#[test]
fn the_reference_results_are_those_of_fmi_2() {
    let fmi2 = detector_fmu(&common::design(), &Record::default(), &Runtimes::detector()).unwrap();
    let (two, three) = (entries(&fmi2), entries(&FMU));
    let rows = |entries: &Entries, name: &str| {
        let text = String::from_utf8(entries[name].clone()).unwrap();
        text.split_once('\n').map(|(head, rows)| (head.to_owned(), rows.to_owned())).unwrap()
    };
    for name in ["extra/SteeringFaultDetector_in.csv", "extra/SteeringFaultDetector_ref.csv"] {
        assert_eq!(rows(&two, name).1, rows(&three, name).1);
    }
    let head = rows(&three, "extra/SteeringFaultDetector_ref.csv").0;
    assert!(head.starts_with("time,residual[1],residual[2],J_rms,"), "{head}");
    // Two FMUs of one design do not take each other's description.
    let token = |entries: &Entries| {
        header(std::str::from_utf8(&entries[DESCRIPTION]).unwrap()).unwrap().guid
    };
    assert_ne!(token(&two), token(&three));
}

#[test]
fn every_platform_has_its_folder() {
    for platform in Platform::PACKAGED {
        let served = platform.of_fmi3();
        assert!(!served.is_empty(), "{platform:?}");
        for of_fmi3 in served {
            assert!(of_fmi3.is_of_fmi3() && of_fmi3.format() == platform.format());
            assert!(platform.architectures().contains(&of_fmi3.architectures()[0]));
        }
        let processors: BTreeSet<_> =
            served.iter().map(|served| format!("{:?}", served.architectures())).collect();
        assert_eq!(processors.len(), platform.architectures().len(), "one folder for each");
    }
    let none = Runtimes(BTreeMap::new());
    let refused = detector_fmi3(&common::design(), &Record::default(), &none);
    assert!(matches!(refused, Err(PackageError::NoLibrary)));
}

#[test]
fn faults_are_found() {
    let library = platform().library_path(names::DETECTOR);
    let library = library.as_str();
    assert_found("note no-icon", |all| drop(all.remove("terminalsAndIcons/icon.png")));
    assert_found("error binary-missing, note no-digest", |all| {
        let bytes = all.remove(library).unwrap();
        all.insert(library.replace("Steering", "Braking"), bytes);
    });
    // The folder of FMI 2.0, where importers of FMI 3.0 do not look.
    assert_found("warning unknown-platform, note no-digest", |all| {
        let bytes = all.remove(library).unwrap();
        all.insert(Platform::HOST.unwrap().library_path(names::DETECTOR), bytes);
    });
    assert_found("error digest, error missing-function, warning other-symbols", |all| {
        edit(all, library, b"\0fmi3GetClock\0", b"\0fmi3GotClock\0");
    });
    // Announced by no flag; for Model Exchange alone; announced by canGetAndSetFMUState.
    assert_found("error digest, warning missing-function, warning other-symbols", |all| {
        edit(all, library, b"\0fmi3GetAdjointDerivative\0", b"\0fmi3GotAdjointDerivative\0");
    });
    assert_found("error digest, warning other-symbols", |all| {
        edit(all, library, b"\0fmi3SetTime\0", b"\0fmi3SatTime\0");
    });
    assert_found("error digest, error missing-function, warning other-symbols", |all| {
        edit(all, library, b"\0fmi3GetFMUState\0", b"\0fmi3GotFMUState\0");
    });
    // A library of FMI 2.0, unbaked, in its place.
    let all_missing = "error missing-function, warning missing-function";
    assert_found(
        &format!("{all_missing}, warning other-symbols, error unbaked, error digest"),
        |all| {
            let runtime = Runtimes::detector().0.remove(&Platform::HOST.unwrap()).unwrap();
            all.insert(library.to_owned(), runtime);
        },
    );
    assert_found("error guid-digest", |all| {
        edit(all, DESCRIPTION, b"Measured yaw rate", b"Measured Yaw rate");
    });
    assert_found("error guid-mismatch, error guid-digest", |all| {
        edit(all, DESCRIPTION, b"instantiationToken=\"{", b"instantiationToken=\"{0");
    });
    assert_found("error clock-without-event-mode, error guid-digest", |all| {
        edit(all, DESCRIPTION, b"hasEventMode=\"true\" ", b"");
    });
    assert_found("error unknown-variable", |all| {
        edit(all, TERMINALS, b"variableName=\"r\"", b"variableName=\"q\"");
    });
    assert_found("error malformed-xml", |all| edit(all, TERMINALS, b"</Terminals>", b""));
    assert_found("error description-encoding", |all| edit(all, TERMINALS, b"vehicle", b"\xff"));
}

#[test]
fn the_command_packages_either_version_or_both() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let design =
        concat!(env!("CARGO_MANIFEST_DIR"), "/../designer/verify/tests/fixtures/paper.json");
    std::fs::copy(design, path.join("design.json")).unwrap();

    let text = success(path, &["package", "design.json", "--fmi", "both", "-o", "car.fmu"]);
    assert!(text.contains("car.fmu  ") && text.contains("car.fmi3.fmu  "), "{text}");
    success(path, &["package", "design.json", "-o", "two.fmu"]);
    success(path, &["package", "design.json", "--fmi", "3", "-o", "three.fmu"]);
    let read = |name: &str| std::fs::read(path.join(name)).unwrap();
    assert!(read("car.fmu") == read("two.fmu") && read("car.fmi3.fmu") == read("three.fmu"));
    for name in ["car.fmu", "car.fmi3.fmu"] {
        assert_eq!(success(path, &["check", name]), format!("{name}: no findings\n"));
    }
    success(path, &["package", "design.json", "--fmi", "both", "-o", "named.so"]);
    assert!(path.join("named.so.fmi3.fmu").is_file());

    let twice = ["package", "design.json", "--fmi", "both", "--plant"];
    let twice = [&twice[..], &["SteeringFaultDetector.fmi3.fmu"]].concat();
    failure(path, &twice, 2, &["`SteeringFaultDetector.fmi3.fmu` would be written twice"]);
    failure(path, &["package", "design.json", "--fmi", "1"], 2, &["--fmi"]);
    // It is co-simulated in FMI 2.0 here.
    let simulate = ["simulate", "--detector", "three.fmu"];
    failure(path, &simulate, 2, &["fmiVersion=\"3.0\"", "2.0"]);
}

#[test]
fn a_given_library_goes_where_it_belongs() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let design =
        concat!(env!("CARGO_MANIFEST_DIR"), "/../designer/verify/tests/fixtures/paper.json");
    std::fs::copy(design, path.join("design.json")).unwrap();
    let host = Platform::HOST.unwrap();
    let libraries = [("two", Runtimes::detector()), ("three", Runtimes::detector_fmi3())];
    for (name, mut runtimes) in libraries {
        let bytes = runtimes.0.remove(&host).unwrap();
        assert_eq!(is_for_fmi3(&bytes), name == "three");
        std::fs::write(path.join(name), bytes).unwrap();
    }
    let given = |name: &str| format!("{}={name}", host.folder());
    let run = |fmi: &'static str, name: &str| {
        let runtime = given(name);
        let arguments = ["package", "design.json", "--fmi", fmi, "--runtime", &runtime];
        command::steerguard(path, &arguments).status.code()
    };
    assert_eq!([run("2", "two"), run("3", "three"), run("both", "three")], [Some(0); 3]);
    let runtime = given("three");
    let arguments = ["package", "design.json", "--runtime", &runtime];
    failure(path, &arguments, 2, &["`three` is not a library for FMI 2.0", "--fmi"]);
    let runtime = given("two");
    let arguments = ["package", "design.json", "--fmi", "3", "--runtime", &runtime];
    failure(path, &arguments, 2, &["`two` is not a library for FMI 3.0", "--fmi"]);
    assert!(Fmu::open(Path::new(&path.join("SteeringFaultDetector.fmu"))).is_ok());
}
