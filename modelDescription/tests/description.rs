//! The detector's description as importers see it: rendered, read back, and examined.

#![allow(clippy::unwrap_used, clippy::panic)]

use steerguard_model_description::detector::{DetectorVariable, INFO};
use steerguard_model_description::xml::{
    Level, ReadError, Rendered, Start, describe, lint, read, render,
};
use steerguard_model_description::{
    Causality, DefaultExperiment, Initial, Kind, Value, Variability, VariableSet,
};

const EXPERIMENT: DefaultExperiment =
    DefaultExperiment { start_time: 0.0, stop_time: 20.0, step_size: 0.01 };

/// Some value that the variable admits.
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
    describe(&INFO, start, &EXPERIMENT).unwrap()
}

/// A change of names, types, references or structure is a change of the stored file.
#[test]
fn the_description_is_the_stored_one() {
    insta::assert_snapshot!("description", rendered().xml);
}

#[test]
fn the_table_is_sound() {
    let table = DetectorVariable::TABLE;
    assert_eq!(table.len(), DetectorVariable::ALL.len());
    for (index, (variable, row)) in DetectorVariable::ALL.iter().zip(table).enumerate() {
        assert_eq!(variable.value_reference() as usize, index);
        assert!(!row.name.is_empty() && row.description.len() > 5, "{row:?}");
        assert!(!row.description.ends_with('.'), "{row:?}");
        assert_eq!(table.iter().filter(|other| other.name == row.name).count(), 1, "{row:?}");
        let role = row.role;
        // FMI 2.0.4, section 2.2.7: what goes together.
        let sound = match role.causality {
            Causality::Parameter => {
                matches!(role.variability, Variability::Fixed | Variability::Tunable)
                    && role.initial == Some(Initial::Exact)
            }
            Causality::Input => {
                let continuous = role.variability == Variability::Continuous;
                role.initial.is_none() && continuous == matches!(row.kind, Kind::Real(_))
            }
            Causality::Output => role.variability == Variability::Discrete,
            Causality::Local => true,
        };
        assert!(sound, "{row:?}");
        assert!(!role.has_start() || row.kind.admits(start(*variable)), "{row:?}");
        if let Kind::Real(real) = row.kind {
            assert!(real.nominal.is_some_and(|nominal| nominal > 0.0), "{row:?}");
        }
    }
}

#[test]
fn what_is_rendered_reads_back() {
    let Rendered { guid, xml } = rendered();
    let description = read(&xml).unwrap();
    assert_eq!(description.guid, guid);
    assert_eq!(description.model_name, "SteeringFaultDetector");
    assert_eq!(description.co_simulation.model_identifier, "SteeringFaultDetector");
    assert!(description.co_simulation.can_serialize_fmu_state);
    assert_eq!(description.default_experiment.step_size, Some(0.01));
    assert_eq!(description.variables.len(), DetectorVariable::ALL.len());
    for (read, (&variable, row)) in
        description.variables.iter().zip(DetectorVariable::ALL.iter().zip(DetectorVariable::TABLE))
    {
        assert_eq!(read.name, row.name);
        assert_eq!(read.value_reference, variable.value_reference());
        assert_eq!(read.kind, row.kind.name());
        let expected = row.role.has_start().then(|| match start(variable) {
            Value::Real(value) => Start::Real(value),
            Value::Integer(value) => Start::Integer(value),
            Value::Boolean(value) => Start::Boolean(value),
            Value::String(value) => Start::String(value.to_str().unwrap().to_owned()),
        });
        assert_eq!(read.start, expected, "{}", row.name);
    }
    let speed = &description.variables[0];
    assert_eq!((speed.causality.as_str(), speed.unit.as_deref()), ("input", Some("m/s")));
}

#[test]
fn numbers_survive_bit_for_bit() {
    for value in [1.0 / 3.0, 5e-324, f64::MAX, -1e-7, 123456789.123456, 1e21] {
        let start = |variable| match start(variable) {
            Value::Real(_) => Value::Real(value),
            other => other,
        };
        let xml = render::<DetectorVariable>(&INFO, "{}", start, &EXPERIMENT).unwrap();
        assert_eq!(read(&xml).unwrap().variables[0].start, Some(Start::Real(value)));
    }
}

#[test]
fn the_guid_follows_the_contents() {
    let Rendered { guid, xml } = rendered();
    assert_eq!(rendered().xml, xml);
    let groups: Vec<_> = guid[1..37].split('-').map(str::len).collect();
    assert_eq!((groups, guid.len()), (vec![8, 4, 4, 4, 12], 38));
    let other = DefaultExperiment { step_size: 0.02, ..EXPERIMENT };
    assert_ne!(describe(&INFO, start, &other).unwrap().guid, guid);
}

#[test]
fn the_description_has_no_finding() {
    assert_eq!(lint(&rendered().xml), []);
}

