//! Rendering to the schema of FMI 2.0.

use std::fmt::Write as _;
use std::io;

use quick_xml::events::{BytesDecl, Event};
use quick_xml::writer::Writer;
use sha2::{Digest, Sha256};

use crate::unit::BASE_UNITS;
use crate::{
    Causality, DefaultExperiment, Dependencies, EnumerationType, Initial, Kind, LogCategory,
    ModelInfo, RealKind, Unit, Value, Variability, Variable, VariableSet,
};

type Xml = Writer<Vec<u8>>;
/// Attributes of an element, in order.
type Attributes = Vec<(&'static str, String)>;

/// A description together with its GUID.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Rendered {
    /// `{8-4-4-4-12}` hexadecimal digits: digest of the description rendered with an empty GUID.
    pub guid: String,
    /// The text of `modelDescription.xml`.
    pub xml: String,
}

/// Renders the description with the GUID that its contents give; `start` as in [`render`].
///
/// # Errors
/// As [`render`].
pub fn describe<'a, V: VariableSet>(
    info: &ModelInfo,
    start: impl Fn(V) -> Value<'a>,
    experiment: &DefaultExperiment,
) -> io::Result<Rendered> {
    let guid = digest(&render(info, "", &start, experiment)?);
    let xml = render(info, &guid, &start, experiment)?;
    Ok(Rendered { guid, xml })
}

/// The GUID that belongs to a description with an empty GUID.
pub fn digest(blank: &str) -> String {
    let mut guid = String::from("{");
    for (i, byte) in Sha256::digest(blank.as_bytes()).iter().take(16).enumerate() {
        let dash = if matches!(i, 4 | 6 | 8 | 10) { "-" } else { "" };
        let _ = write!(guid, "{dash}{byte:02x}"); // writing to a String cannot fail
    }
    guid.push('}');
    guid
}

/// Renders the description of a model. `start` gives a variable's value in a fresh instance; it is
/// asked where the standard wants a start value.
///
/// # Errors
/// Only what writing to memory can give.
pub fn render<'a, V: VariableSet>(
    info: &ModelInfo,
    guid: &str,
    start: impl Fn(V) -> Value<'a>,
    experiment: &DefaultExperiment,
) -> io::Result<String> {
    let mut xml = Writer::new_with_indent(Vec::new(), b' ', 2);
    xml.write_event(Event::Decl(BytesDecl::new("1.0", Some("UTF-8"), None)))?;
    let attributes = vec![
        ("fmiVersion", "2.0".to_owned()),
        ("modelName", info.name.to_owned()),
        ("guid", guid.to_owned()),
        ("description", info.description.to_owned()),
        ("license", "MIT OR Apache-2.0".to_owned()),
        ("generationTool", concat!("steerguard ", env!("CARGO_PKG_VERSION")).to_owned()),
        ("variableNamingConvention", "structured".to_owned()),
    ];
    element(&mut xml, "fmiModelDescription", attributes, |xml| {
        co_simulation(xml, info)?;
        unit_definitions(xml, V::TABLE)?;
        type_definitions(xml, V::TABLE)?;
        log_categories(xml)?;
        default_experiment(xml, experiment)?;
        element(xml, "ModelVariables", vec![], |xml| {
            for (reference, (variable, row)) in V::ALL.iter().zip(V::TABLE).enumerate() {
                let start = row.role.has_start().then(|| start(*variable));
                scalar_variable(xml, reference, row, start)?;
            }
            Ok(())
        })?;
        model_structure::<V>(xml)
    })?;
    let mut text = xml.into_inner();
    text.push(b'\n');
    String::from_utf8(text).map_err(io::Error::other)
}

fn element(
    xml: &mut Xml,
    name: &str,
    attributes: Attributes,
    content: impl FnOnce(&mut Xml) -> io::Result<()>,
) -> io::Result<()> {
    let attributes = attributes.iter().map(|(name, value)| (*name, value.as_str()));
    xml.create_element(name).with_attributes(attributes).write_inner_content(content)?;
    Ok(())
}

