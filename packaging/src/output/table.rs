//! Aligned columns of text.

/// Lines with every column padded to its widest cell. Columns of numbers are right-aligned, others
/// left-aligned.
pub fn aligned(rows: &[Vec<String>], indent: &str) -> String {
    let columns = rows.iter().map(Vec::len).max().unwrap_or(0);
    let cells = |column: usize| rows.iter().filter_map(move |row| row.get(column));
    let widths: Vec<usize> = (0..columns)
        .map(|column| cells(column).map(|cell| cell.chars().count()).max().unwrap_or(0))
        .collect();
    let numbers: Vec<bool> = (0..columns)
        .map(|column| cells(column).next_back().is_some_and(|cell| is_number(cell)))
        .collect();
    let mut text = String::new();
    for row in rows {
        let mut line = indent.to_owned();
        for (column, ((cell, &width), &number)) in row.iter().zip(&widths).zip(&numbers).enumerate()
        {
            let gap = if column == 0 { "" } else { "  " };
            line += &if number {
                format!("{gap}{cell:>width$}")
            } else {
                format!("{gap}{cell:<width$}")
            };
        }
        text.push_str(line.trim_end());
        text.push('\n');
    }
    text
}

/// Whether a cell is a number or stands for a missing one.
pub(super) fn is_number(cell: &str) -> bool {
    cell == "-" || cell.parse::<f64>().is_ok()
}

#[cfg(test)]
mod tests {
    use super::aligned;

    #[test]
    fn numbers_are_aligned_on_the_right_and_words_on_the_left() {
        let rows =
            [["a", "size", "z"], ["long", "9", "words"]].map(|row| row.map(String::from).to_vec());
        assert_eq!(aligned(&rows, " "), " a     size  z\n long     9  words\n");
    }
}
