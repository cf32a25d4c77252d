//! The way in for every function: the instance behind a pointer.

use steerguard_fmu_core::{Fmu, Model};

use crate::Function;
use crate::instance::Instance;
use crate::types::{fmi2Component, fmi2Status};

pub(super) const OK: fmi2Status = fmi2Status::fmi2OK;

/// The instance behind `c`, if `function` may be called on it now.
///
/// # Errors
/// The status to return otherwise.
pub(super) unsafe fn enter<'a, F: Fmu>(
    c: fmi2Component,
    function: Function,
) -> Result<&'a mut Instance<F::Model>, fmi2Status> {
    // SAFETY: the contract of this module.
    let instance = unsafe { c.cast::<Instance<F::Model>>().as_mut() };
    let instance = instance.ok_or(fmi2Status::fmi2Error)?;
    let state = instance.machine.state;
    if function.allowed_states().contains(state as u8) {
        Ok(instance)
    } else {
        Err(instance.refuse(function, |text| {
            text.str("not allowed in state ").str(state.name());
        }))
    }
}

/// Runs `body` on the instance behind `c`, if `function` may be called on it now.
pub(super) unsafe fn call<F: Fmu>(
    c: fmi2Component,
    function: Function,
    body: impl FnOnce(&mut Instance<F::Model>, Function) -> Result<fmi2Status, fmi2Status>,
) -> fmi2Status {
    // SAFETY: the contract of this module.
    let instance = unsafe { enter::<F>(c, function) };
    match instance.and_then(|instance| body(instance, function)) {
        Ok(status) | Err(status) => status,
    }
}

impl<M: Model> Instance<M> {
    /// Refuses an argument that is NULL or no array.
    #[cold]
    pub(super) fn null(&self, function: Function, argument: &str) -> fmi2Status {
        self.refuse(function, |text| {
            text.str("argument ").str(argument).str(" is NULL or no valid array");
        })
    }

    /// Refuses for a fixed reason.
    #[cold]
    pub(super) fn refuse_because(&self, function: Function, reason: &str) -> fmi2Status {
        self.refuse(function, |text| {
            text.str(reason);
        })
    }
}
