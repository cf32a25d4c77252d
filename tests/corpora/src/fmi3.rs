//! Calls of FMI 3.0 in any order with any arguments on the detector FMU, linked into this program.
//!
//! # What is asserted
//! - Statuses are fmi3OK to fmi3Error; messages are UTF-8 without format characters.
//! - No variable but an input is ever NaN or infinite.
//! - A refused call, and one that does not set, step, reset or restore, changes no variable.
//! - A saved state restores bit for bit, in its own and in a new instance; a damaged one is refused.
//!
//! # Conventions
//! Those of `steerguard_conformance_tests::random_calls`.

use std::ffi::{CStr, c_char, c_void};
use std::ptr;

use steerguard_conformance_tests::random_calls::bytes::{Bytes, or_null, or_null_mut};
use steerguard_fmi3::types::*;
use steerguard_fmu::DetectorModel;
use steerguard_model_description::detector::DetectorVariable;
use steerguard_model_description::structure::{Entry, entry, references_beyond_the_table};
use steerguard_model_description::{Causality, Kind, VariableSet};

use crate::unsolved::{BLOCK, GUID};

steerguard_fmi3::export_fmi3!(DetectorModel, block = &BLOCK);

/// Most instances at a time, and most saved states of each.
const MOST: usize = 3;
const PERIOD_S: f64 = 0.01;
/// Value references of the inputs.
static INPUTS: [u32; 4] = [0, 1, 2, 3];

unsafe extern "C" fn log(
    _: *mut c_void,
    status: fmi3Status,
    category: fmi3String,
    text: fmi3String,
) {
    assert!((0..=4).contains(&status.0), "status {status:?} of a message");
    for text in [category, text] {
        // SAFETY: the standard has both be NUL-terminated and valid during the call.
        let text = unsafe { CStr::from_ptr(text) }.to_str().expect("messages are UTF-8");
        assert!(!text.is_empty() && !text.contains(['%', '#']), "message {text:?}");
    }
}

struct Instance {
    c: fmi3Instance,
    time_s: f64,
    states: Vec<fmi3FMUState>,
    serialised: Option<Vec<u8>>,
}

/// All variables, bit by bit.
type Observation = Vec<u64>;

struct Run<'a> {
    bytes: Bytes<'a>,
    instances: Vec<Instance>,
}

/// `fmi3::NAME(ARGUMENTS)`, its answer judged.
macro_rules! call {
    ($name:ident($($argument:expr),* $(,)?)) => {{
        // SAFETY: the arguments are what the standard allows in C, or NULL; see the conventions.
        let status = unsafe { fmi3::$name($($argument),*) };
        assert!((0..=3).contains(&status.0), "{} answered {status:?}", stringify!($name));
        status
    }};
}

pub fn run(bytes: &[u8]) {
    let mut run = Run { bytes: Bytes(bytes), instances: Vec::new() };
    while !run.bytes.0.is_empty() {
        run.next();
    }
    while let Some(instance) = run.instances.pop() {
        free(instance);
    }
}

fn free(mut instance: Instance) {
    for state in &mut instance.states {
        assert_eq!(call!(fmi3FreeFMUState(instance.c, &raw mut *state)), fmi3Status::fmi3OK);
        assert!(state.is_null(), "the pointer to a freed state becomes NULL");
    }
    // SAFETY: the instance is live and not used any more.
    unsafe { fmi3::fmi3FreeInstance(instance.c) };
}

fn instantiate(name: *const c_char, token: *const c_char, flags: [u8; 3]) -> fmi3Instance {
    let [logging, events, early] = flags;
    // SAFETY: strings live until the call returns, or are NULL.
    unsafe {
        fmi3::fmi3InstantiateCoSimulation(
            name,
            token,
            ptr::null(),
            fmi3False,
            logging,
            events,
            early,
            ptr::null(),
            0,
            ptr::null_mut(),
            Some(log),
            None,
        )
    }
}

