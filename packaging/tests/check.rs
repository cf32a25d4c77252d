//! `steerguard check`: one bad FMU for each finding, and hostile files.

#![allow(clippy::unwrap_used)]

mod common;

use std::collections::BTreeSet;
use std::io::{Cursor, Read, Write};
use std::process::Command;
use std::sync::LazyLock;

use object::{Object as _, ObjectSection as _};
use proptest::prelude::*;
use steerguard::check::check;
use steerguard::digest::sha256;
use steerguard::fmu::bill::BILL;
use steerguard::fmu::package::{detector_fmu, plant_fmu};
use steerguard::fmu::runtime::Runtimes;
use steerguard::platform::Platform;
use steerguard::report::design_summary::Record;
use steerguard_model_description::names;
use steerguard_model_description::xml::Finding;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipArchive, ZipWriter};

type Entries = Vec<(String, Vec<u8>)>;

static FMU: LazyLock<Vec<u8>> = LazyLock::new(|| {
    detector_fmu(&common::design(), &Record::default(), &Runtimes::detector()).unwrap()
});

static LIBRARY: LazyLock<String> =
    LazyLock::new(|| Platform::HOST.unwrap().library_path(names::DETECTOR));

fn findings(fmu: &[u8]) -> Vec<Finding> {
    check(Cursor::new(fmu), "X.fmu").unwrap()
}

/// What is found, as `level code`.
fn found(fmu: &[u8]) -> BTreeSet<String> {
    findings(fmu).iter().map(|f| format!("{} {}", f.level.name(), f.code)).collect()
}

/// Asserts that exactly the rules in `expected`, `level code, level code`, find something.
fn assert_found(fmu: &[u8], expected: &str) {
    let expected: BTreeSet<String> = expected.split(", ").map(str::to_owned).collect();
    assert_eq!(found(fmu), expected, "{:#?}", findings(fmu));
}

fn entries() -> Entries {
    let mut zip = ZipArchive::new(Cursor::new(&*FMU)).unwrap();
    let count = zip.len();
    let entry = |index| {
        let mut entry = zip.by_index(index).unwrap();
        let mut bytes = Vec::new();
        entry.read_to_end(&mut bytes).unwrap();
        (entry.name().unwrap().into_owned(), bytes)
    };
    (0..count).map(entry).collect()
}

fn zipped(entries: &Entries) -> Vec<u8> {
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    for (name, bytes) in entries {
        zip.start_file(name.as_str(), SimpleFileOptions::default()).unwrap();
        zip.write_all(bytes).unwrap();
    }
    zip.finish().unwrap().into_inner()
}

/// The FMU with its entries changed.
fn changed(change: impl FnOnce(&mut Entries)) -> Vec<u8> {
    let mut entries = entries();
    change(&mut entries);
    zipped(&entries)
}

/// The FMU with one entry more.
fn with(name: &str) -> Vec<u8> {
    changed(|entries| entries.push((name.to_owned(), b"content".to_vec())))
}

fn without(prefix: &str) -> Vec<u8> {
    changed(|entries| entries.retain(|(name, _)| !name.starts_with(prefix)))
}

/// The FMU with the bytes of an entry changed.
fn edited(name: &str, edit: impl FnOnce(&mut Vec<u8>)) -> Vec<u8> {
    changed(|entries| edit(&mut entries.iter_mut().find(|(n, _)| n == name).unwrap().1))
}

/// The FMU with another library, of which the bill of materials states the digest.
fn with_library(edit: impl FnOnce(&mut Vec<u8>)) -> Vec<u8> {
    changed(|entries| {
        let entry =
            |entries: &Entries, name: &str| entries.iter().position(|(n, _)| n == name).unwrap();
        let (library, bill) = (entry(entries, &LIBRARY), entry(entries, BILL));
        let before = sha256(&entries[library].1);
        edit(&mut entries[library].1);
        let text = String::from_utf8(entries[bill].1.clone()).unwrap();
        assert!(text.contains(&before));
        entries[bill].1 = text.replace(&before, &sha256(&entries[library].1)).into_bytes();
    })
}

