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

use std::collections::BTreeSet;
use std::ffi::{CStr, c_char};
use std::time::{Duration, Instant};
use std::{fmt, ptr};

use steerguard_fmi2::types::*;
use steerguard_fmi2::{Function, Function as F};
use steerguard_model_description::{Causality, Kind, Variable};

use crate::{Functions, host};

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

/// Bytes of a run: SplitMix64 from its number, 200 to 2200 of them.
fn random_bytes(run: u64) -> Vec<u8> {
    let mut state = run.wrapping_mul(0xD134_2543_DE82_EF95);
    let mut next = || {
        state = state.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = state;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    };
    let words = 25 + next() % 250;
    (0..words).flat_map(|_| next().to_le_bytes()).collect()
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

/// The string of bytes, with zeros after its end.
struct Bytes<'a>(&'a [u8]);

impl Bytes<'_> {
    fn byte(&mut self) -> u8 {
        self.0.split_off_first().copied().unwrap_or(0)
    }

    fn below(&mut self, n: usize) -> usize {
        usize::from(self.byte()) % n
    }

    /// True once in `n` times.
    fn rarely(&mut self, n: usize) -> bool {
        self.below(n) == n - 1
    }

    fn choice<T: Copy>(&mut self, items: &[T]) -> T {
        items[self.below(items.len())]
    }

    /// From -1 to 1.
    fn unit(&mut self) -> f64 {
        (f64::from(self.byte()) - 127.5) / 127.5
    }

    fn real(&mut self) -> f64 {
        match self.below(4) {
            0 => self.choice(&[
                0.0,
                -0.0,
                1.0,
                -1.0,
                1e-3,
                1e3,
                1e9,
                -1e9,
                1e12,
                1e300,
                -1e300,
                5e-324,
                f64::MAX,
                f64::INFINITY,
                f64::NEG_INFINITY,
                f64::NAN,
            ]),
            1 => f64::from_bits(u64::from_le_bytes([0; 8].map(|_: u8| self.byte()))),
            2 => 15.0 + 15.0 * self.unit(),
            _ => self.unit(),
        }
    }

    fn integer(&mut self) -> i32 {
        match self.below(3) {
            0 => self.choice(&[0, 1, -1, 2, 3, i32::MAX, i32::MIN, 1_000_000, 1_000_001]),
            1 => self.below(8) as i32,
            _ => i32::from_le_bytes([0; 4].map(|_: u8| self.byte())),
        }
    }

    /// Where a step may begin or end.
    fn time(&mut self, now: f64, period: f64) -> f64 {
        match self.below(8) {
            0 => self.real(),
            1 => now + period * self.unit(),
            2 => now + 1e-9 * self.unit(),
            _ => now,
        }
    }
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

/// NULL in place of `pointer` once in a while.
fn or_null<T>(bytes: &mut Bytes<'_>, pointer: *const T) -> *const T {
    if bytes.rarely(12) { ptr::null() } else { pointer }
}

