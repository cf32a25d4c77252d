//! Steps, derivatives, status.

use steerguard_fmu_core::Fmu;
use steerguard_fmu_core::foreign::{array, place};
use steerguard_model_description::LogCategory;

use super::call::{OK, call};
use crate::Function;
use crate::instance::Instance;
use crate::types::*;

pub unsafe fn fmi2DoStep<F: Fmu>(
    c: fmi2Component,
    current_communication_point: fmi2Real,
    communication_step_size: fmi2Real,
    _no_set_state_prior_to_current_point: fmi2Boolean,
) -> fmi2Status {
    let mut step_finished = None;
    // SAFETY: the contract of this module.
    let status = unsafe {
        call::<F>(c, Function::fmi2DoStep, |instance, _| {
            let status = instance.do_step(current_communication_point, communication_step_size);
            if status <= fmi2Status::fmi2Warning {
                step_finished = instance.environment.step_finished();
            }
            Ok(status)
        })
    };
    if let Some((tell, environment)) = step_finished {
        // FMI 2.0.4, section 2.1.5, asks for the call after every completed step. Here the instance is
        // not borrowed any more: the importer may well use it from there.
        // SAFETY: the importer gave function and environment for this call.
        unsafe { tell(environment, status) };
    }
    status
}

pub unsafe fn fmi2SetRealInputDerivatives<F: Fmu>(
    c: fmi2Component,
    vr: *const fmi2ValueReference,
    nvr: usize,
    order: *const fmi2Integer,
    value: *const fmi2Real,
) -> fmi2Status {
    // SAFETY: the contract of this module.
    unsafe {
        call::<F>(c, Function::fmi2SetRealInputDerivatives, |instance, function| {
            let vr = array(vr, nvr).ok_or_else(|| instance.null(function, "vr"))?;
            let order = array(order, nvr).ok_or_else(|| instance.null(function, "order"))?;
            let value = array(value, nvr).ok_or_else(|| instance.null(function, "value"))?;
            let derivatives = vr.iter().zip(order).zip(value);
            let derivatives = derivatives.map(|((&vr, &order), &value)| (vr, order, value));
            instance
                .machine
                .run
                .set_derivatives(derivatives)
                .map_err(|refusal| instance.refuse_access(function, refusal))?;
            Ok(OK)
        })
    }
}

/// Refuses what this FMU does not provide.
unsafe fn not_provided<F: Fmu>(c: fmi2Component, function: Function, what: &str) -> fmi2Status {
    // SAFETY: the contract of this module.
    unsafe {
        call::<F>(c, function, |instance, function| {
            Err(instance.refuse(function, |text| {
                text.str(what).str(" are not provided: see the capability flags");
            }))
        })
    }
}

pub unsafe fn fmi2GetDirectionalDerivative<F: Fmu>(
    c: fmi2Component,
    _v_unknown: *const fmi2ValueReference,
    _n_unknown: usize,
    _v_known: *const fmi2ValueReference,
    _n_known: usize,
    _dv_known: *const fmi2Real,
    _dv_unknown: *mut fmi2Real,
) -> fmi2Status {
    let function = Function::fmi2GetDirectionalDerivative;
    // SAFETY: the contract of this module.
    unsafe { not_provided::<F>(c, function, "directional derivatives") }
}

pub unsafe fn fmi2GetRealOutputDerivatives<F: Fmu>(
    c: fmi2Component,
    _vr: *const fmi2ValueReference,
    _nvr: usize,
    _order: *const fmi2Integer,
    _value: *mut fmi2Real,
) -> fmi2Status {
    let function = Function::fmi2GetRealOutputDerivatives;
    // SAFETY: the contract of this module.
    unsafe { not_provided::<F>(c, function, "output derivatives") }
}

pub unsafe fn fmi2CancelStep<F: Fmu>(c: fmi2Component) -> fmi2Status {
    // SAFETY: the contract of this module.
    unsafe { not_provided::<F>(c, Function::fmi2CancelStep, "asynchronous steps") }
}

/// Answers a status inquiry, with fmi2Discard where there is no such information.
unsafe fn inquire<F: Fmu, T>(
    c: fmi2Component,
    function: Function,
    value: *mut T,
    answer: impl FnOnce(&Instance<F::Model>) -> Option<T>,
) -> fmi2Status {
    // SAFETY: the contract of this module.
    unsafe {
        call::<F>(c, function, |instance, function| {
            let value = place(value).ok_or_else(|| instance.null(function, "value"))?;
            let Some(answer) = answer(instance) else {
                instance.environment.log().message(LogCategory::StatusDiscard, |text| {
                    text.str(function.name()).str(": no such status, steps are synchronous");
                });
                return Err(fmi2Status::fmi2Discard);
            };
            value.write(answer);
            Ok(OK)
        })
    }
}

pub unsafe fn fmi2GetStatus<F: Fmu>(
    c: fmi2Component,
    _kind: fmi2StatusKind,
    value: *mut fmi2Status,
) -> fmi2Status {
    // SAFETY: the contract of this module.
    unsafe { inquire::<F, _>(c, Function::fmi2GetStatus, value, |_| None) }
}

pub unsafe fn fmi2GetRealStatus<F: Fmu>(
    c: fmi2Component,
    kind: fmi2StatusKind,
    value: *mut fmi2Real,
) -> fmi2Status {
    let answer = |instance: &Instance<F::Model>| {
        (kind == fmi2LastSuccessfulTime).then_some(instance.machine.run.clock.point)
    };
    // SAFETY: the contract of this module.
    unsafe { inquire::<F, _>(c, Function::fmi2GetRealStatus, value, answer) }
}

pub unsafe fn fmi2GetIntegerStatus<F: Fmu>(
    c: fmi2Component,
    _kind: fmi2StatusKind,
    value: *mut fmi2Integer,
) -> fmi2Status {
    // SAFETY: the contract of this module.
    unsafe { inquire::<F, _>(c, Function::fmi2GetIntegerStatus, value, |_| None) }
}

pub unsafe fn fmi2GetBooleanStatus<F: Fmu>(
    c: fmi2Component,
    kind: fmi2StatusKind,
    value: *mut fmi2Boolean,
) -> fmi2Status {
    // A model never asks for the end of the run.
    let answer = |_: &Instance<F::Model>| (kind == fmi2Terminated).then_some(fmi2False);
    // SAFETY: the contract of this module.
    unsafe { inquire::<F, _>(c, Function::fmi2GetBooleanStatus, value, answer) }
}

pub unsafe fn fmi2GetStringStatus<F: Fmu>(
    c: fmi2Component,
    _kind: fmi2StatusKind,
    value: *mut fmi2String,
) -> fmi2Status {
    // SAFETY: the contract of this module.
    unsafe { inquire::<F, _>(c, Function::fmi2GetStringStatus, value, |_| None) }
}
