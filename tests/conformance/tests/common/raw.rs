//! An instance through nothing but the C functions.

use std::ffi::{CStr, CString, c_char};
use std::ptr;

use steerguard_conformance_tests::{Functions, host};
use steerguard_fmi2::types::*;

use super::VARIABLES;

/// An instance in Step Mode; dropping it frees it.
pub struct Raw<'a> {
    functions: &'a Functions,
    component: fmi2Component,
}

fn reference(name: &str) -> u32 {
    VARIABLES.iter().position(|variable| variable.name == name).unwrap() as u32
}

impl<'a> Raw<'a> {
    /// A new instance, initialised.
    pub fn new(functions: &'a Functions, guid: &CStr, name: &str) -> Self {
        let raw = Self::instantiated(functions, guid, name);
        raw.initialise();
        raw
    }

    /// A new instance, as it comes, with logging on.
    pub fn instantiated(functions: &'a Functions, guid: &CStr, name: &str) -> Self {
        let (name, callbacks) = (CString::new(name).unwrap(), host::callbacks());
        // SAFETY: strings and callbacks live until the call returns, and the FMU copies them.
        let component = unsafe {
            (functions.fmi2Instantiate)(
                name.as_ptr(),
                fmi2CoSimulation,
                guid.as_ptr(),
                ptr::null(),
                &raw const callbacks,
                fmi2False,
                fmi2True,
            )
        };
        assert!(!component.is_null());
        Self { functions, component }
    }

    pub fn initialise(&self) {
        let (functions, c) = (self.functions, self.component);
        // SAFETY: a live instance.
        unsafe {
            ok((functions.fmi2SetupExperiment)(c, fmi2False, 0.0, 0.0, fmi2False, 0.0));
            ok((functions.fmi2EnterInitializationMode)(c));
            ok((functions.fmi2ExitInitializationMode)(c));
        }
    }

    /// Sets v_x, r, T_eng and delta.
    pub fn set(&self, inputs: &[f64; 4]) {
        let references = [0, 1, 2, 3];
        // SAFETY: a live instance, four elements each.
        ok(unsafe {
            (self.functions.fmi2SetReal)(self.component, references.as_ptr(), 4, inputs.as_ptr())
        });
    }

    pub fn step(&self, time_s: f64, size_s: f64) -> fmi2Status {
        // SAFETY: a live instance.
        unsafe { (self.functions.fmi2DoStep)(self.component, time_s, size_s, fmi2True) }
    }

    /// All Real results, as bits.
    pub fn results(&self) -> [u64; 8] {
        let references = super::drive::REALS.map(reference);
        let mut values = [f64::NAN; 8];
        // SAFETY: a live instance, eight elements each.
        ok(unsafe {
            let get = self.functions.fmi2GetReal;
            get(self.component, references.as_ptr(), 8, values.as_mut_ptr())
        });
        values.map(f64::to_bits)
    }

    pub fn alarm(&self) -> bool {
        let (reference, mut value) = (reference("alarm"), -1);
        // SAFETY: a live instance, one element each.
        ok(unsafe {
            let get = self.functions.fmi2GetBoolean;
            get(self.component, &raw const reference, 1, &raw mut value)
        });
        value == fmi2True
    }

    /// Sets the inputs of the drive at `k period` and steps over a sample, for all k; the results.
    pub fn drive(&self, steps: std::ops::Range<u64>, period_s: f64) -> Vec<[u64; 8]> {
        steps
            .map(|k| {
                let time_s = k as f64 * period_s;
                self.set(&super::drive::inputs(time_s));
                assert!(self.step(time_s, period_s) <= fmi2Status::fmi2Warning);
                self.results()
            })
            .collect()
    }

    /// The state as bytes.
    pub fn serialised(&self) -> Vec<u8> {
        let (functions, c) = (self.functions, self.component);
        let (mut state, mut size) = (ptr::null_mut(), 0);
        // SAFETY: a live instance; the buffer has the size that the FMU asks for.
        unsafe {
            ok((functions.fmi2GetFMUstate)(c, &raw mut state));
            ok((functions.fmi2SerializedFMUstateSize)(c, state, &raw mut size));
            let mut bytes = vec![0u8; size];
            let buffer = bytes.as_mut_ptr().cast::<c_char>();
            ok((functions.fmi2SerializeFMUstate)(c, state, buffer, size));
            ok((functions.fmi2FreeFMUstate)(c, &raw mut state));
            bytes
        }
    }

    /// Takes on a state.
    pub fn restore(&self, bytes: &[u8]) {
        let (functions, c) = (self.functions, self.component);
        let mut state = ptr::null_mut();
        // SAFETY: a live instance and as many bytes as announced.
        unsafe {
            let from = bytes.as_ptr().cast::<c_char>();
            ok((functions.fmi2DeSerializeFMUstate)(c, from, bytes.len(), &raw mut state));
            ok((functions.fmi2SetFMUstate)(c, state));
            ok((functions.fmi2FreeFMUstate)(c, &raw mut state));
        }
    }

    pub fn terminate(&self) {
        // SAFETY: a live instance.
        ok(unsafe { (self.functions.fmi2Terminate)(self.component) });
    }

    pub fn reset(&self) {
        // SAFETY: a live instance.
        ok(unsafe { (self.functions.fmi2Reset)(self.component) });
    }
}

impl Drop for Raw<'_> {
    fn drop(&mut self) {
        // SAFETY: a live instance that is not used any more.
        unsafe { (self.functions.fmi2FreeInstance)(self.component) }
    }
}

#[track_caller]
fn ok(status: fmi2Status) {
    assert_eq!(status, fmi2Status::fmi2OK);
}
