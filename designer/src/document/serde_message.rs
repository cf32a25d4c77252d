//! What serde and the TOML parser say, as mistakes.
//!
//! # Conventions
//! serde lists names in backquotes: the unknown one first, then those that it knows.

use toml::de::{DeValue, Error};

use super::mistake::{Mistake, MistakeKind};
use super::place;

/// Longest part of a value that is repeated, characters.
const SHOWN: usize = 24;
/// Names at least this similar may have been meant (Sorensen-Dice).
const SIMILAR: f64 = 0.5;

/// How TOML is written.
const GRAMMAR: &str = "write `key = value`: numbers as 1450 or 1.5e3, texts in quotes, lists as [1, 2]; `[table]` begins \
     a table, `[[table]]` one more of several";

/// A mistake of the parser's.
pub(super) fn syntax(error: &Error, text: &str) -> Mistake {
    let at = error.span().unwrap_or(0..0);
    let before = text.get(..at.start).unwrap_or(text);
    let line = before.matches('\n').count() + 1;
    let column = before.chars().rev().take_while(|&c| c != '\n').count() + 1;
    let message = error.message().to_string();
    Mistake::new("", MistakeKind::Syntax { message, at, position: [line, column] }).help(GRAMMAR)
}

/// Whether `error` refuses a value for itself, not a key.
pub(super) fn is_about_a_value(error: &Error) -> bool {
    let message = error.message();
    !message.starts_with("unknown field") && !message.starts_with("missing field")
}

/// The mistake that `error`, at `path`, refuses `value` for.
pub(super) fn mistake(path: &str, error: &Error, value: Option<&DeValue<'_>>) -> Mistake {
    let message = error.message();
    let mut names = message.split('`').skip(1).step_by(2);
    let name = names.next().unwrap_or_default();
    let known: Vec<String> = names.map(str::to_owned).collect();

    if message.starts_with("unknown field") {
        // Of a table whose keys depend on its kind, the path is that of the table.
        let key = if place::ends_with(path, name) { path.into() } else { place::join(path, name) };
        let nearest = nearest(name, &known);
        let has_unit = nearest.as_ref().is_some_and(|nearest| nearest.contains('_'));
        let mistake = Mistake::new(key, MistakeKind::UnknownKey { nearest, known });
        return if has_unit { mistake.help("the unit is part of the key") } else { mistake };
    }
    if message.starts_with("missing field") {
        return Mistake::new(place::join(path, name), MistakeKind::MissingKey)
            .help("it has no default");
    }
    if message.starts_with("unknown variant") {
        let nearest = nearest(name, &known);
        let quoted: Vec<String> = known.iter().map(|name| format!("\"{name}\"")).collect();
        let mistake = Mistake::value(path, cut(name), quoted.join(", "));
        return match nearest {
            Some(nearest) => mistake.help(format!("did you mean \"{nearest}\"?")),
            None => mistake,
        };
    }
    let expected = message.rsplit_once("expected ").map_or(message, |(_, expected)| expected);
    let found = value.map_or_else(|| "something else".into(), found);
    Mistake::new(path, MistakeKind::Type { found, expected: plain(expected) })
}

/// The name that may have been meant.
fn nearest(name: &str, known: &[String]) -> Option<String> {
    let similarity = |known: &String| strsim::sorensen_dice(name, known);
    let nearest = known.iter().max_by(|a, b| similarity(a).total_cmp(&similarity(b)))?;
    (similarity(nearest) > SIMILAR).then(|| nearest.clone())
}

/// The beginning of `text`.
fn cut(text: &str) -> String {
    match text.char_indices().nth(SHOWN) {
        Some((end, _)) => format!("{}...", &text[..end]),
        None => text.to_owned(),
    }
}

/// A value in words.
fn found(value: &DeValue<'_>) -> String {
    match value {
        DeValue::String(text) => format!("the string {:?}", cut(text)),
        DeValue::Integer(number) => format!("the whole number {}", cut(number.as_str())),
        DeValue::Float(number) => format!("the number {}", cut(number.as_str())),
        DeValue::Boolean(value) => format!("the boolean {value}"),
        DeValue::Datetime(value) => format!("the time {value}"),
        DeValue::Array(array) => format!("an array of {}", array.len()),
        DeValue::Table(_) => "a table".into(),
    }
}

/// What serde calls a type, in TOML's words.
fn plain(expected: &str) -> String {
    match expected {
        "f64" => "a number".into(),
        "usize" | "u64" => "a whole number, 0 or more".into(),
        "u32" => format!("a whole number from 0 to {}", u32::MAX),
        "i32" => format!("a whole number from {} to {}", i32::MIN, i32::MAX),
        "a boolean" => "true or false".into(),
        "a sequence" => "an array".into(),
        _ if expected.starts_with("struct") || expected == "a map" => "a table".into(),
        _ => match expected.strip_prefix("an array of length ") {
            Some(length) => format!("an array of {length} numbers"),
            None => expected.into(),
        },
    }
}
