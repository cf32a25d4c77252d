//! What descriptions of all versions have in common.

use std::fmt::Write as _;
use std::io;

use quick_xml::events::{BytesDecl, Event};
use quick_xml::writer::Writer;
use sha2::{Digest, Sha256};

use crate::unit::BASE_UNITS;
use crate::{
    Causality, DefaultExperiment, EnumerationType, Initial, Kind, LogCategory, ModelInfo, RealKind,
    Role, Unit, Value, Variability, Variable,
};

pub(super) type Xml = Writer<Vec<u8>>;
/// Attributes of an element, in order.
pub(super) type Attributes = Vec<(&'static str, String)>;

/// A description together with its GUID.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Rendered {
    /// `{8-4-4-4-12}` hexadecimal digits: digest of the description rendered with an empty GUID.
    pub guid: String,
    /// The text of `modelDescription.xml`.
    pub xml: String,
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

/// A document with a declaration and the element that `content` writes.
pub(super) fn document(content: impl FnOnce(&mut Xml) -> io::Result<()>) -> io::Result<String> {
    let mut xml = Writer::new_with_indent(Vec::new(), b' ', 2);
    xml.write_event(Event::Decl(BytesDecl::new("1.0", Some("UTF-8"), None)))?;
    content(&mut xml)?;
    let mut text = xml.into_inner();
    text.push(b'\n');
    String::from_utf8(text).map_err(io::Error::other)
}

/// Attributes of the root; `token` is the name of what identifies the FMU and its value.
pub(super) fn root(version: &str, info: &ModelInfo, token: (&'static str, &str)) -> Attributes {
    vec![
        ("fmiVersion", version.to_owned()),
        ("modelName", info.name.to_owned()),
        (token.0, token.1.to_owned()),
        ("description", info.description.to_owned()),
        ("license", "MIT OR Apache-2.0".to_owned()),
        ("generationTool", concat!("steerguard ", env!("CARGO_PKG_VERSION")).to_owned()),
        ("variableNamingConvention", "structured".to_owned()),
    ]
}

pub(super) fn element(
    xml: &mut Xml,
    name: &str,
    attributes: Attributes,
    content: impl FnOnce(&mut Xml) -> io::Result<()>,
) -> io::Result<()> {
    let attributes = attributes.iter().map(|(name, value)| (*name, value.as_str()));
    xml.create_element(name).with_attributes(attributes).write_inner_content(content)?;
    Ok(())
}

pub(super) fn empty(xml: &mut Xml, name: &str, attributes: Attributes) -> io::Result<()> {
    let attributes = attributes.iter().map(|(name, value)| (*name, value.as_str()));
    xml.create_element(name).with_attributes(attributes).write_empty()?;
    Ok(())
}

/// The shortest decimal that reads back to the same number.
pub(super) fn number(value: f64) -> String {
    format!("{value:?}")
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

pub(super) fn unit_definitions(xml: &mut Xml, table: &'static [Variable]) -> io::Result<()> {
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

/// The enumerations of a table, each once.
pub(super) fn enumerations(table: &'static [Variable]) -> Vec<&'static EnumerationType> {
    distinct(table.iter().filter_map(|row| match &row.kind {
        Kind::Enumeration(enumeration) => Some(*enumeration),
        _ => None,
    }))
}

/// The items of an enumeration.
pub(super) fn items(xml: &mut Xml, enumeration: &EnumerationType) -> io::Result<()> {
    enumeration.items.iter().enumerate().try_for_each(|(i, item)| {
        let attributes = vec![
            ("name", item.name.to_owned()),
            ("value", (i + 1).to_string()),
            ("description", item.description.to_owned()),
        ];
        empty(xml, "Item", attributes)
    })
}

/// Log categories; `functions` is what names of functions begin with.
pub(super) fn log_categories(xml: &mut Xml, functions: &str) -> io::Result<()> {
    element(xml, "LogCategories", vec![], |xml| {
        LogCategory::ALL.iter().try_for_each(|category| {
            let attributes = vec![
                ("name", category.name().to_string_lossy().into_owned()),
                ("description", category.description().replace("fmi2", functions)),
            ];
            empty(xml, "Category", attributes)
        })
    })
}

pub(super) fn default_experiment(xml: &mut Xml, experiment: &DefaultExperiment) -> io::Result<()> {
    let attributes = vec![
        ("startTime", number(experiment.start_time)),
        ("stopTime", number(experiment.stop_time)),
        ("stepSize", number(experiment.step_size)),
    ];
    empty(xml, "DefaultExperiment", attributes)
}

/// A start value.
pub(super) fn start_text(start: Value<'_>) -> String {
    match start {
        Value::Real(value) => number(value),
        Value::Integer(value) => value.to_string(),
        Value::Boolean(value) => value.to_string(),
        Value::String(value) => value.to_string_lossy().into_owned(),
    }
}

/// Causality, variability and initial.
pub(super) fn role_attributes(role: Role) -> Attributes {
    let mut attributes = vec![
        ("causality", causality(role.causality).to_owned()),
        ("variability", variability(role.variability).to_owned()),
    ];
    attributes.extend(role.initial.map(|initial| {
        let initial = match initial {
            Initial::Exact => "exact",
            Initial::Calculated => "calculated",
        };
        ("initial", initial.to_owned())
    }));
    attributes
}

pub(super) fn real_attributes(real: &RealKind) -> Attributes {
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
