//! Places of a file that must agree.

use std::fmt::Debug;

use crate::refusal::Refusal;

/// How far a figure may be from what it follows from, relative to the numbers that it is made of.
pub const ROUNDING: f64 = 1e-12;

/// A copy is that of `original`.
///
/// # Errors
/// [`Refusal::Disagreement`].
pub fn same<T: PartialEq + Debug + ?Sized>(
    key: &str,
    stored: &T,
    original: &T,
) -> Result<(), Refusal> {
    match stored == original {
        true => Ok(()),
        false => Err(disagreement(key, stored, original)),
    }
}

/// A figure is what it follows from, up to rounding.
///
/// # Errors
/// [`Refusal::Disagreement`].
pub fn near(key: &str, stored: f64, recomputed: f64) -> Result<(), Refusal> {
    within(key, stored, recomputed, ROUNDING * recomputed.abs())
}

/// A figure is what it follows from, up to `tolerance`.
///
/// # Errors
/// [`Refusal::Disagreement`].
pub fn within(key: &str, stored: f64, recomputed: f64, tolerance: f64) -> Result<(), Refusal> {
    // What overflows is near nothing.
    match recomputed.is_finite() && (stored - recomputed).abs() <= tolerance {
        true => Ok(()),
        false => Err(disagreement(key, &stored, &recomputed)),
    }
}

/// `smaller <= larger`.
///
/// # Errors
/// [`Refusal::Disagreement`].
pub fn at_most(key: &str, smaller: f64, larger: f64) -> Result<(), Refusal> {
    match smaller <= larger * (1.0 + ROUNDING) {
        true => Ok(()),
        false => Err(Refusal::Disagreement {
            key: key.into(),
            stored: shown(&smaller),
            recomputed: format!("at most {larger:?}"),
        }),
    }
}

fn disagreement<T: Debug + ?Sized>(key: &str, stored: &T, recomputed: &T) -> Refusal {
    Refusal::Disagreement { key: key.into(), stored: shown(stored), recomputed: shown(recomputed) }
}

/// A value as the file would have it: what may be missing is a number or null.
fn shown<T: Debug + ?Sized>(value: &T) -> String {
    let text = format!("{value:?}");
    match text.strip_prefix("Some(").and_then(|rest| rest.strip_suffix(')')) {
        Some(inner) => inner.to_owned(),
        None if text == "None" => "null".into(),
        None => text,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_told_as_the_file_has_them() {
        let said = same("a.b", &None, &Some(1.5)).unwrap_err().to_string();
        assert_eq!(said, "`a.b` is null, where the rest of the file gives 1.5");
        let said = same("a", "Some(", "None of these").unwrap_err().to_string();
        assert_eq!(said, r#"`a` is "Some(", where the rest of the file gives "None of these""#);
    }
}
