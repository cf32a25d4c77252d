//! What a new user begins with: a specification that is the default and explains every key; completions.

#![allow(clippy::unwrap_used)]

use std::fs;

use steerguard_designer::Spec;

#[path = "common/command.rs"]
mod command;

use command::{failure, success};

fn begun() -> String {
    let folder = tempfile::tempdir().unwrap();
    let text = success(folder.path(), &["init"]);
    assert!(text.contains("steerguard design car.toml"), "{text}");
    let written = fs::read_to_string(folder.path().join("car.toml")).unwrap();
    // What is there stays.
    fs::write(folder.path().join("car.toml"), "mine").unwrap();
    failure(folder.path(), &["init"], 2, &["`car.toml` is there already", "name another file"]);
    assert_eq!(fs::read_to_string(folder.path().join("car.toml")).unwrap(), "mine");
    written
}

/// With the keys in that stand behind a `#` by themselves.
fn uncommented(text: &str) -> String {
    let is_key = |rest: &str| {
        let name = rest.split(" =").next().unwrap_or_default();
        rest.starts_with('[') && rest.contains("]   ")
            || rest.contains(" = ") && !name.is_empty() && !name.contains(' ')
    };
    let line = |line: &str| match line.strip_prefix("# ") {
        Some(rest) if is_key(rest) => format!("{rest}\n"),
        _ => format!("{line}\n"),
    };
    text.lines().map(line).collect()
}

#[test]
fn it_is_the_default_specification() {
    let text = begun();
    assert_eq!(Spec::from_toml(&text).unwrap(), Spec::default());
}

#[test]
fn what_stands_behind_a_hash_is_the_default_or_said_to_be_none() {
    // Those that are none by default, and the one of two that exclude each other.
    let none =
        |line: &&str| !line.contains("none by default") && !line.contains("guessed by default");
    let not_stated = ["bound_", "band_hz = [0.0, 50.0]", "decay", "# gamma"];
    let text: String = begun()
        .lines()
        .filter(none)
        .filter(|line| !line.starts_with('#') || !not_stated.iter().any(|x| line.contains(x)))
        .map(|line| format!("{line}\n"))
        .collect();
    let all = uncommented(&text);
    assert!(all.lines().count() == text.lines().count() && all != text);
    // Where these are not stated they follow from the rest, and are this here.
    let mut default = Spec::default();
    default.evaluation.window_s = Some(0.4);
    default.evaluation.calibration.initial_v_y_m_per_s = Some(vec![-1.0, 0.0, 1.0]);
    assert_eq!(Spec::from_toml(&all).unwrap(), default);
}

#[test]
fn it_names_every_key_of_the_example_that_explains_them() {
    let keys = |text: &str| -> Vec<String> {
        let line = |line: &str| {
            let line = line.trim_start_matches("# ");
            let (key, _) = line.split_once(" = ")?;
            (!key.contains(' ')).then(|| key.to_owned())
        };
        text.lines().filter_map(line).collect()
    };
    let (ours, example) = (keys(&begun()), keys(include_str!("../../examples/paper.toml")));
    let missing: Vec<&String> =
        example.iter().filter(|key| !ours.contains(key) && *key != "constant").collect();
    assert!(missing.is_empty(), "{missing:?}");
}

#[test]
fn shells_complete_what_there_is() {
    let folder = tempfile::tempdir().unwrap();
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let text = success(folder.path(), &["completions", shell]);
        for name in ["identify", "report", "completions"] {
            assert!(text.contains(name), "{shell}: {name}");
        }
    }
    failure(folder.path(), &["completions", "cmd"], 2, &["bash"]);
}
