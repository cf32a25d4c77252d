//! What a co-simulation importer needs to know of an FMU.

use super::tree::{Element, Malformed, parse};

/// A description, as far as an importer needs it.
#[derive(Debug, Clone, PartialEq)]
pub struct Description {
    /// Name of the model.
    pub model_name: String,
    /// GUID, to be passed to `fmi2Instantiate`.
    pub guid: String,
    /// What the FMU can do in a co-simulation.
    pub co_simulation: CoSimulation,
    /// Proposed settings of a run.
    pub default_experiment: Experiment,
    /// All variables, in order.
    pub variables: Vec<ScalarVariable>,
}

/// The element `CoSimulation`; flags that are missing are false.
#[derive(Debug, Clone, PartialEq, Eq)]
#[expect(clippy::struct_excessive_bools, reason = "the standard's flags")]
pub struct CoSimulation {
    /// Base name of the shared library.
    pub model_identifier: String,
    /// Communication steps may differ in size.
    pub can_handle_variable_communication_step_size: bool,
    /// Input derivatives are used.
    pub can_interpolate_inputs: bool,
    /// States can be saved and restored.
    pub can_get_and_set_fmu_state: bool,
    /// Saved states can be serialised.
    pub can_serialize_fmu_state: bool,
}

/// The element `DefaultExperiment`; times in s.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Experiment {
    /// Start time, s.
    pub start_time: Option<f64>,
    /// Stop time, s.
    pub stop_time: Option<f64>,
    /// Communication step, s.
    pub step_size: Option<f64>,
}

/// A variable.
#[derive(Debug, Clone, PartialEq)]
pub struct ScalarVariable {
    /// Name.
    pub name: String,
    /// Handle in the calls.
    pub value_reference: u32,
    /// `parameter`, `input`, `output`, ...; `local` where the file says nothing.
    pub causality: String,
    /// Element name of the type: `Real`, `Integer`, `Boolean`, `String`, `Enumeration`.
    pub kind: String,
    /// Unit of a Real.
    pub unit: Option<String>,
    /// Start value.
    pub start: Option<Start>,
}

/// A start value of its variable's type.
#[derive(Debug, Clone, PartialEq)]
pub enum Start {
    /// Of a Real.
    Real(f64),
    /// Of an Integer or Enumeration.
    Integer(i32),
    /// Of a Boolean.
    Boolean(bool),
    /// Of a String.
    String(String),
}

/// Why a description cannot be used.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum ReadError {
    /// The file is no XML.
    #[error("modelDescription.xml:{line}: {reason}")]
    Malformed {
        /// Line, from 1.
        line: usize,
        /// What is wrong.
        reason: String,
    },
    /// An element or attribute is missing.
    #[error("modelDescription.xml:{line}: <{element}> has no {what}")]
    Missing {
        /// Line, from 1.
        line: usize,
        /// Element that lacks it.
        element: String,
        /// What is missing.
        what: &'static str,
    },
    /// An attribute's value is not of its type.
    #[error(
        "modelDescription.xml:{line}: {attribute}=\"{value}\" in <{element}> is not {expected}"
    )]
    Value {
        /// Line, from 1.
        line: usize,
        /// Element.
        element: String,
        /// Attribute.
        attribute: String,
        /// Its value.
        value: String,
        /// What it should be.
        expected: &'static str,
    },
}

impl From<Malformed> for ReadError {
    fn from(Malformed { line, reason }: Malformed) -> Self {
        Self::Malformed { line, reason }
    }
}

