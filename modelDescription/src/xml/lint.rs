//! Findings about a description, as a compiler would report them.
//!
//! Rules are those of FMI 2.0.4, section 2.2, as far as XML schema validation does not cover them or
//! importers are known to trip over them.

use std::collections::{HashMap, HashSet};
use std::fmt;

use super::tree::{Element, parse};

/// File that the findings here are about.
const FILE: &str = "modelDescription.xml";

/// How bad a finding is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Level {
    /// Nothing is wrong, but it could be better.
    Note,
    /// Importers may well cope.
    Warning,
    /// Against the standard.
    Error,
}

impl Level {
    /// The word for it.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Note => "note",
            Self::Warning => "warning",
            Self::Error => "error",
        }
    }
}

/// A finding about an FMU.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Finding {
    /// How bad.
    pub level: Level,
    /// Name of the rule.
    pub code: &'static str,
    /// What is wrong, with the values.
    pub message: String,
    /// File, and line where there is one.
    pub location: String,
    /// What to do.
    pub help: String,
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}[{}]: {}", self.level.name(), self.code, self.message)?;
        writeln!(f, "  --> {}", self.location)?;
        write!(f, "  = help: {}", self.help)
    }
}

/// Examines a description.
pub fn lint(xml: &str) -> Vec<Finding> {
    let mut linter = Linter { findings: Vec::new() };
    match parse(xml) {
        Ok(root) => linter.description(&root),
        Err(malformed) => {
            let root = Element { line: malformed.line, ..Element::default() };
            linter.error(&root, "malformed-xml", malformed.reason, "write well-formed XML");
        }
    }
    linter.findings
}

struct Linter {
    findings: Vec<Finding>,
}

impl Linter {
    fn report(
        &mut self,
        level: Level,
        at: &Element,
        code: &'static str,
        message: impl Into<String>,
        help: impl Into<String>,
    ) {
        let location = format!("{FILE}:{}", at.line);
        let (message, help) = (message.into(), help.into());
        self.findings.push(Finding { level, code, message, location, help });
    }

    fn error(
        &mut self,
        at: &Element,
        code: &'static str,
        message: impl Into<String>,
        help: impl Into<String>,
    ) {
        self.report(Level::Error, at, code, message, help);
    }

    fn warning(
        &mut self,
        at: &Element,
        code: &'static str,
        message: impl Into<String>,
        help: impl Into<String>,
    ) {
        self.report(Level::Warning, at, code, message, help);
    }

    fn description(&mut self, root: &Element) {
        self.header(root);
        self.implementations(root);
        let units = self.units(root);
        let types = self.types(root);
        self.distinct(root.list("LogCategories"), "log category");
        self.experiment(root);

        let variables = root.list("ModelVariables");
        self.distinct(variables, "variable");
        if variables.is_empty() {
            self.error(root, "no-variables", "no variables are declared", "declare at least one");
        }
        for variable in variables {
            self.variable(variable, &units, &types);
        }
        self.structure(root, variables);
    }

    fn header(&mut self, root: &Element) {
        if root.attribute("fmiVersion") != Some("2.0") {
            self.error(root, "version", "fmiVersion is not \"2.0\"", "FMI 2.0 is what is checked");
        }
        for (attribute, code) in [("guid", "empty-guid"), ("modelName", "empty-model-name")] {
            if root.attribute(attribute).is_none_or(|value| value.trim().is_empty()) {
                let message = format!("{attribute} is missing or empty");
                self.error(root, code, message, "importers identify the FMU by it");
            }
        }
        if let Some(date) = root.attribute("generationDateAndTime")
            && !is_date(date)
        {
            let message = format!("generationDateAndTime=\"{date}\" is no date");
            self.error(root, "date-form", message, "write it as 2024-01-31T23:59:59Z");
        }
    }

