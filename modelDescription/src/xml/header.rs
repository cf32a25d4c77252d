//! What an FMU of any kind says of itself: version, GUID and implementations.

use super::read::ReadError;
use super::tree::{Element, parse};

/// The header of a description.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Header {
    /// Whether it is of FMI 3.0; otherwise it is taken for FMI 2.0.
    pub is_version_3: bool,
    /// GUID, or in FMI 3.0 instantiation token; empty if there is none.
    pub guid: String,
    /// The elements `CoSimulation`, `ModelExchange` and `ScheduledExecution`, in order.
    pub implementations: Vec<Implementation>,
}

/// What an implementation is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum InterfaceType {
    /// Co-Simulation.
    CoSimulation,
    /// Model Exchange.
    ModelExchange,
    /// Scheduled Execution, which FMI 3.0 alone has.
    ScheduledExecution,
}

/// The element `CoSimulation`, `ModelExchange` or `ScheduledExecution`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Implementation {
    /// Which of them it is.
    pub interface: InterfaceType,
    /// Base name of the shared library; empty if there is none.
    pub model_identifier: String,
    /// Names of the flags that are true, such as `canGetAndSetFMUstate`.
    pub flags: Vec<String>,
}

/// Reads the header of a description, whatever else is in it.
///
/// # Errors
/// [`ReadError::Malformed`] if the text is no XML.
pub fn header(xml: &str) -> Result<Header, ReadError> {
    let root = parse(xml)?;
    let implementations = root.children.iter().filter_map(implementation).collect();
    let is_version_3 = is_version_3(&root);
    let guid = text(&root, if is_version_3 { "instantiationToken" } else { "guid" });
    Ok(Header { is_version_3, guid, implementations })
}

/// Whether a description is of FMI 3.0.
pub(super) fn is_version_3(root: &Element) -> bool {
    root.attribute("fmiVersion").is_some_and(|version| version.starts_with("3."))
}

fn implementation(element: &Element) -> Option<Implementation> {
    let interface = match element.name.as_str() {
        "CoSimulation" => InterfaceType::CoSimulation,
        "ModelExchange" => InterfaceType::ModelExchange,
        "ScheduledExecution" => InterfaceType::ScheduledExecution,
        _ => return None,
    };
    let flags = element.attributes.iter().filter(|(_, value)| matches!(&**value, "true" | "1"));
    Some(Implementation {
        interface,
        model_identifier: text(element, "modelIdentifier"),
        flags: flags.map(|(name, _)| name.clone()).collect(),
    })
}

fn text(element: &Element, attribute: &str) -> String {
    element.attribute(attribute).unwrap_or_default().to_owned()
}
