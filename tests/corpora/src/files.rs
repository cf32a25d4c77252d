//! Files of users and of others.

use std::io::{Cursor, Write};
use std::path::Path;
use std::sync::Arc;

use steerguard::drive::scenario::Scenario;
use steerguard_designer::document::{Mistakes, Source};
use steerguard_designer::{Design, Spec};
use steerguard_drives::{Columns, Reader, Resampler, Spacing, Wanted};
use steerguard_model_description::xml;

/// Most bytes of a message about a file: a reader of it has to see its end.
const LONGEST_MESSAGE: usize = 2_000;

fn text(bytes: &[u8]) -> Option<&str> {
    std::str::from_utf8(bytes).ok()
}

/// Draws what is wrong with a text: places are inside it, between characters.
fn draw(mistakes: &Mistakes, text: &str) {
    let source = Source { name: "fuzz.toml".into(), text: Arc::from(text) };
    let diagnostics = mistakes.diagnostics(&source);
    assert!(!diagnostics.is_empty(), "refused without a word");
    for diagnostic in diagnostics {
        assert!(diagnostic.message.len() < LONGEST_MESSAGE, "{}", diagnostic.message);
        for label in &diagnostic.labels {
            assert!(text.get(label.span.clone()).is_some(), "{:?} of {text:?}", label.span);
        }
    }
}

pub fn specification(bytes: &[u8]) {
    let Some(text) = text(bytes) else { return };
    match Spec::from_toml(text) {
        Ok(spec) => assert!(spec.check().is_ok(), "read, and then refused"),
        Err(mistakes) => draw(&mistakes, text),
    }
}

pub fn scenario(bytes: &[u8]) {
    let Some(text) = text(bytes) else { return };
    match Scenario::parse(text) {
        Ok(scenario) => {
            let written = scenario.to_toml().unwrap();
            let again =
                Scenario::parse(&written).unwrap_or_else(|_| panic!("not read again:\n{written}"));
            assert_eq!(again, scenario, "written and read again");
            for t in [0.0, 1.0, 19.99] {
                let _ = scenario.steering_fault_rad(t, 15.0);
            }
        }
        Err(mistakes) => draw(&mistakes, text),
    }
}

pub fn design(bytes: &[u8]) {
    let Some(text) = text(bytes) else { return };
    let read = Design::from_json(text);
    let _ = Design::spec_from_json(text);
    // A text of that digest is verified; a proof takes longer than a fuzzer waits, so that one of the right digest is
    // a matter of the tests of the verifier.
    if steerguard_verify::parse(text).is_ok() && read.is_ok() {
        let _ = steerguard_verify::content(text);
    } else {
        assert!(steerguard_verify::verify(text).is_err(), "verified, and not read");
    }
}

pub fn drive(bytes: &[u8]) {
    let mut file = tempfile::NamedTempFile::new().unwrap();
    file.write_all(bytes).unwrap();
    read_drive(file.path());
}

fn read_drive(path: &Path) {
    let Ok(reader) = Reader::open(path, &Columns::default(), Wanted::ALL) else { return };
    let layout = reader.layout();
    let mut resampler = Resampler::new(reader, layout, Spacing::of_period(0.01));
    let mut last = None;
    // Far more than the rows of a short file span, unless they are far apart.
    for sample in resampler.by_ref().take(100_000) {
        let Ok(sample) = sample else { break };
        assert!(sample.sample.steering_rad.is_finite(), "{sample:?}");
        assert!(last < Some(sample.sample.time_s), "time goes on");
        last = Some(sample.sample.time_s);
    }
    let _ = resampler.rows().findings();
}

pub fn xml(bytes: &[u8]) {
    let Some(text) = text(bytes) else { return };
    judge(&xml::lint(text), text.len());
    let (read, header) = (xml::read(text), xml::header(text));
    let _ = (read, header);
    judge(&xml::lint_terminals(text, text), text.len());
}

pub fn archive(bytes: &[u8]) {
    let found = steerguard::check::check(Cursor::new(bytes), "fuzz.fmu").unwrap();
    judge(&found, bytes.len());
}

/// Findings are few, and can be read.
fn judge(found: &[xml::Finding], length: usize) {
    assert!(found.len() <= 10_000, "{} findings about {length} bytes", found.len());
    for finding in found {
        assert!(!finding.message.is_empty() && !finding.help.is_empty(), "{finding:?}");
        assert!(finding.message.len() < LONGEST_MESSAGE, "{finding:?}");
        assert!(!finding.message.contains(|c: char| c.is_control() && c != '\n'), "{finding:?}");
    }
}