fn empty(xml: &mut Xml, name: &str, attributes: Attributes) -> io::Result<()> {
    let attributes = attributes.iter().map(|(name, value)| (*name, value.as_str()));
    xml.create_element(name).with_attributes(attributes).write_empty()?;
    Ok(())
}

/// The shortest decimal that reads back to the same number.
fn number(value: f64) -> String {
    format!("{value:?}")
}

/// What the FMI layer can do: the same for every model on it.
fn co_simulation(xml: &mut Xml, info: &ModelInfo) -> io::Result<()> {
    let mut attributes = vec![("modelIdentifier", info.identifier.to_owned())];
    for (flag, value) in [
        ("canHandleVariableCommunicationStepSize", "true"),
        ("canInterpolateInputs", "true"),
        ("maxOutputDerivativeOrder", "0"),
        ("canRunAsynchronuously", "false"),
        ("canBeInstantiatedOnlyOncePerProcess", "false"),
        ("canNotUseMemoryManagementFunctions", "false"),
        ("canGetAndSetFMUstate", "true"),
        ("canSerializeFMUstate", "true"),
        ("providesDirectionalDerivative", "false"),
    ] {
        attributes.push((flag, value.to_owned()));
    }
    empty(xml, "CoSimulation", attributes)
}

/// The distinct items of an iterator, in order of first appearance.
fn distinct<'t, T: PartialEq>(items: impl Iterator<Item = &'t T>) -> Vec<&'t T> {
    let mut seen = Vec::new();
    for item in items {
        if !seen.contains(&item) {
            seen.push(item);
        }
    }
    seen
}

fn unit_definitions(xml: &mut Xml, table: &'static [Variable]) -> io::Result<()> {
    let units: Vec<&Unit> = distinct(table.iter().filter_map(|row| match &row.kind {
        Kind::Real(real) => Some(real.unit),
        _ => None,
    }));
    if units.is_empty() {
        return Ok(());
    }
    element(xml, "UnitDefinitions", vec![], |xml| {
        units.into_iter().try_for_each(|unit| {
            element(xml, "Unit", vec![("name", unit.name.to_owned())], |xml| {
                let exponents = BASE_UNITS.into_iter().zip(unit.base);
                let exponents = exponents.filter(|(_, exponent)| *exponent != 0);
                empty(xml, "BaseUnit", exponents.map(|(n, e)| (n, e.to_string())).collect())?;
                unit.display.iter().try_for_each(|display| {
                    let factor = ("factor", number(display.factor));
                    empty(xml, "DisplayUnit", vec![("name", display.name.to_owned()), factor])
                })
            })
        })
    })
}

fn type_definitions(xml: &mut Xml, table: &'static [Variable]) -> io::Result<()> {
    let types: Vec<&EnumerationType> = distinct(table.iter().filter_map(|row| match &row.kind {
        Kind::Enumeration(enumeration) => Some(*enumeration),
        _ => None,
    }));
    if types.is_empty() {
        return Ok(());
    }
    element(xml, "TypeDefinitions", vec![], |xml| {
        types.into_iter().try_for_each(|enumeration| {
            let attributes = vec![
                ("name", enumeration.name.to_owned()),
                ("description", enumeration.description.to_owned()),
            ];
            element(xml, "SimpleType", attributes, |xml| {
                element(xml, "Enumeration", vec![], |xml| {
                    enumeration.items.iter().enumerate().try_for_each(|(i, item)| {
                        let attributes = vec![
                            ("name", item.name.to_owned()),
                            ("value", (i + 1).to_string()),
                            ("description", item.description.to_owned()),
                        ];
                        empty(xml, "Item", attributes)
                    })
                })
            })
        })
    })
}

fn log_categories(xml: &mut Xml) -> io::Result<()> {
    element(xml, "LogCategories", vec![], |xml| {
        LogCategory::ALL.iter().try_for_each(|category| {
            let attributes = vec![
                ("name", category.name().to_string_lossy().into_owned()),
                ("description", category.description().to_owned()),
            ];
            empty(xml, "Category", attributes)
        })
    })
}

