//! Rendering to the schemas of FMI 3.0: the description and its terminals.

use std::io;

use super::common::{
    Attributes, Rendered, Xml, default_experiment, digest, document, element, empty, enumerations,
    items, log_categories, number, real_attributes, role_attributes, root, start_text,
    unit_definitions,
};
use crate::structure::{
    MatchingRule, Member, Structure, Terminal, references_beyond_the_table, type_name,
};
use crate::unit::SECOND;
use crate::{Causality, DefaultExperiment, Kind, ModelInfo, Role, Value, Variable};

/// Renders the description with the instantiation token that its contents give. `start` gives a variable's
/// value in a fresh instance; the experiment's step is the model's sample period.
///
/// # Errors
/// Only what writing to memory can give.
pub fn describe<'a, V: Structure>(
    info: &ModelInfo,
    start: impl Fn(V) -> Value<'a>,
    experiment: &DefaultExperiment,
) -> io::Result<Rendered> {
    let token = digest(&render(info, "", &start, experiment)?);
    let xml = render(info, &token, &start, experiment)?;
    Ok(Rendered { guid: token, xml })
}

fn render<'a, V: Structure>(
    info: &ModelInfo,
    token: &str,
    start: &impl Fn(V) -> Value<'a>,
    experiment: &DefaultExperiment,
) -> io::Result<String> {
    let attributes = root("3.0", info, ("instantiationToken", token));
    document(|xml| {
        element(xml, "fmiModelDescription", attributes, |xml| {
            co_simulation(xml, info, experiment.step_size)?;
            unit_definitions(xml, V::TABLE)?;
            type_definitions(xml, V::TABLE)?;
            log_categories(xml, "fmi3")?;
            default_experiment(xml, experiment)?;
            element(xml, "ModelVariables", vec![], |xml| {
                entries::<V>().iter().try_for_each(|entry| variable(xml, entry, start))?;
                beyond_the_table::<V>(xml)
            })?;
            model_structure::<V>(xml)
        })
    })
}

/// A variable of the table, or an array of it, as it is listed.
struct Listed<V: 'static> {
    name: &'static str,
    description: &'static str,
    elements: &'static [V],
    rows: &'static [Variable],
    is_array: bool,
}

/// What the table becomes, in its order.
fn entries<V: Structure>() -> Vec<Listed<V>> {
    let mut entries = Vec::new();
    let mut next = 0;
    while let (Some(variable), Some(row)) = (V::ALL.get(next), V::TABLE.get(next)) {
        let array = V::ARRAYS.iter().find(|array| array.elements.first() == Some(variable));
        let length = array.map_or(1, |array| array.elements.len());
        entries.push(Listed {
            name: array.map_or(row.name, |array| array.name),
            description: array.map_or(row.description, |array| array.description),
            elements: V::ALL.get(next..next + length).unwrap_or_default(),
            rows: V::TABLE.get(next..next + length).unwrap_or_default(),
            is_array: array.is_some(),
        });
        next += length;
    }
    entries
}

/// What the FMI layer can do, whatever the model; `step_s` is the model's sample period.
fn co_simulation(xml: &mut Xml, info: &ModelInfo, step_s: f64) -> io::Result<()> {
    let mut attributes = vec![("modelIdentifier", info.identifier.to_owned())];
    for flag in [
        "canGetAndSetFMUState",
        "canSerializeFMUState",
        "canHandleVariableCommunicationStepSize",
        "hasEventMode",
        "mightReturnEarlyFromDoStep",
    ] {
        attributes.push((flag, "true".to_owned()));
    }
    attributes.push(("fixedInternalStepSize", number(step_s)));
    empty(xml, "CoSimulation", attributes)
}

fn type_definitions(xml: &mut Xml, table: &'static [Variable]) -> io::Result<()> {
    let types = enumerations(table);
    if types.is_empty() {
        return Ok(());
    }
    element(xml, "TypeDefinitions", vec![], |xml| {
        types.into_iter().try_for_each(|enumeration| {
            let attributes = vec![
                ("name", enumeration.name.to_owned()),
                ("description", enumeration.description.to_owned()),
            ];
            element(xml, "EnumerationType", attributes, |xml| items(xml, enumeration))
        })
    })
}

fn named(name: &str, reference: u32, description: &str) -> Attributes {
    vec![
        ("name", name.to_owned()),
        ("valueReference", reference.to_string()),
        ("description", description.to_owned()),
    ]
}

fn variable<'a, V: Structure>(
    xml: &mut Xml,
    entry: &Listed<V>,
    start: &impl Fn(V) -> Value<'a>,
) -> io::Result<()> {
    let (Some(first), Some(row)) = (entry.elements.first(), entry.rows.first()) else {
        return Ok(());
    };
    let mut attributes = named(entry.name, first.value_reference(), entry.description);
    attributes.extend(role_attributes(row.role));
    match &row.kind {
        Kind::Real(_) => attributes.extend(shared(entry.rows)),
        Kind::Integer { min, max } => {
            attributes.extend([("min", min.to_string()), ("max", max.to_string())]);
        }
        Kind::Enumeration(enumeration) => {
            attributes.push(("declaredType", enumeration.name.to_owned()));
        }
        Kind::Boolean | Kind::String => {}
    }
    let starts: Vec<String> =
        entry.elements.iter().map(|element| start_text(start(*element))).collect();
    // Texts may hold blanks: each is an element.
    let has_texts = row.role.has_start() && matches!(row.kind, Kind::String);
    if row.role.has_start() && !has_texts {
        attributes.push(("start", starts.join(" ")));
    }
    let kind = type_name(&row.kind);
    if !entry.is_array && !has_texts {
        return empty(xml, kind, attributes);
    }
    element(xml, kind, attributes, |xml| {
        if entry.is_array {
            empty(xml, "Dimension", vec![("start", entry.elements.len().to_string())])?;
        }
        if has_texts {
            let starts = starts.into_iter();
            starts
                .map(|text| vec![("value", text)])
                .try_for_each(|text| empty(xml, "Start", text))?;
        }
        Ok(())
    })
}

