//! The shortest decimal number that reads back as a given floating-point number, nearest to it.
//!
//! Steele and White, "How to print floating-point numbers accurately" (1990), in Burger and Dybvig's
//! form ("Printing floating-point numbers quickly and accurately", 1996), on integers of fixed
//! length: exact, small, without tables and without a panic. Messages are not in a hurry.

use core::cmp::Ordering;

/// A positive decimal number: `digits` with the point behind the first one, times ten to `exponent`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Decimal {
    /// 1 to 17 digits; the last one is not zero unless it is the only one.
    pub(crate) digits: u64,
    /// How many digits follow the first.
    pub(crate) decimals: i32,
    /// Power of ten of the first digit.
    pub(crate) exponent: i32,
}

impl Decimal {
    /// The shortest number that reads back as `value`, which is positive and finite.
    pub(crate) fn shortest(value: f64) -> Self {
        let (mantissa, power) = decode(value);
        // value = r / s; numbers less than below / s under it and above / s over it read back as it.
        let (mut r, mut s) = (Natural::from(mantissa), Natural::from(1));
        let (mut below, mut above) = (Natural::from(1), Natural::from(1));
        r.double(1 + power.max(0));
        s.double(1 + (-power).max(0));
        below.double(power.max(0));
        above.double(power.max(0));
        // Under a power of two the next number is half as far away.
        if mantissa == HIDDEN_BIT && power > LOWEST_POWER {
            for number in [&mut r, &mut s, &mut above] {
                number.double(1);
            }
        }
        // Ties are read as the even mantissa.
        let even = mantissa.is_multiple_of(2);
        let too_high = |r: &Natural, above: &Natural, s: &Natural| {
            let order = r.plus(above).cmp(s);
            order == Ordering::Greater || even && order == Ordering::Equal
        };

        // So that 1/10 <= (r + above) / s < 1, value = r / s 10^exponent.
        let mut exponent = 0;
        while too_high(&r, &above, &s) {
            s.times(10);
            exponent += 1;
        }
        loop {
            let [mut ten_r, mut ten_above] = [r, above];
            ten_r.times(10);
            ten_above.times(10);
            if too_high(&ten_r, &ten_above, &s) {
                break;
            }
            (r, above) = (ten_r, ten_above);
            below.times(10);
            exponent -= 1;
        }

        let (mut digits, mut decimals) = (0_u64, -1);
        loop {
            for number in [&mut r, &mut below, &mut above] {
                number.times(10);
            }
            let mut digit = 0;
            while r.cmp(&s) != Ordering::Less {
                r.minus(&s);
                digit += 1;
            }
            digits = digits * 10 + digit;
            decimals += 1;
            let order = r.cmp(&below);
            let low_enough = order == Ordering::Less || even && order == Ordering::Equal;
            let high_enough = too_high(&r, &above, &s);
            if low_enough || high_enough {
                let up = high_enough && (!low_enough || r.plus(&r).cmp(&s) != Ordering::Less);
                digits += u64::from(up);
                return Self { digits, decimals, exponent: exponent - 1 };
            }
        }
    }

    /// The same with at most `count` digits.
    pub(crate) fn rounded(self, count: i32) -> Self {
        let Self { mut digits, mut decimals, mut exponent } = self;
        let surplus = decimals + 1 - count;
        if surplus > 0 {
            let unit = power_of_ten(surplus).max(1);
            digits = (digits + unit / 2) / unit;
            decimals -= surplus;
            if digits >= power_of_ten(count) {
                digits /= 10;
                exponent += 1;
            }
        }
        while decimals > 0 && digits.is_multiple_of(10) {
            digits /= 10;
            decimals -= 1;
        }
        Self { digits, decimals, exponent }
    }
}

/// Ten to `exponent`, which is at most 19; 1 if it is negative.
pub(crate) fn power_of_ten(exponent: i32) -> u64 {
    (0..exponent).fold(1, |power: u64, _| power.saturating_mul(10))
}

/// The bit of a mantissa that is not stored.
const HIDDEN_BIT: u64 = 1 << 52;
/// Power of two of the last bit of the smallest numbers.
const LOWEST_POWER: i32 = -1074;

/// Mantissa and power of two: `value = mantissa 2^power`.
fn decode(value: f64) -> (u64, i32) {
    let bits = value.to_bits();
    let fraction = bits & (HIDDEN_BIT - 1);
    match (bits >> 52) as i32 & 0x7ff {
        0 => (fraction, LOWEST_POWER),
        exponent => (fraction | HIDDEN_BIT, LOWEST_POWER - 1 + exponent),
    }
}

/// 32-bit limbs of a [`Natural`]: the smallest numbers need 2^1076 and 10^324 2^54, the largest less.
const LIMBS: usize = 36;

/// A natural number below 2^1152, least significant limb first.
#[derive(Clone, Copy)]
struct Natural([u32; LIMBS]);

impl From<u64> for Natural {
    fn from(value: u64) -> Self {
        let mut limbs = [0; LIMBS];
        let halves = [value as u32, (value >> 32) as u32];
        for (limb, half) in limbs.iter_mut().zip(halves) {
            *limb = half;
        }
        Self(limbs)
    }
}

impl Natural {
    fn times(&mut self, factor: u32) {
        let mut carry = 0;
        for limb in &mut self.0 {
            let product = u64::from(*limb) * u64::from(factor) + carry;
            *limb = product as u32;
            carry = product >> 32;
        }
    }

    fn double(&mut self, times: i32) {
        for _ in 0..times {
            self.times(2);
        }
    }

    fn plus(&self, other: &Self) -> Self {
        let mut sum = *self;
        let mut carry = 0;
        for (limb, other) in sum.0.iter_mut().zip(&other.0) {
            let total = u64::from(*limb) + u64::from(*other) + carry;
            *limb = total as u32;
            carry = total >> 32;
        }
        sum
    }

    /// Takes away `other`, which is not larger.
    fn minus(&mut self, other: &Self) {
        let mut borrow = false;
        for (limb, other) in self.0.iter_mut().zip(&other.0) {
            let (difference, first) = limb.overflowing_sub(*other);
            let (difference, second) = difference.overflowing_sub(u32::from(borrow));
            *limb = difference;
            borrow = first || second;
        }
    }

    fn cmp(&self, other: &Self) -> Ordering {
        self.0.iter().rev().cmp(other.0.iter().rev())
    }
}
