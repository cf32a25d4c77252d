//! Findings about an FMU file: its archive, its description, its binaries, and what comes with them.
//!
//! # Conventions
//! - Nothing in the file is trusted: it is read once, entry by entry, within the bounds of the
//!   importer; nothing is written, and no code of it runs.
//! - A rule that several entries break is one finding, which names the first of them.
//! - Rules are those of FMI 2.0.4, section 2.3, and FMI 3.0.2, section 2.5, and what importers are known
//!   to trip over. A file without a finding of level error is one that importers can be expected to take.

mod archive;
mod binary;
mod digests;
mod findings;
mod functions;
mod surroundings;

use std::io::{Read, Seek};

use steerguard_model_description::xml::{self, Finding};

use crate::fmu::package::TERMINALS;
use findings::{Contents, DESCRIPTION, Findings};

/// Examines an FMU; `name` is what findings call the file.
///
/// # Errors
/// Only what reading the file says: what is wrong with its bytes is a finding.
pub fn check(fmu: impl Read + Seek, name: &str) -> std::io::Result<Vec<Finding>> {
    let mut findings = Findings { file: name.to_owned(), list: xml::Findings::default() };
    if let Some(contents) = archive::read(fmu, &mut findings)? {
        description(&contents, &mut findings);
        digests::check(&contents, &mut findings);
        surroundings::check(&contents, &mut findings);
    }
    Ok(findings.list.into_list())
}

/// Description, and the binaries as far as it names them.
fn description(contents: &Contents, findings: &mut Findings) {
    let Some(bytes) = contents.files.get(DESCRIPTION) else { return };
    let Ok(text) = std::str::from_utf8(bytes) else {
        let help = "save it as UTF-8, as its XML declaration has to say";
        findings.error("description-encoding", "the description is not UTF-8", DESCRIPTION, help);
        return;
    };
    declared_encoding(text, DESCRIPTION, findings);
    findings.list.extend(xml::lint(text));
    // What is no XML has been found above.
    if let Ok(header) = xml::header(text) {
        binary::check(contents, text, &header, findings);
        if header.is_version_3 {
            terminals(contents, text, findings);
        }
    }
}

/// An XML declaration that names another encoding than the file, which is UTF-8, has.
fn declared_encoding(text: &str, at: &str, findings: &mut Findings) {
    let declaration = text.trim_start_matches('\u{feff}').strip_prefix("<?xml");
    let Some((declaration, _)) = declaration.and_then(|rest| rest.split_once("?>")) else { return };
    let Some((_, value)) = declaration.split_once("encoding") else { return };
    let encoding = value.split(['"', '\'']).nth(1).unwrap_or_default();
    let is_true = encoding.eq_ignore_ascii_case("UTF-8")
        || encoding.eq_ignore_ascii_case("US-ASCII") && text.is_ascii();
    if !is_true {
        let message = format!("the XML declaration says {encoding:?}, the file is UTF-8");
        let help = "importers that believe it read wrong names, or nothing: declare UTF-8";
        findings.error("declared-encoding", message, at, help);
    }
}

/// The terminals of an FMU of FMI 3.0, if it has any.
fn terminals(contents: &Contents, description: &str, findings: &mut Findings) {
    let Some(bytes) = contents.files.get(TERMINALS) else { return };
    match std::str::from_utf8(bytes) {
        Ok(text) => {
            declared_encoding(text, TERMINALS, findings);
            findings.list.extend(xml::lint_terminals(text, description));
        }
        Err(_) => {
            let message = "the file is not UTF-8";
            findings.error("description-encoding", message, TERMINALS, "save it as UTF-8");
        }
    }
}
