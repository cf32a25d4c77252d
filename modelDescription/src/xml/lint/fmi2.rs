//! Rules of FMI 2.0.4, section 2.2.

use std::collections::{HashMap, HashSet};

use super::super::tree::Element;
use super::common::{Linter, Names};

const NAMES: Names = Names {
    token: "guid",
    get_state: "canGetAndSetFMUstate",
    serialize_state: "canSerializeFMUstate",
    implementations: &["CoSimulation", "ModelExchange"],
};

impl Linter {
    pub(super) fn fmi2(&mut self, root: &Element) {
        if root.attribute("fmiVersion") != Some("2.0") {
            let message = "fmiVersion is neither \"2.0\" nor \"3.0\"";
            self.error(root, "version", message, "FMI 2.0 and 3.0 are what is checked");
        }
        self.header(root, &NAMES);
        self.implementations(root, &NAMES);
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

    fn variable(
        &mut self,
        variable: &Element,
        units: &HashMap<&str, HashSet<&str>>,
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
        self.causality(variable, kind, &name);
        match kind.name.as_str() {
            "Real" => {
                let start = self.real(kind, "start", &format!("variable {name}"));
                self.limits(kind, &name, start.as_slice());
            }
            "Integer" => {
                let start = self.real(kind, "start", &format!("variable {name}"));
                self.limits(kind, &name, start.as_slice());
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
    fn causality(&mut self, variable: &Element, kind: &Element, name: &str) {
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
        let allowed = allowed_initials(causality, variability);
        let has_start = kind.attribute("start").is_some();
        self.role(variable, kind, name, [causality, variability], allowed, has_start);
    }

    fn integer_start(&mut self, kind: &Element, name: &str) {
        for attribute in ["start", "min", "max"] {
            if kind.attribute(attribute).is_some_and(|text| text.parse::<i32>().is_err()) {
                let message = format!("{attribute} of {name} is not an integer of 32 bits");
                self.error(kind, "start-form", message, "use an integer");
            }
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
        for word in unknown.attribute("dependencies").into_iter().flat_map(str::split_whitespace) {
            if !word.parse().is_ok_and(|index: usize| (1..=variables).contains(&index)) {
                let message = format!("dependency {word} of \"{name}\" points to no variable");
                self.error(unknown, "dependency", message, "indices count from 1");
            }
        }
        self.dependency_kinds(unknown, name);
    }
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
