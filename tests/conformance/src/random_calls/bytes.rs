//! Bytes, and the choices read off them.

use std::ptr;

/// The string of bytes, with zeros after its end.
pub struct Bytes<'a>(pub &'a [u8]);

impl Bytes<'_> {
    /// The next, 0 at the end.
    pub fn byte(&mut self) -> u8 {
        self.0.split_off_first().copied().unwrap_or(0)
    }

    /// A number from 0 to before `n`.
    pub fn below(&mut self, n: usize) -> usize {
        usize::from(self.byte()) % n
    }

    /// True once in `n` times.
    pub fn rarely(&mut self, n: usize) -> bool {
        self.below(n) == n - 1
    }

    /// One of `items`.
    pub fn choice<T: Copy>(&mut self, items: &[T]) -> T {
        items[self.below(items.len())]
    }

    /// From -1 to 1.
    pub fn unit(&mut self) -> f64 {
        (f64::from(self.byte()) - 127.5) / 127.5
    }

    /// Any real, often a plausible one.
    pub fn real(&mut self) -> f64 {
        match self.below(4) {
            0 => self.choice(&[
                0.0,
                -0.0,
                1.0,
                -1.0,
                1e-3,
                1e3,
                1e9,
                -1e9,
                1e12,
                1e300,
                -1e300,
                5e-324,
                f64::MAX,
                f64::INFINITY,
                f64::NEG_INFINITY,
                f64::NAN,
            ]),
            1 => f64::from_bits(u64::from_le_bytes([0; 8].map(|_: u8| self.byte()))),
            2 => 15.0 + 15.0 * self.unit(),
            _ => self.unit(),
        }
    }

    /// Any integer, often a small one.
    pub fn integer(&mut self) -> i32 {
        match self.below(3) {
            0 => self.choice(&[0, 1, -1, 2, 3, i32::MAX, i32::MIN, 1_000_000, 1_000_001]),
            1 => self.below(8) as i32,
            _ => i32::from_le_bytes([0; 4].map(|_: u8| self.byte())),
        }
    }

    /// Where a step may begin or end.
    pub fn time(&mut self, now: f64, period: f64) -> f64 {
        match self.below(8) {
            0 => self.real(),
            1 => now + period * self.unit(),
            2 => now + 1e-9 * self.unit(),
            _ => now,
        }
    }
}

/// NULL in place of `pointer` once in a while.
pub fn or_null<T>(bytes: &mut Bytes<'_>, pointer: *const T) -> *const T {
    if bytes.rarely(12) { ptr::null() } else { pointer }
}

/// The same of one to be written to.
pub fn or_null_mut<T>(bytes: &mut Bytes<'_>, pointer: *mut T) -> *mut T {
    if bytes.rarely(12) { ptr::null_mut() } else { pointer }
}

/// Bytes of a run: SplitMix64 from its number, 200 to 2200 of them.
pub fn random_bytes(run: u64) -> Vec<u8> {
    let mut state = run.wrapping_mul(0xD134_2543_DE82_EF95);
    let mut next = || {
        state = state.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = state;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    };
    let words = 25 + next() % 250;
    (0..words).flat_map(|_| next().to_le_bytes()).collect()
}
