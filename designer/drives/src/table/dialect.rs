//! How a text is a table: delimiter, decimal mark, and which lines are names, units and numbers.
//!
//! # Conventions
//! Candidates are judged by the first lines of the file: the most numbers less the fewest words, in lines of
//! the same number of cells. Time stamps count as numbers. Where several are as good, the first of [`DELIMITERS`]
//! and the decimal point win.

use super::row::Header;
use crate::error::Cause;
use crate::stamp::{Stamp, StampForm};
use crate::unit::Unit;

/// Delimiters that are looked for.
const DELIMITERS: [u8; 5] = *b";\t|, ";
/// Decimal marks that are looked for.
const DECIMAL_MARKS: [u8; 2] = *b".,";
/// Lines that are judged.
const LINES: usize = 200;

/// How a text is a table.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Dialect {
    /// Between cells.
    pub delimiter: u8,
    /// Before decimals.
    pub decimal_mark: u8,
    /// Whether cells stand in quotes. Where none does, a stray quote shall not swallow the rest of the file.
    pub quoted: bool,
    /// The columns.
    pub headers: Vec<Header>,
    /// Lines before the first one of numbers.
    pub lines_before: u64,
    /// Bytes before it.
    pub bytes_before: u64,
}

/// A line of the file's beginning.
struct Line<'a> {
    text: &'a [u8],
    begin: usize,
    number: u64,
}

/// A number as it stands in a cell: NaN where there is none, `None` where the cell is something else.
pub(super) fn number(cell: &[u8], decimal_mark: u8) -> Option<f64> {
    let cell = cell.trim_ascii();
    let parsed = if decimal_mark == b',' && cell.contains(&b',') {
        let point: Vec<u8> = cell.iter().map(|&b| if b == b',' { b'.' } else { b }).collect();
        // A point beside the comma groups thousands, which nobody can tell from a decimal one.
        if cell.contains(&b'.') {
            return None;
        }
        std::str::from_utf8(&point).ok()?.parse::<f64>().ok()
    } else {
        std::str::from_utf8(cell).ok()?.parse::<f64>().ok()
    };
    match parsed {
        Some(number) if number.is_finite() => Some(number),
        // What Rust reads as infinite or not a number.
        Some(_) => Some(f64::NAN),
        None if is_none(cell) => Some(f64::NAN),
        None => None,
    }
}

/// What loggers write where there is no number.
pub(super) fn is_none(cell: &[u8]) -> bool {
    let cell = cell.trim_ascii();
    cell.is_empty()
        || [
            &b"na"[..],
            b"nan",
            b"nat",
            b"n/a",
            b"null",
            b"none",
            b"-",
            b"--",
            b"-nan",
            b"1.#qnan",
            b"-1.#ind",
        ]
        .iter()
        .any(|none| cell.eq_ignore_ascii_case(none))
}

/// Whether a cell has a number or a time stamp; `None` where it is something else.
fn is_value(cell: &[u8], decimal_mark: u8) -> Option<bool> {
    match number(cell, decimal_mark) {
        Some(number) => Some(!number.is_nan()),
        None => Stamp::parse(cell).map(|_| true),
    }
}

/// The cells of a line.
fn cells(line: &[u8], delimiter: u8) -> Vec<Vec<u8>> {
    let mut reader = csv::ReaderBuilder::new()
        .delimiter(delimiter)
        .has_headers(false)
        .flexible(true)
        .from_reader(line);
    let record = reader.byte_records().next().and_then(Result::ok).unwrap_or_default();
    record.iter().map(<[u8]>::to_vec).collect()
}

/// A line without the mark of a comment.
fn uncommented(line: &[u8]) -> &[u8] {
    let line = line.trim_ascii_start();
    [&b"#"[..], b"%", b"//"].iter().find_map(|mark| line.strip_prefix(*mark)).unwrap_or(line)
}

impl Dialect {
    /// Finds how the text is a table that begins with `begin`, whole lines of it.
    pub fn find(
        begin: &[u8],
        delimiter: Option<u8>,
        decimal_mark: Option<u8>,
    ) -> Result<Self, Cause> {
        let lines = lines(begin);
        let delimiters = delimiter.map_or(DELIMITERS.to_vec(), |told| vec![told]);
        let marks = decimal_mark.map_or(DECIMAL_MARKS.to_vec(), |told| vec![told]);
        let mut best: Option<(i64, u8, u8, usize)> = None;
        for &delimiter in &delimiters {
            let split: Vec<_> = lines.iter().map(|line| cells(line.text, delimiter)).collect();
            for &mark in marks.iter().filter(|&&mark| mark != delimiter || delimiter == b',') {
                let Some((score, width)) = score(&split, mark) else { continue };
                if best.is_none_or(|(least, ..)| score > least) {
                    best = Some((score, delimiter, mark, width));
                }
            }
        }
        match best {
            Some((_, delimiter, mark, width)) => Self::of(&lines, delimiter, mark, width),
            None => Err(without_table(&lines)),
        }
    }

