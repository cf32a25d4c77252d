//! Aligned columns of text.

/// Lines with every column padded to its widest cell; cells are right-aligned, those of the first
/// column left-aligned where `names` is set.
pub fn aligned(rows: &[Vec<String>], indent: &str, names: bool) -> String {
    let columns = rows.iter().map(Vec::len).max().unwrap_or(0);
    let width = |column: usize| {
        rows.iter().filter_map(|row| row.get(column)).map(|cell| cell.chars().count()).max()
    };
    let widths: Vec<usize> = (0..columns).map(|column| width(column).unwrap_or(0)).collect();
    let mut text = String::new();
    for row in rows {
        let mut line = indent.to_owned();
        for (column, (cell, &width)) in row.iter().zip(&widths).enumerate() {
            let gap = if column == 0 { "" } else { "  " };
            let padded = if names && column == 0 {
                format!("{gap}{cell:<width$}")
            } else {
                format!("{gap}{cell:>width$}")
            };
            line.push_str(&padded);
        }
        text.push_str(line.trim_end());
        text.push('\n');
    }
    text
}

#[cfg(test)]
mod tests {
    use super::aligned;

    #[test]
    fn columns_are_as_wide_as_their_widest_cell() {
        let rows = [["a", "10"], ["long", "9"]].map(|row| row.map(String::from).to_vec());
        assert_eq!(aligned(&rows, " ", true), " a     10\n long   9\n");
        assert_eq!(aligned(&rows, "", false), "   a  10\nlong   9\n");
    }
}
