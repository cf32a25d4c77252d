//! Lines that fit a terminal.

/// Columns of the narrowest usual terminal.
pub const WIDTH: usize = 80;

/// The `text` with no line longer than `width` characters, single words apart: what is longer goes on in a further line,
/// below the last column of a table, or below the beginning of the line.
pub fn fitted(text: &str, width: usize) -> String {
    text.split_inclusive('\n').map(|line| fitted_line(line, width)).collect()
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
    fn no_line_is_longer_and_no_word_lost() {
        let line: String = (0..60).map(|k| format!("word{k} ")).collect();
        let text = fitted(&format!("  a     1.5  {line}\n{line}"), WIDTH);
        assert!(text.lines().all(|line| line.chars().count() <= WIDTH), "{text}");
        assert_eq!(text.split_whitespace().count(), 122);
    }
}
