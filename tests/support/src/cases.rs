//! Reference cases: `tests/cases/NAME.toml`, which tests in Rust and in Python read alike.
//!
//! A case says what it is, where its numbers come from, the specification it is about (if any), and
//! what is expected. Each expected figure has a value with an `absolute` or `relative` tolerance, or
//! limits `at_least` and `at_most`; units are in its name.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use serde::Deserialize;

/// A reference case.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ReferenceCase {
    /// What it is, with the numbers of its equations.
    pub about: String,
    /// Where the expected figures come from.
    pub source: String,
    /// Its specification in TOML: what differs from the paper's.
    #[serde(default)]
    pub spec: String,
    expected: BTreeMap<String, Expected>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Expected {
    value: Option<f64>,
    absolute: Option<f64>,
    relative: Option<f64>,
    at_least: Option<f64>,
    at_most: Option<f64>,
}

impl Expected {
    /// Smallest and largest value that agrees.
    fn limits(&self) -> Option<[f64; 2]> {
        match *self {
            Self { value: Some(value), absolute, relative, at_least: None, at_most: None } => {
                let tolerance = match (absolute, relative) {
                    (Some(absolute), None) => absolute,
                    (None, Some(relative)) => relative * value.abs(),
                    _ => return None,
                };
                Some([value - tolerance, value + tolerance])
            }
            Self { value: None, absolute: None, relative: None, at_least, at_most } => {
                (at_least.is_some() || at_most.is_some())
                    .then_some([at_least.unwrap_or(f64::MIN), at_most.unwrap_or(f64::MAX)])
            }
            _ => None,
        }
    }
}

impl ReferenceCase {
    /// Reads `tests/cases/NAME.toml`.
    ///
    /// # Panics
    /// If there is no such case, or it is malformed.
    #[must_use]
    pub fn read(name: &str) -> Self {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("../cases/{name}.toml"));
        let text = fs::read_to_string(&path).unwrap_or_else(|error| panic!("{name}: {error}"));
        let case: Self = toml::from_str(&text).unwrap_or_else(|error| panic!("{name}: {error}"));
        for (figure, expected) in &case.expected {
            assert!(
                expected.limits().is_some(),
                "{name}: `{figure}` needs one tolerance or limits"
            );
        }
        case
    }

    /// The reference value of `figure`.
    ///
    /// # Panics
    /// If the case expects no such value.
    #[must_use]
    #[track_caller]
    pub fn value(&self, figure: &str) -> f64 {
        self.expected(figure).value.unwrap_or_else(|| panic!("`{figure}` has limits only"))
    }

    /// Holds `value` against what the case expects of `figure`.
    ///
    /// # Panics
    /// If it does not agree, or the case expects nothing of that name.
    #[track_caller]
    pub fn check(&self, figure: &str, value: f64) {
        let [least, most] = self.expected(figure).limits().expect("checked when read");
        assert!(
            least <= value && value <= most,
            "{figure} = {value}, expected {least} to {most}: {}, {}",
            self.about,
            self.source
        );
    }

    #[track_caller]
    fn expected(&self, figure: &str) -> &Expected {
        self.expected.get(figure).unwrap_or_else(|| panic!("`{figure}` is not in {:?}", self.about))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_are_those_of_the_tolerance() {
        let limits = |text| toml::from_str::<Expected>(text).unwrap().limits();
        assert_eq!(limits("value = -2.0\nabsolute = 0.5"), Some([-2.5, -1.5]));
        assert_eq!(limits("value = -2.0\nrelative = 0.25"), Some([-2.5, -1.5]));
        assert_eq!(limits("at_least = 1.0\nat_most = 2.0"), Some([1.0, 2.0]));
        assert_eq!(limits("at_most = 2.0"), Some([f64::MIN, 2.0]));
        for malformed in ["", "value = 1.0", "value = 1.0\nat_most = 2.0", "relative = 1.0"] {
            assert_eq!(limits(malformed), None, "{malformed}");
        }
    }
}
