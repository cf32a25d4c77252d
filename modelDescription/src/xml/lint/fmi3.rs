//! Rules of FMI 3.0.2, section 2.4.

use std::collections::{HashMap, HashSet};

use super::super::tree::Element;
use super::common::{Linter, Names};

const NAMES: Names = Names {
    token: "instantiationToken",
    get_state: "canGetAndSetFMUState",
    serialize_state: "canSerializeFMUState",
    implementations: &["CoSimulation", "ModelExchange", "ScheduledExecution"],
};

const FLOATS: [&str; 2] = ["Float32", "Float64"];

const INTEGERS: [&str; 8] =
    ["Int8", "UInt8", "Int16", "UInt16", "Int32", "UInt32", "Int64", "UInt64"];

/// Variables by value reference.
type Variables<'e> = HashMap<u32, &'e Element>;

impl Linter {
    pub(super) fn fmi3(&mut self, root: &Element) {
        self.header(root, &NAMES);
        self.implementations(root, &NAMES);
        let units = self.units(root);
        let types = self.type_definitions(root);
        self.distinct(root.list("LogCategories"), "log category");
        self.experiment(root);

        let list = root.list("ModelVariables");
        self.distinct(list, "variable");
        let variables = self.references(list);
        self.independent(root, list);
        for variable in list {
            self.variable_of_fmi3(variable, &variables, &types);
            self.unit(variable, &quoted(variable), &units);
        }
        self.co_simulation(root, list);
        self.model_structure(root, list, &variables);
    }

