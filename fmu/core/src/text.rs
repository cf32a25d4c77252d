//! Text of log messages in a fixed buffer: no allocation, and none of `core::fmt`, whose printing
//! of floating-point numbers brings panics with it.

use core::ffi::{CStr, c_char};

use crate::decimal::{Decimal, power_of_ten};

const CAPACITY: usize = 384;
/// Most significant digits that a floating-point number needs to be read back.
const MOST_DIGITS: i32 = 17;

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

    /// Appends a real number with all its digits: the fewest that read back as it.
    pub fn real(&mut self, value: f64) -> &mut Self {
        self.decimal(value, MOST_DIGITS)
    }

    /// Appends a real number with up to six significant digits.
    pub fn rounded(&mut self, value: f64) -> &mut Self {
        self.decimal(value, 6)
    }

    /// Appends a real number with at most `count` significant digits.
    #[inline(never)] // small code, as below
    fn decimal(&mut self, value: f64, count: i32) -> &mut Self {
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
        let Decimal { digits, decimals, exponent } = Decimal::shortest(magnitude).rounded(count);
        let plain = (-4..16).contains(&exponent);
        let point = if plain { decimals - exponent } else { decimals };
        if point <= 0 {
            self.digits(digits * power_of_ten(-point), 1);
        } else if point <= MOST_DIGITS + 2 {
            let unit = power_of_ten(point).max(1);
            self.digits(digits / unit, 1).str(".").digits(digits % unit, point);
        } else {
            // 10^20 is none of the powers there are.
            self.str("0.0").digits(digits, point - 1);
        }
        if plain { self } else { self.str("e").integer(exponent.into()) }
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

    fn digits(&mut self, value: u64, at_least: i32) -> &mut Self {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_read_as_usual() {
        for (value, text) in [
            (0.0, "0"),
            (-1.5, "-1.5"),
            (0.01, "0.01"),
            (1.0 / 60.0, "0.016666666666666666"),
            (123456.0, "123456"),
            (1234567.0, "1234567"),
            (1_700_000_000.25, "1700000000.25"),
            (9_007_199_254_740_993.0, "9007199254740992"),
            (1e16, "1e16"),
            (1e-4, "0.0001"),
            (1.0 / 7e3, "0.00014285714285714287"),
            (1e-5, "1e-5"),
            (0.1 + 0.2, "0.30000000000000004"),
            (f64::MAX, "1.7976931348623157e308"),
            (5e-324, "5e-324"),
            (f64::NAN, "NaN"),
            (f64::NEG_INFINITY, "-infinity"),
        ] {
            assert_eq!(Text::new().real(value).as_str(), text);
        }
        for (value, text) in [
            (0.01, "0.01"),
            (1.0 / 60.0, "0.0166667"),
            (999_999.4, "999999"),
            (999_999.6, "1000000"),
            (-12_345_678.0, "-12345700"),
            (0.000_299_999_96, "0.0003"),
            (f64::MAX, "1.79769e308"),
        ] {
            assert_eq!(Text::new().rounded(value).as_str(), text);
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

    /// As the standard library writes it, whose `.0` is left out here.
    fn standard(value: f64) -> String {
        let text = format!("{value:?}").replace("inf", "infinity");
        text.strip_suffix(".0").unwrap_or(&text).to_owned()
    }

    #[test]
    fn real_numbers_have_the_digits_of_the_standard_library() {
        let mut values: Vec<f64> =
            (-1074..1024).step_by(3).map(|power| 2_f64.powi(power)).collect();
        values.extend(
            (-323..309).step_by(3).map(|power| format!("1e{power}").parse::<f64>().unwrap()),
        );
        // The grid of a sampled model, and its neighbours.
        values.extend((0..3_000).map(|k| f64::from(k) * 0.01));
        values.extend((0..1_000).map(|k| 1.7e9 + f64::from(k) * 0.001));
        // Numbers of all sizes: a linear congruential generator's states as bits.
        let states = std::iter::successors(Some(1_u64), |state| {
            Some(state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963))
        });
        values.extend(states.take(5_000).map(f64::from_bits).filter(|value| value.is_finite()));
        for value in values {
            for value in [value, value.next_up(), value.next_down()] {
                assert_eq!(
                    Text::new().real(value).as_str(),
                    standard(value),
                    "{:x}",
                    value.to_bits()
                );
            }
        }
    }
}
