//! Calls in any order with any arguments, read off a string of bytes.
//!
//! # What is asserted
//! - Statuses are fmi2OK to fmi2Error; the functions of Model Exchange and calls on no instance are
//!   refused.
//! - No variable but an input is ever NaN or infinite; truth values and enumerations are in range.
//! - A refused call, and one that does not set, step, reset or restore, changes no variable.
//! - A saved state restores bit for bit, in memory and serialised, in its own and in a new instance;
//!   a damaged one is refused.
//! - Memory that the FMU took from the importer is given back.
//!
//! # Conventions
//! - What C cannot check is never done: no dangling pointers, no arrays shorter than announced.
//! - At most [`MAX_INSTANCES`] instances live at a time, interleaved.

pub mod bytes;
mod others;
mod states;
mod steps;
mod values;

use std::collections::BTreeSet;
use std::ffi::CStr;
use std::time::{Duration, Instant};
use std::{fmt, ptr};

use steerguard_fmi2::types::*;
use steerguard_fmi2::{Function, Function as F};
use steerguard_model_description::{Causality, Kind, Variable};

use crate::{Functions, host};
use bytes::{Bytes, or_null, random_bytes};

/// Most instances at a time.
pub const MAX_INSTANCES: usize = 3;
/// Most saved states of an instance, and most serialised ones.
const MAX_STATES: usize = 3;
/// Value references of the inputs.
static INPUTS: [u32; 4] = [0, 1, 2, 3];
/// Longest communication step that is sure to be carried out, in sample periods.
const LONGEST_STEP: f64 = 300.0;

/// What the calls go to.
#[derive(Clone, Copy)]
pub struct Fmu<'a> {
    /// Its functions.
    pub functions: &'a Functions,
    /// GUID baked into it.
    pub guid: &'a CStr,
    /// Its variables, by value reference.
    pub variables: &'static [Variable],
    /// Distance of its samples, s.
    pub sample_period_s: f64,
}

/// What a run consisted of.
#[derive(Debug, Default)]
pub struct Summary {
    /// Calls of the FMU's functions, those aside that look at its variables after each.
    pub calls: u64,
    /// Instances made.
    pub instances: u64,
    /// Saved states that were continued and compared.
    pub restored: u64,
    /// Functions, by position in [`Function::ALL`], with the statuses they answered.
    pub answers: BTreeSet<(usize, i32)>,
}

impl Summary {
    /// Adds another run.
    pub fn add(&mut self, other: &Self) {
        self.calls += other.calls;
        self.instances += other.instances;
        self.restored += other.restored;
        self.answers.extend(&other.answers);
    }
}

impl fmt::Display for Summary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{} calls on {} instances, {} states restored, {} pairs of function and status",
            self.calls,
            self.instances,
            self.restored,
            self.answers.len()
        )
    }
}

/// Functions that are refused whatever the arguments and the state, or know no answer.
pub const NEVER_SUCCEED: [Function; 16] = [
    F::fmi2GetDirectionalDerivative,
    F::fmi2GetRealOutputDerivatives,
    F::fmi2CancelStep,
    F::fmi2GetStatus,
    F::fmi2GetIntegerStatus,
    F::fmi2GetStringStatus,
    F::fmi2EnterEventMode,
    F::fmi2NewDiscreteStates,
    F::fmi2EnterContinuousTimeMode,
    F::fmi2CompletedIntegratorStep,
    F::fmi2SetTime,
    F::fmi2SetContinuousStates,
    F::fmi2GetDerivatives,
    F::fmi2GetEventIndicators,
    F::fmi2GetContinuousStates,
    F::fmi2GetNominalsOfContinuousStates,
];

/// Runs numbered from `seed` on until `time` is over, each made from its number alone; calls
/// `progress` with the number and the sum after each. Returns how many, and the sum.
///
/// # Panics
/// If the FMU breaks a promise; the message names the run.
pub fn run_for(
    fmu: Fmu<'_>,
    seed: u64,
    time: Duration,
    mut progress: impl FnMut(u64, &Summary),
) -> (u64, Summary) {
    /// Names the run if it ends in a panic.
    struct Current(u64);
    impl Drop for Current {
        fn drop(&mut self) {
            if std::thread::panicking() {
                eprintln!("this was run {}", self.0);
            }
        }
    }
    let started = Instant::now();
    let (mut current, mut summary) = (Current(seed), Summary::default());
    while started.elapsed() < time {
        summary.add(&run(fmu, &random_bytes(current.0)));
        progress(current.0, &summary);
        current.0 += 1;
    }
    (current.0 - seed, summary)
}

