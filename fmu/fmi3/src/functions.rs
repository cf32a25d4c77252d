//! The 75 functions of FMI 3.0 with their signatures, written once.

/// Passes the list of all functions to the macro named in brackets, after the tokens in braces.
///
/// What this FMU does comes first, after `provided:`; then, after `absent` and the reason why, what it does not.
#[doc(hidden)]
#[macro_export]
macro_rules! fmi3_functions {
    ([$($callback:tt)+] {$($given:tt)*}) => { $($callback)+! { {$($given)*}
        provided:
        fn fmi3GetVersion() -> fmi3String;
        fn fmi3SetDebugLogging(
            instance: fmi3Instance, logging_on: fmi3Boolean, n_categories: usize,
            categories: *const fmi3String
        ) -> fmi3Status;
        fn fmi3InstantiateModelExchange(
            instance_name: fmi3String, instantiation_token: fmi3String, resource_path: fmi3String,
            visible: fmi3Boolean, logging_on: fmi3Boolean,
            instance_environment: fmi3InstanceEnvironment,
            log_message: Option<fmi3LogMessageCallback>
        ) -> fmi3Instance;
        fn fmi3InstantiateCoSimulation(
            instance_name: fmi3String, instantiation_token: fmi3String, resource_path: fmi3String,
            visible: fmi3Boolean, logging_on: fmi3Boolean, event_mode_used: fmi3Boolean,
            early_return_allowed: fmi3Boolean,
            required_intermediate_variables: *const fmi3ValueReference,
            n_required_intermediate_variables: usize,
            instance_environment: fmi3InstanceEnvironment,
            log_message: Option<fmi3LogMessageCallback>,
            intermediate_update: Option<fmi3IntermediateUpdateCallback>
        ) -> fmi3Instance;
        fn fmi3InstantiateScheduledExecution(
            instance_name: fmi3String, instantiation_token: fmi3String, resource_path: fmi3String,
            visible: fmi3Boolean, logging_on: fmi3Boolean,
            instance_environment: fmi3InstanceEnvironment,
            log_message: Option<fmi3LogMessageCallback>,
            clock_update: Option<fmi3ClockUpdateCallback>,
            lock_preemption: Option<fmi3LockPreemptionCallback>,
            unlock_preemption: Option<fmi3UnlockPreemptionCallback>
        ) -> fmi3Instance;
        fn fmi3FreeInstance(instance: fmi3Instance) -> ();
        fn fmi3EnterInitializationMode(
            instance: fmi3Instance, tolerance_defined: fmi3Boolean, tolerance: fmi3Float64,
            start_time: fmi3Float64, stop_time_defined: fmi3Boolean, stop_time: fmi3Float64
        ) -> fmi3Status;
        fn fmi3ExitInitializationMode(instance: fmi3Instance) -> fmi3Status;
        fn fmi3EnterEventMode(instance: fmi3Instance) -> fmi3Status;
        fn fmi3Terminate(instance: fmi3Instance) -> fmi3Status;
        fn fmi3Reset(instance: fmi3Instance) -> fmi3Status;
        fn fmi3GetFloat32(
            instance: fmi3Instance, value_references: *const fmi3ValueReference,
            n_value_references: usize, values: *mut fmi3Float32, n_values: usize
        ) -> fmi3Status;
        fn fmi3GetFloat64(
            instance: fmi3Instance, value_references: *const fmi3ValueReference,
            n_value_references: usize, values: *mut fmi3Float64, n_values: usize
        ) -> fmi3Status;
        fn fmi3GetInt8(
            instance: fmi3Instance, value_references: *const fmi3ValueReference,
            n_value_references: usize, values: *mut fmi3Int8, n_values: usize
        ) -> fmi3Status;
        fn fmi3GetUInt8(
            instance: fmi3Instance, value_references: *const fmi3ValueReference,
            n_value_references: usize, values: *mut fmi3UInt8, n_values: usize
        ) -> fmi3Status;
        fn fmi3GetInt16(
            instance: fmi3Instance, value_references: *const fmi3ValueReference,
            n_value_references: usize, values: *mut fmi3Int16, n_values: usize
        ) -> fmi3Status;
        fn fmi3GetUInt16(
            instance: fmi3Instance, value_references: *const fmi3ValueReference,
            n_value_references: usize, values: *mut fmi3UInt16, n_values: usize
        ) -> fmi3Status;
        fn fmi3GetInt32(
            instance: fmi3Instance, value_references: *const fmi3ValueReference,
            n_value_references: usize, values: *mut fmi3Int32, n_values: usize
        ) -> fmi3Status;
        fn fmi3GetUInt32(
            instance: fmi3Instance, value_references: *const fmi3ValueReference,
            n_value_references: usize, values: *mut fmi3UInt32, n_values: usize
        ) -> fmi3Status;
        fn fmi3GetInt64(
            instance: fmi3Instance, value_references: *const fmi3ValueReference,
            n_value_references: usize, values: *mut fmi3Int64, n_values: usize
        ) -> fmi3Status;
        fn fmi3GetUInt64(
            instance: fmi3Instance, value_references: *const fmi3ValueReference,
            n_value_references: usize, values: *mut fmi3UInt64, n_values: usize
        ) -> fmi3Status;
        fn fmi3GetBoolean(
            instance: fmi3Instance, value_references: *const fmi3ValueReference,
            n_value_references: usize, values: *mut fmi3Boolean, n_values: usize
        ) -> fmi3Status;
        fn fmi3GetString(
            instance: fmi3Instance, value_references: *const fmi3ValueReference,
            n_value_references: usize, values: *mut fmi3String, n_values: usize
        ) -> fmi3Status;
        fn fmi3GetBinary(
            instance: fmi3Instance, value_references: *const fmi3ValueReference,
            n_value_references: usize, value_sizes: *mut usize, values: *mut fmi3Binary,
            n_values: usize
        ) -> fmi3Status;
        fn fmi3GetClock(
            instance: fmi3Instance, value_references: *const fmi3ValueReference,
            n_value_references: usize, values: *mut fmi3Clock
        ) -> fmi3Status;
        fn fmi3SetFloat32(
            instance: fmi3Instance, value_references: *const fmi3ValueReference,
            n_value_references: usize, values: *const fmi3Float32, n_values: usize
        ) -> fmi3Status;
        fn fmi3SetFloat64(
            instance: fmi3Instance, value_references: *const fmi3ValueReference,
            n_value_references: usize, values: *const fmi3Float64, n_values: usize
        ) -> fmi3Status;
        fn fmi3SetInt8(
            instance: fmi3Instance, value_references: *const fmi3ValueReference,
            n_value_references: usize, values: *const fmi3Int8, n_values: usize
        ) -> fmi3Status;
        fn fmi3SetUInt8(
            instance: fmi3Instance, value_references: *const fmi3ValueReference,
            n_value_references: usize, values: *const fmi3UInt8, n_values: usize
        ) -> fmi3Status;
        fn fmi3SetInt16(
            instance: fmi3Instance, value_references: *const fmi3ValueReference,
            n_value_references: usize, values: *const fmi3Int16, n_values: usize
        ) -> fmi3Status;
        fn fmi3SetUInt16(
            instance: fmi3Instance, value_references: *const fmi3ValueReference,
            n_value_references: usize, values: *const fmi3UInt16, n_values: usize
        ) -> fmi3Status;
        fn fmi3SetInt32(
            instance: fmi3Instance, value_references: *const fmi3ValueReference,
            n_value_references: usize, values: *const fmi3Int32, n_values: usize
        ) -> fmi3Status;
        fn fmi3SetUInt32(
            instance: fmi3Instance, value_references: *const fmi3ValueReference,
            n_value_references: usize, values: *const fmi3UInt32, n_values: usize
        ) -> fmi3Status;
        fn fmi3SetInt64(
            instance: fmi3Instance, value_references: *const fmi3ValueReference,
            n_value_references: usize, values: *const fmi3Int64, n_values: usize
        ) -> fmi3Status;
        fn fmi3SetUInt64(
            instance: fmi3Instance, value_references: *const fmi3ValueReference,
            n_value_references: usize, values: *const fmi3UInt64, n_values: usize
        ) -> fmi3Status;
        fn fmi3SetBoolean(
            instance: fmi3Instance, value_references: *const fmi3ValueReference,
            n_value_references: usize, values: *const fmi3Boolean, n_values: usize
        ) -> fmi3Status;
        fn fmi3SetString(
            instance: fmi3Instance, value_references: *const fmi3ValueReference,
            n_value_references: usize, values: *const fmi3String, n_values: usize
        ) -> fmi3Status;
        fn fmi3SetBinary(
            instance: fmi3Instance, value_references: *const fmi3ValueReference,
            n_value_references: usize, value_sizes: *const usize, values: *const fmi3Binary,
            n_values: usize
        ) -> fmi3Status;
        fn fmi3GetFMUState(instance: fmi3Instance, state: *mut fmi3FMUState) -> fmi3Status;
        fn fmi3SetFMUState(instance: fmi3Instance, state: fmi3FMUState) -> fmi3Status;
        fn fmi3FreeFMUState(instance: fmi3Instance, state: *mut fmi3FMUState) -> fmi3Status;
        fn fmi3SerializedFMUStateSize(
            instance: fmi3Instance, state: fmi3FMUState, size: *mut usize
        ) -> fmi3Status;
        fn fmi3SerializeFMUState(
            instance: fmi3Instance, state: fmi3FMUState, serialized_state: *mut fmi3Byte,
            size: usize
        ) -> fmi3Status;
        fn fmi3DeserializeFMUState(
            instance: fmi3Instance, serialized_state: *const fmi3Byte, size: usize,
            state: *mut fmi3FMUState
        ) -> fmi3Status;
        fn fmi3UpdateDiscreteStates(
            instance: fmi3Instance, discrete_states_need_update: *mut fmi3Boolean,
            terminate_simulation: *mut fmi3Boolean,
            nominals_of_continuous_states_changed: *mut fmi3Boolean,
            values_of_continuous_states_changed: *mut fmi3Boolean,
            next_event_time_defined: *mut fmi3Boolean, next_event_time: *mut fmi3Float64
        ) -> fmi3Status;
        fn fmi3EnterStepMode(instance: fmi3Instance) -> fmi3Status;
        fn fmi3DoStep(
            instance: fmi3Instance, current_communication_point: fmi3Float64,
            communication_step_size: fmi3Float64,
            no_set_fmustate_prior_to_current_point: fmi3Boolean,
            event_handling_needed: *mut fmi3Boolean, terminate_simulation: *mut fmi3Boolean,
            early_return: *mut fmi3Boolean, last_successful_time: *mut fmi3Float64
        ) -> fmi3Status;
        absent "this FMU is not for Model Exchange":
        fn fmi3EnterContinuousTimeMode(instance: fmi3Instance) -> fmi3Status;
        fn fmi3CompletedIntegratorStep(
            instance: fmi3Instance, no_set_fmustate_prior_to_current_point: fmi3Boolean,
            enter_event_mode: *mut fmi3Boolean, terminate_simulation: *mut fmi3Boolean
        ) -> fmi3Status;
        fn fmi3SetTime(instance: fmi3Instance, time: fmi3Float64) -> fmi3Status;
        fn fmi3SetContinuousStates(
            instance: fmi3Instance, continuous_states: *const fmi3Float64,
            n_continuous_states: usize
        ) -> fmi3Status;
        fn fmi3GetContinuousStateDerivatives(
            instance: fmi3Instance, derivatives: *mut fmi3Float64, n_continuous_states: usize
        ) -> fmi3Status;
        fn fmi3GetEventIndicators(
            instance: fmi3Instance, event_indicators: *mut fmi3Float64, n_event_indicators: usize
        ) -> fmi3Status;
        fn fmi3GetContinuousStates(
            instance: fmi3Instance, continuous_states: *mut fmi3Float64, n_continuous_states: usize
        ) -> fmi3Status;
        fn fmi3GetNominalsOfContinuousStates(
            instance: fmi3Instance, nominals: *mut fmi3Float64, n_continuous_states: usize
        ) -> fmi3Status;
        fn fmi3GetNumberOfEventIndicators(
            instance: fmi3Instance, n_event_indicators: *mut usize
        ) -> fmi3Status;
        fn fmi3GetNumberOfContinuousStates(
            instance: fmi3Instance, n_continuous_states: *mut usize
        ) -> fmi3Status;
        absent "this FMU is not for Scheduled Execution":
        fn fmi3ActivateModelPartition(
            instance: fmi3Instance, clock_reference: fmi3ValueReference,
            activation_time: fmi3Float64
        ) -> fmi3Status;
        absent "dependencies of elements are not provided: see ModelStructure and the capability flags":
        fn fmi3GetNumberOfVariableDependencies(
            instance: fmi3Instance, value_reference: fmi3ValueReference, n_dependencies: *mut usize
        ) -> fmi3Status;
        fn fmi3GetVariableDependencies(
            instance: fmi3Instance, dependent: fmi3ValueReference,
            element_indices_of_dependent: *mut usize, independents: *mut fmi3ValueReference,
            element_indices_of_independents: *mut usize, dependency_kinds: *mut fmi3DependencyKind,
            n_dependencies: usize
        ) -> fmi3Status;
        absent "derivatives are not provided: see the capability flags":
        fn fmi3GetDirectionalDerivative(
            instance: fmi3Instance, unknowns: *const fmi3ValueReference, n_unknowns: usize,
            knowns: *const fmi3ValueReference, n_knowns: usize, seed: *const fmi3Float64,
            n_seed: usize, sensitivity: *mut fmi3Float64, n_sensitivity: usize
        ) -> fmi3Status;
        fn fmi3GetAdjointDerivative(
            instance: fmi3Instance, unknowns: *const fmi3ValueReference, n_unknowns: usize,
            knowns: *const fmi3ValueReference, n_knowns: usize, seed: *const fmi3Float64,
            n_seed: usize, sensitivity: *mut fmi3Float64, n_sensitivity: usize
        ) -> fmi3Status;
        fn fmi3GetOutputDerivatives(
            instance: fmi3Instance, value_references: *const fmi3ValueReference,
            n_value_references: usize, orders: *const fmi3Int32, values: *mut fmi3Float64,
            n_values: usize
        ) -> fmi3Status;
        absent "there are no structural parameters":
        fn fmi3EnterConfigurationMode(instance: fmi3Instance) -> fmi3Status;
        fn fmi3ExitConfigurationMode(instance: fmi3Instance) -> fmi3Status;
        absent "the only clock is a triggered output: it can be got, and has neither interval nor shift":
        fn fmi3SetClock(
            instance: fmi3Instance, value_references: *const fmi3ValueReference,
            n_value_references: usize, values: *const fmi3Clock
        ) -> fmi3Status;
        fn fmi3GetIntervalDecimal(
            instance: fmi3Instance, value_references: *const fmi3ValueReference,
            n_value_references: usize, intervals: *mut fmi3Float64,
            qualifiers: *mut fmi3IntervalQualifier
        ) -> fmi3Status;
        fn fmi3GetIntervalFraction(
            instance: fmi3Instance, value_references: *const fmi3ValueReference,
            n_value_references: usize, counters: *mut fmi3UInt64, resolutions: *mut fmi3UInt64,
            qualifiers: *mut fmi3IntervalQualifier
        ) -> fmi3Status;
        fn fmi3GetShiftDecimal(
            instance: fmi3Instance, value_references: *const fmi3ValueReference,
            n_value_references: usize, shifts: *mut fmi3Float64
        ) -> fmi3Status;
        fn fmi3GetShiftFraction(
            instance: fmi3Instance, value_references: *const fmi3ValueReference,
            n_value_references: usize, counters: *mut fmi3UInt64, resolutions: *mut fmi3UInt64
        ) -> fmi3Status;
        fn fmi3SetIntervalDecimal(
            instance: fmi3Instance, value_references: *const fmi3ValueReference,
            n_value_references: usize, intervals: *const fmi3Float64
        ) -> fmi3Status;
        fn fmi3SetIntervalFraction(
            instance: fmi3Instance, value_references: *const fmi3ValueReference,
            n_value_references: usize, counters: *const fmi3UInt64, resolutions: *const fmi3UInt64
        ) -> fmi3Status;
        fn fmi3SetShiftDecimal(
            instance: fmi3Instance, value_references: *const fmi3ValueReference,
            n_value_references: usize, shifts: *const fmi3Float64
        ) -> fmi3Status;
        fn fmi3SetShiftFraction(
            instance: fmi3Instance, value_references: *const fmi3ValueReference,
            n_value_references: usize, counters: *const fmi3UInt64, resolutions: *const fmi3UInt64
        ) -> fmi3Status;
        absent "discrete states are not evaluated apart: see the capability flags":
        fn fmi3EvaluateDiscreteStates(instance: fmi3Instance) -> fmi3Status;
    } };
}