    /// Finds names, units and the first line of numbers among `lines`.
    fn of(lines: &[Line<'_>], delimiter: u8, mark: u8, width: usize) -> Result<Self, Cause> {
        let numbers = |line: &Line<'_>| {
            let cells = cells(line.text, delimiter);
            let is_number = |cell: &&Vec<u8>| is_value(cell, mark) == Some(true);
            (cells.len() == width).then(|| cells.iter().filter(is_number).count())
        };
        let mut counts: Vec<usize> = lines.iter().filter_map(numbers).filter(|&n| n > 0).collect();
        counts.sort_unstable();
        let typical = counts.get(counts.len() / 2).copied().unwrap_or(1);
        // A name may be a number, and so may a word of the lines before.
        let is_row = |line: &Line<'_>| numbers(line).is_some_and(|n| n > 0 && 2 * n >= typical);
        let first = lines.iter().position(is_row).ok_or(Cause::NoRows)?;
        let words = |line: &Line<'_>| {
            let cells = cells(uncommented(line.text), delimiter);
            let word = |cell: &Vec<u8>| text(cell).trim().to_owned();
            (cells.len() == width).then(|| cells.iter().map(word).collect::<Vec<String>>())
        };
        let mut above = lines[..first].iter().rev().filter_map(words);
        let (mut names, mut units) = (above.next(), None);
        if let Some(last) = names.as_ref().filter(|last| are_units(last)) {
            let before = above.next();
            if before.is_some() {
                units = Some(last.clone());
                names = before;
            }
        }
        // By the first cell with anything in it.
        let stamps = |column: usize| -> Option<StampForm> {
            let rows = lines[first..].iter().map(|line| cells(line.text, delimiter));
            let mut column = rows.filter_map(|cells| cells.get(column).cloned());
            Stamp::parse(&column.find(|cell| !is_none(cell))?).map(|stamp| stamp.form)
        };
        let header = |column: usize| {
            let cell =
                |row: &Option<Vec<String>>| row.as_ref().and_then(|r| r.get(column).cloned());
            let name = cell(&names).filter(|name| !name.is_empty());
            Header {
                name: name.unwrap_or_else(|| (column + 1).to_string()),
                unit: cell(&units)
                    .and_then(|unit| Unit::parse(unit.trim_matches(['[', ']', '(', ')']))),
                stamps: stamps(column),
            }
        };
        let row = &lines[first];
        Ok(Self {
            delimiter,
            decimal_mark: mark,
            quoted: lines[first..].iter().any(|line| line.text.contains(&b'"')),
            headers: (0..width).map(header).collect(),
            lines_before: row.number - 1,
            bytes_before: row.begin as u64,
        })
    }
}

/// The first lines that have something.
fn lines(begin: &[u8]) -> Vec<Line<'_>> {
    let mut lines = Vec::new();
    let mut at = if begin.starts_with(b"\xef\xbb\xbf") { 3 } else { 0 };
    for (index, text) in begin[at..].split(|&byte| byte == b'\n').enumerate() {
        let line = Line { text: text.trim_ascii_end(), begin: at, number: index as u64 + 1 };
        at += text.len() + 1;
        if !line.text.trim_ascii().is_empty() {
            lines.push(line);
        }
        if lines.len() == LINES {
            break;
        }
    }
    lines
}

/// Numbers less words in the lines of the most frequent number of cells, and that number; `None` where
/// there is no table. Lines with more words than numbers are none of its rows.
fn score(split: &[Vec<Vec<u8>>], mark: u8) -> Option<(i64, usize)> {
    let judge = |cell: &Vec<u8>| is_value(cell, mark).map_or(-1, i64::from);
    let judged = split.iter().filter(|cells| cells.len() > 1);
    let judged = judged.map(|cells| (cells.len(), cells.iter().map(judge).sum::<i64>()));
    let rows: Vec<_> = judged.filter(|(_, score)| *score > 0).collect();
    let often = |width: usize| rows.iter().filter(|(other, _)| *other == width).count();
    let width = rows.iter().map(|(width, _)| *width).max_by_key(|&width| (often(width), width))?;
    let score = rows.iter().filter(|(other, _)| *other == width).map(|(_, score)| score).sum();
    Some((score, width))
}

/// Whether a line is one of units.
fn are_units(words: &[String]) -> bool {
    let is_unit = |word: &String| {
        let word = word.trim_matches(['[', ']', '(', ')']);
        Unit::parse(word).is_some() || matches!(word, "" | "-" | "1" | "%")
    };
    let units =
        words.iter().filter(|word| Unit::parse(word.trim_matches(['[', ']', '(', ')'])).is_some());
    // A column may be called `g` or `s`.
    units.count() > 1 && words.iter().filter(|word| is_unit(word)).count() * 2 > words.len()
}

