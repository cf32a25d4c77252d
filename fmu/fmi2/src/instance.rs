//! An instance: the state machine of FMI 2.0.4, section 4.2, around a model. No raw pointers here;
//! the C side is in [`boundary`](crate::boundary).

use core::ffi::CStr;

use steerguard_model_description::{
    Causality, Kind, LogCategory, Role, Value, Variability, Variable, VariableSet,
};

use crate::archive::{self, Archive, GUID_LENGTH};
use crate::clock::{Clock, Step, StepRefusal};
use crate::log::Environment;
use crate::types::fmi2Status;
use crate::{CallState, Function, Log, Model, Text};

/// Most inputs a model may have.
pub(crate) const MAX_INPUTS: usize = 16;
/// Highest order of input derivatives.
const MAX_ORDER: usize = 3;

/// A variable with its row of the table.
pub(crate) type Entry<M> = (<M as Model>::Variable, &'static Variable);

/// An instance as the importer holds it.
pub(crate) struct Instance<M> {
    pub(crate) environment: Environment,
    /// Whether logging was on at instantiation; a reset comes back to it.
    pub(crate) logging_on: bool,
    pub(crate) guid: Guid,
    pub(crate) machine: Machine<M>,
}

/// GUID of the FMU, padded with NUL: saved states carry it.
#[derive(Clone, Copy, PartialEq)]
pub(crate) struct Guid(pub(crate) [u8; GUID_LENGTH]);

impl Guid {
    pub(crate) fn new(guid: &str) -> Self {
        let mut bytes = [0; GUID_LENGTH];
        archive::copy(guid.as_bytes(), &mut bytes);
        Self(bytes)
    }
}

/// Everything of an instance that a saved state holds and a reset renews.
#[derive(Clone)]
pub(crate) struct Machine<M> {
    pub(crate) state: CallState,
    pub(crate) clock: Clock,
    derivatives: InputDerivatives,
    pub(crate) model: M,
}

/// Time derivatives of the inputs at the communication point, valid for the next step.
#[derive(Clone, Copy)]
struct InputDerivatives {
    /// By value reference of the input, then by order less one.
    orders: [[f64; MAX_ORDER]; MAX_INPUTS],
    /// Whether any was set.
    given: bool,
}

impl InputDerivatives {
    const NONE: Self = Self { orders: [[0.0; MAX_ORDER]; MAX_INPUTS], given: false };
}

impl<M: Model> Machine<M> {
    const INPUTS: &'static [M::Variable] = inputs::<M>();

    /// A fresh machine from the baked payload.
    ///
    /// # Errors
    /// Why the payload is of no use.
    pub(crate) fn fresh(payload: &[u8]) -> Result<Self, &'static str> {
        let model = M::new(payload)?;
        let period = model.sample_period_s();
        if !(period > 0.0 && period.is_finite()) {
            return Err("the sample period baked into this library is not positive");
        }
        Ok(Self {
            state: CallState::Instantiated,
            clock: Clock::new(0.0, None),
            derivatives: InputDerivatives::NONE,
            model,
        })
    }

    /// All fields, for saving and restoring.
    pub(crate) fn archive(&mut self, archive: &mut Archive<'_>) {
        archive.choice(&mut self.state, &CallState::ALL);
        archive.require(self.state != CallState::StartAndEnd);
        self.clock.archive(archive);
        archive.flag(&mut self.derivatives.given);
        for value in self.derivatives.orders.as_flattened_mut() {
            archive.real(value);
        }
        self.model.archive(archive);
        // Or the next step would make up for them all.
        let missed = self.clock.sample_before(self.clock.point, self.model.sample_period_s());
        archive.require(missed.is_none());
    }

    fn run(&mut self, step: Step, log: &Log<'_>) -> fmi2Status {
        let period = self.model.sample_period_s();
        let inputs = self.derivatives.given.then(|| self.inputs());
        let mut status = fmi2Status::fmi2OK;
        while let Some(time) = self.clock.sample_before(step.end, period) {
            if let Some(inputs) = &inputs {
                self.extrapolate(inputs, time - step.point);
            }
            status = status.max(self.model.sample(log));
            if status >= fmi2Status::fmi2Discard {
                self.clock.point = time;
                break;
            }
            self.clock.next_sample += 1;
        }
        if let Some(inputs) = &inputs {
            self.extrapolate(inputs, 0.0);
            self.derivatives = InputDerivatives::NONE;
        }
        if status < fmi2Status::fmi2Discard {
            self.clock.point = step.end;
        }
        status
    }

    /// Values of the Real inputs, by value reference.
    fn inputs(&self) -> [f64; MAX_INPUTS] {
        let mut values = [0.0; MAX_INPUTS];
        for (place, &input) in values.iter_mut().zip(Self::INPUTS) {
            self.model.get(input).store_real(place);
        }
        values
    }

    /// Sets the Real inputs to their Taylor series `after` s past the communication point.
    fn extrapolate(&mut self, inputs: &[f64; MAX_INPUTS], after: f64) {
        let series = inputs.iter().zip(&self.derivatives.orders).zip(Self::INPUTS);
        for ((value, [first, second, third]), &input) in series {
            if [first, second, third].iter().any(|&&derivative| derivative != 0.0) {
                let slope = first + after / 2.0 * (second + after / 3.0 * third);
                let value = if after == 0.0 { *value } else { value + after * slope };
                self.model.set(input, Value::Real(value));
            }
        }
    }
}

