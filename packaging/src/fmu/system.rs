//! `SteeringFaultSystem.ssp`: detector and reference vehicle, connected, for tools that read the
//! standard System Structure and Parameterization 1.0.
//!
//! # Conventions
//! - Connectors of components have the names of the FMU variables. An input that both FMUs have, and every
//!   other input of the vehicle, is an input of the system; every output of the detector is an output of it.
//! - Connectors of the system have these names with `_` for each dot: OMSimulator reads a dot as the end of a
//!   component's name. An annotation tells it the master and the step, without which it takes no system.
//! - The parameter set belongs to the system: its names are `<component>.<variable>`. It gives the
//!   vehicle and the actuator that the detector was designed for, its state at the start, and the
//!   drive torque that holds its speed.

use std::collections::BTreeSet;
use std::io;

use quick_xml::events::{BytesDecl, Event};
use quick_xml::writer::Writer;
use steerguard_fmu::{BakedDesign, DetectorModel};
use steerguard_fmu_core::Model;
use steerguard_model_description::detector::DetectorState;
use steerguard_model_description::unit::BASE_UNITS;
use steerguard_model_description::{
    Causality, DefaultExperiment, Kind, Unit, Value, Variable, VariableSet, names,
};
use steerguard_plant::PlantModel;

use crate::drive::cosimulation::name_in_plant;
use crate::drive::scenario::Scenario;
use crate::fmu::archive::Archive;
use crate::fmu::package::{PackageError, STOP_TIME_S, detector_fmu, plant_fmu};
use crate::fmu::reference;
use crate::fmu::runtime::Runtimes;
use crate::report::design_summary::Record;

const PLANT: &str = "plant";
const DETECTOR: &str = "detector";
/// Path of the parameter set in the archive.
const PARAMETERS: &str = "resources/SteeringFaultSystem.ssv";
/// Namespace of the annotations that OMSimulator reads.
const OMSIMULATOR: &str =
    "https://raw.githubusercontent.com/OpenModelica/OMSimulator/master/schema/oms.xsd";
const TOOL: &str = concat!("steerguard ", env!("CARGO_PKG_VERSION"));

const PLANT_TABLE: &[Variable] = <PlantModel as Model>::Variable::TABLE;
const DETECTOR_TABLE: &[Variable] = <DetectorModel as Model>::Variable::TABLE;

type Xml = Writer<Vec<u8>>;

/// The bytes of `SteeringFaultSystem.ssp` with `design` in its detector: the same for the same
/// arguments.
///
/// # Errors
/// [`PackageError`].
pub fn system_ssp(
    design: &BakedDesign,
    record: &Record,
    detector: &Runtimes,
    plant: &Runtimes,
) -> Result<Vec<u8>, PackageError> {
    let experiment = DefaultExperiment {
        start_time: 0.0,
        stop_time: STOP_TIME_S,
        step_size: design.configuration.model.sampling_period_s,
    };
    let mut archive = Archive::system(structure(&experiment)?);
    archive.insert(PARAMETERS, parameter_set(&parameters(design)?)?);
    archive.insert(source(&DetectorModel::INFO), detector_fmu(design, record, detector)?);
    archive.insert(source(&PlantModel::INFO), plant_fmu(plant)?);
    archive.to_bytes().map_err(|error| PackageError::Write(error.into()))
}

/// Path of an FMU in the archive.
fn source(info: &steerguard_model_description::ModelInfo) -> String {
    format!("resources/{}.fmu", info.identifier)
}

fn with(causality: Causality) -> impl Fn(&&'static Variable) -> bool {
    move |variable| variable.role.causality == causality
}

fn is_output_of_plant(name: &str) -> bool {
    PLANT_TABLE.iter().filter(with(Causality::Output)).any(|variable| variable.name == name)
}

/// Name of the system's connector for a variable.
fn name_in_system(variable: &str) -> String {
    variable.replace('.', "_")
}

/// Whether the plant has a variable of the name: an input that it has not, such as a switch, is left out of
/// the system and keeps its start value.
fn is_known_to_plant(input: &Variable) -> bool {
    PLANT_TABLE.iter().any(|variable| variable.name == input.name)
}

/// A parameter or start value, by its name in the system.
struct Parameter {
    name: String,
    unit: &'static Unit,
    value: f64,
}

fn parameters(design: &BakedDesign) -> Result<Vec<Parameter>, PackageError> {
    let configuration = &design.configuration;
    let scenario = Scenario::default();
    let speed = reference::speed_m_per_s(configuration);
    let model = DetectorModel::new(&design.encode()?).map_err(PackageError::Model)?;
    let of_design = |name: &str| {
        let variables = <DetectorModel as Model>::Variable::ALL.iter().zip(DETECTOR_TABLE);
        let mut found = variables.filter(|(_, row)| name_in_plant(row.name) == Some(name));
        found.next().map(|(variable, _)| model.get(*variable))
    };
    let mut parameters = Vec::new();
    for row in PLANT_TABLE {
        let Kind::Real(real) = &row.kind else { continue };
        let (name, value) = match row.name {
            "initial.v_x" => (format!("{PLANT}.{}", row.name), speed),
            "initial.v_y" => {
                (format!("{PLANT}.{}", row.name), scenario.initial_lateral_speed_m_per_s)
            }
            "initial.r" => (format!("{PLANT}.{}", row.name), scenario.initial_yaw_rate_rad_per_s),
            "u.T_eng" => {
                (name_in_system(row.name), configuration.model.vehicle.cruise_torque(speed))
            }
            name => match of_design(name) {
                Some(Value::Real(value)) => (format!("{PLANT}.{name}"), value),
                _ => continue,
            },
        };
        parameters.push(Parameter { name, unit: real.unit, value });
    }
    Ok(parameters)
}