/// Why there is no table.
fn without_table(lines: &[Line<'_>]) -> Cause {
    let is_number = |line: &&Line<'_>| {
        DECIMAL_MARKS.iter().any(|&mark| number(line.text, mark).is_some_and(|x| !x.is_nan()))
    };
    match lines.first() {
        None => Cause::Empty,
        Some(first) if lines.iter().filter(is_number).count() > 0 => {
            Cause::SingleColumn { name: text(first.text) }
        }
        Some(_) => Cause::NoRows,
    }
}

/// Bytes as text: UTF-8, or else Latin-1.
fn text(bytes: &[u8]) -> String {
    let latin_1 = || bytes.iter().map(|&byte| char::from(byte)).collect();
    std::str::from_utf8(bytes).map_or_else(|_| latin_1(), str::to_owned)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(text: &str) -> Dialect {
        Dialect::find(text.as_bytes(), None, None).unwrap()
    }

    fn names(dialect: &Dialect) -> Vec<&str> {
        dialect.headers.iter().map(|header| header.name.as_str()).collect()
    }

    #[test]
    fn delimiter_and_decimal_mark_are_found() {
        for (text, delimiter, mark) in [
            ("a,b\n1.5,2\n3,4.25\n", b',', b'.'),
            ("a;b\n1.5;2\n3;4.25\n", b';', b'.'),
            ("a;b\n1,5;2\n3;4,25\n", b';', b','),
            ("a\tb\n1,5\t2\n3\t4,25\n", b'\t', b','),
            ("a b\n1.5 2\n3 4.25\n", b' ', b'.'),
            ("a, b\n1.5, 2\n3, 4.25\n", b',', b'.'),
            ("a|b\n1.5|2\n", b'|', b'.'),
            ("a,b\n\"1,5\",\"2,0\"\n", b',', b','),
            ("a,b,event\n1.5,2,start of it\n3,4.25,\n", b',', b'.'),
            ("a;b\n1;2\n", b';', b'.'),
            ("t,a,b\n2026-03-01 12:00:00.5,1.5,\n2026-03-01 12:00:01,,2\n", b',', b'.'),
            ("t;a\n12:00:00,5;1,5\n12:00:01,0;2,5\n", b';', b','),
            ("d t a\n2026-03-01 12:00:00.5 1.5\n2026-03-01 12:00:01 2\n", b' ', b'.'),
        ] {
            let dialect = found(text);
            assert_eq!((dialect.delimiter, dialect.decimal_mark), (delimiter, mark), "{text}");
        }
    }

    #[test]
    fn names_units_and_comments_are_found() {
        let text = "Logger 7, of Monday\n\n# a, b\nt,v\n[ms],[km/h]\n1,2\n";
        let dialect = found(text);
        assert_eq!(names(&dialect), ["t", "v"]);
        let units = dialect.headers.iter().map(|header| header.unit.map(|unit| unit.symbol));
        assert_eq!(units.collect::<Vec<_>>(), [Some("ms"), Some("km/h")]);
        assert_eq!(dialect.lines_before, 5);
        assert!(text.as_bytes()[dialect.bytes_before as usize..].starts_with(b"1,2"));

        assert_eq!(names(&found("# t, v\n1,2\n")), ["t", "v"]);
        assert_eq!(names(&found("1,2\n3,4\n")), ["1", "2"]);
        assert_eq!(names(&found("\u{feff}t,v\n1,2\n")), ["t", "v"]);
        let latin_1 = Dialect::find(b"t;\xb0/s\n1;2\n", None, None).unwrap();
        assert_eq!(names(&latin_1), ["t", "°/s"]);
    }

    #[test]
    fn what_is_no_table_is_said() {
        let cause = |text: &str| Dialect::find(text.as_bytes(), None, None).unwrap_err();
        assert!(matches!(cause("\n \n"), Cause::Empty));
        assert!(matches!(cause("a,b\n"), Cause::NoRows));
        assert!(matches!(cause("speed\n1\n2\n"), Cause::SingleColumn { name } if name == "speed"));
    }

    #[test]
    fn cells_without_a_number_are_none_and_words_are_not() {
        for none in ["", " ", "nan", "NaN", "inf", "-", "NULL", "n/a"] {
            assert!(number(none.as_bytes(), b'.').unwrap().is_nan(), "{none}");
        }
        assert_eq!(number(b"x1", b'.'), None);
        assert_eq!(number(b"1,5", b'.'), None);
        assert_eq!(number(b"1.234,5", b','), None);
        assert_eq!(number(b" +1,5e1 ", b','), Some(15.0));
    }
}
