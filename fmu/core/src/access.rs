//! Which variable an importer means, and whether it may set it now.

use steerguard_model_description::{
    Causality, Kind, Role, Value, Variability, Variable, VariableSet,
};

use crate::Model;
use crate::refusal::AccessRefusal;

/// A variable with its row of the table.
pub type Entry<M> = (<M as Model>::Variable, &'static Variable);

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

/// Finds a variable.
///
/// # Errors
/// [`AccessRefusal::Unknown`].
#[inline]
pub fn find<M: Model>(vr: u32) -> Result<Entry<M>, AccessRefusal<'static>> {
    let index = vr as usize;
    let variable = <M::Variable as VariableSet>::ALL.get(index);
    match variable.zip(<M::Variable as VariableSet>::TABLE.get(index)) {
        Some((variable, row)) => Ok((*variable, row)),
        None => Err(AccessRefusal::Unknown(vr)),
    }
}

/// The variable, if it may be set to a value before or after the end of initialisation.
#[inline]
pub fn settable<M: Model>(vr: u32, value: Value<'_>, initialised: bool) -> Option<M::Variable> {
    let (variable, row) = find::<M>(vr).ok()?;
    let settable =
        is_real_input(row, value) || may_set(row.role, initialised) && row.kind.admits(value);
    settable.then_some(variable)
}

/// Why a variable is not [`settable`].
#[cold]
pub fn refusal_to_set<M: Model>(vr: u32, value: Value<'_>, initialised: bool) -> AccessRefusal<'_> {
    match find::<M>(vr) {
        Err(refusal) => refusal,
        Ok((_, row)) if !row.kind.is_type_of(value) => AccessRefusal::WrongType(row),
        Ok((_, row)) if !may_set(row.role, initialised) => AccessRefusal::NotSettable(row),
        Ok((_, row)) => AccessRefusal::OutOfRange(row, value),
    }
}
