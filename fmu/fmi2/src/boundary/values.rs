//! Getting and setting values.

use steerguard_fmu_core::foreign::{array, array_mut, string};
use steerguard_fmu_core::{AccessRefusal, Fmu, Model, access};
use steerguard_model_description::{Value, VariableSet};

use super::call::{OK, call};
use crate::Function;
use crate::types::*;

/// Gets values of the type that `pick` knows.
unsafe fn get<F: Fmu, T>(
    c: fmi2Component,
    function: Function,
    vr: *const fmi2ValueReference,
    nvr: usize,
    value: *mut T,
    pick: impl Fn(Value<'_>) -> Option<T>,
) -> fmi2Status {
    // SAFETY: the contract of this module.
    unsafe {
        call::<F>(c, function, |instance, function| {
            let vr = array(vr, nvr).ok_or_else(|| instance.null(function, "vr"))?;
            let value = array_mut(value, nvr).ok_or_else(|| instance.null(function, "value"))?;
            for (&vr, value) in vr.iter().zip(value) {
                let (variable, row) = access::find::<F::Model>(vr)
                    .map_err(|refusal| instance.refuse_access(function, refusal))?;
                match pick(instance.machine.run.model.get(variable)) {
                    Some(got) => value.write(got),
                    None => {
                        return Err(instance.refuse_access(function, AccessRefusal::WrongType(row)));
                    }
                };
            }
            Ok(OK)
        })
    }
}

/// Sets values, all of them or, where one is refused, none.
unsafe fn set<'a, F: Fmu, T: Copy + 'a>(
    c: fmi2Component,
    function: Function,
    vr: *const fmi2ValueReference,
    nvr: usize,
    value: *const T,
    wrap: impl Fn(T) -> Option<Value<'a>>,
) -> fmi2Status {
    // SAFETY: the contract of this module.
    unsafe {
        call::<F>(c, function, |instance, function| {
            let vr = array(vr, nvr).ok_or_else(|| instance.null(function, "vr"))?;
            let value = array(value, nvr).ok_or_else(|| instance.null(function, "value"))?;
            let all = <<F::Model as Model>::Variable as VariableSet>::ALL;
            for (&vr, &value) in vr.iter().zip(value) {
                let value = wrap(value).ok_or_else(|| instance.null(function, "value"))?;
                instance.settable(function, vr, value)?;
            }
            for (&vr, &value) in vr.iter().zip(value) {
                if let (Some(value), Some(&variable)) = (wrap(value), all.get(vr as usize)) {
                    instance.machine.run.model.set(variable, value);
                }
            }
            Ok(OK)
        })
    }
}

macro_rules! accessors {
    ($($get:ident, $set:ident: $type:ty, $pick:expr, $wrap:expr;)+) => {$(
        pub unsafe fn $get<F: Fmu>(
            c: fmi2Component,
            vr: *const fmi2ValueReference,
            nvr: usize,
            value: *mut $type,
        ) -> fmi2Status {
            // SAFETY: the contract of this module.
            unsafe { get::<F, _>(c, Function::$get, vr, nvr, value, $pick) }
        }

        pub unsafe fn $set<F: Fmu>(
            c: fmi2Component,
            vr: *const fmi2ValueReference,
            nvr: usize,
            value: *const $type,
        ) -> fmi2Status {
            // SAFETY: the contract of this module.
            unsafe { set::<F, _>(c, Function::$set, vr, nvr, value, $wrap) }
        }
    )+};
}

accessors! {
    fmi2GetReal, fmi2SetReal: fmi2Real,
        |value| if let Value::Real(real) = value { Some(real) } else { None },
        |real| Some(Value::Real(real));
    fmi2GetInteger, fmi2SetInteger: fmi2Integer,
        |value| if let Value::Integer(integer) = value { Some(integer) } else { None },
        |integer| Some(Value::Integer(integer));
    fmi2GetBoolean, fmi2SetBoolean: fmi2Boolean,
        |value| if let Value::Boolean(boolean) = value { Some(boolean.into()) } else { None },
        |boolean| Some(Value::Boolean(boolean != fmi2False));
    fmi2GetString, fmi2SetString: fmi2String,
        |value| if let Value::String(text) = value { Some(text.as_ptr()) } else { None },
        |pointer| string(pointer).map(Value::String);
}
