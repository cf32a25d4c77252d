//! What a rule reports, as a compiler would.

use std::collections::BTreeMap;
use std::fmt;

/// Findings of one code that are listed.
const MOST_OF_A_CODE: u64 = 100;
/// Characters of a text in a finding, which may quote what somebody wrote.
const LONGEST: usize = 400;

/// How bad a finding is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Level {
    /// Nothing is wrong, but it could be better.
    Note,
    /// Importers may well cope.
    Warning,
    /// Against the standard.
    Error,
}

impl Level {
    /// The word for it.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Note => "note",
            Self::Warning => "warning",
            Self::Error => "error",
        }
    }
}

/// A finding about an FMU.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Finding {
    /// How bad.
    pub level: Level,
    /// Name of the rule.
    pub code: &'static str,
    /// What is wrong, with the values.
    pub message: String,
    /// File, and line where there is one.
    pub location: String,
    /// What to do.
    pub help: String,
}

/// Findings in the order in which they were found, of each code so many.
#[derive(Debug, Default)]
pub struct Findings {
    list: Vec<Finding>,
    /// How many there were of each code.
    counts: BTreeMap<&'static str, u64>,
}

impl Findings {
    /// Adds a finding; texts are cut to a length that can be read, and shown without control characters.
    pub fn add(&mut self, finding: Finding) {
        let count = self.counts.entry(finding.code).or_default();
        *count += 1;
        if *count <= MOST_OF_A_CODE {
            let Finding { message, location, help, .. } = &finding;
            let [message, location, help] = [message, location, help].map(|text| legible(text));
            self.list.push(Finding { message, location, help, ..finding });
        }
    }

    /// Adds those of another list.
    pub fn extend(&mut self, others: Vec<Finding>) {
        self.list.extend(others);
    }

    /// The list; behind the last of a code how many more there are.
    pub fn into_list(mut self) -> Vec<Finding> {
        for (code, count) in self.counts {
            let more = count.saturating_sub(MOST_OF_A_CODE);
            let last = self.list.iter().rposition(|finding| finding.code == code);
            if let (1.., Some(last)) = (more, last) {
                let finding = Finding {
                    message: format!("and {more} more"),
                    help: "mend those above, and examine it again".to_owned(),
                    ..self.list[last].clone()
                };
                self.list.insert(last + 1, finding);
            }
        }
        self.list
    }
}

/// `text` without control characters, cut in the middle where it is long.
fn legible(text: &str) -> String {
    let shown = |c: char| if c.is_control() { c.escape_default().to_string() } else { c.into() };
    let length = text.chars().count();
    if length <= LONGEST {
        return text.chars().map(shown).collect();
    }
    let half = LONGEST / 2;
    let begin: String = text.chars().take(half).map(shown).collect();
    let end: String = text.chars().skip(length - half).map(shown).collect();
    format!("{begin}...{end}")
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}[{}]: {}", self.level.name(), self.code, self.message)?;
        writeln!(f, "  --> {}", self.location)?;
        write!(f, "  = help: {}", self.help)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn finding(code: &'static str, message: &str) -> Finding {
        let (location, help) = ("a.xml:1".to_owned(), String::new());
        Finding { level: Level::Error, code, message: message.to_owned(), location, help }
    }

    #[test]
    fn of_a_code_so_many_are_listed_and_the_rest_is_counted() {
        let mut findings = Findings::default();
        findings.add(finding("first", "once"));
        for k in 0..400_090 {
            findings.add(finding("many", &k.to_string()));
        }
        findings.add(finding("last", "once"));
        let list = findings.into_list();
        assert_eq!(list.len(), 103);
        let codes: Vec<_> = list.iter().map(|finding| finding.code).collect();
        assert_eq!((codes[0], codes[1], codes[101], codes[102]), ("first", "many", "many", "last"));
        assert_eq!((&list[100].message[..], &list[101].message[..]), ("99", "and 399990 more"));
    }

    #[test]
    fn what_is_quoted_can_be_read() {
        let mut findings = Findings::default();
        findings.add(finding("a", "one\u{1b}[31m line\n"));
        findings.add(finding("a", &"\u{e4}".repeat(100_000)));
        let list = findings.into_list();
        assert_eq!(list[0].message, "one\\u{1b}[31m line\\n");
        assert_eq!(list[1].message.chars().count(), 403);
    }
}