/// Looks at all variables.
fn observe(c: fmi3Instance) -> Observation {
    let mut observation = Vec::new();
    for vr in 0..DetectorVariable::ALL.len() as u32 {
        // An element of an array that is not its first has no reference.
        let Some(Entry::Elements(elements)) = entry::<DetectorVariable>(vr) else { continue };
        let (variable, n) = (&DetectorVariable::TABLE[vr as usize], elements.len());
        let vr = &raw const vr;
        let status = match variable.kind {
            Kind::Real(_) => {
                let mut values = vec![f64::NAN; n];
                let status = call!(fmi3GetFloat64(c, vr, 1, values.as_mut_ptr(), n));
                let input = variable.role.causality == Causality::Input;
                assert!(
                    input || values.iter().all(|value| value.is_finite()),
                    "{} is {values:?}",
                    variable.name
                );
                observation.extend(values.iter().map(|value| value.to_bits()));
                status
            }
            Kind::Integer { .. } => {
                let mut values = vec![0; n];
                let status = call!(fmi3GetInt32(c, vr, 1, values.as_mut_ptr(), n));
                observation.extend(values.iter().map(|&value| value as u64));
                status
            }
            Kind::Enumeration(_) => {
                let mut values = vec![0; n];
                let status = call!(fmi3GetInt64(c, vr, 1, values.as_mut_ptr(), n));
                assert!(values.iter().all(|&value| value > 0), "{} is {values:?}", variable.name);
                observation.extend(values.iter().map(|&value| value as u64));
                status
            }
            Kind::Boolean => {
                let mut values = vec![2; n];
                let status = call!(fmi3GetBoolean(c, vr, 1, values.as_mut_ptr(), n));
                assert!(values.iter().all(|&value| value < 2), "{} is {values:?}", variable.name);
                observation.extend(values.iter().map(|&value| u64::from(value)));
                status
            }
            Kind::String => {
                let mut text = ptr::null();
                let status = call!(fmi3GetString(c, vr, 1, &raw mut text, 1));
                assert!(!text.is_null(), "{} is NULL", variable.name);
                status
            }
        };
        assert_eq!(status, fmi3Status::fmi3OK, "getting {}", variable.name);
    }
    observation
}

/// A step, and the time that it says was reached.
fn step(c: fmi3Instance, time_s: f64, size_s: f64) -> (fmi3Status, f64) {
    let (mut event, mut end, mut early, mut reached) = (2, 2, 2, f64::NAN);
    let out = (&raw mut event, &raw mut end, &raw mut early, &raw mut reached);
    let status = call!(fmi3DoStep(c, time_s, size_s, fmi3True, out.0, out.1, out.2, out.3));
    if status <= fmi3Status::fmi3Warning {
        assert!(event < 2 && end == 0 && early < 2 && reached.is_finite());
    }
    (status, reached)
}

fn update(c: fmi3Instance) -> fmi3Status {
    let (mut flags, mut time_s) = ([2_u8; 5], 0.0);
    let [a, b, c_, d, e] = flags.each_mut().map(|flag| &raw mut *flag);
    call!(fmi3UpdateDiscreteStates(c, a, b, c_, d, e, &raw mut time_s))
}