    fn implementations(&mut self, root: &Element) {
        let mut found = false;
        for element in root.children.iter().filter(|e| is_implementation(&e.name)) {
            found = true;
            let identifier = element.attribute("modelIdentifier").unwrap_or_default();
            let c_identifier = identifier.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
                && identifier.starts_with(|c: char| !c.is_ascii_digit());
            if !c_identifier {
                let message = format!("modelIdentifier=\"{identifier}\" is no C identifier");
                self.error(element, "model-identifier", message, "use letters, digits and _");
            }
            let flag = |name| matches!(element.attribute(name), Some("true" | "1"));
            if flag("canSerializeFMUstate") && !flag("canGetAndSetFMUstate") {
                self.error(
                    element,
                    "serialize-without-get",
                    "canSerializeFMUstate is true, canGetAndSetFMUstate is not",
                    "a state must be got before it can be serialised: set both or none",
                );
            }
        }
        if !found {
            let message = "neither CoSimulation nor ModelExchange is declared";
            self.error(root, "no-implementation", message, "declare the element CoSimulation");
        }
    }

    /// Reports names that appear twice.
    fn distinct(&mut self, elements: &[Element], what: &str) {
        let mut lines = HashMap::new();
        for element in elements {
            let name = element.attribute("name").unwrap_or_default();
            if name.is_empty() {
                let message = format!("a {what} has no name");
                self.error(element, "empty-name", message, "give it a name");
            } else if let Some(line) = lines.insert(name, element.line) {
                let message = format!("{what} \"{name}\" is declared again, first in line {line}");
                self.error(element, "duplicate-name", message, "names must be unique");
            }
        }
    }

