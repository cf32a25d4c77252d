//! Where paths lead in a document.

use std::ops::Range;

use toml::de::{DeTable, DeValue};

/// A part of a path.
enum Step<'a> {
    Key(&'a str),
    Index(usize),
}

fn steps(path: &str) -> impl Iterator<Item = Step<'_>> {
    path.split(['.', '[']).filter(|part| !part.is_empty()).map(|part| {
        let index = part.strip_suffix(']').and_then(|index| index.parse().ok());
        index.map_or(Step::Key(part), Step::Index)
    })
}

/// The path of what holds the last part of `path`; empty for the root.
pub(super) fn parent(path: &str) -> &str {
    path.rfind(['.', '[']).map_or("", |end| &path[..end])
}

/// The first key of `path`.
pub(super) fn first(path: &str) -> &str {
    path.find(['.', '[']).map_or(path, |end| &path[..end])
}

/// The path of the array, where `path` is that of one of its elements.
pub(super) fn without_index(path: &str) -> &str {
    if path.ends_with(']') { without_index(parent(path)) } else { path }
}

/// The value at `path`.
pub(super) fn find<'a>(root: &'a DeTable<'_>, path: &str) -> Option<&'a DeValue<'a>> {
    let mut steps = steps(path);
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
    let mut keys = without_index(path).split('.');
    let first = defaults.get(keys.next()?)?;
    let value = keys.try_fold(first, |value, key| value.get(key))?;
    let is_of_tables =
        value.as_array().is_some_and(|array| array.iter().any(toml::Value::is_table));
    (!value.is_table() && !is_of_tables).then(|| value.to_string())
}

/// Takes the key at `path` out of its table; false where there is none.
pub(super) fn remove(root: &mut DeTable<'_>, path: &str) -> bool {
    let mut steps: Vec<_> = steps(path).collect();
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
    let mut steps = steps(path);
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
