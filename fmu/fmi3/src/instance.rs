//! An instance: the state machine of FMI 3.0.2, section 4.2, around a run. No raw pointers here; the
//! C side is in [`boundary`](crate::boundary).

use core::ffi::CStr;

use steerguard_fmu_core::{
    AccessRefusal, Archive, Categories, Clock, Guid, Model, Run, Text, access, saved_state,
};
use steerguard_model_description::structure::{
    Entry, NO_TICK_TIME, Structure, TriggeredClock, entry, type_name,
};
use steerguard_model_description::{LogCategory, Value, VariableSet};

use crate::environment::Environment;
use crate::types::fmi3Status;
use crate::{CallState, Function};

/// An instance as the importer holds it.
pub(crate) struct Instance<M> {
    pub(crate) environment: Environment,
    /// Whether logging was on at instantiation; a reset comes back to it.
    pub(crate) logging_on: bool,
    /// Whether the importer handles events in Event Mode.
    pub(crate) event_mode_used: bool,
    /// Whether a step may return before its end.
    pub(crate) early_return_allowed: bool,
    pub(crate) token: Guid,
    pub(crate) machine: Machine<M>,
}

/// Everything of an instance that a saved state holds and a reset renews.
#[derive(Clone)]
pub(crate) struct Machine<M> {
    pub(crate) state: CallState,
    pub(crate) run: Run<M>,
    pub(crate) tick: Tick,
}

/// Where the clock stands.
#[derive(Clone, Copy)]
pub(crate) struct Tick {
    /// Its variable has changed, which Event Mode has not been entered for yet.
    pub(crate) due: bool,
    /// It ticks now.
    pub(crate) active: bool,
    /// Sample time of the last tick, s.
    pub(crate) time_s: f64,
}

/// What became of a step.
pub(crate) struct Stepped {
    pub(crate) status: fmi3Status,
    pub(crate) event_handling_needed: bool,
    pub(crate) early_return: bool,
    pub(crate) last_successful_time_s: f64,
}

/// The Boolean that the clock watches.
fn watched<M: Model>(model: &M, clock: &TriggeredClock<M::Variable>) -> bool {
    let mut truth = false;
    model.get(clock.watched).store_boolean(&mut truth);
    truth
}

impl<M: Model> Machine<M> {
    /// A fresh machine from the baked payload.
    ///
    /// # Errors
    /// Why the payload is of no use.
    pub(crate) fn fresh(payload: &[u8]) -> Result<Self, &'static str> {
        Ok(Self {
            state: CallState::Instantiated,
            run: Run::fresh(payload)?,
            tick: Tick { due: false, active: false, time_s: NO_TICK_TIME },
        })
    }

    /// All fields, for saving and restoring.
    pub(crate) fn archive(&mut self, archive: &mut Archive<'_>) {
        archive.choice(&mut self.state, &CallState::ALL);
        archive.require(self.state != CallState::StartAndEnd);
        archive.flag(&mut self.tick.due);
        archive.flag(&mut self.tick.active);
        archive.finite(&mut self.tick.time_s);
        self.run.archive(archive);
    }
}

impl<M: Model<Variable: Structure>> Instance<M> {
    /// Logs why a call is refused.
    #[cold]
    pub(crate) fn refuse(&self, function: Function, reason: impl FnOnce(&mut Text)) -> fmi3Status {
        self.environment.log().error(|text| reason(text.str(function.name()).str(": ")));
        fmi3Status::fmi3Error
    }

    /// Refuses for a fixed reason.
    #[cold]
    #[inline(never)] // small code
    pub(crate) fn refuse_because(&self, function: Function, reason: &str) -> fmi3Status {
        self.refuse(function, |text| {
            text.str(reason);
        })
    }

    /// Logs why a variable cannot be treated as asked.
    #[cold]
    pub(crate) fn refuse_access(
        &self,
        function: Function,
        refusal: AccessRefusal<'_>,
    ) -> fmi3Status {
        self.refuse(function, |text| match refusal {
            AccessRefusal::WrongType(row) => {
                let kind = type_name(&row.kind);
                text.str("variable \"").str(row.name).str("\" is of type ").str(kind);
            }
            other => other.describe(text),
        })
    }

    /// What a value reference stands for.
    ///
    /// # Errors
    /// The status of the refusal.
    #[inline(never)] // small code
    pub(crate) fn find(
        &self,
        function: Function,
        vr: u32,
    ) -> Result<Entry<M::Variable>, fmi3Status> {
        entry(vr).ok_or_else(|| self.refuse_access(function, AccessRefusal::Unknown(vr)))
    }

