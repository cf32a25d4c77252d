//! Saved states.

use std::ptr;

use super::fmi2::*;
use super::toy::{PAYLOAD, ToyVariable as V};
use super::{BLOCK, Component, ERROR, GUID, Importer, LIVE, OK, sealed};
use crate::types::*;

impl Component<'_> {
    /// Frees a state, if there is one.
    pub(super) fn free_state(c: fmi2Component, state: &mut fmi2FMUstate) {
        if !c.is_null() && !state.is_null() {
            unsafe { fmi2FreeFMUstate(c, state) };
        }
    }

    /// Steps `from..to` of 10 ms with a changing input.
    fn run(&self, from: u32, to: u32) {
        for k in from..to {
            assert_eq!(self.set(V::Input, f64::from(k % 7) / 7.0), OK);
            assert_eq!(self.step(f64::from(k) * 0.01, 0.01), OK, "{}", self.importer.last());
        }
    }
}

#[test]
fn a_run_continues_bit_for_bit_from_a_restored_state() {
    let importer = Importer::default();
    let whole = importer.instantiate().initialised(0.0, Some(1.0));
    whole.run(0, 100);

    let first = importer.instantiate();
    assert_eq!(first.set(V::Gain, 1.0), OK);
    let first = first.initialised(0.0, Some(1.0));
    first.run(0, 40);
    let saved = first.serialised();
    // Straight after instantiation, without initialisation.
    let second = importer.instantiate();
    assert_eq!(second.restore(&saved), OK);
    assert_eq!(second.serialised(), saved);
    second.run(40, 100);
    assert_eq!(second.serialised(), whole.serialised());
    // Back in time.
    assert_eq!(first.restore(&saved), OK);
    first.run(40, 100);
    assert_eq!(first.serialised(), whole.serialised());
}

#[test]
fn a_state_holds_nan_inputs_and_derivatives() {
    let importer = Importer::default();
    let component = importer.instantiate().initialised(0.0, None);
    assert_eq!(component.set(V::Input, f64::NAN), OK);
    unsafe { assert_eq!(fmi2SetRealInputDerivatives(component.c, &0, 1, &2, &5.0), OK) };
    let saved = component.serialised();
    let other = importer.instantiate();
    assert_eq!(other.restore(&saved), OK);
    assert_eq!(other.serialised(), saved);
}

#[test]
fn memory_of_a_state_is_used_again() {
    let importer = Importer::default();
    let component = importer.instantiate().initialised(0.0, None);
    let mut state = ptr::null_mut();
    unsafe {
        assert_eq!(fmi2GetFMUstate(component.c, &mut state), OK);
        let first = state;
        component.run(0, 3);
        let live = LIVE.get();
        assert_eq!(fmi2GetFMUstate(component.c, &mut state), OK);
        assert_eq!((state, LIVE.get()), (first, live));
        component.run(3, 6);
        assert_eq!(fmi2SetFMUstate(component.c, state), OK);
        assert_eq!(component.samples(), 3);
        assert_eq!(fmi2FreeFMUstate(component.c, &mut state), OK);
        assert_eq!(fmi2FreeFMUstate(component.c, &mut state), OK, "NULL is ignored");
        assert_eq!(fmi2FreeFMUstate(component.c, ptr::null_mut()), OK);
    }
}

#[test]
fn arguments_of_state_functions_are_checked() {
    let importer = Importer::default();
    let component = importer.instantiate();
    let (c, mut state, mut size) = (component.c, ptr::null_mut(), 0);
    unsafe {
        assert_eq!(fmi2GetFMUstate(c, ptr::null_mut()), ERROR);
        assert_eq!(fmi2SetFMUstate(c, ptr::null_mut()), ERROR);
        assert_eq!(fmi2SerializedFMUstateSize(c, ptr::null_mut(), &mut size), ERROR);
        assert_eq!(fmi2GetFMUstate(c, &mut state), OK);
        assert_eq!(fmi2SerializedFMUstateSize(c, state, ptr::null_mut()), ERROR);
        assert_eq!(fmi2SerializedFMUstateSize(c, state, &mut size), OK);
        let mut bytes = vec![0; size + 8];
        let pointer: *mut fmi2Byte = bytes.as_mut_ptr();
        assert_eq!(fmi2SerializeFMUstate(c, state, ptr::null_mut(), size), ERROR);
        assert_eq!(fmi2SerializeFMUstate(c, state, pointer, size - 1), ERROR);
        assert_eq!(fmi2SerializeFMUstate(c, ptr::null_mut(), pointer, size), ERROR);
        assert_eq!(fmi2SerializeFMUstate(c, state, pointer, size + 8), OK);
        assert_eq!(fmi2DeSerializeFMUstate(c, ptr::null(), size, &mut state), ERROR);
        assert_eq!(fmi2DeSerializeFMUstate(c, pointer, size, ptr::null_mut()), ERROR);
        Component::free_state(c, &mut state);
    }
}

#[test]
fn damaged_and_foreign_states_are_refused_and_change_nothing() {
    let importer = Importer::default();
    let component = importer.instantiate().initialised(0.0, None);
    component.run(0, 5);
    let saved = component.serialised();
    component.run(5, 9);
    let before = component.serialised();
    let refuse = |bytes: &[u8]| {
        importer.messages.take();
        assert_eq!(component.restore(bytes), ERROR);
        assert!(importer.last().contains("the state cannot be restored: "), "{}", importer.last());
        assert_eq!(component.serialised(), before);
    };
    for bit in 0..8 * saved.len() {
        let mut bytes = saved.clone();
        bytes[bit / 8] ^= 1 << (bit % 8);
        refuse(&bytes);
    }
    for length in [0, 1, 55, 56, saved.len() - 1] {
        refuse(&saved[..length]);
    }
    refuse(&[saved.as_slice(), &[0]].concat());

    let good = BLOCK.get();
    BLOCK.set(sealed("{foreign}", &PAYLOAD));
    let c = importer.try_instantiate(c"foreign", 1, c"{foreign}");
    let foreign = Component { c, importer: &importer };
    refuse(&foreign.serialised());
    assert!(importer.last().is_empty() || !importer.last().contains(GUID.to_str().unwrap()));
    BLOCK.set(good);
}

#[test]
fn a_state_with_impossible_contents_is_refused_even_with_a_valid_checksum() {
    let importer = Importer::default();
    let component = importer.instantiate().initialised(0.0, Some(1.0));
    let saved = component.serialised();
    let header = 56;
    // The body begins with the state's code; a run's start time follows.
    for (place, bytes) in [
        (0, vec![0]),
        (0, vec![10]),
        (0, vec![255]),
        (1, f64::NAN.to_le_bytes().to_vec()),
        (9, vec![2]),
        // A communication point that samples are missing before.
        (18, 0.5_f64.to_le_bytes().to_vec()),
        (26, u64::MAX.to_le_bytes().to_vec()),
    ] {
        let mut forged = saved.clone();
        forged[header + place..header + place + bytes.len()].copy_from_slice(&bytes);
        let crc = steerguard_fmu_core::fields::checksum(&forged[header..]).to_le_bytes();
        forged[header - 4..header].copy_from_slice(&crc);
        assert_eq!(component.restore(&forged), ERROR, "{place}");
        assert!(importer.last().ends_with("its contents are not those of a state"));
        assert_eq!(component.serialised(), saved);
    }
}
