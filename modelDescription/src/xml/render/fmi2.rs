//! Rendering to the schema of FMI 2.0.

use std::io;

use super::common::{
    Rendered, Xml, default_experiment, digest, document, element, empty, enumerations, items,
    log_categories, real_attributes, role_attributes, root, start_text, unit_definitions,
};
use crate::{
    Causality, DefaultExperiment, Dependencies, Kind, ModelInfo, Value, Variable, VariableSet,
};

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
    let attributes = root("2.0", info, ("guid", guid));
    document(|xml| {
        element(xml, "fmiModelDescription", attributes, |xml| {
            co_simulation(xml, info)?;
            unit_definitions(xml, V::TABLE)?;
            type_definitions(xml, V::TABLE)?;
            log_categories(xml, "fmi2")?;
            default_experiment(xml, experiment)?;
            element(xml, "ModelVariables", vec![], |xml| {
                for (reference, (variable, row)) in V::ALL.iter().zip(V::TABLE).enumerate() {
                    let start = row.role.has_start().then(|| start(*variable));
                    scalar_variable(xml, reference, row, start)?;
                }
                Ok(())
            })?;
            model_structure::<V>(xml)
        })
    })
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
            element(xml, "SimpleType", attributes, |xml| {
                element(xml, "Enumeration", vec![], |xml| items(xml, enumeration))
            })
        })
    })
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
    ];
    attributes.extend(role_attributes(row.role));
    element(xml, "ScalarVariable", attributes, |xml| {
        let mut attributes = match &row.kind {
            Kind::Real(real) => real_attributes(real),
            Kind::Integer { min, max } => {
                vec![("min", min.to_string()), ("max", max.to_string())]
            }
            Kind::Enumeration(enumeration) => vec![("declaredType", enumeration.name.to_owned())],
            Kind::Boolean | Kind::String => vec![],
        };
        attributes.extend(start.map(|start| ("start", start_text(start))));
        empty(xml, row.kind.name(), attributes)
    })
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