/// The FMU with its description changed.
fn described(from: &str, to: &str) -> Vec<u8> {
    edited("modelDescription.xml", |bytes| {
        let text = String::from_utf8(bytes.clone()).unwrap();
        assert!(text.contains(from), "{from}");
        *bytes = text.replacen(from, to, 1).into_bytes();
    })
}

/// The FMU with an entry `resources/a` whose headers, found in the bytes by their signature, are
/// changed: local header and directory.
fn with_headers(edit: impl Fn(&mut [u8], &mut [u8])) -> Vec<u8> {
    let mut bytes = with("resources/a");
    let header = |bytes: &[u8], signature: &[u8], name_at: usize| {
        (0..bytes.len())
            .find(|&at| {
                bytes[at..].starts_with(signature)
                    && bytes[at..]
                        .get(name_at..)
                        .is_some_and(|rest| rest.starts_with(b"resources/a"))
            })
            .unwrap()
    };
    let local = header(&bytes, b"PK\x03\x04", 30);
    let central = header(&bytes, b"PK\x01\x02", 46);
    let (before, after) = bytes.split_at_mut(central);
    edit(&mut before[local..], after);
    bytes
}

/// `from` in `bytes` replaced by `to`, of the same length, wherever it is.
fn replace(bytes: &mut [u8], from: &[u8], to: &[u8]) {
    let places: Vec<usize> = (0..bytes.len()).filter(|&at| bytes[at..].starts_with(from)).collect();
    assert!(!places.is_empty() && from.len() == to.len());
    for at in places {
        bytes[at..at + to.len()].copy_from_slice(to);
    }
}

#[test]
fn our_fmus_have_no_finding() {
    assert_eq!(findings(&FMU), []);
    assert_eq!(findings(&plant_fmu(&Runtimes::plant()).unwrap()), []);
    assert_eq!(found(&zipped(&entries())), BTreeSet::new(), "nor have they when zipped again");
}

#[test]
fn what_is_no_archive() {
    let mut prefixed = vec![b'x'; 10];
    prefixed.extend_from_slice(&FMU);
    assert_found(b"", "error not-a-zip");
    assert_found(b"no archive", "error not-a-zip");
    assert_found(&FMU[..FMU.len() / 2], "error not-a-zip");
    assert_found(&prefixed, "warning leading-data");
}

#[test]
fn entry_names() {
    for (name, expected) in [
        ("resources\\a", "error backslash"),
        ("/etc/a", "error absolute-path"),
        ("C:/a", "error absolute-path"),
        ("\\a", "error absolute-path, error backslash"),
        ("../a", "error parent-path"),
        ("resources/../../a", "error parent-path"),
        ("resources\\..\\a", "error backslash, error parent-path"),
        ("resources//a", "error entry-name"),
        ("./a", "error entry-name"),
        ("resources/a\0b", "error entry-name"),
        ("resources/a\x07b", "error control-character"),
        ("modelDescription.xml/a", "error file-and-folder"),
        ("model.png/", "error file-and-folder"),
        ("resources/\u{fc}", "warning non-ascii-name"),
        ("MODEL.PNG", "warning name-case"),
    ] {
        assert_found(&with(name), expected);
    }
    let many = changed(|all| all.extend((0..3).map(|i| (format!("../{i}"), Vec::new()))));
    let finding = &findings(&many)[0];
    assert_eq!(finding.message, "\"../0\" has `..` in its path, like 2 more");
}

#[test]
fn headers() {
    let flags = |bit: u8| {
        with_headers(move |local, central| {
            local[6] |= bit;
            central[8] |= bit;
        })
    };
    assert_found(&flags(1), "error encrypted");
    let lzma = with_headers(|local, central| {
        local[8] = 14;
        central[10] = 14;
    });
    assert_found(&lzma, "error compression");
    assert_found(&with_headers(|local, _| local[30] = b'R'), "error header-mismatch");
    let elsewhere = with_headers(|_, central| central[42] = 1);
    assert_found(&elsewhere, "error header-mismatch");
    // The directory claims another CRC than the content has; local header likewise.
    let damaged = with_headers(|local, central| {
        local[14] ^= 1;
        central[16] ^= 1;
    });
    assert_found(&damaged, "error damaged-entry");
    let overlapping = with_headers(|_, central| central[42..46].fill(0));
    assert_found(&overlapping, "error overlapping-entries");

    let twice = changed(|entries| {
        entries.extend([("resources/a".to_owned(), vec![]), ("resources/b".to_owned(), vec![])]);
    });
    let mut twice = twice;
    replace(&mut twice, b"resources/b", b"resources/a");
    assert_found(&twice, "error duplicate-name");
}

