//! What became of a sample or a step.

/// From best to worst.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Status {
    /// All well.
    Ok,
    /// Not quite right, but the computation can continue.
    Warning,
    /// Not done: the importer decides what to do instead.
    Discard,
    /// Failed: the instance is of no use any more.
    Error,
    /// The whole FMU is broken.
    Fatal,
}

impl Status {
    /// Whether the computation can go on.
    pub const fn goes_on(self) -> bool {
        matches!(self, Self::Ok | Self::Warning)
    }
}