macro_rules! declare {
    ({}
        provided: $(fn $p:ident($($pa:ident: $pt:ty),*) -> $pr:ty;)+
        $(absent $reason:literal: $(fn $a:ident($($aa:ident: $at:ty),*) -> $ar:ty;)+)+
    ) => {
        /// A function of the standard.
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        #[allow(non_camel_case_types, missing_docs)]
        pub enum Function { $($p,)+ $($($a,)+)+ }

        impl Function {
            /// All functions, those that are provided first.
            pub const ALL: &'static [Self] = &[$(Self::$p,)+ $($(Self::$a,)+)+];

            /// The C name.
            pub const fn name(self) -> &'static str {
                match self {
                    $(Self::$p => stringify!($p),)+
                    $($(Self::$a => stringify!($a),)+)+
                }
            }
        }

        const PROVIDED: &[Function] = &[$(Function::$p,)+];

        /// Function pointer types, named as the functions.
        #[allow(non_camel_case_types)]
        pub mod pointers {
            use crate::types::*;

            $(
                #[doc = concat!("Type of `", stringify!($p), "`.")]
                pub type $p = unsafe extern "C" fn($($pa: $pt),*) -> $pr;
            )+
            $($(
                #[doc = concat!("Type of `", stringify!($a), "`.")]
                pub type $a = unsafe extern "C" fn($($aa: $at),*) -> $ar;
            )+)+
        }
    };
}

fmi3_functions!([declare] {});

/// Number of functions that FMI 3.0 defines.
pub const FUNCTION_COUNT: usize = Function::ALL.len();

/// Number of those that do something here.
pub const PROVIDED_COUNT: usize = PROVIDED.len();

const _: () = assert!(FUNCTION_COUNT == 75);