#[test]
fn kinds_of_entries() {
    let mut zip = ZipWriter::new_append(Cursor::new(FMU.clone())).unwrap();
    zip.add_symlink("resources/link", "/etc/passwd", SimpleFileOptions::default()).unwrap();
    assert_found(&zip.finish().unwrap().into_inner(), "error symlink");

    let mut stream = ZipWriter::new_stream(Vec::new());
    for (name, bytes) in entries() {
        stream.start_file(name, SimpleFileOptions::default()).unwrap();
        stream.write_all(&bytes).unwrap();
    }
    assert_found(&stream.finish().unwrap().into_inner(), "warning data-descriptor");
}

#[test]
fn bombs_are_not_unpacked() {
    let bomb = changed(|entries| entries.push(("resources/0".to_owned(), vec![0; 40 << 20])));
    assert!(bomb.len() < 1 << 20);
    assert_found(&bomb, "error zip-bomb");
    let crowd = changed(|entries| entries.extend((0..10_000).map(|i| (i.to_string(), vec![]))));
    assert_found(&crowd, "error zip-bomb");
    // As many zeros as do no harm, and a large file that hardly shrinks.
    let zeros = changed(|entries| entries.push(("resources/0".to_owned(), vec![0; 16 << 20])));
    assert_eq!(findings(&zeros), []);
}

#[test]
fn a_description_too_large_is_not_examined() {
    let stored = SimpleFileOptions::default().compression_method(CompressionMethod::Stored);
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    for (name, mut bytes) in entries() {
        if name == "modelDescription.xml" {
            bytes.resize(33 << 20, b' ');
        }
        zip.start_file(name, stored).unwrap();
        zip.write_all(&bytes).unwrap();
    }
    assert_found(&zip.finish().unwrap().into_inner(), "error description-size");
}

#[test]
fn declared_sizes_are_those_of_the_contents() {
    // In the local header, the directory, or both, too small or too large.
    for size in [0_u8, 6, 8, 200] {
        let both = with_headers(|local, central| {
            local[22..26].copy_from_slice(&[size, 0, 0, 0]);
            central[24..28].copy_from_slice(&[size, 0, 0, 0]);
        });
        let codes = found(&both);
        let noticed = ["error damaged-entry", "error header-mismatch"];
        assert!(noticed.iter().any(|&code| codes.contains(code)), "{size}: {codes:?}");
        let directory = with_headers(|_, central| central[24] = size);
        assert!(!found(&directory).is_empty(), "{size}");
    }
}

#[test]
fn descriptions() {
    assert_found(&changed(|entries| entries.rotate_left(1)), "note description-not-first");
    assert_found(&without("modelDescription.xml"), "error no-description");
    let folder = changed(|entries| {
        for (name, _) in entries {
            name.insert_str(0, "X/");
        }
    });
    assert_found(&folder, "error no-description, note no-documentation, note no-icon");
    let latin = edited("modelDescription.xml", |bytes| bytes.extend(b"<!-- \xfc -->"));
    assert_found(&latin, "error description-encoding");
    assert_found(
        &described("encoding=\"UTF-8\"", "encoding=\"ISO-8859-1\""),
        "error declared-encoding, error guid-digest",
    );
    assert_found(&described("</fmiModelDescription>", ""), "error malformed-xml");
    // The rules on a description have tests of their own; here, that they are applied.
    assert_found(
        &described("fmiVersion=\"2.0\"", "fmiVersion=\"2.1\""),
        "error version, error guid-digest",
    );
    let mut attributes = String::from("fmiVersion=\"2.0\"");
    attributes.extend((0..100_000).map(|i| format!(" a{i}=\"\"")));
    assert_found(&described("fmiVersion=\"2.0\"", &attributes), "error malformed-xml");
}