/// `SystemStructure.ssd`.
fn structure(experiment: &DefaultExperiment) -> io::Result<Vec<u8>> {
    let attributes = [
        ("xmlns:ssd", "http://ssp-standard.org/SSP1/SystemStructureDescription"),
        ("xmlns:ssc", "http://ssp-standard.org/SSP1/SystemStructureCommon"),
        ("xmlns:oms", OMSIMULATOR),
        ("version", "1.0"),
        ("name", names::SYSTEM),
        ("generationTool", TOOL),
    ];
    document("ssd:SystemStructureDescription", &attributes, |xml| {
        system(xml, experiment.step_size)?;
        element(xml, "ssd:Enumerations", &[], |xml| {
            let state = &DetectorState::TYPE;
            element(xml, "ssc:Enumeration", &[("name", state.name)], |xml| {
                (1..).zip(state.items).try_for_each(|(value, item)| {
                    let value = i32::to_string(&value);
                    empty(xml, "ssc:Item", &[("name", item.name), ("value", &value)])
                })
            })
        })?;
        let connected = PLANT_TABLE.iter().chain(DETECTOR_TABLE).filter(|variable| {
            matches!(variable.role.causality, Causality::Input | Causality::Output)
        });
        units(xml, "ssd:Units", connected.filter_map(unit))?;
        let times = [experiment.start_time, experiment.stop_time].map(|time| format!("{time:?}"));
        let [start, stop] = &times;
        empty(xml, "ssd:DefaultExperiment", &[("startTime", start), ("stopTime", stop)])
    })
}

fn system(xml: &mut Xml, step_s: f64) -> io::Result<()> {
    let description = "Steering-fault detector on the reference vehicle";
    let attributes = [("name", names::SYSTEM), ("description", description)];
    element(xml, "ssd:System", &attributes, |xml| {
        let inputs = PLANT_TABLE.iter().filter(with(Causality::Input));
        let outputs = DETECTOR_TABLE.iter().filter(with(Causality::Output));
        connectors(xml, inputs.chain(outputs), name_in_system)?;
        element(xml, "ssd:ParameterBindings", &[], |xml| {
            empty(xml, "ssd:ParameterBinding", &[("source", PARAMETERS)])
        })?;
        element(xml, "ssd:Elements", &[], |xml| {
            component(xml, PLANT, &source(&PlantModel::INFO), PLANT_TABLE)?;
            component(xml, DETECTOR, &source(&DetectorModel::INFO), DETECTOR_TABLE)
        })?;
        element(xml, "ssd:Connections", &[], connections)?;
        element(xml, "ssd:Annotations", &[], |xml| {
            element(xml, "ssc:Annotation", &[("type", "org.openmodelica")], |xml| {
                element(xml, "oms:Annotations", &[], |xml| {
                    element(xml, "oms:SimulationInformation", &[], |xml| {
                        let step = format!("{step_s:?}");
                        let tolerance = "0.0001"; // asked for, and of no use to a fixed step
                        let master = [
                            ("description", "oms-ma"),
                            ("stepSize", step.as_str()),
                            ("absoluteTolerance", tolerance),
                            ("relativeTolerance", tolerance),
                        ];
                        empty(xml, "oms:FixedStepMaster", &master)
                    })
                })
            })
        })
    })
}

fn component(
    xml: &mut Xml,
    name: &str,
    source: &str,
    table: &'static [Variable],
) -> io::Result<()> {
    let attributes = [
        ("name", name),
        ("type", "application/x-fmu-sharedlibrary"),
        ("source", source),
        ("implementation", "CoSimulation"),
    ];
    element(xml, "ssd:Component", &attributes, |xml| {
        let inputs =
            table.iter().filter(with(Causality::Input)).filter(|row| is_known_to_plant(row));
        let outputs = table.iter().filter(with(Causality::Output));
        connectors(xml, inputs.chain(outputs), str::to_owned)
    })
}

fn connectors(
    xml: &mut Xml,
    mut variables: impl Iterator<Item = &'static Variable>,
    name: fn(&str) -> String,
) -> io::Result<()> {
    element(xml, "ssd:Connectors", &[], |xml| {
        variables.try_for_each(|row| connector(xml, row, &name(row.name)))
    })
}