/// Reads a description for co-simulation.
///
/// # Errors
/// [`ReadError`] at the first thing that an importer cannot do without or cannot understand.
pub fn read(xml: &str) -> Result<Description, ReadError> {
    let root = parse(xml)?;
    let version = required(&root, "fmiVersion")?;
    if root.name != "fmiModelDescription" || version != "2.0" {
        return Err(value_error(&root, "fmiVersion", version, "2.0"));
    }
    let co_simulation = root.child("CoSimulation").ok_or_else(|| ReadError::Missing {
        line: root.line,
        element: root.name.clone(),
        what: "element CoSimulation",
    })?;
    let experiment = match root.child("DefaultExperiment") {
        Some(element) => Experiment {
            start_time: real(element, "startTime")?,
            stop_time: real(element, "stopTime")?,
            step_size: real(element, "stepSize")?,
        },
        None => Experiment::default(),
    };
    Ok(Description {
        model_name: required(&root, "modelName")?.to_owned(),
        guid: required(&root, "guid")?.to_owned(),
        co_simulation: read_co_simulation(co_simulation)?,
        default_experiment: experiment,
        variables: root.list("ModelVariables").iter().map(variable).collect::<Result<_, _>>()?,
    })
}

fn read_co_simulation(element: &Element) -> Result<CoSimulation, ReadError> {
    let flag = |name| boolean(element, name).map(|flag| flag.unwrap_or(false));
    Ok(CoSimulation {
        model_identifier: required(element, "modelIdentifier")?.to_owned(),
        can_handle_variable_communication_step_size: flag(
            "canHandleVariableCommunicationStepSize",
        )?,
        can_interpolate_inputs: flag("canInterpolateInputs")?,
        can_get_and_set_fmu_state: flag("canGetAndSetFMUstate")?,
        can_serialize_fmu_state: flag("canSerializeFMUstate")?,
    })
}

fn variable(element: &Element) -> Result<ScalarVariable, ReadError> {
    let reference = required(element, "valueReference")?;
    let kind = element.children.first().ok_or_else(|| ReadError::Missing {
        line: element.line,
        element: element.name.clone(),
        what: "type",
    })?;
    let start = match kind.name.as_str() {
        "Real" => real(kind, "start")?.map(Start::Real),
        "Integer" | "Enumeration" => {
            parsed(kind, "start", "an integer", |text| text.parse().ok())?.map(Start::Integer)
        }
        "Boolean" => boolean(kind, "start")?.map(Start::Boolean),
        _ => kind.attribute("start").map(|text| Start::String(text.to_owned())),
    };
    Ok(ScalarVariable {
        name: required(element, "name")?.to_owned(),
        value_reference: reference
            .parse()
            .map_err(|_| value_error(element, "valueReference", reference, "a value reference"))?,
        causality: element.attribute("causality").unwrap_or("local").to_owned(),
        kind: kind.name.clone(),
        unit: kind.attribute("unit").map(str::to_owned),
        start,
    })
}

fn required<'e>(element: &'e Element, what: &'static str) -> Result<&'e str, ReadError> {
    element.attribute(what).ok_or_else(|| ReadError::Missing {
        line: element.line,
        element: element.name.clone(),
        what,
    })
}

fn parsed<T>(
    element: &Element,
    attribute: &str,
    expected: &'static str,
    parse: impl FnOnce(&str) -> Option<T>,
) -> Result<Option<T>, ReadError> {
    let Some(text) = element.attribute(attribute) else { return Ok(None) };
    let value = parse(text.trim());
    value.map(Some).ok_or_else(|| value_error(element, attribute, text, expected))
}

fn real(element: &Element, attribute: &str) -> Result<Option<f64>, ReadError> {
    parsed(element, attribute, "a finite number", |text| {
        text.parse().ok().filter(|value: &f64| value.is_finite())
    })
}

fn boolean(element: &Element, attribute: &str) -> Result<Option<bool>, ReadError> {
    parsed(element, attribute, "true or false", |text| match text {
        "true" | "1" => Some(true),
        "false" | "0" => Some(false),
        _ => None,
    })
}

fn value_error(
    element: &Element,
    attribute: &str,
    value: &str,
    expected: &'static str,
) -> ReadError {
    ReadError::Value {
        line: element.line,
        element: element.name.clone(),
        attribute: attribute.to_owned(),
        value: value.to_owned(),
        expected,
    }
}
