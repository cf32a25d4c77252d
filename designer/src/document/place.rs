//! Where paths lead in a document.

use std::ops::Range;

use toml::de::{DeTable, DeValue};

/// A part of a path.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Step<'a> {
    Key(&'a str),
    Index(usize),
}

/// The parts of `path`, each with where it ends.
fn steps(path: &str) -> Vec<(Step<'_>, usize)> {
    let mut steps = Vec::new();
    let mut rest = path;
    while !rest.is_empty() {
        rest = rest.strip_prefix('.').unwrap_or(rest);
        let (step, behind) = if let Some(index) = rest.strip_prefix('[') {
            let (index, behind) = index.split_once(']').unwrap_or((index, ""));
            (Step::Index(index.parse().unwrap_or(usize::MAX)), behind)
        } else if let Some(quoted) = rest.strip_prefix('"') {
            let (key, behind) = quoted.split_once('"').unwrap_or((quoted, ""));
            (Step::Key(key), behind)
        } else {
            let end = rest.find(['.', '[']).unwrap_or(rest.len());
            (Step::Key(&rest[..end]), &rest[end..])
        };
        rest = behind;
        steps.push((step, path.len() - rest.len()));
    }
    steps
}

/// The path of `key` in the table at `table`.
pub(super) fn join(table: &str, key: &str) -> String {
    let is_bare = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
    let dot = if table.is_empty() { "" } else { "." };
    let quote = if !key.is_empty() && key.chars().all(is_bare) { "" } else { "\"" };
    format!("{table}{dot}{quote}{key}{quote}")
}

/// The path of what holds the last part of `path`; empty for the root.
pub(super) fn parent(path: &str) -> &str {
    let steps = steps(path);
    let end = steps.iter().rev().nth(1).map_or(0, |(_, end)| *end);
    &path[..end]
}

/// The first key of `path`.
pub(super) fn first(path: &str) -> &str {
    steps(path).first().map_or(path, |(_, end)| &path[..*end])
}

/// Whether the last part of `path` is `key`.
pub(super) fn ends_with(path: &str, key: &str) -> bool {
    steps(path).last().is_some_and(|(step, _)| *step == Step::Key(key))
}

/// The path of the array, where `path` is that of one of its elements.
pub(super) fn without_index(path: &str) -> &str {
    let steps = steps(path);
    let last_key = steps.iter().rfind(|(step, _)| matches!(step, Step::Key(_)));
    last_key.map_or(path, |(_, end)| &path[..*end])
}

/// The value at `path`.
pub(super) fn find<'a>(root: &'a DeTable<'_>, path: &str) -> Option<&'a DeValue<'a>> {
    let mut steps = steps(path).into_iter().map(|(step, _)| step);
    let Some(Step::Key(key)) = steps.next() else { return None };
    let mut value = root.get(key)?.get_ref();
    for step in steps {
        value = match step {
            Step::Key(key) => value.as_table()?.get(key)?.get_ref(),
            Step::Index(index) => value.as_array()?.get(index)?.get_ref(),
        };
    }
    Some(value)
}

/// The value at `path` in `defaults`, in TOML; none for tables, and for what is in an array of them.
pub(super) fn default_of(defaults: &toml::Table, path: &str) -> Option<String> {
    let mut steps = steps(without_index(path)).into_iter().map(|(step, _)| step);
    let Some(Step::Key(first)) = steps.next() else { return None };
    let value = steps.try_fold(defaults.get(first)?, |value, step| match step {
        Step::Key(key) => value.get(key),
        Step::Index(_) => None,
    })?;
    let is_of_tables =
        value.as_array().is_some_and(|array| array.iter().any(toml::Value::is_table));
    (!value.is_table() && !is_of_tables).then(|| value.to_string())
}

/// Takes the key at `path` out of its table; false where there is none.
pub(super) fn remove(root: &mut DeTable<'_>, path: &str) -> bool {
    let mut steps: Vec<_> = steps(path).into_iter().map(|(step, _)| step).collect();
    let Some(Step::Key(last)) = steps.pop() else { return false };
    let mut table = root;
    let mut steps = steps.into_iter().peekable();
    while let Some(step) = steps.next() {
        let Step::Key(key) = step else { return false };
        let Some(mut value) = table.get_mut(key).map(|value| value.get_mut()) else { return false };
        while let Some(Step::Index(index)) = steps.next_if(|step| matches!(step, Step::Index(_))) {
            let DeValue::Array(array) = value else { return false };
            let Some(element) = array.get_mut(index) else { return false };
            value = element.get_mut();
        }
        let DeValue::Table(inner) = value else { return false };
        table = inner;
    }
    table.remove(last).is_some()
}

/// The place of a key in the text, in bytes.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Place {
    /// The key, or the head of the table that is an element of an array.
    pub(super) key: Range<usize>,
    /// Its value; of a table, the key.
    pub(super) value: Range<usize>,
    /// Whether all of the path is there, not only what it begins with.
    pub(super) whole: bool,
}

/// The place of `path`, or of the longest beginning of it that is in the document.
pub(super) fn locate(root: &DeTable<'_>, path: &str) -> Option<Place> {
    let mut steps = steps(path).into_iter().map(|(step, _)| step);
    let Some(Step::Key(key)) = steps.next() else { return None };
    let (key, mut value) = root.get_key_value(key)?;
    let mut key = key.span();
    let mut whole = true;
    for step in steps {
        let next = match (step, value.get_ref()) {
            (Step::Key(name), DeValue::Table(table)) => {
                table.get_key_value(name).map(|(key, value)| (key.span(), value))
            }
            (Step::Index(index), DeValue::Array(array)) => {
                array.get(index).map(|value| (value.span(), value))
            }
            _ => None,
        };
        match next {
            Some(next) => (key, value) = next,
            None => {
                whole = false;
                break;
            }
        }
    }
    let is_of_tables = |array: &[toml::Spanned<DeValue<'_>>]| {
        array.first().is_some_and(|element| element.get_ref().is_table())
    };
    let at_key = match value.get_ref() {
        DeValue::Table(_) => true,
        DeValue::Array(array) => is_of_tables(array),
        _ => false,
    };
    let value = if at_key { key.clone() } else { value.span() };
    Some(Place { key, value, whole })
}
