//! The way in for every function: the instance behind a pointer.

use steerguard_fmu_core::{Fmu, Model};
use steerguard_model_description::structure::Structure;

use crate::Function;
use crate::instance::Instance;
use crate::types::{fmi3Instance, fmi3Status};

pub(super) const OK: fmi3Status = fmi3Status::fmi3OK;

/// An FMU whose variables FMI 3.0 can have.
pub trait Fmi3: Fmu<Model: Model<Variable: Structure>> {}

impl<F: Fmu<Model: Model<Variable: Structure>>> Fmi3 for F {}

/// The instance behind a pointer, if `function` may be called on it now.
///
/// # Errors
/// The status to return otherwise.
#[inline(never)] // small code: every function begins with it
pub(super) unsafe fn enter<'a, F: Fmi3>(
    instance: fmi3Instance,
    function: Function,
) -> Result<&'a mut Instance<F::Model>, fmi3Status> {
    // SAFETY: the contract of this module.
    let instance = unsafe { instance.cast::<Instance<F::Model>>().as_mut() };
    let instance = instance.ok_or(fmi3Status::fmi3Error)?;
    let state = instance.machine.state;
    if function.allowed_states().contains(state as u8) {
        Ok(instance)
    } else {
        Err(instance.refuse(function, |text| {
            text.str("not allowed in state ").str(state.name());
        }))
    }
}

/// Runs `body` on the instance behind a pointer, if `function` may be called on it now.
pub(super) unsafe fn call<F: Fmi3>(
    instance: fmi3Instance,
    function: Function,
    body: impl FnOnce(&mut Instance<F::Model>, Function) -> Result<fmi3Status, fmi3Status>,
) -> fmi3Status {
    // SAFETY: the contract of this module.
    let instance = unsafe { enter::<F>(instance, function) };
    match instance.and_then(|instance| body(instance, function)) {
        Ok(status) | Err(status) => status,
    }
}

/// What all functions do that are not provided: say why.
#[inline(never)] // small code, as above
pub unsafe fn absent<F: Fmi3>(
    instance: fmi3Instance,
    function: Function,
    reason: &str,
) -> fmi3Status {
    // SAFETY: the contract of this module.
    match unsafe { instance.cast::<Instance<F::Model>>().as_ref() } {
        Some(instance) => instance.refuse_because(function, reason),
        None => fmi3Status::fmi3Error,
    }
}

impl<M: Model<Variable: Structure>> Instance<M> {
    /// Refuses an argument that is NULL or no array.
    #[cold]
    pub(super) fn null(&self, function: Function, argument: &str) -> fmi3Status {
        self.refuse(function, |text| {
            text.str("argument ").str(argument).str(" is NULL or no valid array");
        })
    }
}