    /// Display units by unit.
    fn units<'e>(&mut self, root: &'e Element) -> HashMap<&'e str, Vec<&'e str>> {
        let units = root.list("UnitDefinitions");
        self.distinct(units, "unit");
        let name = |element: &'e Element| element.attribute("name").unwrap_or_default();
        let display = |unit: &'e Element| {
            unit.children.iter().filter(|child| child.name == "DisplayUnit").map(name).collect()
        };
        units.iter().map(|unit| (name(unit), display(unit))).collect()
    }

    /// Item values of the enumerations; `None` for other types.
    fn types<'e>(&mut self, root: &'e Element) -> HashMap<&'e str, Option<HashSet<i64>>> {
        let types = root.list("TypeDefinitions");
        self.distinct(types, "type");
        let mut declared = HashMap::new();
        for element in types {
            let name = element.attribute("name").unwrap_or_default();
            let values = element.child("Enumeration").map(|e| self.items(name, e));
            declared.insert(name, values);
        }
        declared
    }

    fn items(&mut self, name: &str, enumeration: &Element) -> HashSet<i64> {
        self.distinct(&enumeration.children, "enumeration item");
        let mut values = HashSet::new();
        for item in &enumeration.children {
            match item.attribute("value").and_then(|value| value.parse().ok()) {
                Some(value) if values.insert(value) => {}
                Some(value) => {
                    let message = format!("value {value} appears twice in enumeration \"{name}\"");
                    self.error(item, "enumeration-duplicate", message, "values must be unique");
                }
                None => {
                    let message = format!("an item of enumeration \"{name}\" has no integer value");
                    self.error(item, "enumeration-value", message, "give it one");
                }
            }
        }
        values
    }

    fn experiment(&mut self, root: &Element) {
        let Some(element) = root.child("DefaultExperiment") else { return };
        let start = self.real(element, "startTime", "the default experiment").unwrap_or(0.0);
        if let Some(stop) = self.real(element, "stopTime", "the default experiment")
            && stop < start
        {
            let message = format!("the default experiment stops at {stop} before it starts");
            self.error(element, "experiment", message, "let stopTime follow startTime");
        }
        if let Some(step) = self.real(element, "stepSize", "the default experiment")
            && step <= 0.0
        {
            let message = format!("the default step size {step} is not positive");
            self.error(element, "experiment", message, "use a positive stepSize");
        }
    }

    /// A number that must be finite.
    fn real(&mut self, element: &Element, attribute: &'static str, of: &str) -> Option<f64> {
        let text = element.attribute(attribute)?;
        match text.trim().parse::<f64>() {
            Ok(value) if value.is_finite() => Some(value),
            _ => {
                let message = format!("{attribute}=\"{text}\" of {of} is not a finite number");
                let help = "importers compare and plot it: use a finite number or leave it out";
                self.error(element, "not-finite", message, help);
                None
            }
        }
    }

    fn variable(
        &mut self,
        variable: &Element,
        units: &HashMap<&str, Vec<&str>>,
        types: &HashMap<&str, Option<HashSet<i64>>>,
    ) {
        let name = format!("\"{}\"", variable.attribute("name").unwrap_or_default());
        let reference = variable.attribute("valueReference");
        if reference.is_none_or(|reference| reference.parse::<u32>().is_err()) {
            let message = format!("variable {name} has no valid valueReference");
            self.error(variable, "value-reference", message, "use an unsigned integer");
        }
        let Some(kind) = variable.children.iter().find(|child| is_type(&child.name)) else {
            let message = format!("variable {name} has no type");
            self.error(variable, "no-type", message, "add Real, Integer, Boolean or String");
            return;
        };
        self.role(variable, kind, &name);
        match kind.name.as_str() {
            "Real" => self.limits(kind, &name),
            "Integer" => {
                self.limits(kind, &name);
                self.integer_start(kind, &name);
            }
            "Enumeration" => self.enumeration(kind, &name, types),
            "Boolean" => {
                let start = kind.attribute("start");
                if start.is_some_and(|start| !matches!(start, "true" | "false" | "0" | "1")) {
                    let message = format!("start of {name} is neither true nor false");
                    self.error(kind, "start-form", message, "write true or false");
                }
            }
            _ => {}
        }
        self.unit(kind, &name, units);
    }

    /// Causality, variability, initial and the presence of start: the tables of section 2.2.7.
    fn role(&mut self, variable: &Element, kind: &Element, name: &str) {
        let causality = variable.attribute("causality").unwrap_or("local");
        let variability = variable.attribute("variability").unwrap_or(match causality {
            "parameter" | "calculatedParameter" => "fixed",
            _ if kind.name == "Real" => "continuous",
            _ => "discrete",
        });
        if variability == "continuous" && kind.name != "Real" {
            let message = format!("{name} is continuous but not Real");
            self.error(variable, "continuous-not-real", message, "make it discrete");
        }
        let Some(allowed) = allowed_initials(causality, variability) else {
            let message = format!("{name}: causality {causality} with variability {variability}");
            self.error(variable, "role", message, "this combination is not allowed");
            return;
        };
        let declared = variable.attribute("initial");
        let initial = declared.or(allowed.first().copied());
        if let Some(declared) = declared
            && !allowed.contains(&declared)
        {
            let message = format!(
                "{name}: initial=\"{declared}\" with causality {causality}, variability {variability}"
            );
            let help = match allowed {
                [] => "leave it out".to_owned(),
                allowed => format!("allowed here: {}", allowed.join(", ")),
            };
            self.error(variable, "initial", message, help);
        }
        let wanted = causality == "input" || matches!(initial, Some("exact" | "approx"));
        match (wanted, kind.attribute("start").is_some()) {
            (true, false) => {
                let message = format!("{name} has no start value");
                self.error(kind, "start-missing", message, "give it one");
            }
            (false, true) => {
                let message = format!("{name} is calculated and has a start value");
                self.error(kind, "start-of-calculated", message, "remove the start value");
            }
            _ => {}
        }
    }

    /// Start, min, max and nominal of a Real or Integer.
    fn limits(&mut self, kind: &Element, name: &str) {
        let of = format!("variable {name}");
        let start = self.real(kind, "start", &of);
        let min = self.real(kind, "min", &of).unwrap_or(f64::NEG_INFINITY);
        let max = self.real(kind, "max", &of).unwrap_or(f64::INFINITY);
        if max < min {
            let message = format!("max = {max} of {name} is below its min = {min}");
            self.error(kind, "max-below-min", message, "exchange them");
            return;
        }
        if let Some(start) = start
            && !(min..=max).contains(&start)
        {
            let message = format!("start = {start} of {name} is outside [{min}, {max}]");
            self.error(kind, "start-out-of-range", message, "change start, min or max");
        }
        if let Some(nominal) = self.real(kind, "nominal", &of) {
            if nominal == 0.0 {
                let message = format!("nominal of {name} is zero");
                self.error(kind, "nominal-zero", message, "nominal is a scale: use another value");
            } else if !(min..=max).contains(&nominal) {
                let message = format!("nominal = {nominal} of {name} is outside [{min}, {max}]");
                self.warning(kind, "nominal-out-of-range", message, "change nominal, min or max");
            }
        }
    }

    fn integer_start(&mut self, kind: &Element, name: &str) {
        for attribute in ["start", "min", "max"] {
            if kind.attribute(attribute).is_some_and(|text| text.parse::<i32>().is_err()) {
                let message = format!("{attribute} of {name} is not an integer of 32 bits");
                self.error(kind, "start-form", message, "use an integer");
            }
        }
    }

    fn enumeration(
        &mut self,
        kind: &Element,
        name: &str,
        types: &HashMap<&str, Option<HashSet<i64>>>,
    ) {
        let declared = kind.attribute("declaredType").unwrap_or_default();
        let Some(Some(values)) = types.get(declared) else {
            let message = format!("{name} has the type \"{declared}\", which is no enumeration");
            self.error(kind, "unknown-type", message, "declare it in TypeDefinitions");
            return;
        };
        if let Some(start) = kind.attribute("start")
            && !start.parse().is_ok_and(|start: i64| values.contains(&start))
        {
            let message = format!("start = {start} of {name} is no item of \"{declared}\"");
            self.error(kind, "start-out-of-range", message, "use the value of an item");
        }
    }

    fn unit(&mut self, kind: &Element, name: &str, units: &HashMap<&str, Vec<&str>>) {
        let Some(unit) = kind.attribute("unit") else {
            if kind.attribute("displayUnit").is_some() {
                let message = format!("{name} has a displayUnit but no unit");
                self.error(kind, "unknown-unit", message, "add the unit");
            }
            return;
        };
        let Some(display_units) = units.get(unit) else {
            let message = format!("unit \"{unit}\" of {name} is not defined");
            self.error(kind, "unknown-unit", message, "define it in UnitDefinitions");
            return;
        };
        if let Some(display) = kind.attribute("displayUnit")
            && !display_units.contains(&display)
        {
            let message = format!("displayUnit \"{display}\" of {name} is not defined");
            self.error(kind, "unknown-unit", message, format!("define it in unit \"{unit}\""));
        }
    }

    fn structure(&mut self, root: &Element, variables: &[Element]) {
        let Some(structure) = root.child("ModelStructure") else {
            let message = "ModelStructure is missing";
            self.error(root, "structure", message, "add it, with all outputs");
            return;
        };
        let is_output = |variable: &Element| variable.attribute("causality") == Some("output");
        let calculated = |variable: &Element| {
            let initial = variable.attribute("initial").unwrap_or("calculated");
            let constant = variable.attribute("variability") == Some("constant");
            is_output(variable) && !constant && matches!(initial, "approx" | "calculated")
        };
        self.unknowns(structure, "Outputs", variables, &is_output, true);
        self.unknowns(structure, "InitialUnknowns", variables, &calculated, false);
    }

    /// Checks a list of unknowns: all variables that are `wanted`, `only` these, and dependencies
    /// that exist.
    fn unknowns(
        &mut self,
        structure: &Element,
        list: &str,
        variables: &[Element],
        wanted: &dyn Fn(&Element) -> bool,
        only: bool,
    ) {
        let mut listed = HashSet::new();
        for unknown in structure.list(list) {
            let index = unknown.attribute("index").and_then(|index| index.parse::<usize>().ok());
            let variable =
                index.and_then(|index| variables.get(index.checked_sub(1)?).zip(Some(index)));
            let Some((variable, index)) = variable else {
                let message = format!("an index in {list} points to no variable");
                self.error(unknown, "structure-index", message, "indices count from 1");
                continue;
            };
            let name = variable.attribute("name").unwrap_or_default();
            if !listed.insert(index) {
                let message = format!("\"{name}\" is listed twice in {list}");
                self.error(unknown, "structure-index", message, "list it once");
            }
            if only && !wanted(variable) {
                let message = format!("\"{name}\" is listed in {list} but is no output");
                self.error(unknown, "structure-index", message, "remove it");
            }
            self.dependencies(unknown, name, variables.len());
        }
        for (index, variable) in (1..).zip(variables) {
            if wanted(variable) && !listed.contains(&index) {
                let name = variable.attribute("name").unwrap_or_default();
                let message = format!("output \"{name}\" is missing in {list}");
                self.error(variable, "missing-output", message, "list every output");
            }
        }
    }

    fn dependencies(&mut self, unknown: &Element, name: &str, variables: usize) {
        let words = |attribute| {
            unknown.attribute(attribute).map(|text| text.split_whitespace().collect::<Vec<_>>())
        };
        let (dependencies, kinds) = (words("dependencies"), words("dependenciesKind"));
        for word in dependencies.iter().flatten() {
            if !word.parse().is_ok_and(|index: usize| (1..=variables).contains(&index)) {
                let message = format!("dependency {word} of \"{name}\" points to no variable");
                self.error(unknown, "dependency", message, "indices count from 1");
            }
        }
        if let Some(kinds) = kinds
            && dependencies.is_none_or(|dependencies| dependencies.len() != kinds.len())
        {
            let message = format!("dependenciesKind of \"{name}\" does not match its dependencies");
            self.error(unknown, "dependency", message, "list one kind for each dependency");
        }
    }
}

