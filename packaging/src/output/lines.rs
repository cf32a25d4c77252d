//! Lines that fit a terminal.

use std::ops::Range;

use super::table::is_number;

/// Columns of the narrowest usual terminal.
pub const WIDTH: usize = 80;

/// The `text` with no line longer than `width` characters, single words apart: what is longer goes on in a further line,
/// below the last column of a table, or below the beginning of the line. A table of many columns comes in parts.
pub fn fitted(text: &str, width: usize) -> String {
    let lines: Vec<&str> = text.split_inclusive('\n').collect();
    let blocks = lines.chunk_by(|a, b| a.starts_with("  ") == b.starts_with("  "));
    let block = |block: &[&str]| {
        let line_by_line = || block.iter().map(|line| fitted_line(line, width)).collect();
        in_parts(block, width).unwrap_or_else(line_by_line)
    };
    blocks.map(block).collect()
}

/// Columns from which on lines are taken for a table that can be parted.
const MANY: usize = 5;

/// Lines of a table too wide, one part below the other, each with the columns that say which row it is: those on the left
/// without numbers.
fn in_parts(lines: &[&str], width: usize) -> Option<String> {
    let lines: Vec<Vec<char>> =
        lines.iter().map(|line| line.trim_end().chars().collect()).collect();
    let longest = lines.iter().map(Vec::len).max().filter(|&longest| longest > width)?;
    let blank = |at: usize| lines.iter().all(|line| line.get(at).is_none_or(|&c| c == ' '));
    // A column begins behind two spaces.
    let begins: Vec<usize> =
        (2..longest).filter(|&at| !blank(at) && blank(at - 1) && blank(at - 2)).collect();
    let ends = begins.iter().skip(1).map(|begin| begin - 2).chain([longest]);
    let columns: Vec<_> = begins.iter().zip(ends).map(|(&begin, end)| begin..end).collect();
    let cell = |line: &[char], column: &Range<usize>| -> String {
        let end = column.end.min(line.len());
        line.get(column.start.min(end)..end).unwrap_or_default().iter().collect()
    };
    let is_label =
        |column: &&Range<usize>| !lines.iter().any(|line| is_number(cell(line, column).trim()));
    let labels = columns.iter().take_while(is_label).count();
    if columns.len() < MANY || labels == 0 || labels == columns.len() {
        return None;
    }
    let size =
        |columns: &[Range<usize>]| columns.iter().map(|column| column.len() + 2).sum::<usize>();
    let (labels, mut left) = columns.split_at(labels);
    let mut text = String::new();
    while !left.is_empty() {
        let fit = (1..=left.len())
            .take_while(|&count| size(labels) + size(&left[..count]) <= width)
            .last()?;
        let (part, rest) = left.split_at(fit);
        for line in &lines {
            let cells = labels.iter().chain(part);
            let whole: String =
                cells.map(|column| format!("  {:<1$}", cell(line, column), column.len())).collect();
            text += &(whole.trim_end().to_owned() + "\n");
        }
        left = rest;
        if !left.is_empty() {
            text.push('\n');
        }
    }
    Some(text)
}

fn fitted_line(line: &str, width: usize) -> String {
    let (content, end) = line.strip_suffix('\n').map_or((line, ""), |line| (line, "\n"));
    if content.chars().count() <= width {
        return line.to_owned();
    }
    let indent = hanging_indent(content, width);
    let mut fitted = String::new();
    let mut length = 0;
    // Spaces go with the word behind them, and are dropped where a line is begun.
    for part in content.split_inclusive(' ') {
        let word = part.trim_end_matches(' ');
        if length + word.chars().count() > width && length > indent {
            fitted.truncate(fitted.trim_end().len());
            fitted.push('\n');
            fitted.extend(std::iter::repeat_n(' ', indent));
            length = indent;
            if word.is_empty() {
                continue;
            }
        }
        fitted.push_str(part);
        length += part.chars().count();
    }
    fitted.truncate(fitted.trim_end().len());
    fitted + end
}

/// Where lines go on that a line too long is broken into.
fn hanging_indent(line: &str, width: usize) -> usize {
    let begin = line.chars().take_while(|&c| c == ' ').count();
    // A column begins behind two spaces.
    let columns = line.match_indices("  ").map(|(at, gap)| {
        let behind = &line[at + gap.len()..];
        let spaces = behind.len() - behind.trim_start_matches(' ').len();
        line[..at + gap.len() + spaces].chars().count()
    });
    columns.filter(|&column| column > begin && column <= width / 2).last().unwrap_or(begin + 2)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_lines_go_on_below_their_last_column() {
        let text = "  status   1.0  words that are long\nshort\n";
        assert_eq!(fitted(text, 35), text);
        let expected = "  status   1.0  words that are\n                long\nshort\n";
        assert_eq!(fitted(text, 32), expected);
        assert_eq!(fitted("one two three", 8), "one two\n  three");
        assert_eq!(fitted(&"x".repeat(90), 80), "x".repeat(90), "a word is not broken");
    }

    #[test]
    fn a_table_of_many_columns_comes_in_parts() {
        let rows = [
            ["drives", "h", "alarms", "per h", "largest"],
            ["all", "1.5", "0", "0 [0, 2]", "0.9"],
            ["fast ones", "0.5", "12", "24 [9, 50]", "1.2"],
        ];
        let text =
            super::super::table::aligned(&rows.map(|row| row.map(String::from).to_vec()), "  ");
        assert_eq!(fitted(&text, 45), text);
        let expected = "  drives       h  alarms\n  all        1.5       0\n  fast ones  0.5      12\n\n\
                        \x20 drives     per h       largest\n  all        0 [0, 2]        0.9\n\
                        \x20 fast ones  24 [9, 50]      1.2\n";
        assert_eq!(fitted(&text, 35), expected);
    }

    #[test]
    fn no_line_is_longer_and_no_word_lost() {
        let line: String = (0..60).map(|k| format!("word{k} ")).collect();
        let text = fitted(&format!("  a     1.5  {line}\n{line}"), WIDTH);
        assert!(text.lines().all(|line| line.chars().count() <= WIDTH), "{text}");
        assert_eq!(text.split_whitespace().count(), 122);
    }
}
