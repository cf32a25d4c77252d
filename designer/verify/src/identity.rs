//! What a design file is known by: its format and its hash.

use serde_json::Value;
use sha2::{Digest, Sha256};

/// Value of the key `format`.
pub const FORMAT: &str = "steerguard-design/4";

/// SHA-256, in hexadecimal, of a design's canonical JSON (RFC 8785) without its key `hash`. Layout,
/// order of keys, notation of numbers and the sign of zero may change freely, values may not.
///
/// # Errors
/// [`serde_json::Error`], which no value made of JSON causes.
pub fn content_hash(design: &Value) -> Result<String, serde_json::Error> {
    let mut content = design.clone();
    if let Value::Object(keys) = &mut content {
        keys.remove("hash");
    }
    let digest = Sha256::digest(serde_json_canonicalizer::to_vec(&content)?);
    Ok(digest.iter().map(|byte| format!("{byte:02x}")).collect())
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn values_count_and_notation_does_not() {
        let of = |text: &str| {
            let value: Value = serde_json::from_str(text).unwrap_or_else(|error| panic!("{error}"));
            content_hash(&value).unwrap_or_else(|error| panic!("{error}"))
        };
        let hash = of(r#"{"b": [1e2, -0.0, 1e-7], "a": "\u00e9", "hash": "x"}"#);
        assert_eq!(hash, of(r#"{"a":"\u00e9","b":[100,0,0.0000001]}"#));
        assert_ne!(hash, of(r#"{"a":"\u00e9","b":[100,0,0.00000010000000000000001]}"#));
        // The canonical text by itself.
        let digest = Sha256::digest("{\"a\":\"\u{e9}\",\"b\":[100,0,1e-7]}".as_bytes());
        let digest: String = digest.iter().map(|byte| format!("{byte:02x}")).collect();
        assert_eq!(hash, digest);
        assert_ne!(hash, of(&json!({"a": "e", "b": [100, 0, 1e-7]}).to_string()));
    }
}