    /// The variable, if it may be set to a value now.
    ///
    /// # Errors
    /// The status of the refusal.
    #[inline(never)] // small code
    pub(crate) fn settable(
        &self,
        function: Function,
        variable: M::Variable,
        value: Value<'_>,
    ) -> Result<M::Variable, fmi3Status> {
        let state = self.machine.state;
        let initialised = matches!(state, CallState::EventMode | CallState::StepMode);
        let vr = variable.value_reference();
        access::settable::<M>(vr, value, initialised).ok_or_else(|| {
            self.refuse_access(function, access::refusal_to_set::<M>(vr, value, initialised))
        })
    }

    /// `fmi3EnterInitializationMode`.
    pub(crate) fn set_up(&mut self, start: f64, stop: Option<f64>) -> fmi3Status {
        let period = self.machine.run.model.sample_period_s();
        match Clock::new(start, stop, period) {
            Ok(clock) => {
                self.machine.run.clock = clock;
                self.machine.state = CallState::InitializationMode;
                fmi3Status::fmi3OK
            }
            Err(refusal) => self.refuse(Function::fmi3EnterInitializationMode, |text| {
                refusal.describe(start, stop, period, text);
            }),
        }
    }

    /// `fmi3ExitInitializationMode`.
    pub(crate) fn initialise(&mut self) -> fmi3Status {
        let Run { clock, model, .. } = &mut self.machine.run;
        match model.initialise(clock.start) {
            Ok(()) => {
                self.machine.state =
                    if self.event_mode_used { CallState::EventMode } else { CallState::StepMode };
                fmi3Status::fmi3OK
            }
            Err(reason) => {
                self.machine.state = CallState::Terminated;
                self.refuse_because(Function::fmi3ExitInitializationMode, reason)
            }
        }
    }

    /// `fmi3DoStep`.
    pub(crate) fn do_step(&mut self, point: f64, size: f64) -> Result<Stepped, fmi3Status> {
        let Machine { state, run, tick } = &mut self.machine;
        let step = match run.clock.step(point, size, run.model.sample_period_s()) {
            Ok(step) => step,
            Err(refusal) => {
                return Err(self.refuse(Function::fmi3DoStep, |text| {
                    refusal.describe(point, size, text);
                }));
            }
        };
        let log = self.environment.log();
        let mut status = fmi3Status::fmi3OK;
        if step.displaced {
            status = fmi3Status::fmi3Warning;
            log.warning(|text| {
                text.str("fmi3DoStep: the step begins at ").real(point);
                text.str(" s, but the last one ended at ").real(run.clock.point).str(" s");
            });
        }
        let returns_early = self.event_mode_used && self.early_return_allowed;
        let clock = &<M::Variable as Structure>::CLOCK;
        let mut before = watched(&run.model, clock);
        let mut early_return = false;
        let advanced = run.advance_until(step, &log, |model, time_s| {
            let now = watched(model, clock);
            let changed = now != before;
            before = now;
            if changed {
                tick.due = self.event_mode_used;
                tick.time_s = time_s;
                early_return = returns_early;
            }
            early_return
        });
        status = status.max(advanced.into());
        match status {
            fmi3Status::fmi3Error => *state = CallState::Terminated,
            fmi3Status::fmi3Fatal => *state = CallState::Fatal,
            _ => {}
        }
        Ok(Stepped {
            status,
            event_handling_needed: tick.due && self.event_mode_used,
            early_return,
            last_successful_time_s: run.clock.point,
        })
    }

    /// `fmi3EnterEventMode`.
    pub(crate) fn enter_event_mode(&mut self) -> fmi3Status {
        if !self.event_mode_used {
            let reason = "the importer said at instantiation that it does not use Event Mode";
            return self.refuse_because(Function::fmi3EnterEventMode, reason);
        }
        let Machine { state, tick, .. } = &mut self.machine;
        *state = CallState::EventMode;
        *tick = Tick { due: false, active: tick.due, ..*tick };
        fmi3Status::fmi3OK
    }

    /// The machine that a serialised state describes.
    ///
    /// # Errors
    /// The status of the refusal, if it is not one of this FMU's.
    pub(crate) fn restored(
        &self,
        function: Function,
        state: &[u8],
    ) -> Result<Machine<M>, fmi3Status> {
        let mut machine = self.machine.clone();
        saved_state::read(state, &self.token, |archive| machine.archive(archive)).map_err(
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
    ) -> fmi3Status {
        self.environment.categories = Categories::NONE;
        if !on {
            return fmi3Status::fmi3OK;
        }
        let (mut named, mut status) = (false, fmi3Status::fmi3OK);
        for name in categories {
            named = true;
            match LogCategory::ALL.into_iter().find(|category| category.name() == name) {
                Some(category) => self.environment.categories.enable(category),
                None => {
                    status = fmi3Status::fmi3Warning;
                    self.environment.log().warning(|text| {
                        text.str("fmi3SetDebugLogging: no category \"").c_str(name).str("\"");
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
