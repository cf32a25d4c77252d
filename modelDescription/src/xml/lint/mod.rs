//! Findings about a description, as a compiler would report them: rules of the standard as far as XML
//! schema validation does not cover them or importers are known to trip over them.

mod common;
mod finding;
mod fmi2;
mod fmi3;
mod terminals;

pub use finding::{Finding, Findings, Level};

use super::tree::{Element, Malformed, parse};
use common::Linter;

/// Examines a description of FMI 2.0 or 3.0.
pub fn lint(xml: &str) -> Vec<Finding> {
    examine("modelDescription.xml", parse(xml), |linter, root| {
        if super::header::is_version_3(root) { linter.fmi3(root) } else { linter.fmi2(root) }
    })
}

/// Examines the `terminalsAndIcons.xml` that belongs to a description of FMI 3.0.
pub fn lint_terminals(terminals: &str, description: &str) -> Vec<Finding> {
    // What is wrong with the description is found by `lint`.
    let variables = parse(description).unwrap_or_default();
    examine("terminalsAndIcons.xml", parse(terminals), |linter, root| {
        linter.terminals(root, variables.list("ModelVariables"));
    })
}

fn examine(
    file: &'static str,
    root: Result<Element, Malformed>,
    rules: impl FnOnce(&mut Linter, &Element),
) -> Vec<Finding> {
    let mut linter = Linter { file, findings: Findings::default() };
    match root {
        Ok(root) => {
            linter.characters(&root);
            rules(&mut linter, &root);
        }
        Err(malformed) => {
            let root = Element { line: malformed.line, ..Element::default() };
            linter.error(&root, "malformed-xml", malformed.reason, "write well-formed XML");
        }
    }
    linter.findings.into_list()
}
