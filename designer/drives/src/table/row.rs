//! What tables say of their columns and rows.

use crate::error::Cause;
use crate::stamp::StampForm;
use crate::unit::Unit;

/// What a file says of a column.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Header {
    /// Its name; its number from 1 where there are no names.
    pub name: String,
    /// Its unit, where a line of units or its type says so.
    pub unit: Option<Unit>,
    /// How its cells are written, where they are time stamps and no numbers.
    pub stamps: Option<StampForm>,
}

/// A row that cannot be read.
#[derive(Debug)]
pub(crate) enum RowError {
    /// A cell that is no number, or no time stamp in a column of them.
    Cell {
        /// Its line.
        line: u64,
        /// Which of the selected columns.
        place: usize,
        /// The cell.
        text: String,
    },
    /// Anything else.
    Other(Cause),
}

impl<C: Into<Cause>> From<C> for RowError {
    fn from(cause: C) -> Self {
        Self::Other(cause.into())
    }
}