/// The inputs, which come first in the table.
const fn inputs<M: Model>() -> &'static [M::Variable] {
    let table = <M::Variable as VariableSet>::TABLE;
    let mut count = 0;
    let mut i = 0;
    while i < table.len() {
        if matches!(table[i].role.causality, Causality::Input) {
            assert!(i == count, "inputs must come first in the table");
            count += 1;
        }
        i += 1;
    }
    assert!(count <= MAX_INPUTS, "too many inputs");
    let (inputs, _) = <M::Variable as VariableSet>::ALL.split_at(count);
    inputs
}

/// Whether a variable of this role may be set in a state: FMI 2.0.4, section 4.2.4, except that
/// inputs are taken before Initialization Mode too.
fn may_set(role: Role, state: CallState) -> bool {
    match (role.causality, role.variability) {
        (Causality::Input, _) | (Causality::Parameter, Variability::Tunable) => true,
        (Causality::Parameter, _) => state != CallState::StepComplete,
        (Causality::Output | Causality::Local, _) => false,
    }
}

/// Real inputs may be set to anything: what a model does with NaN is its own affair.
#[inline]
fn is_real_input(row: &Variable, value: Value<'_>) -> bool {
    row.role.causality == Causality::Input
        && matches!((&row.kind, value), (Kind::Real(_), Value::Real(_)))
}

impl<M: Model> Instance<M> {
    /// Logs why a call is refused.
    #[cold]
    pub(crate) fn refuse(&self, function: Function, reason: impl FnOnce(&mut Text)) -> fmi2Status {
        self.environment.log(LogCategory::StatusError, fmi2Status::fmi2Error, |text| {
            reason(text.str(function.name()).str(": "));
        });
        fmi2Status::fmi2Error
    }

    /// Finds a variable.
    ///
    /// # Errors
    /// The status of the refusal.
    pub(crate) fn find(&self, function: Function, vr: u32) -> Result<Entry<M>, fmi2Status> {
        let index = vr as usize;
        let variable = <M::Variable as VariableSet>::ALL.get(index);
        match variable.zip(<M::Variable as VariableSet>::TABLE.get(index)) {
            Some((variable, row)) => Ok((*variable, row)),
            None => Err(self.refuse(function, |text| {
                text.str("no variable has value reference ").integer(vr.into());
            })),
        }
    }

    /// Refuses to treat a variable in a certain way.
    #[cold]
    pub(crate) fn refuse_variable(
        &self,
        function: Function,
        row: &Variable,
        reason: &str,
    ) -> fmi2Status {
        self.refuse(function, |text| {
            text.str("variable \"").str(row.name).str("\" ").str(reason);
        })
    }

    /// Refuses to access a variable of another type.
    #[cold]
    pub(crate) fn wrong_type(&self, function: Function, row: &Variable) -> fmi2Status {
        self.refuse(function, |text| {
            text.str("variable \"").str(row.name).str("\" is of type ").str(row.kind.name());
        })
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
        let variable = <M::Variable as VariableSet>::ALL.get(vr as usize);
        let row = <M::Variable as VariableSet>::TABLE.get(vr as usize);
        match variable.zip(row) {
            Some((variable, row))
                if is_real_input(row, value)
                    || may_set(row.role, self.machine.state) && row.kind.admits(value) =>
            {
                Ok(*variable)
            }
            _ => Err(self.refuse_to_set(function, vr, value)),
        }
    }

    #[cold]
    fn refuse_to_set(&self, function: Function, vr: u32, value: Value<'_>) -> fmi2Status {
        match self.find(function, vr) {
            Err(status) => status,
            Ok((_, row)) if !row.kind.is_type_of(value) => self.wrong_type(function, row),
            Ok((_, row)) if !may_set(row.role, self.machine.state) => {
                self.not_settable(function, row)
            }
            Ok((_, row)) => self.out_of_range(function, row, value),
        }
    }

    fn not_settable(&self, function: Function, row: &Variable) -> fmi2Status {
        let reason = match (row.role.causality, row.role.variability) {
            (Causality::Output, _) => "is an output and cannot be set",
            (_, Variability::Constant) => "is a constant and cannot be set",
            (Causality::Local, _) => "is a local variable and cannot be set",
            _ => "is a fixed parameter and cannot be set after initialization",
        };
        self.refuse_variable(function, row, reason)
    }

    fn out_of_range(&self, function: Function, row: &Variable, value: Value<'_>) -> fmi2Status {
        self.refuse(function, |text| {
            text.str("variable \"").str(row.name).str("\" cannot be ");
            match value {
                Value::Real(value) => text.real(value),
                Value::Integer(value) => text.integer(value.into()),
                Value::Boolean(_) | Value::String(_) => text.str("that"),
            };
            text.str(": finite values between min and max are allowed");
        })
    }

