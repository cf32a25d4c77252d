//! The 44 functions of FMI 2.0 with their signatures, written once.

/// Passes the list of all functions to the macro named in brackets, after the tokens in braces.
///
/// The functions that exist for Model Exchange alone come last, after `model_exchange:`.
#[doc(hidden)]
#[macro_export]
macro_rules! fmi2_functions {
    ([$($callback:tt)+] {$($given:tt)*}) => { $($callback)+! { {$($given)*}
        co_simulation:
        fn fmi2GetTypesPlatform() -> fmi2String;
        fn fmi2GetVersion() -> fmi2String;
        fn fmi2SetDebugLogging(
            c: fmi2Component, logging_on: fmi2Boolean,
            n_categories: usize, categories: *const fmi2String
        ) -> fmi2Status;
        fn fmi2Instantiate(
            instance_name: fmi2String, fmu_type: fmi2Type, guid: fmi2String,
            resource_location: fmi2String, functions: *const fmi2CallbackFunctions,
            visible: fmi2Boolean, logging_on: fmi2Boolean
        ) -> fmi2Component;
        fn fmi2FreeInstance(c: fmi2Component) -> ();
        fn fmi2SetupExperiment(
            c: fmi2Component, tolerance_defined: fmi2Boolean, tolerance: fmi2Real,
            start_time: fmi2Real, stop_time_defined: fmi2Boolean, stop_time: fmi2Real
        ) -> fmi2Status;
        fn fmi2EnterInitializationMode(c: fmi2Component) -> fmi2Status;
        fn fmi2ExitInitializationMode(c: fmi2Component) -> fmi2Status;
        fn fmi2Terminate(c: fmi2Component) -> fmi2Status;
        fn fmi2Reset(c: fmi2Component) -> fmi2Status;
        fn fmi2GetReal(
            c: fmi2Component, vr: *const fmi2ValueReference, nvr: usize, value: *mut fmi2Real
        ) -> fmi2Status;
        fn fmi2GetInteger(
            c: fmi2Component, vr: *const fmi2ValueReference, nvr: usize, value: *mut fmi2Integer
        ) -> fmi2Status;
        fn fmi2GetBoolean(
            c: fmi2Component, vr: *const fmi2ValueReference, nvr: usize, value: *mut fmi2Boolean
        ) -> fmi2Status;
        fn fmi2GetString(
            c: fmi2Component, vr: *const fmi2ValueReference, nvr: usize, value: *mut fmi2String
        ) -> fmi2Status;
        fn fmi2SetReal(
            c: fmi2Component, vr: *const fmi2ValueReference, nvr: usize, value: *const fmi2Real
        ) -> fmi2Status;
        fn fmi2SetInteger(
            c: fmi2Component, vr: *const fmi2ValueReference, nvr: usize, value: *const fmi2Integer
        ) -> fmi2Status;
        fn fmi2SetBoolean(
            c: fmi2Component, vr: *const fmi2ValueReference, nvr: usize, value: *const fmi2Boolean
        ) -> fmi2Status;
        fn fmi2SetString(
            c: fmi2Component, vr: *const fmi2ValueReference, nvr: usize, value: *const fmi2String
        ) -> fmi2Status;
        fn fmi2GetFMUstate(c: fmi2Component, state: *mut fmi2FMUstate) -> fmi2Status;
        fn fmi2SetFMUstate(c: fmi2Component, state: fmi2FMUstate) -> fmi2Status;
        fn fmi2FreeFMUstate(c: fmi2Component, state: *mut fmi2FMUstate) -> fmi2Status;
        fn fmi2SerializedFMUstateSize(
            c: fmi2Component, state: fmi2FMUstate, size: *mut usize
        ) -> fmi2Status;
        fn fmi2SerializeFMUstate(
            c: fmi2Component, state: fmi2FMUstate, serialized: *mut fmi2Byte, size: usize
        ) -> fmi2Status;
        fn fmi2DeSerializeFMUstate(
            c: fmi2Component, serialized: *const fmi2Byte, size: usize, state: *mut fmi2FMUstate
        ) -> fmi2Status;
        fn fmi2GetDirectionalDerivative(
            c: fmi2Component, v_unknown: *const fmi2ValueReference, n_unknown: usize,
            v_known: *const fmi2ValueReference, n_known: usize,
            dv_known: *const fmi2Real, dv_unknown: *mut fmi2Real
        ) -> fmi2Status;
        fn fmi2SetRealInputDerivatives(
            c: fmi2Component, vr: *const fmi2ValueReference, nvr: usize,
            order: *const fmi2Integer, value: *const fmi2Real
        ) -> fmi2Status;
        fn fmi2GetRealOutputDerivatives(
            c: fmi2Component, vr: *const fmi2ValueReference, nvr: usize,
            order: *const fmi2Integer, value: *mut fmi2Real
        ) -> fmi2Status;
        fn fmi2DoStep(
            c: fmi2Component, current_communication_point: fmi2Real,
            communication_step_size: fmi2Real, no_set_state_prior_to_current_point: fmi2Boolean
        ) -> fmi2Status;
        fn fmi2CancelStep(c: fmi2Component) -> fmi2Status;
        fn fmi2GetStatus(
            c: fmi2Component, kind: fmi2StatusKind, value: *mut fmi2Status
        ) -> fmi2Status;
        fn fmi2GetRealStatus(
            c: fmi2Component, kind: fmi2StatusKind, value: *mut fmi2Real
        ) -> fmi2Status;
        fn fmi2GetIntegerStatus(
            c: fmi2Component, kind: fmi2StatusKind, value: *mut fmi2Integer
        ) -> fmi2Status;
        fn fmi2GetBooleanStatus(
            c: fmi2Component, kind: fmi2StatusKind, value: *mut fmi2Boolean
        ) -> fmi2Status;
        fn fmi2GetStringStatus(
            c: fmi2Component, kind: fmi2StatusKind, value: *mut fmi2String
        ) -> fmi2Status;
        model_exchange:
        fn fmi2EnterEventMode(c: fmi2Component) -> fmi2Status;
        fn fmi2NewDiscreteStates(c: fmi2Component, info: *mut fmi2EventInfo) -> fmi2Status;
        fn fmi2EnterContinuousTimeMode(c: fmi2Component) -> fmi2Status;
        fn fmi2CompletedIntegratorStep(
            c: fmi2Component, no_set_state_prior_to_current_point: fmi2Boolean,
            enter_event_mode: *mut fmi2Boolean, terminate_simulation: *mut fmi2Boolean
        ) -> fmi2Status;
        fn fmi2SetTime(c: fmi2Component, time: fmi2Real) -> fmi2Status;
        fn fmi2SetContinuousStates(
            c: fmi2Component, x: *const fmi2Real, nx: usize
        ) -> fmi2Status;
        fn fmi2GetDerivatives(
            c: fmi2Component, derivatives: *mut fmi2Real, nx: usize
        ) -> fmi2Status;
        fn fmi2GetEventIndicators(
            c: fmi2Component, indicators: *mut fmi2Real, ni: usize
        ) -> fmi2Status;
        fn fmi2GetContinuousStates(c: fmi2Component, x: *mut fmi2Real, nx: usize) -> fmi2Status;
        fn fmi2GetNominalsOfContinuousStates(
            c: fmi2Component, x_nominal: *mut fmi2Real, nx: usize
        ) -> fmi2Status;
    } };
}

