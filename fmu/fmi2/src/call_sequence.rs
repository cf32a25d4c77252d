//! Which function may be called in which state: FMI 2.0.4, section 4.2.4, as data.

use steerguard_fmu_core::States;

use crate::Function;

/// State of an instance in the calling sequence, in the order of the standard's table.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum CallState {
    /// No instance.
    StartAndEnd,
    /// After `fmi2Instantiate` or `fmi2Reset`.
    Instantiated,
    /// Between `fmi2EnterInitializationMode` and `fmi2ExitInitializationMode`.
    InitializationMode,
    /// Ready for `fmi2DoStep`.
    StepComplete,
    /// During an asynchronous step: never reached here.
    StepInProgress,
    /// After `fmi2DoStep` returned fmi2Discard.
    StepFailed,
    /// After `fmi2CancelStep`: never reached here.
    StepCanceled,
    /// After `fmi2Terminate`.
    Terminated,
    /// After a step or an initialisation failed with fmi2Error.
    Error,
    /// After fmi2Fatal.
    Fatal,
}

impl CallState {
    /// All states, in the order of the table's columns.
    pub const ALL: [Self; 10] = [
        Self::StartAndEnd,
        Self::Instantiated,
        Self::InitializationMode,
        Self::StepComplete,
        Self::StepInProgress,
        Self::StepFailed,
        Self::StepCanceled,
        Self::Terminated,
        Self::Error,
        Self::Fatal,
    ];

    /// Name in messages.
    pub const fn name(self) -> &'static str {
        match self {
            Self::StartAndEnd => "start and end",
            Self::Instantiated => "instantiated",
            Self::InitializationMode => "Initialization Mode",
            Self::StepComplete => "stepComplete",
            Self::StepInProgress => "stepInProgress",
            Self::StepFailed => "stepFailed",
            Self::StepCanceled => "stepCanceled",
            Self::Terminated => "terminated",
            Self::Error => "error",
            Self::Fatal => "fatal",
        }
    }
}

/// The table, in the order of [`Function::ALL`]: `x` where the standard allows the call, `t` where
/// it does not but importers are known to make it and it does no harm.
#[rustfmt::skip]
const ROWS: [(Function, &str); crate::FUNCTION_COUNT] = {
    use Function::*;
    [
        //                                  start and end
        //                                  | instantiated
        //                                  | | Initialization Mode
        //                                  | | | stepComplete
        //                                  | | | | stepInProgress
        //                                  | | | | | stepFailed
        //                                  | | | | | | stepCanceled
        //                                  | | | | | | | terminated
        //                                  | | | | | | | | error
        //                                  | | | | | | | | | fatal
        (fmi2GetTypesPlatform,             "x x x x x x x x x ."),
        (fmi2GetVersion,                   "x x x x x x x x x ."),
        (fmi2SetDebugLogging,              ". x x x x x x x x ."),
        (fmi2Instantiate,                  "x . . . . . . . . ."),
        (fmi2FreeInstance,                 ". x x x . x x x x ."),
        (fmi2SetupExperiment,              ". x . . . . . . . ."),
        (fmi2EnterInitializationMode,      ". x . . . . . . . ."),
        (fmi2ExitInitializationMode,       ". . x . . . . . . ."),
        (fmi2Terminate,                    ". . . x . x . . . ."),
        (fmi2Reset,                        ". x x x . x x x x ."),
        (fmi2GetReal,                      ". t x x . x x x x ."),
        (fmi2GetInteger,                   ". t x x . x x x x ."),
        (fmi2GetBoolean,                   ". t x x . x x x x ."),
        (fmi2GetString,                    ". t x x . x x x x ."),
        (fmi2SetReal,                      ". x x x . . . . . ."),
        (fmi2SetInteger,                   ". x x x . . . . . ."),
        (fmi2SetBoolean,                   ". x x x . . . . . ."),
        (fmi2SetString,                    ". x x x . . . . . ."),
        (fmi2GetFMUstate,                  ". x x x . x x x x ."),
        (fmi2SetFMUstate,                  ". x x x . x x x x ."),
        (fmi2FreeFMUstate,                 ". x x x . x x x x ."),
        (fmi2SerializedFMUstateSize,       ". x x x . x x x x ."),
        (fmi2SerializeFMUstate,            ". x x x . x x x x ."),
        (fmi2DeSerializeFMUstate,          ". x x x . x x x x ."),
        (fmi2GetDirectionalDerivative,     ". . x x . x x x x ."),
        (fmi2SetRealInputDerivatives,      ". x x x . . . . . ."),
        (fmi2GetRealOutputDerivatives,     ". . . x . x x x x ."),
        (fmi2DoStep,                       ". . . x . . . . . ."),
        (fmi2CancelStep,                   ". . . . x . . . . ."),
        (fmi2GetStatus,                    ". . . x x x . x . ."),
        (fmi2GetRealStatus,                ". . . x x x . x . ."),
        (fmi2GetIntegerStatus,             ". . . x x x . x . ."),
        (fmi2GetBooleanStatus,             ". . . x x x . x . ."),
        (fmi2GetStringStatus,              ". . . x x x . x . ."),
        // Model Exchange alone: in no state of a co-simulation.
        (fmi2EnterEventMode,               ". . . . . . . . . ."),
        (fmi2NewDiscreteStates,            ". . . . . . . . . ."),
        (fmi2EnterContinuousTimeMode,      ". . . . . . . . . ."),
        (fmi2CompletedIntegratorStep,      ". . . . . . . . . ."),
        (fmi2SetTime,                      ". . . . . . . . . ."),
        (fmi2SetContinuousStates,          ". . . . . . . . . ."),
        (fmi2GetDerivatives,               ". . . . . . . . . ."),
        (fmi2GetEventIndicators,           ". . . . . . . . . ."),
        (fmi2GetContinuousStates,          ". . . . . . . . . ."),
        (fmi2GetNominalsOfContinuousStates,". . . . . . . . . ."),
    ]
};

const fn compiled(marks: &[u8]) -> [States; crate::FUNCTION_COUNT] {
    let mut table = [States::NONE; crate::FUNCTION_COUNT];
    let mut i = 0;
    while i < table.len() {
        assert!(ROWS[i].0 as usize == i);
        table[i] = States::from_row(ROWS[i].1, marks, CallState::ALL.len());
        i += 1;
    }
    table
}

static STANDARD: [States; crate::FUNCTION_COUNT] = compiled(b"x");
static ALLOWED: [States; crate::FUNCTION_COUNT] = compiled(b"xt");

impl Function {
    /// States in which the standard allows the call.
    pub fn standard_states(self) -> States {
        STANDARD[self as usize]
    }

    /// States in which the call is accepted: the standard's, and those tolerated.
    pub fn allowed_states(self) -> States {
        ALLOWED[self as usize]
    }
}