/// What is replaced in the sound description, by what, and the rule that must notice.
const DEFECTS: [(&str, &str, &str); 38] = [
    ("</ModelStructure>", "", "malformed-xml"),
    ("fmiVersion=\"2.0\"", "fmiVersion=\"1.0\"", "version"),
    ("modelName=\"SteeringFaultDetector\"", "modelName=\"\"", "empty-model-name"),
    ("license=", "generationDateAndTime=\"31.1.2024\" license=", "date-form"),
    ("license=", "generationDateAndTime=\"2024-13-31T23:59:59Z\" license=", "date-form"),
    ("CoSimulation model", "CoDissimulation model", "no-implementation"),
    ("modelIdentifier=\"Ste", "modelIdentifier=\"2 Ste", "model-identifier"),
    ("canGetAndSetFMUstate=\"true\"", "canGetAndSetFMUstate=\"false\"", "serialize-without-get"),
    ("<Unit name=\"m/s\">", "<Unit name=\"rad\">", "duplicate-name"),
    ("<Unit name=\"m/s\">", "<Unit name=\"km/s\">", "unknown-unit"),
    ("<DisplayUnit name=\"km/h\"", "<DisplayUnit name=\"mph\"", "unknown-unit"),
    ("<SimpleType name=\"DetectorState\"", "<SimpleType name=\"S\"", "unknown-type"),
    ("Item name=\"Starting\"", "Item name=\"Monitoring\"", "duplicate-name"),
    (
        "value=\"1\" description=\"No sample",
        "value=\"2\" description=\"No",
        "enumeration-duplicate",
    ),
    ("value=\"1\" description=\"No sample", "value=\"a\" description=\"No", "enumeration-value"),
    ("<Category name=\"logAll\"", "<Category name=\"logEvents\"", "duplicate-name"),
    ("stopTime=\"20.0\"", "stopTime=\"-1\"", "experiment"),
    ("stepSize=\"0.01\"", "stepSize=\"0\"", "experiment"),
    ("ScalarVariable name=\"r\"", "ScalarVariable name=\"v_x\"", "duplicate-name"),
    ("ScalarVariable name=\"r\"", "ScalarVariable name=\"\"", "empty-name"),
    ("<Boolean start=\"false\"", "<Boolaen start=\"false\"", "no-type"),
    ("<Boolean start=\"false\"", "<Boolean start=\"yes\"", "start-form"),
    ("valueReference=\"0\"", "valueReference=\"-1\"", "value-reference"),
    ("max=\"150.0\"", "max=\"-151\"", "max-below-min"),
    ("max=\"150.0\" nominal=\"10.0\"", "max=\"0.05\"", "start-out-of-range"),
    ("nominal=\"10.0\" start=\"0.1\"", "nominal=\"200\" start=\"0.1\"", "nominal-out-of-range"),
    ("nominal=\"10.0\" start=\"0.1\"", "nominal=\"0\" start=\"0.1\"", "nominal-zero"),
    ("nominal=\"10.0\" start=\"0.1\"", "nominal=\"10\" start=\"NaN\"", "not-finite"),
    ("nominal=\"10.0\" start=\"0.1\"", "nominal=\"10\"", "start-missing"),
    ("nominal=\"0.01\"/>", "nominal=\"0.01\" start=\"0\"/>", "start-of-calculated"),
    ("variability=\"continuous\"", "variability=\"fixed\"", "role"),
    ("causality=\"input\"", "causality=\"input\" initial=\"exact\"", "initial"),
    (
        "discrete\" initial=\"calculated\">\n      <Bool",
        "continuous\">\n      <Bool",
        "continuous-not-real",
    ),
    (
        "declaredType=\"Initialisation\" start=\"1\"",
        "declaredType=\"Initialisation\" start=\"3\"",
        "start-out-of-range",
    ),
    ("<Unknown index=\"6\" dependencies=\"\"/>", "", "missing-output"),
    ("<Unknown index=\"6\"", "<Unknown index=\"1\"", "structure-index"),
    ("<Unknown index=\"6\"", "<Unknown index=\"500\"", "structure-index"),
    ("index=\"6\" dependencies=\"\"", "index=\"6\" dependencies=\"0\"", "dependency"),
];

#[test]
fn every_rule_notices_its_defect() {
    let Rendered { guid, xml } = rendered();
    let empty_guid = (guid.as_str(), "", "empty-guid");
    for (from, to, code) in DEFECTS.into_iter().chain([empty_guid]) {
        assert!(xml.contains(from), "{from}");
        let findings = lint(&xml.replacen(from, to, 1));
        let found = findings.iter().find(|finding| finding.code == code);
        let finding = found.unwrap_or_else(|| panic!("{code} not found among {findings:#?}"));
        assert!(finding.location.starts_with("modelDescription.xml:"), "{finding}");
        assert!(finding.level == Level::Error || code == "nominal-out-of-range");
    }
}

#[test]
fn elements_that_are_missing_are_noticed() {
    let xml = rendered().xml;
    for (element, code) in [("ModelVariables", "no-variables"), ("ModelStructure", "structure")] {
        let findings = lint(&xml.replace(element, "Other"));
        assert!(findings.iter().any(|finding| finding.code == code), "{findings:#?}");
    }
}

#[test]
fn a_finding_reads_like_a_compiler_s() {
    let Rendered { guid, xml } = rendered();
    let findings = lint(&xml.replace(&guid, ""));
    assert_eq!(
        findings[0].to_string(),
        "error[empty-guid]: guid is missing or empty\n  --> modelDescription.xml:2\n  = help: \
         importers identify the FMU by it"
    );
}

#[test]
fn reading_names_line_and_reason() {
    let xml = rendered().xml;
    let refuse = |from: &str, to: &str| read(&xml.replacen(from, to, 1)).unwrap_err();
    assert!(matches!(refuse("</fmiModelDescription>", ""), ReadError::Malformed { .. }));
    assert!(matches!(
        refuse("<CoSimulation", "<ModelExchange"),
        ReadError::Missing { line: 2, .. }
    ));
    assert_eq!(
        refuse("stepSize=\"0.01\"", "stepSize=\"fast\"").to_string().split(": ").nth(1),
        Some("stepSize=\"fast\" in <DefaultExperiment> is not a finite number")
    );
    let deep = "<a>".repeat(1000);
    assert!(read(&deep).unwrap_err().to_string().contains("nested"));
    for text in ["", "no xml", "<a b='1' b='2'/>", "<a/><b/>", "<a>&unknown;", "<a b='&c;'/>"] {
        assert!(read(text).is_err(), "{text}");
    }
}
