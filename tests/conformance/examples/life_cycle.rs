//! Loads, runs and unloads the detector library many times, for valgrind to watch:
//! `life_cycle LIBRARY GUID [LIVES]`. Nothing else goes on in this program.
#![allow(clippy::unwrap_used, clippy::panic)]

use std::ffi::{CStr, CString, c_char};
use std::path::Path;
use std::ptr;

use steerguard_conformance_tests::{Functions, host};
use steerguard_fmi2::types::*;

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [library, guid, rest @ ..] = &arguments[..] else {
        panic!("usage: life_cycle LIBRARY GUID [LIVES]");
    };
    let guid = CString::new(guid.as_str()).unwrap();
    let lives: u32 = rest.first().map_or(100, |lives| lives.parse().unwrap());
    for _ in 0..lives {
        let library = Path::new(library);
        let guid = &*guid;
        std::thread::scope(|scope| scope.spawn(|| live(library, guid)).join()).unwrap();
    }
    println!("{lives} lives, no more memory in use than before");
}

fn live(library: &Path, guid: &CStr) {
    let (functions, code) = Functions::load(library).unwrap();
    let counted = host::callbacks();
    let own = fmi2CallbackFunctions { allocateMemory: None, freeMemory: None, ..counted };
    for callbacks in [counted, own] {
        // SAFETY: pointers to live values; the calls follow the standard's sequence.
        unsafe { run(&functions, guid, &callbacks) };
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
unsafe fn run(f: &Functions, guid: &CStr, callbacks: &fmi2CallbackFunctions) {
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
                let inputs = [15.0, if k == 50 { f64::NAN } else { 0.05 }, 78.75, 0.0];
                (f.fmi2SetReal)(c, [0, 1, 2, 3].as_ptr(), 4, inputs.as_ptr());
                (f.fmi2DoStep)(c, f64::from(k) * 0.01, 0.01, 1);
                let mut results = [0.0; 4];
                (f.fmi2GetReal)(c, [4, 5, 6, 7].as_ptr(), 4, results.as_mut_ptr());
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
