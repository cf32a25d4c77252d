//! What can be wrong with a specification, said by key, value and allowed range.

use std::fmt::Debug;

use serde::de::DeserializeOwned;

/// Why a specification is refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SpecError {
    /// Not TOML.
    #[error("not valid TOML: {0}")]
    Syntax(String),
    /// A key that no table has.
    #[error("unknown key `{key}`{hint}")]
    UnknownKey {
        /// Path of the key.
        key: String,
        /// Nearest known key, or a reason; may be empty.
        hint: String,
    },
    /// A value of the wrong type, or a missing one.
    #[error("`{key}`: {message}")]
    Type {
        /// Path of the key, or of the table that lacks it.
        key: String,
        /// What was found and what was expected.
        message: String,
    },
    /// A value that is not possible.
    #[error("`{key}` = {value}: allowed is {allowed}")]
    Value {
        /// Path of the key.
        key: String,
        /// The value.
        value: String,
        /// What is allowed.
        allowed: String,
    },
}

impl SpecError {
    /// Refuses `value` at `key` unless the condition `holds`.
    pub(crate) fn unless(
        holds: bool,
        key: &str,
        value: impl Debug,
        allowed: &str,
    ) -> Result<(), Self> {
        if holds {
            return Ok(());
        }
        Err(Self::Value { key: key.into(), value: format!("{value:?}"), allowed: allowed.into() })
    }
}

/// A range of finite numbers.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Allowed {
    min: f64,
    max: f64,
    ends: bool,
}

impl Allowed {
    pub(crate) const POSITIVE: Self = Self::inside(0.0, f64::INFINITY);
    pub(crate) const NOT_NEGATIVE: Self = Self::between(0.0, f64::INFINITY);
    pub(crate) const FINITE: Self = Self::inside(f64::NEG_INFINITY, f64::INFINITY);

    /// From `min` to `max`, ends included.
    pub(crate) const fn between(min: f64, max: f64) -> Self {
        Self { min, max, ends: true }
    }

    /// From `min` to `max`, ends excluded.
    pub(crate) const fn inside(min: f64, max: f64) -> Self {
        Self { min, max, ends: false }
    }

    /// Refuses a value out of the range.
    pub(crate) fn check(self, key: &str, value: f64) -> Result<(), SpecError> {
        let Self { min, max, ends } = self;
        let above = value > min || (ends && value == min);
        let below = value < max || (ends && value == max);
        let than = if ends { ">= " } else { "> " };
        let allowed = match (min.is_finite(), max.is_finite()) {
            (true, true) if ends => format!("from {min} to {max}"),
            (true, true) => format!("between {min} and {max}"),
            (true, false) => format!("a finite number {than}{min}"),
            _ => "a finite number".into(),
        };
        SpecError::unless(value.is_finite() && above && below, key, value, &allowed)
    }
}

/// Reads TOML, with the path of what is wrong.
pub(crate) fn parse<T: DeserializeOwned>(text: &str) -> Result<T, SpecError> {
    let document = toml::Deserializer::parse(text)
        .map_err(|error| SpecError::Syntax(error.to_string().trim_end().into()))?;
    serde_path_to_error::deserialize(document).map_err(|error| {
        let key = error.path().to_string();
        let message = error.into_inner().message().to_string();
        // serde lists the names it knows in backquotes: the unknown one first.
        let mut names = message.split('`').skip(1).step_by(2);
        let unknown = names.next().unwrap_or_default();
        let known: Vec<&str> = names.collect();
        if message.starts_with("unknown field") {
            let parent = key.strip_suffix(unknown).unwrap_or(&key).trim_end_matches('.');
            let dot = if parent.is_empty() { "" } else { "." };
            SpecError::UnknownKey {
                key: format!("{parent}{dot}{unknown}"),
                hint: hint(unknown, &known),
            }
        } else {
            SpecError::Type { key, message }
        }
    })
}

/// What may have been meant by an unknown key.
fn hint(unknown: &str, known: &[&str]) -> String {
    let nearest = known
        .iter()
        .map(|name| (name, strsim::sorensen_dice(unknown, name)))
        .max_by(|a, b| a.1.total_cmp(&b.1));
    match nearest {
        Some((name, similarity)) if similarity > 0.5 => {
            format!(": did you mean `{name}`? (the unit is part of the key)")
        }
        _ => format!(": known here are {}", known.join(", ")),
    }
}