#[test]
fn binaries() {
    let library = &*LIBRARY;
    assert_found(&without("binaries/"), "error no-binary");
    let sources = changed(|entries| {
        entries.retain(|(name, _)| !name.starts_with("binaries/"));
        entries.push(("sources/a.c".to_owned(), vec![]));
    });
    assert_found(&sources, "note no-binary");
    assert_found(&with("binaries/amiga/a"), "warning unknown-platform, note no-digest");
    assert_found(&with("binaries/win32/other.dll"), "error binary-missing, note no-digest");
    for other in ["win64", "aarch64-windows"] {
        let fmu = changed(|entries| {
            let to = format!("binaries/{other}/SteeringFaultDetector.dll");
            let bill = entries.iter_mut().find(|(name, _)| name == BILL).unwrap();
            bill.1 = String::from_utf8(bill.1.clone()).unwrap().replace(&**library, &to).into();
            entries.iter_mut().find(|(name, _)| name == library).unwrap().0 = to;
        });
        assert_found(&fmu, "error binary-format");
    }
    assert_found(&with_library(|bytes| bytes.truncate(100)), "error binary-format");
    assert_found(&with_library(|bytes| *bytes = b"text".to_vec()), "error binary-format");
}

#[test]
#[cfg(target_os = "linux")]
fn exported_symbols() {
    let rename = |from: &'static [u8], to: &'static [u8]| {
        with_library(move |bytes| replace(bytes, from, to))
    };
    let fmu = rename(b"\0fmi2DoStep\0", b"\0fmi2DoStop\0");
    assert_found(&fmu, "error missing-function, warning other-symbols");
    let messages: Vec<_> = findings(&fmu).into_iter().map(|finding| finding.message).collect();
    assert_eq!(messages, ["not exported: fmi2DoStep", "exports more than FMI: fmi2DoStop"]);
    // Announced by no flag.
    assert_found(
        &rename(b"\0fmi2GetDirectionalDerivative\0", b"\0fmi2GotDirectionalDerivative\0"),
        "warning missing-function, warning other-symbols",
    );
    // Announced by canGetAndSetFMUstate.
    assert_found(
        &rename(b"\0fmi2GetFMUstate\0", b"\0fmi2GotFMUstate\0"),
        "error missing-function, warning other-symbols",
    );
    // For Model Exchange alone.
    let fmu = rename(b"\0fmi2GetDerivatives\0", b"\0fmi2GotDerivatives\0");
    assert_found(&fmu, "warning other-symbols");
}

#[test]
fn baked_blocks() {
    let section = |bytes: &[u8]| {
        let file = object::File::parse(bytes).unwrap();
        let names = [".steerguard", "__steerguard", ".sguard"];
        let section = names.iter().find_map(|name| file.section_by_name(name)).unwrap();
        section.file_range().unwrap().0 as usize
    };
    let runtime = Runtimes::detector().0.remove(&Platform::HOST.unwrap()).unwrap();
    assert_found(&with_library(|bytes| *bytes = runtime), "error unbaked");
    let damage = |bytes: &mut Vec<u8>| {
        let at = section(bytes) + 200;
        bytes[at] ^= 1;
    };
    assert_found(&with_library(damage), "error baked-block");
    assert_found(&described("guid=\"{", "guid=\"{0"), "error guid-mismatch, error guid-digest");
    assert_found(&described("Measured yaw rate", "Measured Yaw rate"), "error guid-digest");
    assert_found(
        &described("0123456789abcdef", "0123456789abcdee"),
        "error guid-digest, error baked-block",
    );
}

#[test]
fn digests() {
    // A byte of the text of a log message, which nothing else covers.
    let fmu = edited(&LIBRARY, |bytes| replace(bytes, b"monitoring from", b"monitoring From"));
    assert_found(&fmu, "error digest");
    assert_found(&without(BILL), "note no-digest");
    assert_found(&edited(BILL, |bytes| *bytes = b"{".to_vec()), "note no-digest");
    let beside = with(&LIBRARY.replace("SteeringFaultDetector", "another"));
    assert_found(&beside, "note no-digest");
}

