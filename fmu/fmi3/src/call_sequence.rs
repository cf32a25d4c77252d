//! Which function may be called in which state: the state machines of FMI 3.0.2, sections 2.3 and 4.2, as data.

use steerguard_fmu_core::States;

use crate::Function;

/// State of an instance in the calling sequence.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum CallState {
    /// No instance.
    StartAndEnd,
    /// After `fmi3InstantiateCoSimulation` or `fmi3Reset`.
    Instantiated,
    /// Between `fmi3EnterInitializationMode` and `fmi3ExitInitializationMode`.
    InitializationMode,
    /// Where events are handled.
    EventMode,
    /// Ready for `fmi3DoStep`.
    StepMode,
    /// After `fmi3Terminate`, or where a step or an initialisation failed.
    Terminated,
    /// After fmi3Fatal.
    Fatal,
}

impl CallState {
    /// All states, in the order of the table's columns.
    pub const ALL: [Self; 7] = [
        Self::StartAndEnd,
        Self::Instantiated,
        Self::InitializationMode,
        Self::EventMode,
        Self::StepMode,
        Self::Terminated,
        Self::Fatal,
    ];

    /// Name in messages.
    pub const fn name(self) -> &'static str {
        match self {
            Self::StartAndEnd => "start and end",
            Self::Instantiated => "Instantiated",
            Self::InitializationMode => "Initialization Mode",
            Self::EventMode => "Event Mode",
            Self::StepMode => "Step Mode",
            Self::Terminated => "Terminated",
            Self::Fatal => "Fatal",
        }
    }
}

/// The table, in the order of [`Function::ALL`], of the functions that are provided: `x` where the standard
/// allows the call, `t` where it does not but it does no harm.
#[rustfmt::skip]
const ROWS: [(Function, &str); crate::PROVIDED_COUNT] = {
    use Function::*;
    [
        //                                      start and end
        //                                      | Instantiated
        //                                      | | Initialization Mode
        //                                      | | | Event Mode
        //                                      | | | | Step Mode
        //                                      | | | | | Terminated
        //                                      | | | | | | Fatal
        (fmi3GetVersion,                     "x x x x x x ."),
        (fmi3SetDebugLogging,                ". x x x x x ."),
        (fmi3InstantiateModelExchange,       "x . . . . . ."),
        (fmi3InstantiateCoSimulation,        "x . . . . . ."),
        (fmi3InstantiateScheduledExecution,  "x . . . . . ."),
        (fmi3FreeInstance,                   ". x x x x x ."),
        (fmi3EnterInitializationMode,        ". x . . . . ."),
        (fmi3ExitInitializationMode,         ". . x . . . ."),
        (fmi3EnterEventMode,                 ". . . . x . ."),
        (fmi3Terminate,                      ". . . x x . ."),
        (fmi3Reset,                          ". x x x x x ."),
        (fmi3GetFloat32,                     ". x x x x x ."),
        (fmi3GetFloat64,                     ". x x x x x ."),
        (fmi3GetInt8,                        ". x x x x x ."),
        (fmi3GetUInt8,                       ". x x x x x ."),
        (fmi3GetInt16,                       ". x x x x x ."),
        (fmi3GetUInt16,                      ". x x x x x ."),
        (fmi3GetInt32,                       ". x x x x x ."),
        (fmi3GetUInt32,                      ". x x x x x ."),
        (fmi3GetInt64,                       ". x x x x x ."),
        (fmi3GetUInt64,                      ". x x x x x ."),
        (fmi3GetBoolean,                     ". x x x x x ."),
        (fmi3GetString,                      ". x x x x x ."),
        (fmi3GetBinary,                      ". x x x x x ."),
        (fmi3GetClock,                       ". . t x t t ."),
        (fmi3SetFloat32,                     ". x x x x . ."),
        (fmi3SetFloat64,                     ". x x x x . ."),
        (fmi3SetInt8,                        ". x x x x . ."),
        (fmi3SetUInt8,                       ". x x x x . ."),
        (fmi3SetInt16,                       ". x x x x . ."),
        (fmi3SetUInt16,                      ". x x x x . ."),
        (fmi3SetInt32,                       ". x x x x . ."),
        (fmi3SetUInt32,                      ". x x x x . ."),
        (fmi3SetInt64,                       ". x x x x . ."),
        (fmi3SetUInt64,                      ". x x x x . ."),
        (fmi3SetBoolean,                     ". x x x x . ."),
        (fmi3SetString,                      ". x x x x . ."),
        (fmi3SetBinary,                      ". x x x x . ."),
        (fmi3GetFMUState,                    ". x x x x x ."),
        (fmi3SetFMUState,                    ". x x x x x ."),
        (fmi3FreeFMUState,                   ". x x x x x ."),
        (fmi3SerializedFMUStateSize,         ". x x x x x ."),
        (fmi3SerializeFMUState,              ". x x x x x ."),
        (fmi3DeserializeFMUState,            ". x x x x x ."),
        (fmi3UpdateDiscreteStates,           ". . . x . . ."),
        (fmi3EnterStepMode,                  ". . . x . . ."),
        (fmi3DoStep,                         ". . . . x . ."),
    ]
};

const fn compiled(marks: &[u8]) -> [States; crate::PROVIDED_COUNT] {
    let mut table = [States::NONE; crate::PROVIDED_COUNT];
    let mut i = 0;
    while i < table.len() {
        assert!(ROWS[i].0 as usize == i);
        table[i] = States::from_row(ROWS[i].1, marks, CallState::ALL.len());
        i += 1;
    }
    table
}

static STANDARD: [States; crate::PROVIDED_COUNT] = compiled(b"x");
static ALLOWED: [States; crate::PROVIDED_COUNT] = compiled(b"xt");

impl Function {
    /// States in which the standard allows the call; none of a function that is not provided.
    pub fn standard_states(self) -> States {
        STANDARD.get(self as usize).copied().unwrap_or(States::NONE)
    }

    /// States in which the call is accepted: the standard's, and those tolerated.
    pub fn allowed_states(self) -> States {
        ALLOWED.get(self as usize).copied().unwrap_or(States::NONE)
    }
}