    /// Sets derivatives of inputs, given as value reference, order and value: all or none.
    pub(crate) fn set_derivatives(
        &mut self,
        given: impl Iterator<Item = (u32, i32, f64)>,
    ) -> Result<(), fmi2Status> {
        let function = Function::fmi2SetRealInputDerivatives;
        let mut derivatives = self.machine.derivatives;
        for (vr, order, value) in given {
            let (_, row) = self.find(function, vr)?;
            if row.role.causality != Causality::Input {
                return Err(self.refuse_variable(function, row, "is not an input"));
            }
            if !row.kind.is_type_of(Value::Real(value)) {
                return Err(self.wrong_type(function, row));
            }
            let orders = derivatives.orders.get_mut(vr as usize);
            let index = order.checked_sub(1).and_then(|index| usize::try_from(index).ok());
            match orders.zip(index).and_then(|(orders, index)| orders.get_mut(index)) {
                Some(place) => *place = value,
                None => {
                    return Err(self.refuse(function, |text| {
                        text.str("derivatives of order ").integer(order.into());
                        text.str(" cannot be used, only 1 to ").integer(MAX_ORDER as i64);
                    }));
                }
            }
            derivatives.given = true;
        }
        self.machine.derivatives = derivatives;
        Ok(())
    }

    /// `fmi2SetupExperiment`.
    pub(crate) fn set_up(&mut self, start: f64, stop: Option<f64>) -> fmi2Status {
        let ordered = stop.is_none_or(|stop| stop.is_finite() && stop >= start);
        if !(start.is_finite() && ordered) {
            return self.refuse(Function::fmi2SetupExperiment, |text| {
                text.str("no run can last from ").real(start).str(" s to ");
                text.real(stop.unwrap_or(f64::INFINITY)).str(" s");
            });
        }
        self.machine.clock = Clock::new(start, stop);
        fmi2Status::fmi2OK
    }

    /// `fmi2ExitInitializationMode`.
    pub(crate) fn initialise(&mut self) -> fmi2Status {
        match self.machine.model.initialise(self.machine.clock.start) {
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
        let period = self.machine.model.sample_period_s();
        let step = match self.machine.clock.step(point, size, period) {
            Ok(step) => step,
            Err(refusal) => return self.refuse_step(point, size, refusal),
        };
        let mut status = fmi2Status::fmi2OK;
        if step.displaced {
            status = fmi2Status::fmi2Warning;
            self.environment.log(LogCategory::StatusWarning, status, |text| {
                text.str("fmi2DoStep: the step begins at ").real(point);
                text.str(" s, but the last one ended at ").real(self.machine.clock.point).str(" s");
            });
        }
        status = status.max(self.machine.run(step, &Log::new(&self.environment)));
        if status >= fmi2Status::fmi2Discard {
            self.machine.state = match status {
                fmi2Status::fmi2Discard => CallState::StepFailed,
                fmi2Status::fmi2Error => CallState::Error,
                _ => CallState::Fatal,
            };
        }
        status
    }

    #[cold]
    fn refuse_step(&self, point: f64, size: f64, refusal: StepRefusal) -> fmi2Status {
        self.refuse(Function::fmi2DoStep, |text| {
            text.str("a step of ").real(size).str(" s from ").real(point).str(" s ");
            match refusal {
                StepRefusal::NotASpan => text.str("is not a positive, finite span of time"),
                StepRefusal::WrongPoint(expected) => text
                    .str("does not begin where the last one ended, at ")
                    .real(expected)
                    .str(" s"),
                StepRefusal::PastStopTime(stop) => {
                    text.str("ends after the stop time ").real(stop).str(" s")
                }
                StepRefusal::TooFar => text.str("ends too far from the start time"),
            };
        })
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
        archive::read(state, &self.guid, |archive| machine.archive(archive)).map_err(|reason| {
            self.refuse(function, |text| {
                text.str("the state cannot be restored: ").str(reason);
            })
        })?;
        Ok(machine)
    }

    /// Turns logging on for the named categories, for all if none is named, or off.
    pub(crate) fn set_logging<'c>(
        &mut self,
        on: bool,
        categories: impl Iterator<Item = &'c CStr>,
    ) -> fmi2Status {
        self.environment.disable_all();
        if !on {
            return fmi2Status::fmi2OK;
        }
        let (mut named, mut status) = (false, fmi2Status::fmi2OK);
        for name in categories {
            named = true;
            match LogCategory::ALL.into_iter().find(|category| category.name() == name) {
                Some(category) => self.environment.enable(category),
                None => {
                    status = fmi2Status::fmi2Warning;
                    self.environment.log(LogCategory::StatusWarning, status, |text| {
                        text.str("fmi2SetDebugLogging: no category \"").c_str(name).str("\"");
                    });
                }
            }
        }
        if !named {
            self.environment.enable(LogCategory::All);
        }
        status
    }
}