impl Run<'_> {
    /// The next call or group of calls.
    fn next(&mut self) {
        let action = self.bytes.byte();
        if self.instances.is_empty() || (action >= 250 && self.instances.len() < MOST) {
            return self.instantiate();
        }
        let index = self.bytes.below(self.instances.len());
        let mut instance = self.instances.swap_remove(index);
        let c = instance.c;
        let before = observe(c);
        let (status, may_change) = match action % 22 {
            0 | 1 => (self.set(c), true),
            2 => (self.get(c), false),
            3 => (self.do_step(&mut instance), true),
            4..=6 => (self.drive(&mut instance), true),
            7 => (self.save(&mut instance), false),
            8 => (self.restore(&mut instance), true),
            9 => (self.deserialise(&mut instance), false),
            10 => {
                let mut state = instance.states.pop().unwrap_or(ptr::null_mut());
                (call!(fmi3FreeFMUState(c, &raw mut state)), false)
            }
            11 => {
                self.replay(&instance);
                (fmi3Status::fmi3OK, true)
            }
            12 => (self.enter_initialisation(&mut instance), false),
            13 => (call!(fmi3ExitInitializationMode(c)), false),
            14 => (self.initialise(&mut instance), false),
            15 => (call!(fmi3EnterEventMode(c)), false),
            16 => (call!(fmi3EnterStepMode(c)), false),
            17 => (update(c), false),
            18 => (self.debug_logging(c), false),
            19 => (self.absent(c), false),
            20 => {
                self.without_an_instance();
                (fmi3Status::fmi3OK, false)
            }
            _ => match self.bytes.below(6) {
                0 => (call!(fmi3Terminate(c)), false),
                1 | 2 => (call!(fmi3Reset(c)), true),
                3 => return free(instance),
                _ => (self.clock(c), false),
            },
        };
        let after = observe(c);
        if !may_change || status >= fmi3Status::fmi3Discard {
            assert_eq!(before, after, "action {} answered {status:?}", action % 22);
        }
        self.instances.push(instance);
    }

    fn instantiate(&mut self) {
        let bytes = &mut self.bytes;
        let name = bytes.choice(&[c"name", c"%s#r1#", c"\xC3\xA9", c"name", c""]);
        let token = if bytes.rarely(12) { c"{other}" } else { GUID };
        let (name, token) = (or_null(bytes, name.as_ptr()), or_null(bytes, token.as_ptr()));
        let flags = [0; 3].map(|_: u8| bytes.choice(&[0, 1, 1, 255]));
        let c = instantiate(name, token, flags);
        if !c.is_null() {
            self.instances.push(Instance { c, time_s: 0.0, states: Vec::new(), serialised: None });
        }
    }

    /// Value references, valid and not.
    fn references(&mut self) -> Vec<u32> {
        let count = self.bytes.below(6);
        let [clock, ..] = references_beyond_the_table::<DetectorVariable>();
        (0..count)
            .map(|_| match self.bytes.below(16) {
                0 => clock + self.bytes.below(5) as u32,
                1 => u32::MAX,
                _ => self.bytes.below(DetectorVariable::ALL.len()) as u32,
            })
            .collect()
    }

    /// Sets values of one type: all of them as wanted, or none.
    fn set(&mut self, c: fmi3Instance) -> fmi3Status {
        let given = self.references();
        let (n, mut vr) = (given.len(), or_null(&mut self.bytes, given.as_ptr()));
        if vr.is_null() && self.bytes.rarely(2) {
            vr = INPUTS.as_ptr();
            let values = [0.0; 4].map(|_: f64| self.bytes.real());
            return call!(fmi3SetFloat64(c, vr, 4, values.as_ptr(), 4));
        }
        // There is room for eight; more or fewer than the variables have elements may be announced.
        let m = if self.bytes.rarely(4) { self.bytes.below(9) } else { n };
        match self.bytes.below(7) {
            0..=2 => {
                let values = [0.0; 8].map(|_: f64| self.bytes.real());
                call!(fmi3SetFloat64(c, vr, n, or_null(&mut self.bytes, values.as_ptr()), m))
            }
            3 => {
                let values = [0; 8].map(|_: i32| self.bytes.integer());
                call!(fmi3SetInt32(c, vr, n, or_null(&mut self.bytes, values.as_ptr()), m))
            }
            4 => {
                let values = [0; 8].map(|_: i64| i64::from(self.bytes.integer()));
                call!(fmi3SetInt64(c, vr, n, or_null(&mut self.bytes, values.as_ptr()), m))
            }
            5 => {
                let values = [0; 8].map(|_: u8| self.bytes.byte() % 3);
                call!(fmi3SetBoolean(c, vr, n, or_null(&mut self.bytes, values.as_ptr()), m))
            }
            _ => {
                let values = [c"text".as_ptr(); 8];
                call!(fmi3SetString(c, vr, n, or_null(&mut self.bytes, values.as_ptr()), m))
            }
        }
    }

    fn get(&mut self, c: fmi3Instance) -> fmi3Status {
        let given = self.references();
        let (n, vr) = (given.len(), or_null(&mut self.bytes, given.as_ptr()));
        // Room for six arrays.
        let (mut reals, mut integers, mut longs) = ([0.0; 64], [0; 64], [0; 64]);
        let (mut truths, mut texts, mut halves) = ([0; 64], [ptr::null(); 64], [0; 64]);
        let m = self.bytes.below(65);
        let bytes = &mut self.bytes;
        match bytes.below(6) {
            0 => call!(fmi3GetFloat64(c, vr, n, or_null_mut(bytes, reals.as_mut_ptr()), m)),
            1 => call!(fmi3GetInt32(c, vr, n, or_null_mut(bytes, integers.as_mut_ptr()), m)),
            2 => call!(fmi3GetInt64(c, vr, n, or_null_mut(bytes, longs.as_mut_ptr()), m)),
            3 => call!(fmi3GetBoolean(c, vr, n, or_null_mut(bytes, truths.as_mut_ptr()), m)),
            4 => call!(fmi3GetString(c, vr, n, or_null_mut(bytes, texts.as_mut_ptr()), m)),
            _ => call!(fmi3GetUInt16(c, vr, n, or_null_mut(bytes, halves.as_mut_ptr()), m)),
        }
    }

    fn clock(&mut self, c: fmi3Instance) -> fmi3Status {
        let given = self.references();
        let mut ticks = [2; 8];
        let (n, vr) = (given.len(), or_null(&mut self.bytes, given.as_ptr()));
        call!(fmi3GetClock(c, vr, n, or_null_mut(&mut self.bytes, ticks.as_mut_ptr())))
    }

    fn enter_initialisation(&mut self, instance: &mut Instance) -> fmi3Status {
        let [tolerance, start, stop] = [0.0; 3].map(|_: f64| self.bytes.real());
        let [a, b] = [0; 2].map(|_: u8| self.bytes.choice(&[0, 0, 1]));
        let status = call!(fmi3EnterInitializationMode(instance.c, a, tolerance, start, b, stop));
        if status == fmi3Status::fmi3OK {
            instance.time_s = start;
        }
        status
    }

    /// The ordinary way from Instantiated to Step Mode.
    fn initialise(&mut self, instance: &mut Instance) -> fmi3Status {
        let start = self.bytes.choice(&[0.0, 0.0, -3.5, 1e6, 1e300]);
        let entered = call!(fmi3EnterInitializationMode(instance.c, 0, 0.0, start, 0, 0.0));
        if entered == fmi3Status::fmi3OK {
            instance.time_s = start;
        }
        let status = call!(fmi3ExitInitializationMode(instance.c));
        update(instance.c);
        call!(fmi3EnterStepMode(instance.c));
        status
    }

    fn do_step(&mut self, instance: &mut Instance) -> fmi3Status {
        let point = self.bytes.time(instance.time_s, PERIOD_S);
        let size = match self.bytes.below(6) {
            0 => self.bytes.choice(&[0.0, -PERIOD_S, f64::NAN, f64::INFINITY, 1e-12, 5e-324, 1e12]),
            1 => PERIOD_S * 300.0 * self.bytes.unit(),
            2 => PERIOD_S / 3.0,
            _ => PERIOD_S * 4.0 * self.bytes.unit().abs(),
        };
        let (status, reached) = step(instance.c, point, size);
        if status <= fmi3Status::fmi3Warning {
            instance.time_s = reached;
        }
        status
    }

    /// Sets plausible inputs and steps over some samples; events are handled where they come.
    fn drive(&mut self, instance: &mut Instance) -> fmi3Status {
        let speed = 15.0 + 12.0 * self.bytes.unit();
        let (yaw_rate, angle) = (0.3 * self.bytes.unit(), 0.05 * self.bytes.unit());
        let inputs = [speed, yaw_rate, 100.0 * self.bytes.unit(), angle];
        call!(fmi3SetFloat64(instance.c, INPUTS.as_ptr(), 4, inputs.as_ptr(), 4));
        for _ in 0..self.bytes.below(8) {
            let (status, reached) = step(instance.c, instance.time_s, PERIOD_S);
            if status <= fmi3Status::fmi3Warning {
                instance.time_s = reached;
            }
            if self.bytes.rarely(4) && call!(fmi3EnterEventMode(instance.c)) == fmi3Status::fmi3OK {
                update(instance.c);
                call!(fmi3EnterStepMode(instance.c));
            }
        }
        // The inputs were set, whatever became of the steps.
        fmi3Status::fmi3OK
    }

    fn save(&mut self, instance: &mut Instance) -> fmi3Status {
        let reused = instance.states.len() == MOST || self.bytes.rarely(4);
        let mut state =
            if reused { instance.states.pop() } else { None }.unwrap_or(ptr::null_mut());
        let status =
            call!(fmi3GetFMUState(instance.c, or_null_mut(&mut self.bytes, &raw mut state)));
        if !state.is_null() {
            instance.serialised = Some(serialised(instance.c, state));
            instance.states.push(state);
        }
        status
    }

    fn restore(&mut self, instance: &mut Instance) -> fmi3Status {
        let state = instance.states.last().copied().unwrap_or(ptr::null_mut());
        let status = call!(fmi3SetFMUState(instance.c, state));
        assert!(!state.is_null() || status == fmi3Status::fmi3Error, "NULL is no state");
        let mut time_s = f64::NAN;
        let [.., time] = references_beyond_the_table::<DetectorVariable>();
        call!(fmi3GetFloat64(instance.c, &raw const time, 1, &raw mut time_s, 1));
        if time_s.is_finite() {
            instance.time_s = time_s;
        }
        status
    }

    /// Deserialises a state, damaged or not, of any instance.
    fn deserialise(&mut self, instance: &mut Instance) -> fmi3Status {
        let of_any = self.instances.iter().chain([&*instance]);
        let Some(mut bytes) = of_any.filter_map(|one| one.serialised.clone()).next() else {
            return fmi3Status::fmi3OK;
        };
        let length = bytes.len();
        let damaged = match self.bytes.below(4) {
            0 => {
                let place = usize::from(u16::from_be_bytes([self.bytes.byte(), self.bytes.byte()]));
                bytes[place % length] ^= 1 << self.bytes.below(8);
                true
            }
            1 => {
                bytes.truncate(self.bytes.below(256) * length / 256);
                true
            }
            _ => false,
        };
        if instance.states.len() == MOST {
            let mut oldest = instance.states.remove(0);
            call!(fmi3FreeFMUState(instance.c, &raw mut oldest));
        }
        let mut state = ptr::null_mut();
        let status =
            call!(fmi3DeserializeFMUState(instance.c, bytes.as_ptr(), bytes.len(), &raw mut state));
        assert_eq!(damaged, status == fmi3Status::fmi3Error, "damaged {damaged}");
        assert_eq!(state.is_null(), damaged);
        if !state.is_null() {
            instance.states.push(state);
        }
        status
    }

    /// Saves, goes on, comes back and goes on again, here and in a new instance.
    fn replay(&mut self, instance: &Instance) {
        let c = instance.c;
        let mut state = ptr::null_mut();
        assert_eq!(call!(fmi3GetFMUState(c, &raw mut state)), fmi3Status::fmi3OK);
        let saved = serialised(c, state);
        let course = [0; 24].map(|_: u8| self.bytes.byte());
        let first = continued(c, instance.time_s, &course);
        assert_eq!(call!(fmi3SetFMUState(c, state)), fmi3Status::fmi3OK);
        assert_eq!(continued(c, instance.time_s, &course), first, "continued in the same instance");
        assert_eq!(call!(fmi3SetFMUState(c, state)), fmi3Status::fmi3OK);
        call!(fmi3FreeFMUState(c, &raw mut state));

        let other = instantiate(c"other".as_ptr(), GUID.as_ptr(), [0, 0, 0]);
        assert!(!other.is_null(), "a sound call is answered");
        let mut copy = ptr::null_mut();
        let read =
            call!(fmi3DeserializeFMUState(other, saved.as_ptr(), saved.len(), &raw mut copy));
        assert_eq!(read, fmi3Status::fmi3OK);
        assert_eq!(serialised(other, copy), saved, "serialised again");
        assert_eq!(call!(fmi3SetFMUState(other, copy)), fmi3Status::fmi3OK);
        assert_eq!(observe(other), observe(c), "restored in another instance");
        call!(fmi3FreeFMUState(other, &raw mut copy));
        // SAFETY: the instance is live and not used any more.
        unsafe { fmi3::fmi3FreeInstance(other) };
    }

    fn debug_logging(&mut self, c: fmi3Instance) -> fmi3Status {
        let names = [c"logEvents".as_ptr(), c"logStatusError".as_ptr(), c"nonsense".as_ptr()];
        let names = &names[..self.bytes.below(4)];
        let on = self.bytes.choice(&[0, 1, 255]);
        call!(fmi3SetDebugLogging(c, on, names.len(), or_null(&mut self.bytes, names.as_ptr())))
    }

    /// What this FMU does not do is refused.
    fn absent(&mut self, c: fmi3Instance) -> fmi3Status {
        let (mut real, mut size, mut flags) = (0.0, 0, [0; 2]);
        let [a, b] = flags.each_mut().map(|flag| &raw mut *flag);
        let status = match self.bytes.below(8) {
            0 => call!(fmi3EnterContinuousTimeMode(c)),
            1 => call!(fmi3CompletedIntegratorStep(c, 1, a, b)),
            2 => call!(fmi3SetTime(c, 1.0)),
            3 => call!(fmi3GetContinuousStates(c, &raw mut real, 1)),
            4 => call!(fmi3ActivateModelPartition(c, 0, 0.0)),
            5 => call!(fmi3GetNumberOfVariableDependencies(c, 0, &raw mut size)),
            6 => call!(fmi3EnterConfigurationMode(c)),
            _ => call!(fmi3GetShiftDecimal(c, INPUTS.as_ptr(), 1, &raw mut real)),
        };
        assert_eq!(status, fmi3Status::fmi3Error);
        status
    }

    fn without_an_instance(&mut self) {
        let none = ptr::null_mut();
        let status = match self.bytes.below(5) {
            0 => call!(fmi3Reset(none)),
            1 => step(none, 0.0, PERIOD_S).0,
            2 => update(none),
            3 => call!(fmi3SetTime(none, 1.0)),
            _ => call!(fmi3GetFMUState(none, ptr::null_mut())),
        };
        assert_eq!(status, fmi3Status::fmi3Error);
        // SAFETY: the standard allows NULL.
        unsafe { fmi3::fmi3FreeInstance(none) };
        // SAFETY: strings live until the call returns.
        let other_kinds = unsafe {
            let (name, token, here) = (c"name".as_ptr(), GUID.as_ptr(), ptr::null());
            [
                fmi3::fmi3InstantiateModelExchange(name, token, here, 0, 1, none, Some(log)),
                fmi3::fmi3InstantiateScheduledExecution(
                    name,
                    token,
                    here,
                    0,
                    1,
                    none,
                    Some(log),
                    None,
                    None,
                    None,
                ),
            ]
        };
        assert!(other_kinds.iter().all(|made| made.is_null()));
    }
}