/// Makes the calls that `bytes` stand for.
///
/// # Panics
/// If the FMU breaks a promise.
pub fn run(fmu: Fmu<'_>, bytes: &[u8]) -> Summary {
    let before = host::counts();
    let mut run =
        Run { fmu, bytes: Bytes(bytes), instances: Vec::new(), summary: Summary::default() };
    while !run.bytes.0.is_empty() {
        run.next();
    }
    host::set_out_of_memory(false);
    while let Some(instance) = run.instances.pop() {
        run.free(instance);
    }
    let after = host::counts();
    assert_eq!(
        after.allocations - before.allocations,
        after.frees - before.frees,
        "memory that the FMU took is given back"
    );
    run.summary
}

struct Instance {
    component: fmi2Component,
    states: Vec<fmi2FMUstate>,
    serialised: Vec<Vec<u8>>,
}

/// All variables, bit by bit.
type Observation = Vec<u64>;

struct Run<'a, 'b> {
    fmu: Fmu<'a>,
    bytes: Bytes<'b>,
    instances: Vec<Instance>,
    summary: Summary,
}

/// `(functions.NAME)(ARGUMENTS)`, its answer noted and judged.
macro_rules! call {
    ($run:expr, $name:ident($($argument:expr),*)) => {{
        // SAFETY: the arguments are what the standard allows in C, or NULL; see the conventions.
        let status = unsafe { ($run.fmu.functions.$name)($($argument),*) };
        $run.answered(F::$name, status)
    }};
}
use call;

impl Run<'_, '_> {
    /// The next call or group of calls.
    fn next(&mut self) {
        let action = self.bytes.byte();
        if self.instances.is_empty() || (action >= 250 && self.instances.len() < MAX_INSTANCES) {
            return self.instantiate();
        }
        let index = self.bytes.below(self.instances.len());
        let mut instance = self.instances.swap_remove(index);
        let before = self.observe(&instance);
        let (status, may_change) = match action % 25 {
            0 => (self.set(&instance), true),
            1 => (self.get(&instance), false),
            2 => (self.do_step(&instance), true),
            3..=5 => (self.drive(&instance), true),
            6 => (self.save(&mut instance), false),
            7 => (self.restore(&instance), true),
            8 => (self.release_state(&mut instance), false),
            9 => (self.serialise(&mut instance), false),
            10 => (self.deserialise(&mut instance), false),
            11 => (self.forge(&instance), false),
            12 => {
                self.replay(&instance);
                (fmi2Status::fmi2OK, true)
            }
            13 => (self.set_up(&instance), false),
            14 => (call!(self, fmi2EnterInitializationMode(instance.component)), false),
            15 => (call!(self, fmi2ExitInitializationMode(instance.component)), false),
            16..=17 => (self.initialise(&instance), false),
            18 => (self.debug_logging(&instance), false),
            19 => (self.inquire(&instance), false),
            20 => (self.derivatives(&instance), false),
            21 => (self.model_exchange(instance.component), false),
            22 => {
                self.without_an_instance();
                (fmi2Status::fmi2OK, false)
            }
            23 => match self.bytes.below(6) {
                0 => (call!(self, fmi2Terminate(instance.component)), false),
                1 => (call!(self, fmi2CancelStep(instance.component)), false),
                2..=3 => (call!(self, fmi2Reset(instance.component)), true),
                4 => return self.free(instance),
                _ => {
                    host::set_out_of_memory(self.bytes.rarely(2));
                    (fmi2Status::fmi2OK, false)
                }
            },
            _ => (self.set_one_parameter(&instance), true),
        };
        let after = self.observe(&instance);
        if !may_change || status >= fmi2Status::fmi2Discard {
            assert_eq!(before, after, "action {} answered {status:?}", action % 25);
        }
        self.instances.push(instance);
    }

    fn answered(&mut self, function: Function, status: fmi2Status) -> fmi2Status {
        self.summary.calls += 1;
        self.summary.answers.insert((function as usize, status.0));
        assert!((0..=3).contains(&status.0), "{} answered {status:?}", function.name());
        status
    }

