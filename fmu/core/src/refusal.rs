//! Why an importer does not get its way with a variable.

use steerguard_model_description::{
    Causality, EnumerationType, Kind, RealKind, Value, Variability, Variable,
};

use crate::Text;

/// Why a variable cannot be treated as asked.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum AccessRefusal<'v> {
    /// No variable has this value reference.
    Unknown(u32),
    /// The variable is of another type.
    WrongType(&'static Variable),
    /// The variable cannot be set, or not any more.
    NotSettable(&'static Variable),
    /// The variable does not take this value.
    OutOfRange(&'static Variable, Value<'v>),
    /// Derivatives belong to inputs.
    NotAnInput(&'static Variable),
    /// Derivatives of this order are not used.
    Order {
        /// The order given.
        order: i32,
        /// The highest order that is used.
        highest: usize,
    },
}

impl AccessRefusal<'_> {
    /// Says why.
    pub fn describe(self, text: &mut Text) {
        match self {
            Self::Unknown(vr) => {
                text.str("no variable has value reference ").integer(vr.into());
            }
            Self::WrongType(row) => {
                variable(row, text).str("is of type ").str(row.kind.name());
            }
            Self::NotSettable(row) => {
                variable(row, text).str(match (row.role.causality, row.role.variability) {
                    (Causality::Output, _) => "is an output and cannot be set",
                    (_, Variability::Constant) => "is a constant and cannot be set",
                    (Causality::Local, _) => "is a local variable and cannot be set",
                    _ => "is a fixed parameter and cannot be set after initialization",
                });
            }
            Self::OutOfRange(row, value) => {
                variable(row, text).str("cannot be ");
                match value {
                    Value::Real(value) => text.real(value),
                    Value::Integer(value) => text.integer(value.into()),
                    Value::Boolean(_) | Value::String(_) => text.str("that"),
                };
                allowed(&row.kind, text.str(": "));
            }
            Self::NotAnInput(row) => {
                variable(row, text).str("is not an input");
            }
            Self::Order { order, highest } => {
                text.str("derivatives of order ").integer(order.into());
                text.str(" cannot be used, only 1 to ").integer(highest as i64);
            }
        }
    }
}

fn variable<'t>(row: &Variable, text: &'t mut Text) -> &'t mut Text {
    text.str("variable \"").str(row.name).str("\" ")
}

/// Says which values a type allows.
fn allowed(kind: &Kind, text: &mut Text) {
    match kind {
        Kind::Real(RealKind { min: Some(min), max: Some(max), .. }) => {
            text.real(*min).str(" to ").real(*max).str(" is allowed");
        }
        Kind::Real(RealKind { min: Some(min), .. }) => {
            text.str("at least ").real(*min).str(" is allowed");
        }
        Kind::Real(RealKind { max: Some(max), .. }) => {
            text.str("at most ").real(*max).str(" is allowed");
        }
        Kind::Integer { min, max } => {
            text.integer((*min).into()).str(" to ").integer((*max).into()).str(" is allowed");
        }
        Kind::Enumeration(EnumerationType { items, .. }) => {
            let mut separator = "its items are ";
            for (item, value) in items.iter().zip(1..) {
                text.str(separator).integer(value).str(" ").str(item.name);
                separator = ", ";
            }
        }
        Kind::Real(_) | Kind::Boolean | Kind::String => {
            text.str("finite values are allowed");
        }
    }
}
