//! Frequency ranges.

use std::f64::consts::PI;

use crate::lmi::affine::Affine;

/// A frequency range of an input, in radians a sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Band {
    /// `|w| <= theta`.
    Low(f64),
    /// `|w| >= theta`.
    High(f64),
    /// All frequencies.
    Full,
}

impl Band {
    /// Lowest and highest frequency, in `[0, pi]`.
    pub fn limits(self) -> [f64; 2] {
        match self {
            Self::Low(theta) => [0.0, theta],
            Self::High(theta) => [theta, PI],
            Self::Full => [0.0, PI],
        }
    }

    /// Whether the frequency `w`, in `[0, pi]`, lies in it.
    pub fn holds(self, w: f64) -> bool {
        let [from, to] = self.limits();
        (from..=to).contains(&w)
    }

    /// `count + 1` frequencies evenly spread over the range, ends included.
    pub fn grid(self, count: u32) -> impl Iterator<Item = f64> {
        let [from, to] = self.limits();
        let step = (to - from) / f64::from(count);
        (0..=count).map(move |k| if k == count { to } else { from + step * f64::from(k) })
    }

    /// `[P_i - 2 cos(theta) Q, 0, Q; 0, 0, 0; Q, 0, -P_k]` for `inputs` inputs; Q changes its sign
    /// for a high band and is absent for the full one.
    pub(crate) fn base(self, p_i: &Affine, p_k: &Affine, q: &Affine, inputs: usize) -> Affine {
        let (theta, q) = match self {
            Self::Low(theta) => (theta, q.clone()),
            Self::High(theta) => (theta, -q),
            Self::Full => (0.0, 0.0 * q),
        };
        let zero = |rows, columns| Affine::zeros(rows, columns);
        Affine::blocks([
            [p_i - &(2.0 * theta.cos() * &q), zero(3, inputs), q.clone()],
            [zero(inputs, 3), zero(inputs, inputs), zero(inputs, 3)],
            [q, zero(3, inputs), -p_k],
        ])
    }
}