fn or_null_mut<T>(bytes: &mut Bytes<'_>, pointer: *mut T) -> *mut T {
    if bytes.rarely(12) { ptr::null_mut() } else { pointer }
}

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

    /// Value references, valid and not.
    fn references(&mut self) -> Vec<u32> {
        let count = self.bytes.below(6);
        (0..count)
            .map(|_| match self.bytes.below(16) {
                0 => self.fmu.variables.len() as u32,
                1 => u32::MAX,
                _ => self.bytes.below(self.fmu.variables.len()) as u32,
            })
            .collect()
    }

    /// Sets values of one type: all of them as wanted, or none.
    fn set(&mut self, instance: &Instance) -> fmi2Status {
        let c = instance.component;
        let vr = self.references();
        let (n, mut references) = (vr.len(), or_null(&mut self.bytes, vr.as_ptr()));
        let kind = self.bytes.below(4);
        if kind == 0 && self.bytes.rarely(2) {
            references = INPUTS.as_ptr();
            let values = [0.0; 4].map(|_: f64| self.bytes.real());
            return call!(self, fmi2SetReal(c, references, 4, values.as_ptr()));
        }
        match kind {
            0 => {
                let given: Vec<f64> = vr.iter().map(|_| self.bytes.real()).collect();
                let values = or_null(&mut self.bytes, given.as_ptr());
                let n = self.count(n, references, values);
                call!(self, fmi2SetReal(c, references, n, values))
            }
            1 => {
                let given: Vec<i32> = vr.iter().map(|_| self.bytes.integer()).collect();
                let values = or_null(&mut self.bytes, given.as_ptr());
                let n = self.count(n, references, values);
                call!(self, fmi2SetInteger(c, references, n, values))
            }
            2 => {
                let given: Vec<i32> = vr.iter().map(|_| self.bytes.integer()).collect();
                let values = or_null(&mut self.bytes, given.as_ptr());
                let n = self.count(n, references, values);
                call!(self, fmi2SetBoolean(c, references, n, values))
            }
            _ => {
                let given: Vec<*const c_char> =
                    vr.iter().map(|_| or_null(&mut self.bytes, c"text".as_ptr())).collect();
                let values = or_null(&mut self.bytes, given.as_ptr());
                let n = self.count(n, references, values);
                call!(self, fmi2SetString(c, references, n, values))
            }
        }
    }

    /// A wrong number of elements where the array is NULL anyway.
    fn count<A, B>(&mut self, n: usize, a: *const A, b: *const B) -> usize {
        if a.is_null() && b.is_null() { self.bytes.choice(&[n, 0, 1, usize::MAX]) } else { n }
    }

    fn set_one_parameter(&mut self, instance: &Instance) -> fmi2Status {
        let parameters: Vec<u32> = (0u32..)
            .zip(self.fmu.variables)
            .filter(|(_, variable)| variable.role.causality == Causality::Parameter)
            .map(|(vr, _)| vr)
            .collect();
        let vr = self.bytes.choice(&parameters);
        let (c, pointer) = (instance.component, &raw const vr);
        if matches!(self.fmu.variables[vr as usize].kind, Kind::Real(_)) {
            let value = self.bytes.real();
            call!(self, fmi2SetReal(c, pointer, 1, &raw const value))
        } else {
            let value = self.bytes.integer();
            call!(self, fmi2SetInteger(c, pointer, 1, &raw const value))
        }
    }

    fn get(&mut self, instance: &Instance) -> fmi2Status {
        let c = instance.component;
        let vr = self.references();
        let (n, references) = (vr.len(), or_null(&mut self.bytes, vr.as_ptr()));
        let (mut reals, mut integers, mut texts) = ([0.0; 6], [0; 6], [ptr::null(); 6]);
        match self.bytes.below(4) {
            0 => {
                let values = or_null_mut(&mut self.bytes, reals.as_mut_ptr());
                let n = self.count(n, references, values);
                call!(self, fmi2GetReal(c, references, n, values))
            }
            1 => {
                let values = or_null_mut(&mut self.bytes, integers.as_mut_ptr());
                let n = self.count(n, references, values);
                call!(self, fmi2GetInteger(c, references, n, values))
            }
            2 => {
                let values = or_null_mut(&mut self.bytes, integers.as_mut_ptr());
                let n = self.count(n, references, values);
                call!(self, fmi2GetBoolean(c, references, n, values))
            }
            _ => {
                let values = or_null_mut(&mut self.bytes, texts.as_mut_ptr());
                let n = self.count(n, references, values);
                call!(self, fmi2GetString(c, references, n, values))
            }
        }
    }

    /// Time that the FMU has reached, s.
    fn now(&mut self, instance: &Instance) -> f64 {
        let mut time = 0.0;
        call!(self, fmi2GetRealStatus(instance.component, fmi2LastSuccessfulTime, &raw mut time));
        assert!(time.is_finite(), "last successful time {time}");
        time
    }

    fn do_step(&mut self, instance: &Instance) -> fmi2Status {
        let now = self.now(instance);
        let period = self.fmu.sample_period_s;
        let point = self.bytes.time(now, period);
        let size = match self.bytes.below(6) {
            0 => self.bytes.choice(&[0.0, -period, f64::NAN, f64::INFINITY, 1e-12, 5e-324, 1e12]),
            1 => period * LONGEST_STEP * self.bytes.unit(),
            2 => period / 3.0,
            _ => period * 4.0 * self.bytes.unit().abs(),
        };
        let flag = self.bytes.integer();
        call!(self, fmi2DoStep(instance.component, point, size, flag))
    }

    /// Sets plausible inputs and steps over some samples.
    fn drive(&mut self, instance: &Instance) -> fmi2Status {
        let period = self.fmu.sample_period_s;
        let speed = 15.0 + 12.0 * self.bytes.unit();
        let (yaw_rate, angle) = (0.3 * self.bytes.unit(), 0.05 * self.bytes.unit());
        let inputs = [speed, yaw_rate, 100.0 * self.bytes.unit(), angle];
        call!(self, fmi2SetReal(instance.component, INPUTS.as_ptr(), 4, inputs.as_ptr()));
        let steps = self.bytes.below(8);
        let start = self.now(instance);
        let mut status = fmi2Status::fmi2OK;
        for k in 0..steps {
            let point = start + k as f64 * period;
            status = call!(self, fmi2DoStep(instance.component, point, period, fmi2True));
        }
        // The inputs were set, whatever became of the steps.
        status.min(fmi2Status::fmi2Warning)
    }

    fn save(&mut self, instance: &mut Instance) -> fmi2Status {
        let c = instance.component;
        let reused = instance.states.len() == MAX_STATES || self.bytes.rarely(4);
        let mut state =
            if reused { instance.states.pop() } else { None }.unwrap_or(ptr::null_mut());
        let pointer = or_null_mut(&mut self.bytes, &raw mut state);
        let status = call!(self, fmi2GetFMUstate(c, pointer));
        if !state.is_null() {
            instance.states.push(state);
        }
        status
    }

    fn restore(&mut self, instance: &Instance) -> fmi2Status {
        let state = instance.states.last().copied().unwrap_or(ptr::null_mut());
        let status = call!(self, fmi2SetFMUstate(instance.component, state));
        assert!(!state.is_null() || status == fmi2Status::fmi2Error, "NULL is no state");
        status
    }

    fn release_state(&mut self, instance: &mut Instance) -> fmi2Status {
        let c = instance.component;
        if self.bytes.rarely(8) {
            return call!(self, fmi2FreeFMUstate(c, ptr::null_mut()));
        }
        let mut state = instance.states.pop().unwrap_or(ptr::null_mut());
        call!(self, fmi2FreeFMUstate(c, &raw mut state))
    }

    fn serialise(&mut self, instance: &mut Instance) -> fmi2Status {
        let c = instance.component;
        let state = instance.states.last().copied().unwrap_or(ptr::null_mut());
        let mut size = 0;
        let status = call!(self, fmi2SerializedFMUstateSize(c, state, &raw mut size));
        if status != fmi2Status::fmi2OK {
            return status;
        }
        call!(self, fmi2SerializedFMUstateSize(c, state, ptr::null_mut()));
        let mut buffer = vec![0u8; size + 3];
        let room = match self.bytes.below(6) {
            0 => size - 1,
            1 => 0,
            2 => size + 3,
            _ => size,
        };
        let pointer = or_null_mut(&mut self.bytes, buffer.as_mut_ptr().cast::<c_char>());
        let status = call!(self, fmi2SerializeFMUstate(c, state, pointer, room));
        let possible = room >= size && !pointer.is_null();
        assert_eq!(status == fmi2Status::fmi2OK, possible, "{size} bytes into {room}");
        if possible {
            buffer.truncate(size);
            if instance.serialised.len() == MAX_STATES {
                instance.serialised.remove(0);
            }
            instance.serialised.push(buffer);
        }
        status
    }

    /// Deserialises a state, damaged or not, of this instance or of another.
    fn deserialise(&mut self, instance: &mut Instance) -> fmi2Status {
        let of_any = self.instances.iter().chain([&*instance]);
        let Some(mut bytes) = of_any.filter_map(|one| one.serialised.last()).next().cloned() else {
            return fmi2Status::fmi2OK;
        };
        let length = bytes.len();
        let damaged = match self.bytes.below(6) {
            0 => {
                let (high, low) = (self.bytes.byte(), self.bytes.byte());
                bytes[usize::from(u16::from_be_bytes([high, low])) % length] ^= 1 << (low % 8);
                true
            }
            1 => {
                bytes.truncate(self.bytes.below(256) * length / 256);
                true
            }
            2 => {
                bytes.extend([0; 5]);
                true
            }
            _ => false,
        };
        let c = instance.component;
        if instance.states.len() == MAX_STATES {
            let mut oldest = instance.states.remove(0);
            call!(self, fmi2FreeFMUstate(c, &raw mut oldest));
        }
        let mut state = ptr::null_mut();
        let pointer = or_null_mut(&mut self.bytes, &raw mut state);
        let from = bytes.as_ptr().cast::<c_char>();
        let status = call!(self, fmi2DeSerializeFMUstate(c, from, bytes.len(), pointer));
        assert!(!damaged || status == fmi2Status::fmi2Error, "a damaged state was taken");
        assert_eq!(state.is_null(), status == fmi2Status::fmi2Error);
        if !state.is_null() {
            instance.states.push(state);
        }
        status
    }

    /// A state with other contents and a checksum that fits: whatever is made of it, the process
    /// survives.
    fn forge(&mut self, instance: &Instance) -> fmi2Status {
        /// Before the body; in it, state and clock, which decide how many samples a step runs.
        const HEADER: usize = 56;
        const CHECKSUM: usize = 52;
        const CLOCK: usize = 34;
        let Some(mut bytes) = instance.serialised.last().cloned() else {
            return fmi2Status::fmi2OK;
        };
        for _ in 0..=self.bytes.below(4) {
            let (high, low) = (self.bytes.byte(), self.bytes.byte());
            let body = bytes.len() - HEADER - CLOCK;
            let at = HEADER + CLOCK + usize::from(u16::from_be_bytes([high, low])) % body;
            bytes[at] = self.bytes.byte();
        }
        let checksum = crc_32(&bytes[HEADER..]);
        bytes[CHECKSUM..HEADER].copy_from_slice(&checksum.to_le_bytes());
        let Some(other) = self.fresh() else { return fmi2Status::fmi2OK };
        let mut state = ptr::null_mut();
        let from = bytes.as_ptr().cast::<c_char>();
        let c = other.component;
        call!(self, fmi2DeSerializeFMUstate(c, from, bytes.len(), &raw mut state));
        if !state.is_null() {
            call!(self, fmi2SetFMUstate(c, state));
            self.drive(&other);
            call!(self, fmi2GetFMUstate(c, &raw mut state));
            call!(self, fmi2FreeFMUstate(c, &raw mut state));
        }
        self.free(other);
        fmi2Status::fmi2OK
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

    /// Saves, goes on, comes back and goes on again, here and in a new instance.
    fn replay(&mut self, instance: &Instance) {
        host::set_out_of_memory(false);
        let c = instance.component;
        let mut state = ptr::null_mut();
        assert_eq!(call!(self, fmi2GetFMUstate(c, &raw mut state)), fmi2Status::fmi2OK);
        let saved = self.bytes_of(instance, state);

        let course: [u8; 24] = [0; 24].map(|_: u8| self.bytes.byte());
        let first = self.course(instance, &course);
        assert_eq!(call!(self, fmi2SetFMUstate(c, state)), fmi2Status::fmi2OK);
        assert_eq!(self.course(instance, &course), first, "continued in the same instance");

        let Some(other) = self.fresh() else { return };
        let mut copy = ptr::null_mut();
        let from = saved.as_ptr().cast::<c_char>();
        let c_other = other.component;
        let read = call!(self, fmi2DeSerializeFMUstate(c_other, from, saved.len(), &raw mut copy));
        assert_eq!(read, fmi2Status::fmi2OK);
        assert_eq!(self.bytes_of(&other, copy), saved, "serialised again");
        assert_eq!(call!(self, fmi2SetFMUstate(c_other, copy)), fmi2Status::fmi2OK);
        assert_eq!(self.course(&other, &course), first, "continued in a new instance");

        for (component, mut state) in [(c_other, copy), (c, state)] {
            call!(self, fmi2FreeFMUstate(component, &raw mut state));
        }
        self.free(other);
        self.summary.restored += 1;
    }

    /// Some samples from here, with all that is to be seen after each.
    fn course(&mut self, instance: &Instance, course: &[u8]) -> Vec<Observation> {
        let mut observations = Vec::new();
        let rest = std::mem::replace(&mut self.bytes, Bytes(&[]));
        for inputs in course.chunks(6) {
            let mut bytes = Bytes(inputs);
            let period = self.fmu.sample_period_s;
            let (speed, yaw_rate) = (16.0 + 15.0 * bytes.unit(), 0.4 * bytes.unit());
            let inputs = [speed, yaw_rate, 100.0 * bytes.unit(), 0.1 * bytes.unit()];
            let size = period * 2.0 * bytes.unit().abs();
            let c = instance.component;
            let set = call!(self, fmi2SetReal(c, INPUTS.as_ptr(), 4, inputs.as_ptr()));
            let now = self.now(instance);
            let step = call!(self, fmi2DoStep(c, now, size, fmi2True));
            let mut observation = self.observe(instance);
            observation.extend([set.0 as u64, step.0 as u64]);
            observations.push(observation);
        }
        self.bytes = rest;
        observations
    }

    fn bytes_of(&mut self, instance: &Instance, state: fmi2FMUstate) -> Vec<u8> {
        let (c, mut size) = (instance.component, 0);
        call!(self, fmi2SerializedFMUstateSize(c, state, &raw mut size));
        let mut bytes = vec![0u8; size];
        let pointer = bytes.as_mut_ptr().cast::<c_char>();
        let status = call!(self, fmi2SerializeFMUstate(c, state, pointer, size));
        assert_eq!(status, fmi2Status::fmi2OK);
        bytes
    }

    fn set_up(&mut self, instance: &Instance) -> fmi2Status {
        let c = instance.component;
        let bytes = &mut self.bytes;
        let (start, stop) = (bytes.real(), bytes.real());
        let (tolerance, given) = (bytes.real(), bytes.choice(&[0, 0, 1]));
        call!(self, fmi2SetupExperiment(c, given, tolerance, start, given, stop))
    }

    /// The ordinary way from Instantiated to Step Mode.
    fn initialise(&mut self, instance: &Instance) -> fmi2Status {
        let c = instance.component;
        let start = self.bytes.choice(&[0.0, 0.0, -3.5, 1e6, 1e300]);
        call!(self, fmi2SetupExperiment(c, 0, 0.0, start, 0, 0.0));
        call!(self, fmi2EnterInitializationMode(c));
        call!(self, fmi2ExitInitializationMode(c))
    }

    fn debug_logging(&mut self, instance: &Instance) -> fmi2Status {
        let names = [c"logAll", c"logEvents", c"logStatusError", c"logStatusWarning", c"none"];
        let count = self.bytes.below(4);
        let given: Vec<_> = (0..count)
            .map(|_| {
                let name = self.bytes.choice(&names).as_ptr();
                or_null(&mut self.bytes, name)
            })
            .collect();
        let (pointer, on) = (or_null(&mut self.bytes, given.as_ptr()), self.bytes.integer());
        call!(self, fmi2SetDebugLogging(instance.component, on, count, pointer))
    }

    fn inquire(&mut self, instance: &Instance) -> fmi2Status {
        let (c, kind) = (instance.component, self.bytes.choice(&[0, 1, 2, 3, -1, 77]));
        let (mut status, mut real, mut integer, mut text) =
            (fmi2Status::fmi2OK, 0.0, 0, ptr::null());
        let null = self.bytes.rarely(12);
        let which = self.bytes.below(5);
        macro_rules! inquire {
            ($name:ident, $place:ident) => {{
                let place = if null { ptr::null_mut() } else { &raw mut $place };
                call!(self, $name(c, kind, place))
            }};
        }
        match which {
            0 => inquire!(fmi2GetStatus, status),
            1 => inquire!(fmi2GetRealStatus, real),
            2 => inquire!(fmi2GetIntegerStatus, integer),
            3 => inquire!(fmi2GetBooleanStatus, integer),
            _ => inquire!(fmi2GetStringStatus, text),
        }
    }

    fn derivatives(&mut self, instance: &Instance) -> fmi2Status {
        let c = instance.component;
        let vr = self.references();
        let (n, references) = (vr.len(), or_null(&mut self.bytes, vr.as_ptr()));
        let orders = [0; 6].map(|_: i32| self.bytes.below(5) as i32);
        let orders = or_null(&mut self.bytes, orders.as_ptr());
        let mut reals = [0.0; 6].map(|_: f64| self.bytes.real());
        match self.bytes.below(4) {
            0 => call!(
                self,
                fmi2GetRealOutputDerivatives(c, references, n, orders, reals.as_mut_ptr())
            ),
            1 => call!(
                self,
                fmi2GetDirectionalDerivative(
                    c,
                    references,
                    n,
                    references,
                    n,
                    reals.as_ptr(),
                    reals.as_mut_ptr()
                )
            ),
            _ => call!(self, fmi2SetRealInputDerivatives(c, references, n, orders, reals.as_ptr())),
        }
    }

    /// Functions for Model Exchange, which have no place here.
    fn model_exchange(&mut self, c: fmi2Component) -> fmi2Status {
        let mut values = [0.0; 4];
        let mut flags = [0; 2];
        let mut info = fmi2EventInfo {
            newDiscreteStatesNeeded: 0,
            terminateSimulation: 0,
            nominalsOfContinuousStatesChanged: 0,
            valuesOfContinuousStatesChanged: 0,
            nextEventTimeDefined: 0,
            nextEventTime: 0.0,
        };
        let n = self.bytes.below(5);
        let values = or_null_mut(&mut self.bytes, values.as_mut_ptr());
        let info = or_null_mut(&mut self.bytes, &raw mut info);
        let flag = or_null_mut(&mut self.bytes, flags.as_mut_ptr());
        let time = self.bytes.real();
        let status = match self.bytes.below(10) {
            0 => call!(self, fmi2EnterEventMode(c)),
            1 => call!(self, fmi2NewDiscreteStates(c, info)),
            2 => call!(self, fmi2EnterContinuousTimeMode(c)),
            3 => call!(self, fmi2CompletedIntegratorStep(c, 1, flag, flag)),
            4 => call!(self, fmi2SetTime(c, time)),
            5 => call!(self, fmi2SetContinuousStates(c, values, n)),
            6 => call!(self, fmi2GetDerivatives(c, values, n)),
            7 => call!(self, fmi2GetEventIndicators(c, values, n)),
            8 => call!(self, fmi2GetContinuousStates(c, values, n)),
            _ => call!(self, fmi2GetNominalsOfContinuousStates(c, values, n)),
        };
        assert_eq!(status, fmi2Status::fmi2Error, "a function of Model Exchange");
        status
    }

    /// The same functions on no instance, and those that need none.
    fn without_an_instance(&mut self) {
        let none = Instance {
            component: ptr::null_mut(),
            states: Vec::new(),
            serialised: vec![vec![0; 100]],
        };
        let mut state = ptr::null_mut();
        let status = match self.bytes.below(13) {
            0 => self.set(&none),
            1 => self.get(&none),
            2 => call!(self, fmi2DoStep(ptr::null_mut(), 0.0, 1.0, 1)),
            3 => call!(self, fmi2GetFMUstate(ptr::null_mut(), &raw mut state)),
            4 => self.restore(&none),
            5 => self.set_up(&none),
            6 => self.debug_logging(&none),
            7 => self.inquire(&none),
            8 => self.derivatives(&none),
            9 => self.model_exchange(ptr::null_mut()),
            10 => call!(self, fmi2Reset(ptr::null_mut())),
            11 => call!(self, fmi2FreeFMUstate(ptr::null_mut(), &raw mut state)),
            _ => call!(self, fmi2CancelStep(ptr::null_mut())),
        };
        assert_eq!(status, fmi2Status::fmi2Error, "a call on no instance");
        // SAFETY: NULL is no instance; the strings are constants of the FMU.
        unsafe {
            (self.fmu.functions.fmi2FreeInstance)(ptr::null_mut());
            let version = (self.fmu.functions.fmi2GetVersion)();
            let platform = (self.fmu.functions.fmi2GetTypesPlatform)();
            assert_eq!(CStr::from_ptr(version), c"2.0");
            assert_eq!(CStr::from_ptr(platform), c"default");
        }
        self.summary.calls += 3;
    }
}

/// CRC-32 as in zip.
fn crc_32(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(u32::MAX, |crc, &byte| {
        (0..8).fold(crc ^ u32::from(byte), |crc, _| (crc >> 1) ^ (0xEDB8_8320 * (crc & 1)))
    })
}