#[test]
fn control_characters_in_the_description() {
    let named = |character: &str| format!("name=\"v_y{character}hat\"");
    for character in ["&#9;", "&#10;", "&#13;", "&#x7f;", "\u{7f}", "&#x9b;", "\u{9b}"] {
        assert_found(
            &described("name=\"v_y_hat\"", &named(character)),
            "error control-character, error guid-digest",
        );
    }
    // XML itself has no others.
    for character in ["\x01", "\x1b", "&#1;", "&#x1b;", "&#0;", "\u{fffe}"] {
        assert_found(&described("name=\"v_y_hat\"", &named(character)), "error malformed-xml");
    }
    assert_found(&described("Detects", "&#9;&#10;Detects"), "error guid-digest");
    assert_found(
        &described("Detects", "&#x9b;2JDetects"),
        "warning control-character, error guid-digest",
    );
}

#[test]
fn surroundings() {
    assert_found(&without("documentation/index.html"), "note no-documentation");
    assert_found(&without("model.png"), "note no-icon");
    assert_found(&edited("model.png", |bytes| *bytes = b"GIF89a".to_vec()), "note icon-format");
    assert_found(
        &edited("model.png", |bytes| bytes[16..20].copy_from_slice(&[0, 0, 0, 99])),
        "note icon-size",
    );
}

/// Runs the command on `fmu` in an empty folder and returns exit code, output and error output.
fn run(fmu: &[u8], arguments: &[&str]) -> (Option<i32>, String, String) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("X.fmu");
    std::fs::write(&path, fmu).unwrap();
    let output = Command::new(env!("CARGO_BIN_EXE_steerguard"))
        .current_dir(folder.path())
        .env("TMPDIR", folder.path())
        .arg("check")
        .args(arguments)
        .output()
        .unwrap();
    let names: Vec<_> = std::fs::read_dir(folder.path()).unwrap().collect();
    assert_eq!(names.len(), 1, "nothing is written");
    let text = |bytes| String::from_utf8(bytes).unwrap();
    (output.status.code(), text(output.stdout), text(output.stderr))
}

#[test]
fn the_command_reports_and_exits() {
    let (code, text, _) = run(&FMU, &["X.fmu"]);
    assert_eq!((code, text.as_str()), (Some(0), "X.fmu: no findings\n"));
    let (code, text, _) = run(&without("model.png"), &["X.fmu"]);
    assert_eq!(code, Some(0));
    assert!(
        text.starts_with("note[no-icon]: model.png is missing\n--> X.fmu\n = help: "),
        "{text}"
    );
    assert!(text.ends_with("\n\nX.fmu: 1 note\n"), "{text}");

    let (code, json, _) = run(&with("../evil\x1b[2J"), &["X.fmu", "--json"]);
    assert_eq!(code, Some(1));
    let value: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!(
        (&value["errors"], &value["findings"][0]["code"]),
        (&2.into(), &"parent-path".into())
    );
    let (code, text, _) = run(&with("../evil\x1b[2J"), &["X.fmu"]);
    assert_eq!(code, Some(1));
    assert!(text.contains("error[parent-path]") && !text.contains('\x1b'), "{text}");
    let (code, text, _) = run(&described("Detects", "\x1b[2J"), &["X.fmu"]);
    assert!(code == Some(1) && !text.contains('\x1b'), "{text}");

    let (code, _, error) = run(b"", &["missing.fmu"]);
    assert_eq!(code, Some(2));
    assert!(error.contains("missing.fmu") && error.contains("help: "), "{error}");
    assert_eq!(run(b"", &["."]).0, Some(2), "a folder");
    assert_eq!(run(b"", &["X.fmu"]).0, Some(1), "an empty file");
}

/// Checks, whatever the result.
fn survives(fmu: &[u8]) {
    check(Cursor::new(fmu), "X.fmu").unwrap();
}

