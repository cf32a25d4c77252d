//! What a model gives to become an FMU.

use steerguard_model_description::{ModelInfo, Value, VariableSet};

use crate::{Archive, Block, Log, Status};

/// A sampled model. Its inputs are the first variables of its table.
pub trait Model: Clone {
    /// Its variables.
    type Variable: VariableSet;
    /// Name, identifier, description.
    const INFO: ModelInfo;

    /// A fresh model from the payload of the baked block: all inputs and parameters at their start
    /// values.
    ///
    /// # Errors
    /// Why the payload is of no use.
    fn new(payload: &[u8]) -> Result<Self, &'static str>;

    /// Time between samples, s: positive and constant.
    fn sample_period_s(&self) -> f64;

    /// Value of a variable, of the type that the table declares.
    fn get(&self, variable: Self::Variable) -> Value<'_>;

    /// Sets an input or a parameter. The layer has checked the type, that the variable may be set
    /// now and, but for Real inputs, that the value is finite and within its limits. A Real input
    /// may be anything, NaN included.
    fn set(&mut self, variable: Self::Variable, value: Value<'_>);

    /// Called at the end of Initialization Mode with the start time in s.
    ///
    /// # Errors
    /// Why the model cannot start from the parameters it was given.
    fn initialise(&mut self, start_time_s: f64) -> Result<(), &'static str>;

    /// Runs the next sample with the inputs valid at it. With [`Status::Discard`] and worse the step
    /// ends here.
    fn sample(&mut self, log: &Log<'_>) -> Status;

    /// Passes everything that [`Model::new`] would not restore through `archive`, in a fixed order:
    /// inputs, parameters, states, outputs.
    fn archive(&mut self, archive: &mut Archive<'_>);
}

/// A model together with the block its numbers are baked into; made by the macro that exports it.
pub trait Fmu {
    /// The model.
    type Model: Model;

    /// The block in this library.
    fn block() -> &'static Block;
}
