//! Getting and setting values.

use std::ffi::CStr;
use std::ptr;

use super::toy::{CLOCK, CLOCK_TIME, TIME, ToyVariable as V};
use super::{ERROR, Importer, OK, fmi3::*};

#[test]
fn values_of_all_types_come_back() {
    let importer = Importer::default();
    let component = importer.instantiate();
    let c = component.c;
    unsafe {
        let (order, mut read) = (V::Order as u32, 7);
        assert_eq!(fmi3SetInt32(c, &order, 1, &-3, 1), OK);
        assert_eq!(fmi3GetInt32(c, &order, 1, &mut read, 1), OK);
        assert_eq!(read, -3);

        let (mode, mut read) = (V::Mode as u32, 7);
        assert_eq!(fmi3SetInt64(c, &mode, 1, &2, 1), OK);
        assert_eq!(fmi3GetInt64(c, &mode, 1, &mut read, 1), OK);
        assert_eq!(read, 2);

        let (hold, mut read) = (V::Hold as u32, 7);
        assert_eq!(fmi3SetBoolean(c, &hold, 1, &5, 1), OK);
        assert_eq!(fmi3GetBoolean(c, &hold, 1, &mut read, 1), OK);
        assert_eq!(read, 1);

        let (label, mut read) = (V::Label as u32, ptr::null());
        assert_eq!(fmi3SetString(c, &label, 1, &c"some text".as_ptr(), 1), OK);
        assert_eq!(fmi3GetString(c, &label, 1, &mut read, 1), OK);
        assert_eq!(CStr::from_ptr(read), c"some text");
    }
}

#[test]
fn an_array_takes_as_many_values_as_it_has_elements() {
    let importer = Importer::default();
    let component = importer.instantiate();
    let c = component.c;
    let vr = [V::Offset as u32, V::First as u32, V::Input as u32];
    let mut read = [f64::NAN; 4];
    unsafe {
        assert_eq!(fmi3SetFloat64(c, vr.as_ptr(), 3, [7.0, 1.5, 2.5, 0.25].as_ptr(), 4), OK);
        assert_eq!(fmi3GetFloat64(c, vr.as_ptr(), 3, read.as_mut_ptr(), 4), OK);
        assert_eq!(read, [7.0, 1.5, 2.5, 0.25]);

        // All or none: the second element is refused.
        let before = component.serialised();
        assert_eq!(fmi3SetFloat64(c, vr.as_ptr(), 3, [8.0, 3.0, 11.0, 0.5].as_ptr(), 4), ERROR);
        let text = "fmi3SetFloat64: variable \"x[2]\" cannot be 11: at most 10 is allowed";
        assert_eq!(importer.last(), text);
        for count in [2, 3, 5] {
            let values = [0.5; 5];
            assert_eq!(fmi3SetFloat64(c, vr.as_ptr(), 3, values.as_ptr(), count), ERROR);
            let text = format!("fmi3SetFloat64: the variables have 4 elements, nValues is {count}");
            assert_eq!(importer.last(), text);
            let mut read = [f64::NAN; 5];
            assert_eq!(fmi3GetFloat64(c, vr.as_ptr(), 3, read.as_mut_ptr(), count), ERROR);
            assert!(read.iter().all(|value| value.is_nan()), "nothing is written");
        }
        assert_eq!(component.serialised(), before);
    }
}

#[test]
fn what_is_no_variable_or_of_another_type_is_refused() {
    let importer = Importer::default();
    let component = importer.instantiate();
    let (c, mut real, mut integer, mut wide) = (component.c, 0.0, 0, 0);
    unsafe {
        for (vr, text) in [
            (V::Second as u32, "no variable has value reference 5"),
            (TIME + 1, "no variable has value reference 13"),
            (u32::MAX, "no variable has value reference 4294967295"),
            (V::Mode as u32, "variable \"mode\" is of type Enumeration"),
            (CLOCK, "variable \"change\" is of type Clock"),
        ] {
            assert_eq!(fmi3GetFloat64(c, &vr, 1, &mut real, 1), ERROR);
            assert_eq!(importer.last(), format!("fmi3GetFloat64: {text}"));
            assert_eq!(fmi3SetFloat64(c, &vr, 1, &real, 1), ERROR);
        }
        // Enumerations are of 64 bits, Integers of 32.
        assert_eq!(fmi3GetInt32(c, &(V::Mode as u32), 1, &mut integer, 1), ERROR);
        assert_eq!(fmi3GetInt64(c, &(V::Order as u32), 1, &mut wide, 1), ERROR);
        assert_eq!(importer.last(), "fmi3GetInt64: variable \"order\" is of type Int32");
        for item in [0, 3, i64::MAX] {
            assert_eq!(fmi3SetInt64(c, &(V::Mode as u32), 1, &item, 1), ERROR, "{item}");
        }
        assert_eq!(fmi3SetString(c, &(V::Label as u32), 1, &ptr::null(), 1), ERROR);
        let mut active = 7;
        assert_eq!(fmi3GetClock(c, &(V::Flag as u32), 1, &mut active), ERROR);
    }
}

#[test]
fn times_are_got_and_not_set() {
    let importer = Importer::default();
    let component = importer.instantiate().initialised(3.0, None);
    assert_eq!((component.get(TIME), component.get(CLOCK_TIME)), (3.0, -1.0));
    assert_eq!(component.step(3.0, 0.25).status, OK);
    assert_eq!(component.get(TIME), 3.25);
    for vr in [TIME, CLOCK_TIME] {
        unsafe { assert_eq!(fmi3SetFloat64(component.c, &vr, 1, &1.0, 1), ERROR) };
        let text = "fmi3SetFloat64: a time is the FMU's own and cannot be set";
        assert_eq!(importer.last(), text);
    }
}

#[test]
fn fixed_parameters_are_not_set_after_initialisation() {
    let importer = Importer::default();
    let component = importer.instantiate();
    assert_eq!(component.set(V::Offset, 1.0), OK);
    let component = component.initialised(0.0, None);
    assert_eq!(component.set(V::Offset, 2.0), ERROR);
    assert!(importer.last().contains("cannot be set after initialization"), "{}", importer.last());
    // As long as they are within its limits: the last of a Real input is the model's affair.
    assert_eq!(component.set(V::Input, f64::INFINITY), OK);
    assert_eq!(component.get(V::Offset as u32), 1.0);
}

#[test]
fn empty_requests_need_no_arrays_and_others_do() {
    let importer = Importer::default();
    let component = importer.instantiate();
    let (c, vr, mut value) = (component.c, V::Offset as u32, 0.0);
    let odd = ptr::dangling::<u8>().cast::<u32>();
    unsafe {
        assert_eq!(fmi3GetFloat64(c, ptr::null(), 0, ptr::null_mut(), 0), OK);
        assert_eq!(fmi3GetFloat64(c, ptr::null(), 1, &mut value, 1), ERROR);
        assert_eq!(fmi3GetFloat64(c, odd, 1, &mut value, 1), ERROR);
        assert_eq!(fmi3GetFloat64(c, &vr, 1, ptr::null_mut(), 1), ERROR);
        assert_eq!(fmi3GetFloat64(c, &vr, usize::MAX, &mut value, usize::MAX), ERROR);
        assert!(importer.last().contains("valueReferences is NULL or no valid array"));
    }
}
