//! Rules that FMI 2.0 and 3.0 share.

use std::collections::{HashMap, HashSet};

use super::super::tree::Element;
use super::finding::{Finding, Findings, Level};

/// The findings so far, about one file.
pub(super) struct Linter {
    pub(super) file: &'static str,
    pub(super) findings: Findings,
}

/// Names of attributes that differ by version.
pub(super) struct Names {
    /// What identifies the FMU.
    pub(super) token: &'static str,
    /// States can be saved.
    pub(super) get_state: &'static str,
    /// Saved states can be serialised.
    pub(super) serialize_state: &'static str,
    /// Elements of implementations.
    pub(super) implementations: &'static [&'static str],
}

impl Linter {
    pub(super) fn report(
        &mut self,
        level: Level,
        at: &Element,
        code: &'static str,
        message: impl Into<String>,
        help: impl Into<String>,
    ) {
        let location = format!("{}:{}", self.file, at.line);
        let (message, help) = (message.into(), help.into());
        self.findings.add(Finding { level, code, message, location, help });
    }

    pub(super) fn error(
        &mut self,
        at: &Element,
        code: &'static str,
        message: impl Into<String>,
        help: impl Into<String>,
    ) {
        self.report(Level::Error, at, code, message, help);
    }

    pub(super) fn warning(
        &mut self,
        at: &Element,
        code: &'static str,
        message: impl Into<String>,
        help: impl Into<String>,
    ) {
        self.report(Level::Warning, at, code, message, help);
    }

    /// Reports control characters: in names any, in other texts those that are neither a tab nor end a line.
    pub(super) fn characters(&mut self, element: &Element) {
        const NAMES: [&str; 7] = [
            "name",
            "modelName",
            "modelIdentifier",
            "guid",
            "instantiationToken",
            "variableName",
            "memberName",
        ];
        for (attribute, value) in &element.attributes {
            let is_name = NAMES.contains(&attribute.as_str());
            let strange =
                |c: &char| c.is_control() && (is_name || !matches!(c, '\t' | '\n' | '\r'));
            if let Some(c) = value.chars().find(strange) {
                let message =
                    format!("{attribute}={value:?} has the character U+{:04X}", u32::from(c));
                let help = "terminals obey control characters, and tables break at them: remove it";
                if is_name {
                    self.error(element, "control-character", message, help);
                } else {
                    self.warning(element, "control-character", message, help);
                }
            }
        }
        for child in &element.children {
            self.characters(child);
        }
    }

    pub(super) fn header(&mut self, root: &Element, names: &Names) {
        for (attribute, code) in [(names.token, "empty-guid"), ("modelName", "empty-model-name")] {
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

    pub(super) fn implementations(&mut self, root: &Element, names: &Names) {
        let Names { get_state, serialize_state, implementations, .. } = *names;
        let mut found = false;
        for element in root.children.iter().filter(|e| implementations.contains(&e.name.as_str())) {
            found = true;
            let identifier = element.attribute("modelIdentifier").unwrap_or_default();
            let c_identifier = identifier.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
                && identifier.starts_with(|c: char| !c.is_ascii_digit());
            if !c_identifier {
                let message = format!("modelIdentifier=\"{identifier}\" is no C identifier");
                self.error(element, "model-identifier", message, "use letters, digits and _");
            }
            let flag = |name| matches!(element.attribute(name), Some("true" | "1"));
            if flag(serialize_state) && !flag(get_state) {
                self.error(
                    element,
                    "serialize-without-get",
                    format!("{serialize_state} is true, {get_state} is not"),
                    "a state must be got before it can be serialised: set both or none",
                );
            }
        }
        if !found {
            let message = format!("none of {} is declared", implementations.join(", "));
            self.error(root, "no-implementation", message, "declare the element CoSimulation");
        }
    }

    /// Reports names that appear twice.
    pub(super) fn distinct(&mut self, elements: &[Element], what: &str) {
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
    pub(super) fn units<'e>(&mut self, root: &'e Element) -> HashMap<&'e str, HashSet<&'e str>> {
        let units = root.list("UnitDefinitions");
        self.distinct(units, "unit");
        let name = |element: &'e Element| element.attribute("name").unwrap_or_default();
        let display = |unit: &'e Element| {
            unit.children.iter().filter(|child| child.name == "DisplayUnit").map(name).collect()
        };
        units.iter().map(|unit| (name(unit), display(unit))).collect()
    }

    pub(super) fn items(&mut self, name: &str, enumeration: &Element) -> HashSet<i64> {
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

    pub(super) fn experiment(&mut self, root: &Element) {
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
    pub(super) fn real(
        &mut self,
        element: &Element,
        attribute: &'static str,
        of: &str,
    ) -> Option<f64> {
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
    /// Whether initial is allowed where it stands, and a start value where it has to be; `allowed` are the values of
    /// initial that causality and variability leave, `None` if they do not go together.
    pub(super) fn role(
        &mut self,
        variable: &Element,
        kind: &Element,
        name: &str,
        [causality, variability]: [&str; 2],
        allowed: Option<&[&str]>,
        has_start: bool,
    ) {
        let Some(allowed) = allowed else {
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
        match (wanted, has_start) {
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

    /// Start, min, max and nominal of a number; start of an array is a list.
    pub(super) fn limits(&mut self, kind: &Element, name: &str, starts: &[f64]) {
        let of = format!("variable {name}");
        let min = self.real(kind, "min", &of).unwrap_or(f64::NEG_INFINITY);
        let max = self.real(kind, "max", &of).unwrap_or(f64::INFINITY);
        if max < min {
            let message = format!("max = {max} of {name} is below its min = {min}");
            self.error(kind, "max-below-min", message, "exchange them");
            return;
        }
        for start in starts.iter().filter(|start| !(min..=max).contains(*start)) {
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

    pub(super) fn enumeration(
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

    pub(super) fn unit(
        &mut self,
        kind: &Element,
        name: &str,
        units: &HashMap<&str, HashSet<&str>>,
    ) {
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
            && !display_units.contains(display)
        {
            let message = format!("displayUnit \"{display}\" of {name} is not defined");
            self.error(kind, "unknown-unit", message, format!("define it in unit \"{unit}\""));
        }
    }

    /// Whether there is a kind of dependency for each dependency.
    pub(super) fn dependency_kinds(&mut self, unknown: &Element, name: &str) {
        let words =
            |attribute| unknown.attribute(attribute).map(|text| text.split_whitespace().count());
        if let Some(kinds) = words("dependenciesKind")
            && words("dependencies") != Some(kinds)
        {
            let message = format!("dependenciesKind of \"{name}\" does not match its dependencies");
            self.error(unknown, "dependency", message, "list one kind for each dependency");
        }
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