/// Unit, limits and nominal value of all elements, as far as they have them in common.
fn shared(rows: &[Variable]) -> Attributes {
    let mut of_each = rows.iter().filter_map(|row| match &row.kind {
        Kind::Real(real) => Some(real_attributes(real)),
        _ => None,
    });
    let mut shared = of_each.next().unwrap_or_default();
    for other in of_each {
        shared.retain(|attribute| other.contains(attribute));
    }
    shared
}

/// The clock, its time and the independent variable.
fn beyond_the_table<V: Structure>(xml: &mut Xml) -> io::Result<()> {
    let [clock, clock_time, time] = references_beyond_the_table::<V>();
    let mut attributes = named(V::CLOCK.name, clock, V::CLOCK.description);
    attributes.extend([
        ("causality", "output".to_owned()),
        ("variability", "discrete".to_owned()),
        ("intervalVariability", "triggered".to_owned()),
    ]);
    empty(xml, "Clock", attributes)?;
    let mut attributes = named(V::CLOCK.time_name, clock_time, V::CLOCK.time_description);
    attributes.extend(role_attributes(Role::OUTPUT));
    attributes.push(("clocks", clock.to_string()));
    attributes.push(("unit", SECOND.name.to_owned()));
    empty(xml, "Float64", attributes)?;
    let mut attributes = named("time", time, "Simulation time");
    attributes.extend([
        ("causality", "independent".to_owned()),
        ("variability", "continuous".to_owned()),
        ("unit", SECOND.name.to_owned()),
    ]);
    empty(xml, "Float64", attributes)
}

fn model_structure<V: Structure>(xml: &mut Xml) -> io::Result<()> {
    let outputs: Vec<u32> = entries::<V>()
        .iter()
        .filter(|entry| {
            entry.rows.first().is_some_and(|row| row.role.causality == Causality::Output)
        })
        .filter_map(|entry| entry.elements.first().map(|first| first.value_reference()))
        .collect();
    let [clock, clock_time, _] = references_beyond_the_table::<V>();
    // Outputs change at samples only: nothing follows an input without a communication step between.
    let unknown = |xml: &mut Xml, name, reference: &u32| {
        let none = ("dependencies", String::new());
        empty(xml, name, vec![("valueReference", reference.to_string()), none])
    };
    element(xml, "ModelStructure", vec![], |xml| {
        let (clock, own) = ([clock], [clock, clock_time]);
        let mut all = outputs.iter().chain(&own);
        all.try_for_each(|reference| unknown(xml, "Output", reference))?;
        // The clock is an output that is not clocked, which the wording of section 2.4.8 puts here; importers
        // differ on whether a clock is meant.
        let mut at_first = outputs.iter().chain(&clock);
        at_first.try_for_each(|reference| unknown(xml, "InitialUnknown", reference))
    })
}

/// `terminalsAndIcons.xml`: the terminals, and where the icon lies.
///
/// # Errors
/// Only what writing to memory can give.
pub fn terminals<V: Structure>() -> io::Result<String> {
    let corners = |half: f64| {
        let (low, high) = (number(-half), number(half));
        vec![("x1", low.clone()), ("y1", low), ("x2", high.clone()), ("y2", high)]
    };
    document(|xml| {
        element(xml, "fmiTerminalsAndIcons", vec![("fmiVersion", "3.0".to_owned())], |xml| {
            element(xml, "GraphicalRepresentation", vec![], |xml| {
                let mut system = corners(100.0);
                system.push(("suggestedScalingFactorTo_mm", number(0.1)));
                empty(xml, "CoordinateSystem", system)?;
                empty(xml, "Icon", corners(100.0))
            })?;
            element(xml, "Terminals", vec![], |xml| {
                V::TERMINALS.iter().try_for_each(|of| terminal(xml, of))
            })
        })
    })
}

fn terminal<V: Structure>(xml: &mut Xml, terminal: &Terminal<V>) -> io::Result<()> {
    let rule = match terminal.matching_rule {
        MatchingRule::Plug => "plug",
        MatchingRule::Bus => "bus",
    };
    let attributes = vec![
        ("name", terminal.name.to_owned()),
        ("matchingRule", rule.to_owned()),
        ("description", terminal.description.to_owned()),
    ];
    element(xml, "Terminal", attributes, |xml| {
        terminal.members.iter().try_for_each(|(name, member)| {
            let variable = match *member {
                Member::Variable(variable) => {
                    V::TABLE.get(variable.value_reference() as usize).map(|row| row.name)
                }
                Member::Array(index) => V::ARRAYS.get(index).map(|array| array.name),
                Member::Clock => Some(V::CLOCK.name),
                Member::ClockTime => Some(V::CLOCK.time_name),
            };
            let attributes = vec![
                ("variableName", variable.unwrap_or_default().to_owned()),
                ("memberName", (*name).to_owned()),
                ("variableKind", "signal".to_owned()),
            ];
            empty(xml, "TerminalMemberVariable", attributes)
        })
    })
}
