//! The page of `steerguard report` as users make it: whole by itself, the same each time, honest about what it is given.

#![allow(clippy::unwrap_used)]

use std::fs;
use std::path::Path;

use quick_xml::Reader;
use quick_xml::events::Event;
use tempfile::TempDir;

#[path = "common/command.rs"]
mod command;

use command::{failure, success};

/// What designing examples/paper.toml gives: designer/tests/format.rs holds it current.
const DESIGN: &str = "../designer/verify/tests/fixtures/paper.json";

/// A folder with a design and what is given for its campaign, as JSON of that design's hash.
fn folder() -> (TempDir, String) {
    let folder = tempfile::tempdir().unwrap();
    let design = fs::read_to_string(DESIGN).unwrap();
    fs::write(folder.path().join("design.json"), &design).unwrap();
    let design: serde_json::Value = serde_json::from_str(&design).unwrap();
    (folder, design["hash"].as_str().unwrap().to_owned())
}

fn page(folder: &Path, further: &[&str]) -> String {
    success(folder, &[&["report", "design.json"], further].concat());
    fs::read_to_string(folder.join("report.html")).unwrap()
}

#[test]
fn it_is_whole_by_itself_and_the_same_each_time() {
    let (folder, hash) = folder();
    let page_1 = page(folder.path(), &[]);
    assert!(page_1 == page(folder.path(), &[]));
    assert!(page_1.len() < 1_000_000, "{}", page_1.len());
    for fetched in ["http:", "https:", "src=", "<script", "url(", "@import", "NaN", "inf"] {
        assert!(!page_1.contains(fetched), "{fetched}");
    }
    assert!(page_1.contains(&hash));
    for link in page_1.split("href=\"#").skip(1) {
        let target = link.split('"').next().unwrap();
        assert!(page_1.contains(&format!("id=\"{target}\"")), "{target}");
    }
    // Every figure is drawn, in the page's colours, and says what it shows.
    let figures: Vec<&str> = page_1.split("<figure>").skip(1).collect();
    assert!(figures.len() >= 7, "{}", figures.len());
    for figure in figures {
        let svg = figure.split("<svg").nth(1).unwrap().split("</svg>").next().unwrap();
        assert!(svg.contains("role=\"img\" aria-label=\""), "{svg:.100}");
        assert!(svg.contains("var(--s1)") && !svg.contains("#0072B2"), "{svg:.100}");
    }
}

#[test]
fn the_markup_is_well_formed() {
    let (folder, _) = folder();
    let page = page(folder.path(), &[]);
    let void = |page: &str, tag: &str| page.replace(&format!("<{tag}"), &format!("<!--{tag}"));
    // Elements that HTML never closes are no XML.
    let mut text = page.replacen("<!DOCTYPE html>", "", 1);
    for tag in ["meta", "link"] {
        text = void(&text, tag);
        text = text
            .split("<!--")
            .enumerate()
            .map(|(k, part)| match k {
                0 => part.to_owned(),
                _ if part.starts_with(tag) => part.split_once('>').unwrap().1.to_owned(),
                _ => format!("<!--{part}"),
            })
            .collect();
    }
    let mut reader = Reader::from_str(&text);
    while reader.read_event().unwrap() != Event::Eof {}
}

#[test]
fn what_results_say_is_text_and_nothing_else() {
    let (folder, hash) = folder();
    fs::create_dir(folder.path().join("c")).unwrap();
    let settings = serde_json::json!({
        "design": hash, "seed": 1, "drives": 1, "duration_s": 60.0,
        "mix": "<img src=x onerror=alert(1)>", "faults": "\"><b>\u{0}\u{1b}",
    });
    let figures = serde_json::json!({
        "drives": 1, "driven_h": 1.0, "monitored_h": 1.0, "out_of_range_share": 0.0,
        "out_of_range_by_cause": [0.0, 0.0, 0.0], "invalid_input_share": 0.0, "not_excited_share": 0.1, "confidence": 0.95,
        "false_alarms": [], "detections": [], "detections_by_size": [],
    });
    fs::write(folder.path().join("c/campaign.json"), settings.to_string()).unwrap();
    fs::write(folder.path().join("c/report.json"), figures.to_string()).unwrap();
    let page = page(folder.path(), &["--campaign", "c"]);
    assert!(page.contains("&lt;img src=x onerror=alert(1)&gt;"));
    assert!(!page.contains("<img") && !page.contains("<b>"));
    assert!(!page.contains(['\0', '\u{1b}']));
}

#[test]
fn results_of_another_design_and_damaged_ones_are_refused() {
    let (folder, _) = folder();
    fs::create_dir(folder.path().join("c")).unwrap();
    let campaign = ["report", "design.json", "--campaign", "c"];
    failure(folder.path(), &campaign, 2, &["campaign.json"]);
    fs::write(folder.path().join("c/campaign.json"), "{}").unwrap();
    failure(
        folder.path(),
        &campaign,
        2,
        &["campaign.json", "missing field", "steerguard campaign"],
    );
    let settings = serde_json::json!({
        "design": "0".repeat(64), "seed": 1, "drives": 1, "duration_s": 60.0, "mix": "standard", "faults": "all",
    });
    fs::write(folder.path().join("c/campaign.json"), settings.to_string()).unwrap();
    failure(folder.path(), &campaign, 2, &["results of another design", "campaign.json"]);
    failure(folder.path(), &["report", "design.json", "-o", "design.json"], 2, &["over itself"]);
    assert!(!folder.path().join("report.html").exists());
}
