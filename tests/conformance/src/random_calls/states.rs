//! Saving, restoring, damaging and comparing states.

use std::ffi::c_char;
use std::ptr;

use steerguard_fmi2::Function as F;
use steerguard_fmi2::types::*;

use super::bytes::{Bytes, or_null_mut};
use super::{INPUTS, Instance, MAX_STATES, Observation, Run, call};
use crate::host;

impl Run<'_, '_> {
    pub(super) fn save(&mut self, instance: &mut Instance) -> fmi2Status {
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

    pub(super) fn restore(&mut self, instance: &Instance) -> fmi2Status {
        let state = instance.states.last().copied().unwrap_or(ptr::null_mut());
        let status = call!(self, fmi2SetFMUstate(instance.component, state));
        assert!(!state.is_null() || status == fmi2Status::fmi2Error, "NULL is no state");
        status
    }

    pub(super) fn release_state(&mut self, instance: &mut Instance) -> fmi2Status {
        let c = instance.component;
        if self.bytes.rarely(8) {
            return call!(self, fmi2FreeFMUstate(c, ptr::null_mut()));
        }
        let mut state = instance.states.pop().unwrap_or(ptr::null_mut());
        call!(self, fmi2FreeFMUstate(c, &raw mut state))
    }

    pub(super) fn serialise(&mut self, instance: &mut Instance) -> fmi2Status {
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
    pub(super) fn deserialise(&mut self, instance: &mut Instance) -> fmi2Status {
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
    pub(super) fn forge(&mut self, instance: &Instance) -> fmi2Status {
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

    /// Saves, goes on, comes back and goes on again, here and in a new instance.
    pub(super) fn replay(&mut self, instance: &Instance) {
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
    pub(super) fn course(&mut self, instance: &Instance, course: &[u8]) -> Vec<Observation> {
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

    pub(super) fn bytes_of(&mut self, instance: &Instance, state: fmi2FMUstate) -> Vec<u8> {
        let (c, mut size) = (instance.component, 0);
        call!(self, fmi2SerializedFMUstateSize(c, state, &raw mut size));
        let mut bytes = vec![0u8; size];
        let pointer = bytes.as_mut_ptr().cast::<c_char>();
        let status = call!(self, fmi2SerializeFMUstate(c, state, pointer, size));
        assert_eq!(status, fmi2Status::fmi2OK);
        bytes
    }
}

/// CRC-32 as in zip.
fn crc_32(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(u32::MAX, |crc, &byte| {
        (0..8).fold(crc ^ u32::from(byte), |crc, _| (crc >> 1) ^ (0xEDB8_8320 * (crc & 1)))
    })
}
