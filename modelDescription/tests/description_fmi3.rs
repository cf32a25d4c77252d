//! The detector's description in FMI 3.0: rendered, and examined.

#![allow(clippy::unwrap_used, clippy::panic)]

use std::collections::HashSet;

use steerguard_model_description::detector::{DetectorVariable, INFO};
use steerguard_model_description::structure::{Entry, Member, Structure, entry};
use steerguard_model_description::xml::{Rendered, fmi3, header, lint, lint_terminals};
use steerguard_model_description::{DefaultExperiment, Kind, Value, VariableSet};

const EXPERIMENT: DefaultExperiment =
    DefaultExperiment { start_time: 0.0, stop_time: 20.0, step_size: 0.01 };

fn start(variable: DetectorVariable) -> Value<'static> {
    match DetectorVariable::TABLE[variable.value_reference() as usize].kind {
        Kind::Real(_) => Value::Real(0.1),
        Kind::Integer { min, .. } => Value::Integer(min),
        Kind::Enumeration(_) => Value::Integer(1),
        Kind::Boolean => Value::Boolean(false),
        Kind::String => Value::String(c"<&\">"),
    }
}

fn rendered() -> Rendered {
    fmi3::describe(&INFO, start, &EXPERIMENT).unwrap()
}

/// A change of names, types, references or structure is a change of the stored files.
#[test]
fn description_and_terminals_are_the_stored_ones() {
    insta::assert_snapshot!("description_fmi3", rendered().xml);
    insta::assert_snapshot!("terminals", fmi3::terminals::<DetectorVariable>().unwrap());
}

#[test]
fn they_have_no_finding() {
    let Rendered { guid, xml } = rendered();
    assert_eq!(lint(&xml), []);
    assert_eq!(lint_terminals(&fmi3::terminals::<DetectorVariable>().unwrap(), &xml), []);
    let header = header(&xml).unwrap();
    assert!(header.is_version_3);
    assert_eq!(header.guid, guid);
}

#[test]
fn an_array_is_of_neighbours_of_one_type_and_role() {
    for array in DetectorVariable::ARRAYS {
        let indices: Vec<usize> =
            array.elements.iter().map(|element| element.value_reference() as usize).collect();
        assert!(indices.len() > 1 && indices.windows(2).all(|pair| pair[1] == pair[0] + 1));
        let first = DetectorVariable::TABLE[indices[0]];
        for &index in &indices {
            let row = DetectorVariable::TABLE[index];
            assert_eq!(row.role, first.role);
            assert_eq!(row.kind.name(), first.kind.name());
        }
    }
    let watched = DetectorVariable::CLOCK.watched.value_reference() as usize;
    assert_eq!(DetectorVariable::TABLE[watched].kind, Kind::Boolean);
}

#[test]
fn a_value_reference_stands_for_what_the_description_says() {
    let xml = rendered().xml;
    let count = DetectorVariable::ALL.len() as u32;
    let mut elements: HashSet<DetectorVariable> = HashSet::new();
    for reference in 0..count + 10 {
        let described = xml.contains(&format!(" valueReference=\"{reference}\" description="));
        let found = entry::<DetectorVariable>(reference);
        assert_eq!(found.is_some(), described, "{reference}");
        if let Some(Entry::Elements(of)) = found {
            assert_eq!(of[0].value_reference(), reference);
            elements.extend(of);
        }
    }
    assert_eq!(elements.len(), DetectorVariable::ALL.len(), "each variable is in one");
    assert_eq!(entry::<DetectorVariable>(u32::MAX), None);
}

#[test]
fn members_of_terminals_are_no_elements_of_arrays() {
    for terminal in DetectorVariable::TERMINALS {
        for (name, member) in terminal.members {
            if let Member::Variable(variable) = member {
                let alone = Some(Entry::Elements(std::slice::from_ref(variable)));
                assert_eq!(entry::<DetectorVariable>(variable.value_reference()), alone, "{name}");
            }
        }
    }
}

