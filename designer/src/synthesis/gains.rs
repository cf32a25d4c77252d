//! Observer gains from the unknowns of Theorem 4: Table 2, with (34) corrected.

use steerguard_detector::{C, Gains, RULES};

use crate::lmi::matrix::{Matrix, matrix, rows};

/// Gains of the observer (10), and the H_i they were made from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ObserverGains {
    /// N_i, L_i, M, E.
    pub gains: Gains,
    /// H_i, 3 x 2 each.
    pub h: [[[f64; 2]; 3]; RULES],
}

impl ObserverGains {
    /// Table 2. None where R is singular.
    pub fn table_2(
        r: &Matrix,
        s: &Matrix,
        w: &[Matrix; RULES],
        a: &[Matrix; RULES],
    ) -> Option<Self> {
        let r_inverse = r.clone().try_inverse()?;
        let e = &r_inverse * s; // (36)
        let h = w.each_ref().map(|w| &r_inverse * w); // (37)
        Some(Self::new(&e, &h, a))
    }

    /// The gains of given E and H_i.
    pub fn new(e: &Matrix, h: &[Matrix; RULES], a: &[Matrix; RULES]) -> Self {
        let c = matrix(&C);
        let m = Matrix::identity(3, 3) + e * &c; // (11)
        let n: [_; RULES] = std::array::from_fn(|i| &m * &a[i] - &h[i] * &c); // (35)
        let l: [_; RULES] = std::array::from_fn(|i| &h[i] - &n[i] * e); // (34), corrected
        Self {
            gains: Gains {
                n: n.map(|n| rows(&n)),
                l: l.map(|l| rows(&l)),
                m: rows(&m),
                e: rows(e),
            },
            h: h.each_ref().map(rows),
        }
    }

    /// Largest element of `M A_i - N_i M - L_i C` over the rules: the observer equation (13).
    pub fn observer_equation_error(&self, a: &[Matrix; RULES]) -> f64 {
        let Gains { n, l, m, .. } = &self.gains;
        let m = matrix(m);
        let error = |i: usize| &m * &a[i] - matrix(&n[i]) * &m - matrix(&l[i]) * matrix(&C);
        (0..RULES).map(|i| error(i).amax()).fold(0.0, f64::max)
    }
}
