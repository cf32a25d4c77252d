//! Saved states.

use std::ptr;

use super::toy::{CLOCK_TIME, PAYLOAD, ToyVariable as V};
use super::{BLOCK, ERROR, Importer, OK, TOKEN, fmi3, sealed};
use crate::CallState;

#[test]
fn a_state_between_sample_and_event_continues_bit_for_bit() {
    let importer = Importer::default();
    let component = importer.instantiate().initialised(0.0, None);
    assert_eq!(component.set(V::Input, f64::NAN), OK);
    assert!(component.step(0.0, 0.1).early);
    let saved = component.serialised();
    // Straight after instantiation, without initialisation.
    let other = importer.instantiate();
    assert_eq!(other.restore(&saved), OK);
    assert_eq!(other.serialised(), saved);
    for component in [&component, &other] {
        unsafe { assert_eq!(fmi3::fmi3EnterEventMode(component.c), OK) };
        assert!(component.ticks(), "the event is still to come");
        assert_eq!(component.get(CLOCK_TIME), 0.02);
    }
    // In the event: the tick is part of the state.
    let saved = component.serialised();
    component.update();
    assert_eq!(component.restore(&saved), OK);
    assert!(component.ticks());
    assert_eq!(component.state(), CallState::EventMode);
}

#[test]
fn what_is_no_state_of_this_fmu_is_refused() {
    let importer = Importer::default();
    let component = importer.instantiate().initialised(0.0, None);
    let saved = component.serialised();
    for bit in 0..8 * saved.len() {
        let mut bytes = saved.clone();
        bytes[bit / 8] ^= 1 << (bit % 8);
        assert_eq!(component.restore(&bytes), ERROR, "bit {bit}");
    }
    assert_eq!(component.restore(&saved[1..]), ERROR);
    assert_eq!(component.restore(&[]), ERROR);
    assert!(importer.last().contains("the state cannot be restored: it is too short"));
    assert_eq!(component.serialised(), saved);

    BLOCK.set(sealed("{other}", &PAYLOAD));
    let c = importer.try_instantiate(c"toy", c"{other}", true, true, 0);
    let other = super::Component { c, importer: &importer };
    assert_eq!(other.restore(&saved), ERROR);
    assert!(importer.last().contains("another GUID"), "{}", importer.last());
    BLOCK.set(sealed(TOKEN.to_str().unwrap(), &PAYLOAD));
    unsafe { assert_eq!(fmi3::fmi3SetFMUState(component.c, ptr::null_mut()), ERROR) };
}
