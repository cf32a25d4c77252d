//! What an FMU of either kind says of itself: GUID and implementations.

use super::read::ReadError;
use super::tree::{Element, parse};

/// The header of a description.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Header {
    /// GUID; empty if there is none.
    pub guid: String,
    /// The elements `CoSimulation` and `ModelExchange`, in order.
    pub implementations: Vec<Implementation>,
}

/// The element `CoSimulation` or `ModelExchange`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Implementation {
    /// Whether it is `CoSimulation`.
    pub is_co_simulation: bool,
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
    Ok(Header { guid: text(&root, "guid"), implementations })
}

fn implementation(element: &Element) -> Option<Implementation> {
    let is_co_simulation = match element.name.as_str() {
        "CoSimulation" => true,
        "ModelExchange" => false,
        _ => return None,
    };
    let flags = element.attributes.iter().filter(|(_, value)| matches!(&**value, "true" | "1"));
    Some(Implementation {
        is_co_simulation,
        model_identifier: text(element, "modelIdentifier"),
        flags: flags.map(|(name, _)| name.clone()).collect(),
    })
}

fn text(element: &Element, attribute: &str) -> String {
    element.attribute(attribute).unwrap_or_default().to_owned()
}
