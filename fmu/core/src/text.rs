//! Text of log messages in a fixed buffer: no allocation, and none of `core::fmt`, whose printing
//! of floating-point numbers brings panics with it.

use core::ffi::{CStr, c_char};

const CAPACITY: usize = 384;

/// A message under construction, always NUL-terminated.
///
/// Importers may take it for a printf format or expand `#r12#` in it: `%` and `#` never get in.
pub struct Text {
    bytes: [u8; CAPACITY],
    length: usize,
}

impl Text {
    /// An empty text.
    #[expect(clippy::new_without_default, reason = "a buffer, not a value")]
    pub const fn new() -> Self {
        Self { bytes: [0; CAPACITY], length: 0 }
    }

    /// Appends `text`; what is not printable ASCII, or `%` or `#`, becomes `?`; what does not fit is
    /// left out.
    pub fn str(&mut self, text: &str) -> &mut Self {
        self.bytes(text.as_bytes())
    }

    /// Appends a C string in the same way.
    pub fn c_str(&mut self, text: &CStr) -> &mut Self {
        self.bytes(text.to_bytes())
    }

    /// Appends an integer.
    pub fn integer(&mut self, value: i64) -> &mut Self {
        if value < 0 {
            self.str("-");
        }
        self.digits(value.unsigned_abs(), 1)
    }

    /// Appends a real number with up to six significant digits.
    pub fn real(&mut self, value: f64) -> &mut Self {
        if value.is_nan() {
            return self.str("NaN");
        }
        if value.is_sign_negative() {
            self.str("-");
        }
        let magnitude = value.abs();
        if magnitude.is_infinite() {
            return self.str("infinity");
        }
        if magnitude == 0.0 {
            return self.str("0");
        }

        // magnitude = scaled 10^exponent, 1 <= scaled < 10.
        let (mut scaled, mut exponent) = (magnitude, 0_i64);
        while scaled >= 10.0 {
            scaled /= 10.0;
            exponent += 1;
        }
        while scaled < 1.0 {
            scaled *= 10.0;
            exponent -= 1;
        }
        // digits = scaled 10^5, rounded; without trailing zeros.
        let mut digits = (scaled * 1e5 + 0.5) as u64;
        if digits >= 1_000_000 {
            digits /= 10;
            exponent += 1;
        }
        let mut decimals = 5;
        while decimals > 0 && digits.is_multiple_of(10) {
            digits /= 10;
            decimals -= 1;
        }

        let plain = (-4..6).contains(&exponent);
        let point = if plain { decimals - exponent } else { decimals };
        if point <= 0 {
            self.digits(digits * power_of_ten(-point), 1);
        } else {
            let unit = power_of_ten(point).max(1);
            self.digits(digits / unit, 1).str(".").digits(digits % unit, point);
        }
        if plain { self } else { self.str("e").integer(exponent) }
    }

    /// The text for C.
    pub fn as_ptr(&self) -> *const c_char {
        self.bytes.as_ptr().cast()
    }

    /// The text for Rust.
    pub fn as_str(&self) -> &str {
        let text = self.bytes.get(..self.length).unwrap_or(&[]);
        core::str::from_utf8(text).unwrap_or("")
    }

    fn digits(&mut self, value: u64, at_least: i64) -> &mut Self {
        let mut buffer = [b'0'; 20];
        let (mut rest, mut used) = (value, 0);
        for digit in buffer.iter_mut().rev() {
            if rest == 0 && used >= at_least {
                break;
            }
            *digit = b'0' + (rest % 10) as u8;
            rest /= 10;
            used += 1;
        }
        let start = buffer.len() - used as usize;
        self.bytes(buffer.get(start..).unwrap_or(&[]))
    }

    #[inline(never)] // small code: messages have many parts
    fn bytes(&mut self, bytes: &[u8]) -> &mut Self {
        // The last byte stays NUL.
        let free = self.bytes.iter_mut().take(CAPACITY - 1).skip(self.length);
        for (place, &byte) in free.zip(bytes) {
            let plain = (b' '..=b'~').contains(&byte) && byte != b'%' && byte != b'#';
            *place = if plain { byte } else { b'?' };
            self.length += 1;
        }
        self
    }
}

fn power_of_ten(exponent: i64) -> u64 {
    (0..exponent).fold(1_u64, |power, _| power.saturating_mul(10))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_read_as_usual() {
        for (value, text) in [
            (0.0, "0"),
            (-1.5, "-1.5"),
            (0.01, "0.01"),
            (1.0 / 60.0, "0.0166667"),
            (123456.0, "123456"),
            (120000.0, "120000"),
            (1234567.0, "1.23457e6"),
            (999999.9, "1e6"),
            (1e-4, "0.0001"),
            (1e-5, "1e-5"),
            (f64::MAX, "1.79769e308"),
            (5e-324, "4.94066e-324"),
            (f64::NAN, "NaN"),
            (f64::NEG_INFINITY, "-infinity"),
        ] {
            assert_eq!(Text::new().real(value).as_str(), text);
        }
        for (value, text) in [(0, "0"), (-7, "-7"), (i64::MIN, "-9223372036854775808")] {
            assert_eq!(Text::new().integer(value).as_str(), text);
        }
    }

    #[test]
    fn text_is_safe_as_a_format_and_never_overflows() {
        let mut text = Text::new();
        text.str("100 % of #r1# \n ü");
        assert_eq!(text.as_str(), "100 ? of ?r1? ? ??");
        for _ in 0..100 {
            text.str("0123456789");
        }
        assert_eq!(text.as_str().len(), CAPACITY - 1);
        assert_eq!(text.bytes[CAPACITY - 1], 0);
    }
}
