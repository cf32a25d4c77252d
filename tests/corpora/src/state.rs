//! Saved states with other contents and a checksum that fits, of both models: whatever is made of them, the
//! instance goes on.

use std::ffi::c_char;
use std::ptr;

use steerguard_conformance_tests::host;
use steerguard_fmi2::boundary as b;
use steerguard_fmi2::types::*;
use steerguard_fmu::DetectorModel;
use steerguard_fmu_core::{Block, Fmu, Model, fields};
use steerguard_model_description::{Causality, Kind, VariableSet};
use steerguard_plant::PlantModel;

use crate::block::edited;
use crate::unsolved::{BLOCK, GUID};

/// Before the body, and in it the checksum of the body.
const HEADER: usize = 56;
const CHECKSUM: usize = 52;
/// Of the body: state and clock, which decide how many samples a step runs.
const CLOCK: usize = 34;

struct Detector;

impl Fmu for Detector {
    type Model = DetectorModel;

    fn block() -> &'static Block {
        &BLOCK
    }
}

struct Plant;

impl Fmu for Plant {
    type Model = PlantModel;

    fn block() -> &'static Block {
        static EMPTY: std::sync::LazyLock<Block> =
            std::sync::LazyLock::new(|| Block::sealed("{fuzz}", &[]).unwrap());
        &EMPTY
    }
}

pub fn run(bytes: &[u8]) {
    let [kind, edits @ ..] = bytes else { return };
    // SAFETY: all pointers below are to live values of the announced size, and the calls are on live instances.
    unsafe {
        if kind % 2 == 0 {
            of::<Detector>([15.0, 0.1, 100.0, 0.02], edits);
        } else {
            of::<Plant>([100.0, 0.02, 0.0, 0.0], edits);
        }
    }
}

/// Every real variable that is no input is a finite number, whatever the state.
///
/// # Safety
/// `c` is a live instance.
unsafe fn all_finite<F: Fmu>(c: fmi2Component) {
    let rows = <F::Model as Model>::Variable::TABLE;
    for (reference, row) in (0..).zip(rows) {
        if row.role.causality == Causality::Input || !matches!(row.kind, Kind::Real(_)) {
            continue;
        }
        let mut value = f64::NAN;
        // SAFETY: as promised; both pointers are to one value.
        let status = unsafe { b::fmi2GetReal::<F>(c, &raw const reference, 1, &raw mut value) };
        assert_eq!(status, fmi2Status::fmi2OK, "{}", row.name);
        assert!(value.is_finite(), "{} is {value}", row.name);
    }
}

/// # Safety
/// None beyond that of the functions called.
unsafe fn of<F: Fmu>(inputs: [f64; 4], edits: &[u8]) {
    let before = host::counts();
    let callbacks = host::callbacks();
    // SAFETY: as above.
    unsafe {
        let c = b::fmi2Instantiate::<F>(
            c"state".as_ptr(),
            fmi2CoSimulation,
            GUID.as_ptr(),
            ptr::null(),
            &raw const callbacks,
            fmi2False,
            fmi2True,
        );
        assert!(!c.is_null());
        b::fmi2SetupExperiment::<F>(c, fmi2False, 0.0, 0.0, fmi2False, 0.0);
        b::fmi2EnterInitializationMode::<F>(c);
        assert_eq!(b::fmi2ExitInitializationMode::<F>(c), fmi2Status::fmi2OK);
        let drive = |from: f64| {
            for k in 0..8 {
                b::fmi2SetReal::<F>(c, [0, 1, 2, 3].as_ptr(), 4, inputs.as_ptr());
                b::fmi2DoStep::<F>(c, from + f64::from(k) * 0.01, 0.01, fmi2True);
                all_finite::<F>(c);
            }
        };
        drive(0.0);
        let (mut state, mut size) = (ptr::null_mut(), 0);
        assert_eq!(b::fmi2GetFMUstate::<F>(c, &raw mut state), fmi2Status::fmi2OK);
        b::fmi2SerializedFMUstateSize::<F>(c, state, &raw mut size);
        let mut saved = vec![0_u8; size];
        let to = saved.as_mut_ptr().cast::<c_char>();
        assert_eq!(b::fmi2SerializeFMUstate::<F>(c, state, to, size), fmi2Status::fmi2OK);

        let (header, body) = saved.split_at(HEADER);
        let (clock, rest) = body.split_at(CLOCK);
        let mut forged = [header, clock, &edited(rest, edits)].concat();
        let checksum = fields::checksum(&forged[HEADER..]);
        forged[CHECKSUM..HEADER].copy_from_slice(&checksum.to_le_bytes());
        let from = forged.as_ptr().cast::<c_char>();
        let mut other = ptr::null_mut();
        let taken = b::fmi2DeSerializeFMUstate::<F>(c, from, size, &raw mut other);
        assert_eq!(other.is_null(), taken != fmi2Status::fmi2OK);
        if !other.is_null() {
            assert_eq!(b::fmi2SetFMUstate::<F>(c, other), fmi2Status::fmi2OK);
            let mut again = vec![0_u8; size];
            let to = again.as_mut_ptr().cast::<c_char>();
            assert_eq!(b::fmi2SerializeFMUstate::<F>(c, other, to, size), fmi2Status::fmi2OK);
            assert_eq!(again, forged, "what was taken is what was given");
            all_finite::<F>(c);
            drive(0.08);
            b::fmi2FreeFMUstate::<F>(c, &raw mut other);
        }
        // The state that was saved is not touched by any of it.
        assert_eq!(b::fmi2SetFMUstate::<F>(c, state), fmi2Status::fmi2OK);
        b::fmi2FreeFMUstate::<F>(c, &raw mut state);
        b::fmi2FreeInstance::<F>(c);
    }
    let after = host::counts();
    assert_eq!(
        after.allocations - before.allocations,
        after.frees - before.frees,
        "memory is given back"
    );
}
