//! The C types of the FMI layer against those that bindgen reads from the standard's headers.

#![allow(clippy::unwrap_used)]

mod common;

use std::mem::{align_of, offset_of, size_of};

use fmi::fmi2::binding;
use fmi::traits::FmiImport;
use steerguard_fmi2::types as ours;

/// Size and alignment of types of the same name.
macro_rules! assert_same_layout {
    ($($name:ident)+) => { $(
        assert_eq!(size_of::<ours::$name>(), size_of::<binding::$name>(), stringify!($name));
        assert_eq!(align_of::<ours::$name>(), align_of::<binding::$name>(), stringify!($name));
    )+ };
}

/// The same types: assignable to each other without a cast.
macro_rules! assert_same_type {
    ($($name:ident)+) => { $( let _: fn(ours::$name) -> binding::$name = |x| x; )+ };
}

/// Offsets of all fields of a structure; naming each in a pattern makes the list complete.
macro_rules! assert_same_fields {
    ($name:ident { $($field:ident)+ }) => {
        assert_same_layout!($name);
        let _ = |ours::$name { $($field: _,)+ }: ours::$name| ();
        let _ = |binding::$name { $($field: _,)+ }: binding::$name| ();
        $(assert_eq!(
            offset_of!(ours::$name, $field),
            offset_of!(binding::$name, $field),
            concat!(stringify!($name), "::", stringify!($field)),
        );)+
    };
}

#[test]
fn scalar_types_are_the_same() {
    assert_same_type!(
        fmi2Component fmi2ComponentEnvironment fmi2FMUstate fmi2ValueReference fmi2Real fmi2Integer
        fmi2Boolean fmi2String fmi2Byte
    );
    assert_same_layout!(fmi2Status fmi2Type fmi2StatusKind);
}

#[test]
fn structures_have_the_same_layout() {
    assert_same_fields!(fmi2CallbackFunctions {
        logger allocateMemory freeMemory stepFinished componentEnvironment
    });
    assert_same_fields!(fmi2EventInfo {
        newDiscreteStatesNeeded terminateSimulation nominalsOfContinuousStatesChanged
        valuesOfContinuousStatesChanged nextEventTimeDefined nextEventTime
    });
}

#[test]
fn constants_have_the_same_values() {
    use ours::fmi2Status as Status;
    let pairs = [
        (ours::fmi2True, binding::fmi2True),
        (ours::fmi2False, binding::fmi2False),
        (ours::fmi2ModelExchange, binding::fmi2Type_fmi2ModelExchange),
        (ours::fmi2CoSimulation, binding::fmi2Type_fmi2CoSimulation),
        (ours::fmi2DoStepStatus, binding::fmi2StatusKind_fmi2DoStepStatus),
        (ours::fmi2PendingStatus, binding::fmi2StatusKind_fmi2PendingStatus),
        (ours::fmi2LastSuccessfulTime, binding::fmi2StatusKind_fmi2LastSuccessfulTime),
        (ours::fmi2Terminated, binding::fmi2StatusKind_fmi2Terminated),
        (Status::fmi2OK.0, binding::fmi2Status_fmi2OK),
        (Status::fmi2Warning.0, binding::fmi2Status_fmi2Warning),
        (Status::fmi2Discard.0, binding::fmi2Status_fmi2Discard),
        (Status::fmi2Error.0, binding::fmi2Status_fmi2Error),
        (Status::fmi2Fatal.0, binding::fmi2Status_fmi2Fatal),
        (Status::fmi2Pending.0, binding::fmi2Status_fmi2Pending),
    ];
    for (place, (ours, theirs)) in pairs.into_iter().enumerate() {
        assert_eq!(u32::try_from(ours), Ok(theirs), "constant {place} of the list");
    }
}

/// The layer's list of functions with its types taken from the standard's headers: compiles only if
/// it has their names, their number of arguments and each argument's type.
mod signatures {
    use fmi::fmi2::binding::*;

    macro_rules! compare {
        ({}
            co_simulation: $(fn $cs:ident($($ca:ident: $ct:ty),*) -> $cr:ty;)+
            model_exchange: $(fn $me:ident($($ma:ident: $mt:ty),*) -> $mr:ty;)+
        ) => {
            pub fn loaded(binding: &Fmi2Binding) -> usize {
                $( let $cs: Option<&unsafe extern "C" fn($($ct),*) -> $cr> =
                    binding.$cs.as_ref().ok(); )+
                $( let $me: Option<&unsafe extern "C" fn($($mt),*) -> $mr> =
                    binding.$me.as_ref().ok(); )+
                [$($cs.is_some(),)+ $($me.is_some(),)+].into_iter().filter(|x| *x).count()
            }
        };
    }

    steerguard_fmi2::fmi2_functions!([compare] {});
}

#[test]
fn both_libraries_export_all_functions() {
    for name in ["SteeringFaultDetector", "VehiclePlant"] {
        let import = common::import(name);
        let binding = import.binding(name).unwrap();
        assert_eq!(signatures::loaded(&binding), 44, "{name}");
    }
}
