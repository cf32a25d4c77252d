//! Loads, runs and unloads a library of ours many times, for valgrind to watch:
//! `life_cycle VERSION LIBRARY GUID INPUTS [LIVES]`, VERSION 2 or 3 for FMI 2.0 or 3.0, four INPUTS between
//! commas. Nothing else goes on in this program.
#![allow(clippy::unwrap_used, clippy::panic)]

use std::ffi::{CStr, CString, c_char};
use std::path::Path;
use std::ptr;

use libloading::Library;
use steerguard_conformance_tests::{Functions, host};
use steerguard_fmi2::types::*;
use steerguard_fmi3::pointers as fmi3;
use steerguard_fmi3::types::*;

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [version, library, guid, inputs, rest @ ..] = &arguments[..] else {
        panic!("usage: life_cycle VERSION LIBRARY GUID INPUTS [LIVES]");
    };
    let guid = CString::new(guid.as_str()).unwrap();
    let inputs: Vec<f64> = inputs.split(',').map(|input| input.parse().unwrap()).collect();
    let inputs: [f64; 4] = inputs.try_into().unwrap();
    let lives: u32 = rest.first().map_or(100, |lives| lives.parse().unwrap());
    let live = if version == "3" { live_fmi3 } else { live_fmi2 };
    for _ in 0..lives {
        let library = Path::new(library);
        let guid = &*guid;
        std::thread::scope(|scope| scope.spawn(|| live(library, guid, inputs)).join()).unwrap();
    }
    println!("{lives} lives, no more memory in use than before");
}

fn live_fmi2(library: &Path, guid: &CStr, inputs: [f64; 4]) {
    let (functions, code) = Functions::load(library).unwrap();
    let counted = host::callbacks();
    let own = fmi2CallbackFunctions { allocateMemory: None, freeMemory: None, ..counted };
    for callbacks in [counted, own] {
        // The plant refuses a step with it, and has to be reset then.
        let survives_nan = !library.to_string_lossy().contains("Plant");
        // SAFETY: pointers to live values; the calls follow the standard's sequence.
        unsafe { run_fmi2(&functions, guid, inputs, survives_nan, &callbacks) };
    }
    let counts = host::counts();
    assert_eq!(counts.allocations, counts.frees);
    assert!(counts.allocations > 0);
    code.close().unwrap();
}

/// Every function that handles memory, and samples in between.
///
/// # Safety
/// `callbacks` are those of an importer.
unsafe fn run_fmi2(
    f: &Functions,
    guid: &CStr,
    inputs: [f64; 4],
    survives_nan: bool,
    callbacks: &fmi2CallbackFunctions,
) {
    // SAFETY: all pointers are to live values of the announced size.
    unsafe {
        let instantiate = |guid: &CStr| {
            let (name, guid) = (c"watched".as_ptr(), guid.as_ptr());
            (f.fmi2Instantiate)(name, fmi2CoSimulation, guid, ptr::null(), callbacks, 0, 1)
        };
        assert!(instantiate(c"wrong").is_null());
        let c = instantiate(guid);
        let initialise = || {
            assert_eq!((f.fmi2SetupExperiment)(c, 0, 0.0, 0.0, 0, 0.0), fmi2Status::fmi2OK);
            assert_eq!((f.fmi2EnterInitializationMode)(c), fmi2Status::fmi2OK);
            assert_eq!((f.fmi2ExitInitializationMode)(c), fmi2Status::fmi2OK);
        };
        let drive = |from: u32| {
            for k in from..from + 100 {
                let mut inputs = inputs;
                if k == 50 && survives_nan {
                    inputs[1] = f64::NAN;
                }
                (f.fmi2SetReal)(c, [0, 1, 2, 3].as_ptr(), 4, inputs.as_ptr());
                (f.fmi2DoStep)(c, f64::from(k) * 0.01, 0.01, 1);
                let mut results = [0.0; 4];
                (f.fmi2GetReal)(c, [5, 6, 7, 8].as_ptr(), 4, results.as_mut_ptr());
                assert!(results.iter().all(|value| value.is_finite()));
            }
        };
        initialise();
        drive(0);
        let (mut state, mut copy, mut size) = (ptr::null_mut(), ptr::null_mut(), 0);
        assert_eq!((f.fmi2GetFMUstate)(c, &raw mut state), fmi2Status::fmi2OK);
        assert_eq!((f.fmi2GetFMUstate)(c, &raw mut state), fmi2Status::fmi2OK);
        (f.fmi2SerializedFMUstateSize)(c, state, &raw mut size);
        let mut bytes = vec![0u8; size];
        let serialised = bytes.as_mut_ptr().cast::<c_char>();
        assert_eq!((f.fmi2SerializeFMUstate)(c, state, serialised, size), fmi2Status::fmi2OK);
        drive(100);
        let read = (f.fmi2DeSerializeFMUstate)(c, serialised, size, &raw mut copy);
        assert_eq!(read, fmi2Status::fmi2OK);
        *bytes.last_mut().unwrap() ^= 1;
        let damaged = bytes.as_ptr().cast::<c_char>();
        let read = (f.fmi2DeSerializeFMUstate)(c, damaged, size, &raw mut copy);
        assert_eq!(read, fmi2Status::fmi2Error);
        assert_eq!((f.fmi2SetFMUstate)(c, copy), fmi2Status::fmi2OK);
        drive(100);
        (f.fmi2FreeFMUstate)(c, &raw mut state);
        (f.fmi2FreeFMUstate)(c, &raw mut copy);
        assert_eq!((f.fmi2Terminate)(c), fmi2Status::fmi2OK);
        assert_eq!((f.fmi2Reset)(c), fmi2Status::fmi2OK);
        initialise();
        drive(0);
        (f.fmi2FreeInstance)(c);
    }
}