fn connector(xml: &mut Xml, variable: &Variable, name: &str) -> io::Result<()> {
    let kind = if variable.role.causality == Causality::Input { "input" } else { "output" };
    let attributes = [("name", name), ("kind", kind), ("description", variable.description)];
    element(xml, "ssd:Connector", &attributes, |xml| match &variable.kind {
        Kind::Real(real) => empty(xml, "ssc:Real", &[("unit", real.unit.name)]),
        Kind::Integer { .. } => empty(xml, "ssc:Integer", &[]),
        Kind::Boolean => empty(xml, "ssc:Boolean", &[]),
        Kind::String => empty(xml, "ssc:String", &[]),
        Kind::Enumeration(enumeration) => {
            empty(xml, "ssc:Enumeration", &[("name", enumeration.name)])
        }
    })
}

fn connections(xml: &mut Xml) -> io::Result<()> {
    for input in PLANT_TABLE.iter().filter(with(Causality::Input)) {
        connection(xml, None, Some(PLANT), input.name)?;
    }
    for input in DETECTOR_TABLE.iter().filter(with(Causality::Input)) {
        if !is_known_to_plant(input) {
            continue;
        }
        let start = is_output_of_plant(input.name).then_some(PLANT);
        connection(xml, start, Some(DETECTOR), input.name)?;
    }
    for output in DETECTOR_TABLE.iter().filter(with(Causality::Output)) {
        connection(xml, Some(DETECTOR), None, output.name)?;
    }
    Ok(())
}

/// Connects the connectors for a variable; `None` is the system itself.
fn connection(
    xml: &mut Xml,
    start: Option<&str>,
    end: Option<&str>,
    variable: &str,
) -> io::Result<()> {
    let in_system = name_in_system(variable);
    let connector = |element: Option<&str>| element.map_or(in_system.as_str(), |_| variable);
    let mut attributes = Vec::new();
    attributes.extend(start.map(|element| ("startElement", element)));
    attributes.push(("startConnector", connector(start)));
    attributes.extend(end.map(|element| ("endElement", element)));
    attributes.push(("endConnector", connector(end)));
    empty(xml, "ssd:Connection", &attributes)
}

/// The parameter set.
fn parameter_set(parameters: &[Parameter]) -> io::Result<Vec<u8>> {
    let attributes = [
        ("xmlns:ssv", "http://ssp-standard.org/SSP1/SystemStructureParameterValues"),
        ("xmlns:ssc", "http://ssp-standard.org/SSP1/SystemStructureCommon"),
        ("version", "1.0"),
        ("name", names::SYSTEM),
        ("generationTool", TOOL),
    ];
    document("ssv:ParameterSet", &attributes, |xml| {
        element(xml, "ssv:Parameters", &[], |xml| {
            parameters.iter().try_for_each(|Parameter { name, unit, value }| {
                element(xml, "ssv:Parameter", &[("name", name)], |xml| {
                    let value = format!("{value:?}");
                    empty(xml, "ssv:Real", &[("value", &value), ("unit", unit.name)])
                })
            })
        })?;
        units(xml, "ssv:Units", parameters.iter().map(|parameter| parameter.unit))
    })
}

fn unit(variable: &Variable) -> Option<&'static Unit> {
    match &variable.kind {
        Kind::Real(real) => Some(real.unit),
        _ => None,
    }
}

/// The definitions of `units`, each once.
fn units(xml: &mut Xml, list: &str, units: impl Iterator<Item = &'static Unit>) -> io::Result<()> {
    let mut seen = BTreeSet::new();
    element(xml, list, &[], |xml| {
        units.filter(|unit| seen.insert(unit.name)).try_for_each(|unit| {
            element(xml, "ssc:Unit", &[("name", unit.name)], |xml| {
                let exponents = BASE_UNITS.into_iter().zip(unit.base.map(|e| e.to_string()));
                let exponents: Vec<_> = exponents.filter(|(_, e)| e != "0").collect();
                let attributes: Vec<_> = exponents.iter().map(|(n, e)| (*n, e.as_str())).collect();
                empty(xml, "ssc:BaseUnit", &attributes)
            })
        })
    })
}

fn document(
    root: &str,
    attributes: &[(&str, &str)],
    content: impl FnOnce(&mut Xml) -> io::Result<()>,
) -> io::Result<Vec<u8>> {
    let mut xml = Writer::new_with_indent(Vec::new(), b' ', 2);
    xml.write_event(Event::Decl(BytesDecl::new("1.0", Some("UTF-8"), None)))?;
    element(&mut xml, root, attributes, content)?;
    let mut bytes = xml.into_inner();
    bytes.push(b'\n');
    Ok(bytes)
}

fn element(
    xml: &mut Xml,
    name: &str,
    attributes: &[(&str, &str)],
    content: impl FnOnce(&mut Xml) -> io::Result<()>,
) -> io::Result<()> {
    let attributes = attributes.iter().copied();
    xml.create_element(name).with_attributes(attributes).write_inner_content(content)?;
    Ok(())
}

fn empty(xml: &mut Xml, name: &str, attributes: &[(&str, &str)]) -> io::Result<()> {
    xml.create_element(name).with_attributes(attributes.iter().copied()).write_empty()?;
    Ok(())
}
