//! What this FMU does not do.

use steerguard_fmu_core::Fmu;

use super::call::call;
use crate::Function;
use crate::types::{fmi2Component, fmi2Status};

/// What all functions for Model Exchange do.
pub unsafe fn model_exchange<F: Fmu>(c: fmi2Component, function: Function) -> fmi2Status {
    // SAFETY: the contract of this module.
    unsafe {
        call::<F>(c, function, |instance, function| {
            // Not reached: the call is allowed in no state.
            Err(instance.refuse_because(function, "this FMU is not for Model Exchange"))
        })
    }
}