fn default_experiment(xml: &mut Xml, experiment: &DefaultExperiment) -> io::Result<()> {
    let attributes = vec![
        ("startTime", number(experiment.start_time)),
        ("stopTime", number(experiment.stop_time)),
        ("stepSize", number(experiment.step_size)),
    ];
    empty(xml, "DefaultExperiment", attributes)
}

fn scalar_variable(
    xml: &mut Xml,
    reference: usize,
    row: &Variable,
    start: Option<Value<'_>>,
) -> io::Result<()> {
    let mut attributes = vec![
        ("name", row.name.to_owned()),
        ("valueReference", reference.to_string()),
        ("description", row.description.to_owned()),
        ("causality", causality(row.role.causality).to_owned()),
        ("variability", variability(row.role.variability).to_owned()),
    ];
    if let Some(initial) = row.role.initial {
        let initial = match initial {
            Initial::Exact => "exact",
            Initial::Calculated => "calculated",
        };
        attributes.push(("initial", initial.to_owned()));
    }
    element(xml, "ScalarVariable", attributes, |xml| {
        let mut attributes = match &row.kind {
            Kind::Real(real) => real_attributes(real),
            Kind::Integer { min, max } => {
                vec![("min", min.to_string()), ("max", max.to_string())]
            }
            Kind::Enumeration(enumeration) => vec![("declaredType", enumeration.name.to_owned())],
            Kind::Boolean | Kind::String => vec![],
        };
        attributes.extend(start.map(|start| {
            let text = match start {
                Value::Real(value) => number(value),
                Value::Integer(value) => value.to_string(),
                Value::Boolean(value) => value.to_string(),
                Value::String(value) => value.to_string_lossy().into_owned(),
            };
            ("start", text)
        }));
        empty(xml, row.kind.name(), attributes)
    })
}

fn real_attributes(real: &RealKind) -> Attributes {
    let mut attributes = vec![("unit", real.unit.name.to_owned())];
    attributes.extend(real.unit.display.first().map(|unit| ("displayUnit", unit.name.to_owned())));
    attributes.extend(real.min.map(|min| ("min", number(min))));
    attributes.extend(real.max.map(|max| ("max", number(max))));
    attributes.extend(real.nominal.map(|nominal| ("nominal", number(nominal))));
    attributes
}

const fn causality(causality: Causality) -> &'static str {
    match causality {
        Causality::Parameter => "parameter",
        Causality::Input => "input",
        Causality::Output => "output",
        Causality::Local => "local",
    }
}

const fn variability(variability: Variability) -> &'static str {
    match variability {
        Variability::Constant => "constant",
        Variability::Fixed => "fixed",
        Variability::Tunable => "tunable",
        Variability::Discrete => "discrete",
        Variability::Continuous => "continuous",
    }
}

fn model_structure<V: VariableSet>(xml: &mut Xml) -> io::Result<()> {
    let outputs: Vec<V> = V::ALL
        .iter()
        .zip(V::TABLE)
        .filter(|(_, row)| row.role.causality == Causality::Output)
        .map(|(output, _)| *output)
        .collect();
    let index = |variable: &V| (variable.value_reference() + 1).to_string();
    let list = |xml: &mut Xml, name, known: fn(&Dependencies<V>) -> &'static [V]| {
        element(xml, name, vec![], |xml| {
            outputs.iter().try_for_each(|output| {
                let dependencies = V::DEPENDENCIES.iter().find(|of| of.output == *output);
                let known: Vec<_> = dependencies.map_or(&[][..], known).iter().map(index).collect();
                let attributes = vec![("index", index(output)), ("dependencies", known.join(" "))];
                empty(xml, "Unknown", attributes)
            })
        })
    };
    element(xml, "ModelStructure", vec![], |xml| {
        if outputs.is_empty() {
            return Ok(());
        }
        list(xml, "Outputs", |of| of.inputs)?;
        list(xml, "InitialUnknowns", |of| of.initial)
    })
}
