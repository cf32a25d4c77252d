//! How diagnostics look: for people as a compiler would draw them, for machines as JSON.

use annotate_snippets::{
    Annotation, AnnotationKind, Element, Level as Title, Message, Origin, Renderer, Snippet,
};
use schemars::JsonSchema;
use serde::Serialize;
use steerguard_designer::document::{Diagnostic, Label, Level, Source};

/// Columns that a message takes at most.
const WIDTH: usize = 80;
/// Columns before the text of a note, beside line numbers of up to four digits.
const NOTE_INDENT: usize = 13;

/// Draws `diagnostic`, with the colours of a terminal.
pub(super) fn draw(diagnostic: &Diagnostic) -> String {
    let Diagnostic { level, code, message, labels, source, place, notes, help } = diagnostic;
    let title_of = match level {
        Level::Error => Title::ERROR,
        Level::Warning => Title::WARNING,
        Level::Note => Title::NOTE,
    };
    let indent = level.name().len() + code.map_or(0, |code| code.len() + 2) + 2;
    let mut title = title_of.primary_title(wrapped(message, indent));
    if let Some(code) = code {
        title = title.id(*code);
    }

    let mut remarks = Vec::new();
    let mut elements: Vec<Element<'_>> = Vec::new();
    match source {
        Some(source) if !labels.is_empty() => {
            let annotations = labels.iter().enumerate().map(|(index, label)| {
                let is_first = index == 0;
                let kind = if is_first { AnnotationKind::Primary } else { AnnotationKind::Context };
                if is_first && !fits(label, source) {
                    remarks.push(label.text.as_str());
                    return kind.span(label.span.clone());
                }
                labelled(kind.span(label.span.clone()), &label.text)
            });
            let snippet = Snippet::source(&*source.text).path(printable(&source.name));
            elements.push(snippet.annotations(annotations.collect::<Vec<_>>()).into());
        }
        Some(source) => elements.push(Origin::path(printable(&source.name)).into()),
        None => {
            elements.extend(place.iter().map(|place| Origin::path(printable(place)).into()));
        }
    }
    let note = |text: &str| Title::NOTE.message(wrapped(text, NOTE_INDENT));
    let notes = remarks.into_iter().chain(notes.iter().map(String::as_str)).map(note);
    let help = help.iter().map(|text| Title::HELP.message(wrapped(text, NOTE_INDENT)));
    elements.extend(notes.chain(help).map(|message: Message<'_>| Element::from(message)));
    Renderer::styled().term_width(WIDTH).render(&[title.elements(elements)])
}

fn labelled<'a>(annotation: Annotation<'a>, text: &str) -> Annotation<'a> {
    if text.is_empty() { annotation } else { annotation.label(printable(text)) }
}

/// Whether the text of `label` has room beside its place.
fn fits(label: &Label, source: &Source) -> bool {
    let before = source.text.get(..label.span.end).unwrap_or(&source.text);
    let line_start = before.rfind('\n').map_or(0, |end| end + 1);
    let line_number_width = (before.matches('\n').count() + 1).to_string().len();
    let columns = textwrap::core::display_width;
    line_number_width + 4 + columns(&before[line_start..]) + columns(&label.text) <= WIDTH
}

/// `text` on lines that leave `indent` columns free.
fn wrapped(text: &str, indent: usize) -> String {
    textwrap::fill(&printable(&cut(text)), WIDTH - indent)
}

/// Characters of what is quoted that are shown.
const LONGEST_QUOTED: usize = 200;

/// `text`, what it quotes in `"` or backquotes, and its words, cut in the middle where they are long: files may
/// have anything where a number belongs.
fn cut(text: &str) -> String {
    let mut shown = String::new();
    let mut rest = text;
    while !rest.is_empty() {
        let quote = rest.chars().next().filter(|c| ['"', '`'].contains(c));
        let end = match quote {
            Some(quote) => rest[1..].find(quote).map(|at| at + 2),
            None => rest.find([' ', '\n', '"', '`']).map(|at| at.max(1)),
        };
        let (part, after) = rest.split_at(end.unwrap_or(rest.len()));
        let length = part.chars().count();
        if length > LONGEST_QUOTED {
            let half = LONGEST_QUOTED / 2;
            shown.extend(part.chars().take(half));
            shown.push_str("...");
            shown.extend(part.chars().skip(length - half));
        } else {
            shown.push_str(part);
        }
        rest = after;
    }
    shown
}

/// What files and FMUs say must not reach the terminal as a control sequence.
fn printable(text: &str) -> String {
    text.chars().map(|c| if c.is_control() && c != '\n' { '\u{fffd}' } else { c }).collect()
}

/// A diagnostic, for machines.
#[derive(Debug, JsonSchema, Serialize)]
pub(super) struct Record<'a> {
    /// `error`, `warning` or `note`.
    level: &'static str,
    /// Of a finding, its code.
    #[serde(skip_serializing_if = "Option::is_none")]
    code: Option<&'static str>,
    /// What is wrong.
    message: &'a str,
    /// File, function or the like.
    #[serde(skip_serializing_if = "Option::is_none")]
    place: Option<&'a str>,
    /// Where in the file.
    labels: Vec<LabelRecord<'a>>,
    /// Why.
    notes: &'a [String],
    /// What to do.
    help: &'a [String],
}

/// A label, for machines.
#[derive(Debug, JsonSchema, Serialize)]
struct LabelRecord<'a> {
    /// Line, from 1.
    line: usize,
    /// Column in characters, from 1.
    column: usize,
    /// First byte, and the one behind the last.
    bytes: [usize; 2],
    /// What is said of that place.
    text: &'a str,
}

impl<'a> From<&'a Diagnostic> for Record<'a> {
    fn from(diagnostic: &'a Diagnostic) -> Self {
        let Diagnostic { level, code, message, labels, source, place, notes, help } = diagnostic;
        let label = |label: &'a Label| {
            let text = source.as_ref().map_or("", |source| &source.text);
            let before = text.get(..label.span.start).unwrap_or(text);
            let line_start = before.rfind('\n').map_or(0, |end| end + 1);
            LabelRecord {
                line: before.matches('\n').count() + 1,
                column: before[line_start..].chars().count() + 1,
                bytes: [label.span.start, label.span.end],
                text: &label.text,
            }
        };
        let source_name = source.as_ref().map(|source| source.name.as_str());
        Self {
            level: level.name(),
            code: *code,
            message,
            place: source_name.or(place.as_deref()),
            labels: labels.iter().map(label).collect(),
            notes,
            help,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_quoted_is_cut_and_the_rest_stays() {
        let long = "x y".repeat(1000);
        let said = cut(&format!("`a` is \"{long}\", where {}", "words follow ".repeat(100)));
        assert!(said.starts_with("`a` is \"x yx y") && said.ends_with("words follow "), "{said}");
        assert_eq!(said.chars().count(), "`a` is , where ".len() + 203 + 1300);
        assert_eq!(cut(&"\u{e4}".repeat(201)).chars().count(), 203);
        // A quotation mark that nothing closes, and nothing at all.
        assert_eq!(cut("it's 5\" and"), "it's 5\" and");
        assert_eq!(cut(&format!("\"{long}")).chars().count(), 203);
        assert_eq!(cut(""), "");
    }
}
