//! A model on its clock: what a saved state holds and a reset renews, whatever the FMI version.

use steerguard_model_description::{Causality, Value, VariableSet};

use crate::access::find;
use crate::clock::{Clock, Step};
use crate::derivatives::{InputDerivatives, MAX_INPUTS, MAX_ORDER};
use crate::refusal::AccessRefusal;
use crate::{Archive, Log, Model, Status};

/// A model on its clock.
#[derive(Clone)]
pub struct Run<M> {
    /// Where the run stands.
    pub clock: Clock,
    derivatives: InputDerivatives,
    /// The model.
    pub model: M,
}

impl<M: Model> Run<M> {
    const INPUTS: &'static [M::Variable] = inputs::<M>();

    /// A fresh run of the model that the baked payload describes.
    ///
    /// # Errors
    /// Why the payload is of no use.
    pub fn fresh(payload: &[u8]) -> Result<Self, &'static str> {
        let model = M::new(payload)?;
        let period = model.sample_period_s();
        if !(period > 0.0 && period.is_finite()) {
            return Err("the sample period baked into this library is not positive");
        }
        Ok(Self { clock: Clock::ZERO, derivatives: InputDerivatives::NONE, model })
    }

    /// All fields, for saving and restoring.
    pub fn archive(&mut self, archive: &mut Archive<'_>) {
        self.clock.archive(self.model.sample_period_s(), archive);
        archive.flag(&mut self.derivatives.given);
        for value in self.derivatives.orders.as_flattened_mut() {
            archive.real(value);
        }
        self.model.archive(archive);
    }

    /// Runs the samples of a step that the clock has accepted; the worst of their statuses.
    pub fn advance(&mut self, step: Step, log: &Log<'_>) -> Status {
        self.advance_until(step, log, |_, _| false)
    }

    /// The same, but the step ends at the time of the first sample after which `is_over` says so of the
    /// model and that time, s.
    pub fn advance_until(
        &mut self,
        step: Step,
        log: &Log<'_>,
        mut is_over: impl FnMut(&M, f64) -> bool,
    ) -> Status {
        let period = self.model.sample_period_s();
        let inputs = self.derivatives.given.then(|| self.inputs());
        let mut status = Status::Ok;
        let mut end = step.end;
        while let Some(time) = self.clock.sample_before(step.end, period) {
            if let Some(inputs) = &inputs {
                self.extrapolate(inputs, time - step.point);
            }
            status = status.max(self.model.sample(log));
            if !status.goes_on() {
                self.clock.point = time;
                break;
            }
            self.clock.next_sample += 1;
            if is_over(&self.model, time) {
                end = time.max(step.point);
                break;
            }
        }
        if let Some(inputs) = &inputs {
            self.extrapolate(inputs, 0.0);
            self.derivatives = InputDerivatives::NONE;
        }
        if status.goes_on() {
            self.clock.point = end;
        }
        status
    }

    /// Sets derivatives of inputs for the next step, given as value reference, order and value: all
    /// or none.
    ///
    /// # Errors
    /// Why they are refused.
    pub fn set_derivatives(
        &mut self,
        given: impl Iterator<Item = (u32, i32, f64)>,
    ) -> Result<(), AccessRefusal<'static>> {
        let mut derivatives = self.derivatives;
        for (vr, order, value) in given {
            let (_, row) = find::<M>(vr)?;
            if row.role.causality != Causality::Input {
                return Err(AccessRefusal::NotAnInput(row));
            }
            if !row.kind.is_type_of(Value::Real(value)) {
                return Err(AccessRefusal::WrongType(row));
            }
            let orders = derivatives.orders.get_mut(vr as usize);
            let index = order.checked_sub(1).and_then(|index| usize::try_from(index).ok());
            match orders.zip(index).and_then(|(orders, index)| orders.get_mut(index)) {
                Some(place) => *place = value,
                None => return Err(AccessRefusal::Order { order, highest: MAX_ORDER }),
            }
            derivatives.given = true;
        }
        self.derivatives = derivatives;
        Ok(())
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