/// Changes to a file: where in it, as a fraction, and what is put there.
fn changes() -> impl Strategy<Value = Vec<(f64, Vec<u8>)>> {
    prop::collection::vec((0.0..1.0, prop::collection::vec(any::<u8>(), 1..9)), 1..20)
}

fn apply(bytes: &mut [u8], from: f64, changes: &[(f64, Vec<u8>)]) {
    for (place, change) in changes {
        let at = ((from + (1.0 - from) * place) * bytes.len() as f64) as usize;
        for (byte, new) in bytes.iter_mut().skip(at).zip(change) {
            *byte = *new;
        }
    }
}

/// A small FMU, so that changes hit headers often.
fn small() -> Vec<u8> {
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    let stored = SimpleFileOptions::default().compression_method(CompressionMethod::Stored);
    for (name, bytes) in entries().into_iter().filter(|(name, _)| name.ends_with(".xml")) {
        zip.start_file(name, SimpleFileOptions::default()).unwrap();
        zip.write_all(&bytes[..2000]).unwrap();
    }
    for name in ["model.png", "binaries/linux64/a.so", "documentation/index.html"] {
        zip.start_file(name, stored).unwrap();
        zip.write_all(&[7; 20]).unwrap();
    }
    zip.finish().unwrap().into_inner()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn random_bytes_are_survived(bytes in prop::collection::vec(any::<u8>(), 0..2000)) {
        survives(&bytes);
        // Behind an end of central directory that points somewhere into them.
        let mut zip = bytes.clone();
        zip.extend(b"PK\x05\x06\0\0\0\0");
        zip.extend(bytes.iter().copied().chain([0; 14]).take(12));
        zip.extend([0, 0]);
        survives(&zip);
    }

    #[test]
    fn changed_archives_are_survived(changes in changes(), cut in 0.0..1.0_f64, at_end in any::<bool>()) {
        let mut bytes = small();
        apply(&mut bytes, if at_end { 0.6 } else { 0.0 }, &changes);
        survives(&bytes);
        bytes.truncate((cut * bytes.len() as f64) as usize);
        survives(&bytes);
    }

    #[test]
    fn changed_contents_are_survived(changes in changes(), which in 0..10_usize) {
        let mut entries = entries();
        let (_, bytes) = &mut entries[which];
        apply(bytes, 0.0, &changes);
        survives(&zipped(&entries));
    }

    #[test]
    fn changed_library_headers_are_survived(changes in changes(), tables in any::<bool>()) {
        let fmu = edited(&LIBRARY, |bytes| {
            let length = bytes.len();
            // The header, then the dynamic symbols; or the section headers at the end.
            let part = if tables { &mut bytes[..4096] } else { &mut bytes[length - 2048..] };
            apply(part, 0.0, &changes);
        });
        survives(&fmu);
    }
}

#[test]
fn of_many_findings_the_first_are_listed_and_quoted_legibly() {
    let name = "a".repeat(5000) + "&#9;";
    let variables: String = (0..1000)
        .map(|k| {
            format!(
                "<ScalarVariable name=\"{name}{k}\" valueReference=\"{k}\" causality=\"local\">\
                 <Real unit=\"furlong\"/></ScalarVariable>"
            )
        })
        .collect();
    // Half a million display units, and a variable that names the last of them.
    let units: String = (0..500_000).map(|k| format!("<DisplayUnit name=\"{k}\"/>")).collect();
    let fmu = changed(|entries| {
        let (_, description) = &mut entries[0];
        let text = String::from_utf8(description.clone()).unwrap();
        let text = text.replacen("</Unit>", &format!("{units}</Unit>"), 1);
        let text = text.replacen("</ModelVariables>", &format!("{variables}</ModelVariables>"), 1);
        *description = text.into_bytes();
    });
    let findings = findings(&fmu);
    let of_units: Vec<_> = findings.iter().filter(|f| f.code == "unknown-unit").collect();
    assert_eq!(of_units.len(), 101);
    assert_eq!(of_units[100].message, "and 900 more");
    let longest = findings.iter().map(|finding| finding.message.chars().count()).max();
    assert!(longest.unwrap() < 500, "{longest:?}");
    assert!(findings.iter().all(|f| !f.message.contains(char::is_control)));
}