    fn instantiate(&mut self) {
        let fmu = self.fmu;
        let full = host::callbacks();
        let callbacks = match self.bytes.below(6) {
            0 => fmi2CallbackFunctions { logger: None, ..full },
            1 => fmi2CallbackFunctions { allocateMemory: None, ..full },
            2 => fmi2CallbackFunctions { freeMemory: None, ..full },
            _ => full,
        };
        let bytes = &mut self.bytes;
        let name = bytes.choice(&[c"name", c"%s#r1#", c"\xC3\xA9", c"name", c""]);
        let guid = if bytes.rarely(12) { c"{other}" } else { fmu.guid };
        let (kind, logging) = (if bytes.rarely(12) { 0 } else { 1 }, bytes.integer());
        let (name, guid) = (or_null(bytes, name.as_ptr()), or_null(bytes, guid.as_ptr()));
        let callbacks = or_null(bytes, &raw const callbacks);
        // SAFETY: strings and callbacks live until the call returns, or are NULL.
        let component = unsafe {
            (fmu.functions.fmi2Instantiate)(name, kind, guid, ptr::null(), callbacks, 0, logging)
        };
        self.summary.calls += 1;
        if !component.is_null() {
            self.keep(component);
        }
    }

    fn keep(&mut self, component: fmi2Component) {
        self.summary.instances += 1;
        self.instances.push(Instance { component, states: Vec::new(), serialised: Vec::new() });
    }

    fn free(&mut self, mut instance: Instance) {
        for state in &mut instance.states {
            let status = call!(self, fmi2FreeFMUstate(instance.component, &raw mut *state));
            assert_eq!(status, fmi2Status::fmi2OK, "a state can always be freed");
            assert!(state.is_null(), "the pointer to a freed state becomes NULL");
        }
        // SAFETY: the instance is live and not used any more.
        unsafe { (self.fmu.functions.fmi2FreeInstance)(instance.component) };
        self.summary.calls += 1;
    }

    /// Looks at all variables.
    fn observe(&self, instance: &Instance) -> Observation {
        let (functions, c) = (self.fmu.functions, instance.component);
        let mut observation = Vec::with_capacity(self.fmu.variables.len());
        for (vr, variable) in (0u32..).zip(self.fmu.variables) {
            let vr = &raw const vr;
            let (mut real, mut integer, mut text) = (f64::NAN, i32::MIN, ptr::null());
            // SAFETY: one reference and room for one value; the string is read at once.
            let (status, bits) = unsafe {
                match variable.kind {
                    Kind::Real(_) => {
                        let status = (functions.fmi2GetReal)(c, vr, 1, &raw mut real);
                        let finite = real.is_finite();
                        assert!(
                            finite || variable.role.causality == Causality::Input,
                            "{} is {real}",
                            variable.name
                        );
                        (status, real.to_bits())
                    }
                    Kind::Integer { .. } | Kind::Enumeration(_) => {
                        let status = (functions.fmi2GetInteger)(c, vr, 1, &raw mut integer);
                        let value = steerguard_model_description::Value::Integer(integer);
                        assert!(variable.kind.admits(value), "{} is {integer}", variable.name);
                        (status, integer as u64)
                    }
                    Kind::Boolean => {
                        let status = (functions.fmi2GetBoolean)(c, vr, 1, &raw mut integer);
                        assert!([0, 1].contains(&integer), "{} is {integer}", variable.name);
                        (status, integer as u64)
                    }
                    Kind::String => {
                        let status = (functions.fmi2GetString)(c, vr, 1, &raw mut text);
                        assert!(!text.is_null(), "{} is NULL", variable.name);
                        let sum = CStr::from_ptr(text).to_bytes().iter().fold(0, |sum, &byte| {
                            u64::from(byte).wrapping_add(31u64.wrapping_mul(sum))
                        });
                        (status, sum)
                    }
                }
            };
            assert_eq!(status, fmi2Status::fmi2OK, "getting {}", variable.name);
            observation.push(bits);
        }
        observation
    }

    /// An instance beside those of the run.
    fn fresh(&mut self) -> Option<Instance> {
        host::set_out_of_memory(false);
        let callbacks = host::callbacks();
        // SAFETY: strings and callbacks live until the call returns.
        let component = unsafe {
            let instantiate = self.fmu.functions.fmi2Instantiate;
            let guid = self.fmu.guid.as_ptr();
            instantiate(c"fresh".as_ptr(), 1, guid, ptr::null(), &raw const callbacks, 0, 0)
        };
        assert!(!component.is_null(), "a sound call of fmi2Instantiate is answered");
        self.keep(component);
        self.instances.pop()
    }
}
