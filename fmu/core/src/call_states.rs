//! Sets of states of a calling sequence, written as rows of a table.

/// A set of states, by column of the table.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct States(u16);

impl States {
    /// No state.
    pub const NONE: Self = Self(0);

    /// Reads a row of a table with so many `columns`: one character for each state, blanks aside, of which
    /// those in `marks` count.
    ///
    /// # Panics
    /// If the row has another number of columns: tables are constants.
    pub const fn from_row(row: &str, marks: &[u8], columns: usize) -> Self {
        let bytes = row.as_bytes();
        let (mut states, mut column, mut i) = (0, 0, 0);
        while i < bytes.len() {
            if bytes[i] != b' ' {
                let mut m = 0;
                while m < marks.len() {
                    if bytes[i] == marks[m] {
                        states |= 1 << column;
                    }
                    m += 1;
                }
                column += 1;
            }
            i += 1;
        }
        assert!(column == columns);
        Self(states)
    }

    /// Whether the state of this column is one of them.
    pub const fn contains(self, column: u8) -> bool {
        self.0 & (1 << column) != 0
    }
}
