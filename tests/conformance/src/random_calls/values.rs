//! Getting and setting.

use std::ffi::c_char;
use std::ptr;

use steerguard_fmi2::Function as F;
use steerguard_fmi2::types::*;
use steerguard_model_description::{Causality, Kind};

use super::bytes::{or_null, or_null_mut};
use super::{INPUTS, Instance, Run, call};

impl Run<'_, '_> {
    /// Value references, valid and not.
    pub(super) fn references(&mut self) -> Vec<u32> {
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
    pub(super) fn set(&mut self, instance: &Instance) -> fmi2Status {
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
    pub(super) fn count<A, B>(&mut self, n: usize, a: *const A, b: *const B) -> usize {
        if a.is_null() && b.is_null() { self.bytes.choice(&[n, 0, 1, usize::MAX]) } else { n }
    }

    pub(super) fn set_one_parameter(&mut self, instance: &Instance) -> fmi2Status {
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

    pub(super) fn get(&mut self, instance: &Instance) -> fmi2Status {
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

    pub(super) fn derivatives(&mut self, instance: &Instance) -> fmi2Status {
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
}