/// What is replaced in the sound description, by what, and the rule that must notice.
const DEFECTS: [(&str, &str, &str); 33] = [
    ("</ModelStructure>", "", "malformed-xml"),
    ("modelName=\"SteeringFaultDetector\"", "modelName=\"\"", "empty-model-name"),
    ("<CoSimulation model", "<CoDissimulation model", "no-implementation"),
    ("modelIdentifier=\"Ste", "modelIdentifier=\"2 Ste", "model-identifier"),
    ("canGetAndSetFMUState=\"true\"", "", "serialize-without-get"),
    ("hasEventMode=\"true\"", "hasEventMode=\"false\"", "clock-without-event-mode"),
    (
        "hasEventMode=\"true\"",
        "hasEventMode=\"true\" canReturnEarlyAfterIntermediateUpdate=\"1\"",
        "early-return",
    ),
    ("fixedInternalStepSize=\"0.01\"", "fixedInternalStepSize=\"0\"", "experiment"),
    ("<Unit name=\"m/s\">", "<Unit name=\"km/s\">", "unknown-unit"),
    ("<EnumerationType name=\"DetectorState\"", "<EnumerationType name=\"S\"", "unknown-type"),
    ("Item name=\"Starting\"", "Item name=\"Monitoring\"", "duplicate-name"),
    ("stopTime=\"20.0\"", "stopTime=\"-1\"", "experiment"),
    ("Float64 name=\"r\"", "Float64 name=\"v_x\"", "duplicate-name"),
    ("valueReference=\"0\" desc", "valueReference=\"-1\" desc", "value-reference"),
    ("valueReference=\"0\" desc", "valueReference=\"1\" desc", "value-reference"),
    ("causality=\"independent\"", "causality=\"local\" initial=\"calculated\"", "independent"),
    ("max=\"150.0\"", "max=\"-151\"", "max-below-min"),
    ("nominal=\"10.0\" start=\"0.1\"", "nominal=\"10\" start=\"151\"", "start-out-of-range"),
    ("nominal=\"10.0\" start=\"0.1\"", "nominal=\"10\" start=\"NaN\"", "not-finite"),
    ("nominal=\"10.0\" start=\"0.1\"", "nominal=\"10\"", "start-missing"),
    ("start=\"0.1 0.1 0.1\"", "start=\"0.1 0.1\"", "start-count"),
    ("<Dimension start=\"3\"/>", "<Dimension/>", "dimension"),
    ("<Dimension start=\"3\"/>", "<Dimension valueReference=\"1\"/>", "dimension"),
    ("variability=\"continuous\"", "variability=\"fixed\"", "role"),
    ("causality=\"input\"", "causality=\"input\" initial=\"approx\"", "initial"),
    (
        "variability=\"discrete\" start=\"false\"",
        "variability=\"continuous\"",
        "continuous-not-real",
    ),
    ("intervalVariability=\"triggered\"", "intervalVariability=\"sometimes\"", "clock"),
    ("clocks=\"", "clocks=\"0 ", "clock"),
    ("<Output valueReference=\"7\" dependencies=\"\"/>", "", "missing-output"),
    ("<InitialUnknown valueReference=\"7\" dependencies=\"\"/>", "", "missing-output"),
    ("<Output valueReference=\"7\"", "<Output valueReference=\"1\"", "structure-index"),
    ("<Output valueReference=\"7\"", "<Output valueReference=\"6\"", "structure-index"),
    (
        "<Output valueReference=\"7\" dependencies=\"\"",
        "<Output valueReference=\"7\" dependencies=\"500\"",
        "dependency",
    ),
];

#[test]
fn every_rule_notices_its_defect() {
    let Rendered { guid, xml } = rendered();
    let empty_token = (guid.as_str(), "", "empty-guid");
    for (from, to, code) in DEFECTS.into_iter().chain([empty_token]) {
        assert!(xml.contains(from), "{from}");
        let findings = lint(&xml.replacen(from, to, 1));
        let found = findings.iter().find(|finding| finding.code == code);
        let finding = found.unwrap_or_else(|| panic!("{code} not found among {findings:#?}"));
        assert!(finding.location.starts_with("modelDescription.xml:"), "{finding}");
    }
}

#[test]
fn every_rule_of_terminals_notices_its_defect() {
    let description = rendered().xml;
    let terminals = fmi3::terminals::<DetectorVariable>().unwrap();
    for (from, to, code) in [
        ("</Terminals>", "", "malformed-xml"),
        ("fmiVersion=\"3.0\"", "fmiVersion=\"2.0\"", "version"),
        ("Terminal name=\"command\"", "Terminal name=\"verdict\"", "duplicate-name"),
        ("matchingRule=\"plug\"", "matchingRule=\"glue\"", "matching-rule"),
        ("variableName=\"v_x\"", "variableName=\"v_z\"", "unknown-variable"),
        ("memberName=\"v_x\"", "memberName=\"r\"", "duplicate-name"),
        ("memberName=\"v_x\"", "", "member-name"),
    ] {
        assert!(terminals.contains(from), "{from}");
        let findings = lint_terminals(&terminals.replacen(from, to, 1), &description);
        let found = findings.iter().find(|finding| finding.code == code);
        let finding = found.unwrap_or_else(|| panic!("{code} not found among {findings:#?}"));
        assert!(finding.location.starts_with("terminalsAndIcons.xml:"), "{finding}");
    }
}