fn live_fmi3(library: &Path, token: &CStr, inputs: [f64; 4]) {
    // SAFETY: the libraries under test are ours; they have no initialisers.
    let code = unsafe { Library::new(library) }.unwrap();
    // Without and with events, which end steps early.
    for events in [fmi3False, fmi3True] {
        // SAFETY: pointers to live values; the calls follow the standard's sequence.
        unsafe { run_fmi3(&code, token, inputs, events) };
    }
    code.close().unwrap();
}

unsafe extern "C" fn log(
    _: fmi3InstanceEnvironment,
    _: fmi3Status,
    of: fmi3String,
    text: fmi3String,
) {
    for text in [of, text] {
        // SAFETY: the standard has both be NUL-terminated and valid during the call.
        assert!(!unsafe { CStr::from_ptr(text) }.is_empty());
    }
}

/// As `run_fmi2`, in FMI 3.0.
///
/// # Safety
/// `code` is a library of FMI 3.0.
unsafe fn run_fmi3(code: &Library, token: &CStr, inputs: [f64; 4], events: fmi3Boolean) {
    macro_rules! call {
        ($name:ident($($argument:expr),* $(,)?)) => {
            (*code.get::<fmi3::$name>(stringify!($name)).unwrap())($($argument),*)
        };
    }
    // SAFETY: the FMI 3.0 headers declare the functions with these types; all pointers are to live values of the
    // announced size.
    unsafe {
        let instantiate = |token: &CStr| {
            let (name, token) = (c"watched".as_ptr(), token.as_ptr());
            let (none, log) = (ptr::null_mut(), Some(log as _));
            call!(fmi3InstantiateCoSimulation(
                name,
                token,
                ptr::null(),
                0,
                1,
                events,
                events,
                ptr::null(),
                0,
                none,
                log,
                None
            ))
        };
        assert!(instantiate(c"wrong").is_null());
        let c = instantiate(token);
        let initialise = || {
            let entered = call!(fmi3EnterInitializationMode(c, 0, 0.0, 0.0, 0, 0.0));
            assert_eq!(entered, fmi3Status::fmi3OK);
            assert_eq!(call!(fmi3ExitInitializationMode(c)), fmi3Status::fmi3OK);
        };
        let update = || {
            let (mut flags, mut next) = ([0; 5], 0.0);
            let [a, b, c_, d, e] = flags.each_mut().map(|flag| &raw mut *flag);
            let updated = call!(fmi3UpdateDiscreteStates(c, a, b, c_, d, e, &raw mut next));
            assert_eq!(updated, fmi3Status::fmi3OK);
            assert_eq!(call!(fmi3EnterStepMode(c)), fmi3Status::fmi3OK);
        };
        let drive = |mut time: f64, steps: u32| {
            for k in 0..steps {
                let mut inputs = inputs;
                if k == 50 {
                    inputs[1] = f64::NAN;
                }
                call!(fmi3SetFloat64(c, [0, 1, 2, 3].as_ptr(), 4, inputs.as_ptr(), 4));
                let (mut event, mut end, mut early, mut reached) = (0, 0, 0, 0.0);
                let out = (&raw mut event, &raw mut end, &raw mut early, &raw mut reached);
                call!(fmi3DoStep(c, time, 0.01, 1, out.0, out.1, out.2, out.3));
                time = reached;
                if event != 0 {
                    assert_eq!(call!(fmi3EnterEventMode(c)), fmi3Status::fmi3OK);
                    update();
                }
                // J_rms and what stands behind it.
                let mut results = [0.0; 2];
                let got = call!(fmi3GetFloat64(c, [7, 8].as_ptr(), 2, results.as_mut_ptr(), 2));
                assert_eq!(got, fmi3Status::fmi3OK);
                assert!(results.iter().all(|value| value.is_finite()));
            }
            time
        };
        let begin = || {
            initialise();
            if events == fmi3True {
                update();
            }
        };
        begin();
        let time = drive(0.0, 100);
        let (mut state, mut copy, mut size) = (ptr::null_mut(), ptr::null_mut(), 0);
        assert_eq!(call!(fmi3GetFMUState(c, &raw mut state)), fmi3Status::fmi3OK);
        assert_eq!(call!(fmi3GetFMUState(c, &raw mut state)), fmi3Status::fmi3OK);
        call!(fmi3SerializedFMUStateSize(c, state, &raw mut size));
        let mut bytes = vec![0_u8; size];
        let serialised = call!(fmi3SerializeFMUState(c, state, bytes.as_mut_ptr(), size));
        assert_eq!(serialised, fmi3Status::fmi3OK);
        drive(time, 100);
        let read = call!(fmi3DeserializeFMUState(c, bytes.as_ptr(), size, &raw mut copy));
        assert_eq!(read, fmi3Status::fmi3OK);
        *bytes.last_mut().unwrap() ^= 1;
        let read = call!(fmi3DeserializeFMUState(c, bytes.as_ptr(), size, &raw mut copy));
        assert_eq!(read, fmi3Status::fmi3Error);
        assert_eq!(call!(fmi3SetFMUState(c, copy)), fmi3Status::fmi3OK);
        drive(time, 100);
        call!(fmi3FreeFMUState(c, &raw mut state));
        call!(fmi3FreeFMUState(c, &raw mut copy));
        assert_eq!(call!(fmi3Terminate(c)), fmi3Status::fmi3OK);
        assert_eq!(call!(fmi3Reset(c)), fmi3Status::fmi3OK);
        begin();
        drive(0.0, 100);
        call!(fmi3FreeInstance(c));
    }
}