    /// Item values of the enumerations; `None` for other types.
    fn type_definitions<'e>(
        &mut self,
        root: &'e Element,
    ) -> HashMap<&'e str, Option<HashSet<i64>>> {
        let types = root.list("TypeDefinitions");
        self.distinct(types, "type");
        let mut declared = HashMap::new();
        for element in types {
            let name = element.attribute("name").unwrap_or_default();
            let is_enumeration = element.name == "EnumerationType";
            declared.insert(name, is_enumeration.then(|| self.items(name, element)));
        }
        declared
    }

    fn references<'e>(&mut self, list: &'e [Element]) -> Variables<'e> {
        let mut variables = HashMap::new();
        for variable in list {
            let name = quoted(variable);
            let reference = variable.attribute("valueReference");
            let Some(reference) = reference.and_then(|text| text.parse().ok()) else {
                let message = format!("variable {name} has no valid valueReference");
                self.error(variable, "value-reference", message, "use an unsigned integer");
                continue;
            };
            if let Some(other) = variables.insert(reference, variable) {
                let message =
                    format!("{name} has the valueReference of {}: {reference}", quoted(other));
                let help = "FMI 3.0 has one for each variable: use Alias for a further name";
                self.error(variable, "value-reference", message, help);
            }
        }
        variables
    }

    fn independent(&mut self, root: &Element, list: &[Element]) {
        let independent = |v: &&Element| v.attribute("causality") == Some("independent");
        let mut found = list.iter().filter(independent);
        match (found.next(), found.next()) {
            (None, _) => {
                let message = "no variable has the causality independent";
                self.error(root, "independent", message, "add one, usually named time");
            }
            (Some(time), None) => {
                if !FLOATS.contains(&time.name.as_str()) || time.child("Dimension").is_some() {
                    let message = format!("{} is independent and no scalar Float", quoted(time));
                    self.error(time, "independent", message, "make it a Float64");
                }
            }
            (_, Some(second)) => {
                let message = format!("{} is a second independent variable", quoted(second));
                self.error(second, "independent", message, "keep one");
            }
        }
    }

    fn variable_of_fmi3(
        &mut self,
        variable: &Element,
        variables: &Variables<'_>,
        types: &HashMap<&str, Option<HashSet<i64>>>,
    ) {
        let name = quoted(variable);
        let kind = variable.name.as_str();
        self.causality_of_fmi3(variable, &name);
        self.clocks(variable, &name, variables);
        let size = self.size(variable, &name, variables);
        if kind == "Clock" {
            let interval = variable.attribute("intervalVariability").unwrap_or_default();
            let known = ["constant", "fixed", "tunable", "changing", "countdown", "triggered"];
            if !known.contains(&interval) {
                let message = format!("intervalVariability=\"{interval}\" of clock {name}");
                self.error(variable, "clock", message, format!("use one of {}", known.join(", ")));
            }
        } else if kind == "Enumeration" {
            self.enumeration(variable, &name, types);
        } else if FLOATS.contains(&kind) || INTEGERS.contains(&kind) {
            let starts = self.starts(variable, &name);
            self.limits(variable, &name, &starts);
            self.count(variable, &name, size, starts.len());
        } else if kind == "Boolean" {
            let words: Vec<_> =
                variable.attribute("start").into_iter().flat_map(str::split_whitespace).collect();
            if words.iter().any(|word| !matches!(*word, "true" | "false" | "0" | "1")) {
                let message = format!("start of {name} is neither true nor false");
                self.error(variable, "start-form", message, "write true or false");
            }
            self.count(variable, &name, size, words.len());
        }
    }

    /// The numbers of a start value.
    fn starts(&mut self, variable: &Element, name: &str) -> Vec<f64> {
        let mut starts = Vec::new();
        for word in variable.attribute("start").into_iter().flat_map(str::split_whitespace) {
            match word.parse::<f64>() {
                Ok(number) if number.is_finite() => starts.push(number),
                _ => {
                    let message =
                        format!("start=\"{word}\" of variable {name} is not a finite number");
                    let help = "importers compare and plot it: use a finite number";
                    self.error(variable, "not-finite", message, help);
                }
            }
        }
        starts
    }

    /// Number of elements, where the description says it.
    fn size(&mut self, variable: &Element, name: &str, variables: &Variables<'_>) -> Option<usize> {
        let mut size = Some(1_usize);
        for dimension in variable.children.iter().filter(|child| child.name == "Dimension") {
            let number = |attribute| dimension.attribute(attribute)?.trim().parse::<u32>().ok();
            match (number("start"), number("valueReference")) {
                (Some(length), None) => size = size.and_then(|s| s.checked_mul(length as usize)),
                (None, Some(reference)) => {
                    // Its length is the importer's choice.
                    size = None;
                    let structural = variables.get(&reference).is_some_and(|v| {
                        matches!(v.attribute("causality"), Some("structuralParameter"))
                            || v.attribute("variability") == Some("constant")
                    });
                    if !structural {
                        let message = format!("a dimension of {name} refers to {reference}");
                        let help = "refer to a structural parameter or a constant";
                        self.error(dimension, "dimension", message, help);
                    }
                }
                _ => {
                    let message = format!("a dimension of {name} has no length");
                    self.error(dimension, "dimension", message, "give it start or valueReference");
                }
            }
        }
        size
    }

    fn count(&mut self, variable: &Element, name: &str, size: Option<usize>, starts: usize) {
        if let Some(size) = size
            && starts != size
            && starts > 1.min(size)
        {
            let message = format!("{name} has {size} elements and {starts} start values");
            self.error(variable, "start-count", message, "give one value, or one for each element");
        }
    }

    /// Causality, variability, initial and the presence of start: the tables of section 2.4.7.5.
    fn causality_of_fmi3(&mut self, variable: &Element, name: &str) {
        let is_float = FLOATS.contains(&variable.name.as_str());
        let causality = variable.attribute("causality").unwrap_or("local");
        let variability = variable.attribute("variability").unwrap_or(match causality {
            "parameter" | "calculatedParameter" | "structuralParameter" => "fixed",
            _ if is_float => "continuous",
            _ => "discrete",
        });
        if variability == "continuous" && !is_float {
            let message = format!("{name} is continuous but no Float");
            self.error(variable, "continuous-not-real", message, "make it discrete");
        }
        if variable.name == "Clock" {
            // It has neither initial nor start.
            if !matches!((causality, variability), ("input" | "output" | "local", "discrete")) {
                let message =
                    format!("clock {name}: causality {causality}, variability {variability}");
                self.error(
                    variable,
                    "role",
                    message,
                    "clocks are discrete inputs, outputs or locals",
                );
            }
            return;
        }
        let allowed = allowed_initials(causality, variability);
        // A String or Binary has elements, since its values may hold blanks.
        let has_start = variable.attribute("start").is_some() || variable.child("Start").is_some();
        self.role(variable, variable, name, [causality, variability], allowed, has_start);
    }

    fn clocks(&mut self, variable: &Element, name: &str, variables: &Variables<'_>) {
        let Some(clocks) = variable.attribute("clocks") else { return };
        for word in clocks.split_whitespace() {
            let clock = word.parse().ok().and_then(|reference: u32| variables.get(&reference));
            if clock.is_none_or(|clock| clock.name != "Clock") {
                let message = format!("clocks of {name}: {word} is no clock");
                self.error(variable, "clock", message, "list value references of clocks");
            }
        }
        if variable.attribute("variability").is_some_and(|v| v != "discrete") {
            let message = format!("{name} is clocked and not discrete");
            self.error(variable, "clock", message, "clocked variables change at ticks only");
        }
    }

    /// What the element CoSimulation promises.
    fn co_simulation(&mut self, root: &Element, list: &[Element]) {
        let Some(element) = root.child("CoSimulation") else { return };
        let flag = |name| matches!(element.attribute(name), Some("true" | "1"));
        if list.iter().any(|variable| variable.name == "Clock") && !flag("hasEventMode") {
            let message = "there are clocks and no event mode";
            let help = "clocks tick in Event Mode only: set hasEventMode, or remove them";
            self.error(element, "clock-without-event-mode", message, help);
        }
        if flag("canReturnEarlyAfterIntermediateUpdate") && !flag("providesIntermediateUpdate") {
            let message =
                "canReturnEarlyAfterIntermediateUpdate without providesIntermediateUpdate";
            self.error(element, "early-return", message, "set both or none");
        }
        if let Some(step) = self.real(element, "fixedInternalStepSize", "CoSimulation")
            && step <= 0.0
        {
            let message = format!("fixedInternalStepSize = {step} is not positive");
            self.error(element, "experiment", message, "use a positive step, or leave it out");
        }
    }

    fn model_structure(&mut self, root: &Element, list: &[Element], variables: &Variables<'_>) {
        let Some(structure) = root.child("ModelStructure") else {
            let message = "ModelStructure is missing";
            self.error(root, "structure", message, "add it, with all outputs");
            return;
        };
        let is_output = |variable: &Element| variable.attribute("causality") == Some("output");
        let unknown_at_first = |variable: &Element| {
            let initial = variable.attribute("initial").unwrap_or("calculated");
            let constant = variable.attribute("variability") == Some("constant");
            is_output(variable)
                && !constant
                && variable.name != "Clock"
                && variable.attribute("clocks").is_none()
                && matches!(initial, "approx" | "calculated")
        };
        self.listed(structure, "Output", list, variables, &is_output, true);
        self.listed(structure, "InitialUnknown", list, variables, &unknown_at_first, false);
    }

    /// Checks the elements of a name: all variables that are `wanted`, `only` these, and dependencies that exist.
    fn listed(
        &mut self,
        structure: &Element,
        element: &str,
        list: &[Element],
        variables: &Variables<'_>,
        wanted: &dyn Fn(&Element) -> bool,
        only: bool,
    ) {
        let mut found = HashSet::new();
        for unknown in structure.children.iter().filter(|child| child.name == element) {
            let reference = unknown.attribute("valueReference").and_then(|text| text.parse().ok());
            let Some((reference, variable)) =
                reference.and_then(|reference: u32| Some((reference, *variables.get(&reference)?)))
            else {
                let message = format!("a valueReference of {element} is of no variable");
                self.error(unknown, "structure-index", message, "refer to a variable");
                continue;
            };
            let name = quoted(variable);
            if !found.insert(reference) {
                let message = format!("{name} is listed twice as {element}");
                self.error(unknown, "structure-index", message, "list it once");
            }
            if only && !wanted(variable) {
                let message = format!("{name} is listed as {element} but is no output");
                self.error(unknown, "structure-index", message, "remove it");
            }
            let words = unknown.attribute("dependencies").into_iter();
            for word in words.flat_map(str::split_whitespace) {
                if !word.parse().is_ok_and(|reference: u32| variables.contains_key(&reference)) {
                    let message = format!("dependency {word} of {name} is of no variable");
                    self.error(unknown, "dependency", message, "list value references");
                }
            }
            self.dependency_kinds(unknown, name.trim_matches('"'));
        }
        for variable in list.iter().filter(|variable| wanted(variable)) {
            let reference = variable.attribute("valueReference").and_then(|text| text.parse().ok());
            if reference.is_none_or(|reference: u32| !found.contains(&reference)) {
                let message = format!("output {} is missing among {element}", quoted(variable));
                self.error(variable, "missing-output", message, "list every output");
            }
        }
    }
}

fn quoted(variable: &Element) -> String {
    format!("\"{}\"", variable.attribute("name").unwrap_or_default())
}

/// Values of `initial` that a causality and variability allow, the default first; `None` if they do
/// not go together.
fn allowed_initials(causality: &str, variability: &str) -> Option<&'static [&'static str]> {
    match (causality, variability) {
        ("parameter" | "structuralParameter", "fixed" | "tunable")
        | ("output" | "local", "constant")
        | ("input", "discrete" | "continuous") => Some(&["exact"]),
        ("calculatedParameter", "fixed" | "tunable") | ("local", "fixed" | "tunable") => {
            Some(&["calculated", "approx"])
        }
        ("output" | "local", "discrete" | "continuous") => Some(&["calculated", "exact", "approx"]),
        ("independent", "continuous") => Some(&[]),
        _ => None,
    }
}