fn is_implementation(name: &str) -> bool {
    matches!(name, "CoSimulation" | "ModelExchange")
}

fn is_type(name: &str) -> bool {
    matches!(name, "Real" | "Integer" | "Boolean" | "String" | "Enumeration")
}

/// Values of `initial` that a causality and variability allow, the default first; `None` if they do
/// not go together.
fn allowed_initials(causality: &str, variability: &str) -> Option<&'static [&'static str]> {
    let calculated: &[_] = &["calculated", "exact", "approx"];
    match (causality, variability) {
        ("parameter", "fixed" | "tunable") | ("output" | "local", "constant") => Some(&["exact"]),
        ("calculatedParameter", "fixed" | "tunable") | ("local", "fixed" | "tunable") => {
            Some(&["calculated", "approx"])
        }
        ("output" | "local", "discrete" | "continuous") => Some(calculated),
        ("input", "discrete" | "continuous") | ("independent", "continuous") => Some(&[]),
        _ => None,
    }
}

/// Whether a text has the form `2024-01-31T23:59:59Z` with possible numbers.
fn is_date(text: &str) -> bool {
    let form = "dddd-dd-ddTdd:dd:ddZ";
    let fits = |(c, f): (char, char)| if f == 'd' { c.is_ascii_digit() } else { c == f };
    let number = |range: std::ops::Range<usize>| {
        text.get(range).and_then(|digits| digits.parse::<u32>().ok()).unwrap_or(u32::MAX)
    };
    text.len() == form.len()
        && text.chars().zip(form.chars()).all(fits)
        && (1..=12).contains(&number(5..7))
        && (1..=31).contains(&number(8..10))
        && number(11..13) < 24
        && number(14..16) < 60
        && number(17..19) < 61
}
