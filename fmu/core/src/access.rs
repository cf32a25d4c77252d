//! Which variable an importer means, and whether it may set it now.

use steerguard_model_description::{
    Causality, Kind, Role, Value, Variability, Variable, VariableSet,
};

use crate::run::{MAX_ORDER, Run};
use crate::{Model, Text};

/// A variable with its row of the table.
pub type Entry<M> = (<M as Model>::Variable, &'static Variable);

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
    Order(i32),
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
                text.str(": finite values between min and max are allowed");
            }
            Self::NotAnInput(row) => {
                variable(row, text).str("is not an input");
            }
            Self::Order(order) => {
                text.str("derivatives of order ").integer(order.into());
                text.str(" cannot be used, only 1 to ").integer(MAX_ORDER as i64);
            }
        }
    }
}

fn variable<'t>(row: &Variable, text: &'t mut Text) -> &'t mut Text {
    text.str("variable \"").str(row.name).str("\" ")
}

/// Whether a variable of this role may be set before or after the end of initialisation; inputs are
/// taken at any time.
fn may_set(role: Role, initialised: bool) -> bool {
    match (role.causality, role.variability) {
        (Causality::Input, _) | (Causality::Parameter, Variability::Tunable) => true,
        (Causality::Parameter, _) => !initialised,
        (Causality::Output | Causality::Local, _) => false,
    }
}

/// Real inputs may be set to anything: what a model does with NaN is its own affair.
#[inline]
fn is_real_input(row: &Variable, value: Value<'_>) -> bool {
    row.role.causality == Causality::Input
        && matches!((&row.kind, value), (Kind::Real(_), Value::Real(_)))
}

impl<M: Model> Run<M> {
    /// Finds a variable.
    ///
    /// # Errors
    /// [`AccessRefusal::Unknown`].
    #[inline]
    pub fn find(vr: u32) -> Result<Entry<M>, AccessRefusal<'static>> {
        let index = vr as usize;
        let variable = <M::Variable as VariableSet>::ALL.get(index);
        match variable.zip(<M::Variable as VariableSet>::TABLE.get(index)) {
            Some((variable, row)) => Ok((*variable, row)),
            None => Err(AccessRefusal::Unknown(vr)),
        }
    }

    /// The variable, if it may be set to a value before or after the end of initialisation.
    #[inline]
    pub fn settable(vr: u32, value: Value<'_>, initialised: bool) -> Option<M::Variable> {
        let (variable, row) = Self::find(vr).ok()?;
        let settable =
            is_real_input(row, value) || may_set(row.role, initialised) && row.kind.admits(value);
        settable.then_some(variable)
    }

    /// Why a variable is not [`settable`](Self::settable).
    #[cold]
    pub fn refusal_to_set(vr: u32, value: Value<'_>, initialised: bool) -> AccessRefusal<'_> {
        match Self::find(vr) {
            Err(refusal) => refusal,
            Ok((_, row)) if !row.kind.is_type_of(value) => AccessRefusal::WrongType(row),
            Ok((_, row)) if !may_set(row.role, initialised) => AccessRefusal::NotSettable(row),
            Ok((_, row)) => AccessRefusal::OutOfRange(row, value),
        }
    }
}
