//! An instance: the state machine of FMI 2.0.4, section 4.2, around a run. No raw pointers here; the
//! C side is in [`boundary`](crate::boundary).

use core::ffi::CStr;

use steerguard_fmu_core::{
    AccessRefusal, Archive, Categories, Clock, Guid, Model, Run, Text, access, saved_state,
};
use steerguard_model_description::{LogCategory, Value};

use crate::environment::Environment;
use crate::types::fmi2Status;
use crate::{CallState, Function};

/// An instance as the importer holds it.
pub(crate) struct Instance<M> {
    pub(crate) environment: Environment,
    /// Whether logging was on at instantiation; a reset comes back to it.
    pub(crate) logging_on: bool,
    pub(crate) guid: Guid,
    pub(crate) machine: Machine<M>,
}

/// Everything of an instance that a saved state holds and a reset renews.
#[derive(Clone)]
pub(crate) struct Machine<M> {
    pub(crate) state: CallState,
    pub(crate) run: Run<M>,
}

impl<M: Model> Machine<M> {
    /// A fresh machine from the baked payload.
    ///
    /// # Errors
    /// Why the payload is of no use.
    pub(crate) fn fresh(payload: &[u8]) -> Result<Self, &'static str> {
        Ok(Self { state: CallState::Instantiated, run: Run::fresh(payload)? })
    }

    /// All fields, for saving and restoring.
    pub(crate) fn archive(&mut self, archive: &mut Archive<'_>) {
        archive.choice(&mut self.state, &CallState::ALL);
        archive.require(self.state != CallState::StartAndEnd);
        self.run.archive(archive);
    }
}

impl<M: Model> Instance<M> {
    /// Logs why a call is refused.
    #[cold]
    pub(crate) fn refuse(&self, function: Function, reason: impl FnOnce(&mut Text)) -> fmi2Status {
        self.environment.log().error(|text| reason(text.str(function.name()).str(": ")));
        fmi2Status::fmi2Error
    }

    /// Logs why a variable cannot be treated as asked.
    #[cold]
    pub(crate) fn refuse_access(
        &self,
        function: Function,
        refusal: AccessRefusal<'_>,
    ) -> fmi2Status {
        self.refuse(function, |text| refusal.describe(text))
    }

    /// The variable, if it may be set to a value now.
    ///
    /// # Errors
    /// The status of the refusal.
    #[inline]
    pub(crate) fn settable(
        &self,
        function: Function,
        vr: u32,
        value: Value<'_>,
    ) -> Result<M::Variable, fmi2Status> {
        let initialised = self.machine.state == CallState::StepComplete;
        access::settable::<M>(vr, value, initialised).ok_or_else(|| {
            self.refuse_access(function, access::refusal_to_set::<M>(vr, value, initialised))
        })
    }

    /// `fmi2SetupExperiment`.
    pub(crate) fn set_up(&mut self, start: f64, stop: Option<f64>) -> fmi2Status {
        let period = self.machine.run.model.sample_period_s();
        match Clock::new(start, stop, period) {
            Ok(clock) => {
                self.machine.run.clock = clock;
                fmi2Status::fmi2OK
            }
            Err(refusal) => self.refuse(Function::fmi2SetupExperiment, |text| {
                refusal.describe(start, stop, period, text);
            }),
        }
    }

    /// `fmi2ExitInitializationMode`.
    pub(crate) fn initialise(&mut self) -> fmi2Status {
        let Run { clock, model, .. } = &mut self.machine.run;
        match model.initialise(clock.start) {
            Ok(()) => {
                self.machine.state = CallState::StepComplete;
                fmi2Status::fmi2OK
            }
            Err(reason) => {
                self.machine.state = CallState::Error;
                self.refuse(Function::fmi2ExitInitializationMode, |text| {
                    text.str(reason);
                })
            }
        }
    }

    /// `fmi2DoStep`.
    pub(crate) fn do_step(&mut self, point: f64, size: f64) -> fmi2Status {
        let Machine { state, run } = &mut self.machine;
        let step = match run.clock.step(point, size, run.model.sample_period_s()) {
            Ok(step) => step,
            Err(refusal) => {
                return self.refuse(Function::fmi2DoStep, |text| {
                    refusal.describe(point, size, text);
                });
            }
        };
        let log = self.environment.log();
        let mut status = fmi2Status::fmi2OK;
        if step.displaced {
            status = fmi2Status::fmi2Warning;
            log.warning(|text| {
                text.str("fmi2DoStep: the step begins at ").real(point);
                text.str(" s, but the last one ended at ").real(run.clock.point).str(" s");
            });
        }
        status = status.max(run.advance(step, &log).into());
        if status >= fmi2Status::fmi2Discard {
            *state = match status {
                fmi2Status::fmi2Discard => CallState::StepFailed,
                fmi2Status::fmi2Error => CallState::Error,
                _ => CallState::Fatal,
            };
        }
        status
    }

    /// The machine that a serialised state describes.
    ///
    /// # Errors
    /// The status of the refusal, if it is not one of this FMU's.
    pub(crate) fn restored(
        &self,
        function: Function,
        state: &[u8],
    ) -> Result<Machine<M>, fmi2Status> {
        let mut machine = self.machine.clone();
        saved_state::read(state, &self.guid, |archive| machine.archive(archive)).map_err(
            |reason| {
                self.refuse(function, |text| {
                    text.str("the state cannot be restored: ").str(reason);
                })
            },
        )?;
        Ok(machine)
    }

    /// Turns logging on for the named categories, for all if none is named, or off.
    pub(crate) fn set_logging<'c>(
        &mut self,
        on: bool,
        categories: impl Iterator<Item = &'c CStr>,
    ) -> fmi2Status {
        self.environment.categories = Categories::NONE;
        if !on {
            return fmi2Status::fmi2OK;
        }
        let (mut named, mut status) = (false, fmi2Status::fmi2OK);
        for name in categories {
            named = true;
            match LogCategory::ALL.into_iter().find(|category| category.name() == name) {
                Some(category) => self.environment.categories.enable(category),
                None => {
                    status = fmi2Status::fmi2Warning;
                    self.environment.log().warning(|text| {
                        text.str("fmi2SetDebugLogging: no category \"").c_str(name).str("\"");
                    });
                }
            }
        }
        if !named {
            self.environment.categories.enable(LogCategory::All);
        }
        status
    }
}
