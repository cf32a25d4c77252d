//! The program: what it prints and its exit status.

#![allow(clippy::unwrap_used)]

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

fn run(arguments: &[&Path]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_steerguard-verify")).args(arguments).output().unwrap()
}

/// A file with the given text in the folder for this test run.
fn file(name: &str, text: &str) -> PathBuf {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    std::fs::write(&path, text).unwrap();
    path
}

#[test]
fn exit_status_tells_proven_from_changed_from_unreadable() {
    let paper = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/fixtures/paper.json");
    let text = std::fs::read_to_string(paper).unwrap();
    let proven = run(&[Path::new(paper)]);
    assert_eq!(proven.status.code(), Some(0));
    let printed = String::from_utf8(proven.stdout).unwrap();
    assert!(printed.starts_with("certified") && printed.contains("margins"), "{printed}");

    let changed = file("changed.json", &text.replacen("\"decay\": 0.97", "\"decay\": 0.96", 1));
    let refused = run(&[&changed]);
    assert_eq!(refused.status.code(), Some(1));
    let error = String::from_utf8(refused.stderr).unwrap();
    assert!(error.contains("not certified") && error.contains("hash"), "{error}");

    let mut design: serde_json::Value = serde_json::from_str(&text).unwrap();
    design["synthesis"]["status"] = "uncertified".into();
    design["performance"]["certified"] = serde_json::Value::Null;
    design["certificate"]["a_posteriori"] = serde_json::Value::Null;
    design["hash"] = steerguard_verify::content_hash(&design).unwrap().into();
    let uncertified = run(&[&file("uncertified.json", &design.to_string())]);
    assert_eq!(uncertified.status.code(), Some(1));
    let printed = String::from_utf8(uncertified.stdout).unwrap();
    assert!(printed.starts_with("not certified, as it says of itself"), "{printed}");

    let foreign = file("foreign.json", "{\"format\": \"another\"}");
    for arguments in [&[][..], &[Path::new("no such file")], &[&foreign], &[&foreign, &foreign]] {
        let output = run(arguments);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        assert!(!output.stderr.is_empty());
    }
}

#[test]
fn what_is_read_has_an_end() {
    let long = file("long.json", "");
    std::fs::File::options().write(true).open(&long).unwrap().set_len((64 << 20) + 1).unwrap();
    let latin = Path::new(env!("CARGO_TARGET_TMPDIR")).join("latin.json");
    std::fs::write(&latin, b"{\"a\": \"\xfc\"}").unwrap();
    let mut cases = vec![
        (long, "more than 67108864 bytes"),
        (PathBuf::from(env!("CARGO_TARGET_TMPDIR")), "it is a folder"),
        (latin, "UTF-8: invalid utf-8 sequence of 1 bytes from index 7"),
    ];
    if cfg!(unix) {
        cases.push((PathBuf::from("/dev/zero"), "more than 67108864 bytes"));
    }
    for (path, expected) in cases {
        let output = run(&[&path]);
        assert_eq!(output.status.code(), Some(2), "{path:?}");
        let error = String::from_utf8(output.stderr).unwrap();
        assert!(error.contains(expected) && error.contains(&*path.to_string_lossy()), "{error}");
    }
}