fn serialised(c: fmi3Instance, state: fmi3FMUState) -> Vec<u8> {
    let mut size = 0;
    assert_eq!(call!(fmi3SerializedFMUStateSize(c, state, &raw mut size)), fmi3Status::fmi3OK);
    let mut bytes = vec![0; size];
    assert_eq!(
        call!(fmi3SerializeFMUState(c, state, bytes.as_mut_ptr(), size)),
        fmi3Status::fmi3OK
    );
    bytes
}

/// Some samples from `time_s`, with all that is to be seen after each.
fn continued(c: fmi3Instance, mut time_s: f64, course: &[u8]) -> Vec<(fmi3Status, Observation)> {
    let mut observations = Vec::new();
    for inputs in course.chunks(6) {
        let mut bytes = Bytes(inputs);
        let (speed, yaw_rate) = (16.0 + 15.0 * bytes.unit(), 0.4 * bytes.unit());
        let inputs = [speed, yaw_rate, 100.0 * bytes.unit(), 0.1 * bytes.unit()];
        let size = PERIOD_S * 2.0 * bytes.unit().abs();
        call!(fmi3SetFloat64(c, INPUTS.as_ptr(), 4, inputs.as_ptr(), 4));
        let (status, reached) = step(c, time_s, size);
        if status <= fmi3Status::fmi3Warning {
            time_s = reached;
        }
        observations.push((status, observe(c)));
    }
    observations
}