macro_rules! declare {
    ({}
        co_simulation: $(fn $cs:ident($($ca:ident: $ct:ty),*) -> $cr:ty;)+
        model_exchange: $(fn $me:ident($($ma:ident: $mt:ty),*) -> $mr:ty;)+
    ) => {
        /// A function of the standard.
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        #[allow(non_camel_case_types, missing_docs)]
        pub enum Function { $($cs,)+ $($me,)+ }

        impl Function {
            /// All functions.
            pub const ALL: &'static [Self] = &[$(Self::$cs,)+ $(Self::$me,)+];

            /// The C name.
            pub const fn name(self) -> &'static str {
                match self {
                    $(Self::$cs => stringify!($cs),)+
                    $(Self::$me => stringify!($me),)+
                }
            }
        }

        /// Function pointer types, named as the functions.
        #[allow(non_camel_case_types)]
        pub mod pointers {
            use crate::types::*;

            $(
                #[doc = concat!("Type of `", stringify!($cs), "`.")]
                pub type $cs = unsafe extern "C" fn($($ca: $ct),*) -> $cr;
            )+
            $(
                #[doc = concat!("Type of `", stringify!($me), "`.")]
                pub type $me = unsafe extern "C" fn($($ma: $mt),*) -> $mr;
            )+
        }
    };
}

fmi2_functions!([declare] {});

/// Number of functions that FMI 2.0 defines.
pub const FUNCTION_COUNT: usize = Function::ALL.len();

const _: () = assert!(FUNCTION_COUNT == 44);
