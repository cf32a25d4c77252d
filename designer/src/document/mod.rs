//! Documents that people write, in TOML: read with all their mistakes, not only the first.
//!
//! # Conventions
//! - A path names a key from the document's root, such as `fault[1].smallest_deg`; indices count
//!   from 0, and a key that is not bare stands in quotes.
//! - A key left out has its default; what has none is found missing.

mod allowed;
mod diagnostic;
mod mistake;
mod place;
mod serde_message;

use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_path_to_error::Segment;
use toml::Spanned;
use toml::de::{DeTable, DeValue, Error};

pub use allowed::Allowed;
pub use diagnostic::{Diagnostic, Label, Level, Source};
pub use mistake::{Mistake, MistakeKind, Mistakes};

/// Reads `text` and has it checked.
///
/// What is of the wrong type, unknown or missing is left out of the value that `check` is given, so
/// that it has its default there.
///
/// # Errors
/// [`Mistakes`]: all that the parser finds in what is no TOML; else all unknown and missing keys,
/// values of the wrong type and what `check` finds.
pub fn read<T>(text: &str, check: impl FnOnce(&T, &mut Mistakes)) -> Result<T, Mistakes>
where
    T: Default + DeserializeOwned + Serialize,
{
    let (mut document, errors) = DeTable::parse_recoverable(text);
    if !errors.is_empty() {
        let mut mistakes = Mistakes::default();
        for error in errors {
            mistakes.add(serde_message::syntax(&error, text));
        }
        return Err(mistakes);
    }

    let mut mistakes = Mistakes::default();
    let value = loop {
        let (path, error) = match deserialize::<T>(document.clone()) {
            Ok(value) => break value,
            Err(refused) => refused,
        };
        let path = culprit::<T>(&document, path, &error);
        let mistake = serde_message::mistake(&path, &error, place::find(document.get_ref(), &path));
        // A table with another mistake may lack the key for that reason.
        let parent = place::parent(&mistake.key);
        let follows = mistake.kind == MistakeKind::MissingKey && !mistakes.sound(parent);
        let left_out = match mistake.kind {
            MistakeKind::MissingKey => place::first(&mistake.key),
            _ => place::without_index(&mistake.key),
        };
        let removed = place::remove(document.get_mut(), left_out);
        if !follows {
            mistakes.add(mistake);
        }
        if !removed {
            return Err(mistakes);
        }
    };
    check(&value, &mut mistakes);
    mistakes.state_defaults(&toml::Table::try_from(T::default()).unwrap_or_default());
    mistakes.into_result().map(|()| value)
}

/// The value, or the path at which it is refused and why.
fn deserialize<T: DeserializeOwned>(document: Spanned<DeTable<'_>>) -> Result<T, (String, Error)> {
    serde_path_to_error::deserialize(toml::Deserializer::from(document)).map_err(|error| {
        let path = error.path().iter().fold(String::new(), |path, segment| match segment {
            Segment::Seq { index } => format!("{path}[{index}]"),
            Segment::Map { key } | Segment::Enum { variant: key } => place::join(&path, key),
            Segment::Unknown => path,
        });
        (path, error.into_inner())
    })
}

/// The path of the value that `error` is about: `path`, or of a table whose keys depend on its kind,
/// which is refused as a whole, the key without which it is not refused for the same reason.
fn culprit<T: DeserializeOwned>(
    document: &Spanned<DeTable<'_>>,
    path: String,
    error: &Error,
) -> String {
    if !serde_message::is_about_a_value(error) {
        return path;
    }
    let Some(DeValue::Table(table)) = place::find(document.get_ref(), &path) else { return path };
    let mut keys = table.keys().map(|key| place::join(&path, key.get_ref()));
    let is_culprit = |key: &String| {
        let mut without = document.clone();
        place::remove(without.get_mut(), key);
        let still = deserialize::<T>(without).err();
        still.is_none_or(|(at, other)| at != path || other.message() != error.message())
    };
    keys.find(is_culprit).unwrap_or(path)
}
