//! Initialising and stepping.

use steerguard_fmi2::Function as F;
use steerguard_fmi2::types::*;

use super::{INPUTS, Instance, LONGEST_STEP, Run, call};

impl Run<'_, '_> {
    pub(super) fn set_up(&mut self, instance: &Instance) -> fmi2Status {
        let c = instance.component;
        let bytes = &mut self.bytes;
        let (start, stop) = (bytes.real(), bytes.real());
        let (tolerance, given) = (bytes.real(), bytes.choice(&[0, 0, 1]));
        call!(self, fmi2SetupExperiment(c, given, tolerance, start, given, stop))
    }

    /// The ordinary way from Instantiated to Step Mode.
    pub(super) fn initialise(&mut self, instance: &Instance) -> fmi2Status {
        let c = instance.component;
        let start = self.bytes.choice(&[0.0, 0.0, -3.5, 1e6, 1e300]);
        call!(self, fmi2SetupExperiment(c, 0, 0.0, start, 0, 0.0));
        call!(self, fmi2EnterInitializationMode(c));
        call!(self, fmi2ExitInitializationMode(c))
    }

    /// Time that the FMU has reached, s.
    pub(super) fn now(&mut self, instance: &Instance) -> f64 {
        let mut time = 0.0;
        call!(self, fmi2GetRealStatus(instance.component, fmi2LastSuccessfulTime, &raw mut time));
        assert!(time.is_finite(), "last successful time {time}");
        time
    }

    pub(super) fn do_step(&mut self, instance: &Instance) -> fmi2Status {
        let now = self.now(instance);
        let period = self.fmu.sample_period_s;
        let point = self.bytes.time(now, period);
        let size = match self.bytes.below(6) {
            0 => self.bytes.choice(&[0.0, -period, f64::NAN, f64::INFINITY, 1e-12, 5e-324, 1e12]),
            1 => period * LONGEST_STEP * self.bytes.unit(),
            2 => period / 3.0,
            _ => period * 4.0 * self.bytes.unit().abs(),
        };
        let flag = self.bytes.integer();
        call!(self, fmi2DoStep(instance.component, point, size, flag))
    }

    /// Sets plausible inputs and steps over some samples.
    pub(super) fn drive(&mut self, instance: &Instance) -> fmi2Status {
        let period = self.fmu.sample_period_s;
        let speed = 15.0 + 12.0 * self.bytes.unit();
        let (yaw_rate, angle) = (0.3 * self.bytes.unit(), 0.05 * self.bytes.unit());
        let inputs = [speed, yaw_rate, 100.0 * self.bytes.unit(), angle];
        call!(self, fmi2SetReal(instance.component, INPUTS.as_ptr(), 4, inputs.as_ptr()));
        let steps = self.bytes.below(8);
        let start = self.now(instance);
        let mut status = fmi2Status::fmi2OK;
        for k in 0..steps {
            let point = start + k as f64 * period;
            status = call!(self, fmi2DoStep(instance.component, point, period, fmi2True));
        }
        // The inputs were set, whatever became of the steps.
        status.min(fmi2Status::fmi2Warning)
    }
}
