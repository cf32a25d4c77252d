//! Logging, inquiries, Model Exchange, and calls on no instance.

use std::ffi::CStr;
use std::ptr;

use steerguard_fmi2::Function as F;
use steerguard_fmi2::types::*;

use super::bytes::{or_null, or_null_mut};
use super::{Instance, Run, call};

impl Run<'_, '_> {
    pub(super) fn debug_logging(&mut self, instance: &Instance) -> fmi2Status {
        let names = [c"logAll", c"logEvents", c"logStatusError", c"logStatusWarning", c"none"];
        let count = self.bytes.below(4);
        let given: Vec<_> = (0..count)
            .map(|_| {
                let name = self.bytes.choice(&names).as_ptr();
                or_null(&mut self.bytes, name)
            })
            .collect();
        let (pointer, on) = (or_null(&mut self.bytes, given.as_ptr()), self.bytes.integer());
        call!(self, fmi2SetDebugLogging(instance.component, on, count, pointer))
    }

    pub(super) fn inquire(&mut self, instance: &Instance) -> fmi2Status {
        let (c, kind) = (instance.component, self.bytes.choice(&[0, 1, 2, 3, -1, 77]));
        let (mut status, mut real, mut integer, mut text) =
            (fmi2Status::fmi2OK, 0.0, 0, ptr::null());
        let null = self.bytes.rarely(12);
        let which = self.bytes.below(5);
        macro_rules! inquire {
            ($name:ident, $place:ident) => {{
                let place = if null { ptr::null_mut() } else { &raw mut $place };
                call!(self, $name(c, kind, place))
            }};
        }
        match which {
            0 => inquire!(fmi2GetStatus, status),
            1 => inquire!(fmi2GetRealStatus, real),
            2 => inquire!(fmi2GetIntegerStatus, integer),
            3 => inquire!(fmi2GetBooleanStatus, integer),
            _ => inquire!(fmi2GetStringStatus, text),
        }
    }

    /// Functions for Model Exchange, which have no place here.
    pub(super) fn model_exchange(&mut self, c: fmi2Component) -> fmi2Status {
        let mut values = [0.0; 4];
        let mut flags = [0; 2];
        let mut info = fmi2EventInfo {
            newDiscreteStatesNeeded: 0,
            terminateSimulation: 0,
            nominalsOfContinuousStatesChanged: 0,
            valuesOfContinuousStatesChanged: 0,
            nextEventTimeDefined: 0,
            nextEventTime: 0.0,
        };
        let n = self.bytes.below(5);
        let values = or_null_mut(&mut self.bytes, values.as_mut_ptr());
        let info = or_null_mut(&mut self.bytes, &raw mut info);
        let flag = or_null_mut(&mut self.bytes, flags.as_mut_ptr());
        let time = self.bytes.real();
        let status = match self.bytes.below(10) {
            0 => call!(self, fmi2EnterEventMode(c)),
            1 => call!(self, fmi2NewDiscreteStates(c, info)),
            2 => call!(self, fmi2EnterContinuousTimeMode(c)),
            3 => call!(self, fmi2CompletedIntegratorStep(c, 1, flag, flag)),
            4 => call!(self, fmi2SetTime(c, time)),
            5 => call!(self, fmi2SetContinuousStates(c, values, n)),
            6 => call!(self, fmi2GetDerivatives(c, values, n)),
            7 => call!(self, fmi2GetEventIndicators(c, values, n)),
            8 => call!(self, fmi2GetContinuousStates(c, values, n)),
            _ => call!(self, fmi2GetNominalsOfContinuousStates(c, values, n)),
        };
        assert_eq!(status, fmi2Status::fmi2Error, "a function of Model Exchange");
        status
    }

    /// The same functions on no instance, and those that need none.
    pub(super) fn without_an_instance(&mut self) {
        let none = Instance {
            component: ptr::null_mut(),
            states: Vec::new(),
            serialised: vec![vec![0; 100]],
        };
        let mut state = ptr::null_mut();
        let status = match self.bytes.below(13) {
            0 => self.set(&none),
            1 => self.get(&none),
            2 => call!(self, fmi2DoStep(ptr::null_mut(), 0.0, 1.0, 1)),
            3 => call!(self, fmi2GetFMUstate(ptr::null_mut(), &raw mut state)),
            4 => self.restore(&none),
            5 => self.set_up(&none),
            6 => self.debug_logging(&none),
            7 => self.inquire(&none),
            8 => self.derivatives(&none),
            9 => self.model_exchange(ptr::null_mut()),
            10 => call!(self, fmi2Reset(ptr::null_mut())),
            11 => call!(self, fmi2FreeFMUstate(ptr::null_mut(), &raw mut state)),
            _ => call!(self, fmi2CancelStep(ptr::null_mut())),
        };
        assert_eq!(status, fmi2Status::fmi2Error, "a call on no instance");
        // SAFETY: NULL is no instance; the strings are constants of the FMU.
        unsafe {
            (self.fmu.functions.fmi2FreeInstance)(ptr::null_mut());
            let version = (self.fmu.functions.fmi2GetVersion)();
            let platform = (self.fmu.functions.fmi2GetTypesPlatform)();
            assert_eq!(CStr::from_ptr(version), c"2.0");
            assert_eq!(CStr::from_ptr(platform), c"default");
        }
        self.summary.calls += 3;
    }
}
