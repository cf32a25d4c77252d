//! The inequalities, each proven by exact elimination.

use std::fmt;

use crate::Refusal;
use crate::exact::{Matrix, Rational, approximate, exact, whole};
use crate::file::{Certified, Design, Disturbance, Fault, GainCertificate, RULES, Rows3};
use crate::model::{Band, pi};
use crate::verdict::{Figures, Margin, Residues};

/// Largest residue of the observer's equations that counts as rounding.
const RESIDUE: f64 = 1e-10;

/// A family of inequalities.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Family {
    /// `P_s,i > 0`, `tau^2 P_s,i - N_i(rho)' P_s,k N_i(rho) > 0`: the error decays at least like
    /// tau^k.
    Decay,
    /// `P_i - C' W_r^2 C > 0`, `tau^2 P_i - N_i(rho)' P_k N_i(rho) > 0`, `amplitude^2 >= P_i,22
    /// v_y^2`: the residual after a start, `||W_r r_j|| <= amplitude tau^j`.
    StartUp,
    /// beta: with `L_k(i, j) = base(P_i, P_k, Q) + diag(-C'C, beta^2 I, 0) +
    /// He(X_jk [N_i(rho), M F, -I])`, `Q > 0`, `L_k(i, i) < 0`, `L_k(i, j) + L_k(j, i) < 0`.
    FaultSensitivity,
    /// gamma: the same with `diag(C'C, -gamma^2 I, 0)` and `M D`.
    DisturbanceAttenuation,
    /// gamma of all frequencies: the same with Q = 0.
    FullBandAttenuation,
}

impl fmt::Display for Family {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Decay => "decay",
            Self::StartUp => "start-up",
            Self::FaultSensitivity => "fault sensitivity, beta",
            Self::DisturbanceAttenuation => "disturbance attenuation, gamma",
            Self::FullBandAttenuation => "disturbance attenuation, full band",
        })
    }
}

/// Place of an inequality in its family, with rules from 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Combination {
    /// `P_i` or what bounds it from below.
    Rule(usize),
    /// `Q > 0`.
    Q,
    /// A rule, its successor and rho.
    Successor {
        /// Rule of this sample.
        i: usize,
        /// Rule of the next.
        k: usize,
        /// Slope of phi.
        rho: f64,
    },
    /// A pair of rules, their successor and rho.
    Pair {
        /// Rule of this sample.
        i: usize,
        /// The same or another.
        j: usize,
        /// Rule of the next.
        k: usize,
        /// Slope of phi.
        rho: f64,
    },
}

impl fmt::Display for Combination {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Rule(i) => write!(f, "rule i = {i}"),
            Self::Q => write!(f, "Q > 0"),
            Self::Successor { i, k, rho } => write!(f, "rules i = {i}, k = {k}, rho = {rho}"),
            Self::Pair { i, j, k, rho } => {
                write!(f, "rules i = {i}, j = {j}, k = {k}, rho = {rho}")
            }
        }
    }
}

/// The error dynamics: `N_i(rho) = N_i + M G rho [0 1 0]` at both extremes of rho, each with its
/// rho.
struct ErrorDynamics {
    n: [[Matrix; RULES]; 2],
    rho: [f64; 2],
}

impl ErrorDynamics {
    /// phi(x) - phi(x^) = (v_y + v_y^) (v_y - v_y^), (15): rho is at most twice an end of v_y.
    fn new(design: &Design) -> Self {
        let rho = design.premise.v_y_m_per_s.map(|v_y| 2.0 * v_y);
        let m_g = &Matrix::exactly(&design.m) * &Matrix::exactly(&design.g);
        let e_2 = Matrix::exactly(&[[0.0, 1.0, 0.0]]);
        let n = |rule: &crate::file::Rule, rho| {
            &Matrix::exactly(&rule.n) + &(&m_g * &e_2).times(&exact(rho))
        };
        Self { n: rho.map(|rho| design.vertices.each_ref().map(|rule| n(rule, rho))), rho }
    }

    /// Every rule, successor and extreme of rho.
    fn successors(&self) -> impl Iterator<Item = (usize, usize, f64, &Matrix)> {
        let at_rho = self.n.iter().zip(self.rho);
        at_rho.flat_map(|(n, rho)| {
            n.iter().enumerate().flat_map(move |(i, n)| (0..RULES).map(move |k| (i, k, rho, n)))
        })
    }
}

/// What rounding left of the equations that the observer is built on. They make the error obey the
/// equation that everything else is about.
///
/// # Errors
/// [`Refusal::Residue`]: more than rounding.
pub fn residues(design: &Design) -> Result<Residues, Refusal> {
    let [c, e, m] =
        [Matrix::exactly(&design.c), Matrix::exactly(&design.e), Matrix::exactly(&design.m)];
    let m_equation = &m - &(&Matrix::identity(3) + &(&e * &c));
    let mut observer_equation = whole(0);
    let mut l_equation = whole(0);
    for rule in &design.vertices {
        let [a, n] = [&rule.a, &rule.n].map(|x| Matrix::exactly(x));
        let [l, h] = [&rule.l, &rule.h].map(|x| Matrix::exactly(x));
        let observer = &(&(&m * &a) - &(&n * &m)) - &(&l * &c);
        observer_equation = observer_equation.max(observer.largest());
        l_equation = l_equation.max((&(&h - &(&n * &e)) - &l).largest());
    }
    for (equation, residue) in [
        ("M - (I + E C)", &m_equation.largest()),
        ("M A_i - N_i M - L_i C", &observer_equation),
        ("L_i - (H_i - N_i E)", &l_equation),
    ] {
        if *residue > exact(RESIDUE) {
            return Err(Refusal::Residue { equation, residue: approximate(residue) });
        }
    }
    Ok(Residues {
        m: approximate(&m_equation.largest()),
        observer_equation: approximate(&observer_equation),
        l: approximate(&l_equation),
    })
}

/// Proves all families.
///
/// # Errors
/// [`Refusal`]: the first inequality that does not hold.
pub fn prove(design: &Design) -> Result<(Figures, Vec<Margin>), Refusal> {
    let missing = |key| Refusal::NoCertificate { key };
    let claimed = design.performance.certified.as_ref();
    let claimed = claimed.ok_or(missing("performance.certified"))?;
    let certificate = design.certificate.a_posteriori.as_ref();
    let certificate = certificate.ok_or(missing("certificate.a_posteriori"))?;
    let Certified { beta, gamma, gamma_full_band, decay, .. } = *claimed;
    let channels = Channels::new(design)?;
    check_figures(claimed, &channels)?;

    let dynamics = ErrorDynamics::new(design);
    let m = Matrix::exactly(&design.m);
    let [from_fault, from_disturbances] = [&channels.f, &channels.d].map(|input| &m * input);
    let gain = |family, certificate, band: &Band, input: &Matrix, value| {
        prove_gain(&dynamics, family, certificate, band, input, value)
    };
    let margins = vec![
        prove_decay(&dynamics, &design.certificate.p_s, decay)?,
        prove_start_up(&dynamics, design)?,
        gain(Family::FaultSensitivity, &certificate.beta, &channels.fault_band, &from_fault, beta)?,
        gain(
            Family::DisturbanceAttenuation,
            &certificate.gamma,
            &channels.disturbance_band,
            &from_disturbances,
            gamma,
        )?,
        gain(
            Family::FullBandAttenuation,
            &certificate.gamma_full_band,
            &Band::Full,
            &from_disturbances,
            gamma_full_band,
        )?,
    ];
    let figures = Figures { beta, gamma, gap: claimed.gap, gamma_full_band, decay };
    Ok((figures, margins))
}

/// The inputs of the error dynamics as the figures count them.
pub struct Channels {
    /// F, 3 x 1, per rad or N m.
    f: Matrix,
    /// D with each column in proportion to its bound, per unit of the first disturbance.
    d: Matrix,
    /// Band of the fault.
    pub fault_band: Band,
    /// Band of the disturbances.
    pub disturbance_band: Band,
    /// At most the smallest fault of interest, rad or N m.
    smallest_fault: Rational,
    /// Bound of the first disturbance.
    bound: Rational,
}

impl Channels {
    /// From the specification inside the file.
    pub fn new(design: &Design) -> Result<Self, Refusal> {
        let (smallest, in_rad, fault_band) = match design.spec.fault[0] {
            Fault::Steering { smallest_deg, band_hz } => {
                let [pi, _] = pi();
                (smallest_deg, pi / whole(180), band_hz)
            }
            Fault::Torque { smallest_n_m, band_hz } => (smallest_n_m, whole(1), band_hz),
        };
        let disturbances = design.spec.disturbance.iter().map(|disturbance| match *disturbance {
            Disturbance::SideWind { bound_m_per_s2: bound, band_hz, .. }
            | Disturbance::Bank { bound_deg: bound, band_hz }
            | Disturbance::YawMoment { bound_n_m: bound, band_hz }
            | Disturbance::Direction { bound, band_hz, .. } => (bound, band_hz),
        });
        let (bounds, bands): (Vec<f64>, Vec<[f64; 2]>) = disturbances.unzip();
        for (key, &value) in [("spec.fault[0]", &smallest)]
            .into_iter()
            .chain(bounds.iter().map(|bound| ("spec.disturbance: bound", bound)))
        {
            if value <= 0.0 {
                return Err(Refusal::NotPositive { key: key.into(), value });
            }
        }
        if let Some(&band_hz) = bands.iter().find(|&&band| band != bands[0]) {
            return Err(Refusal::Band { band_hz });
        }
        let d = design.d()?;
        let relative = |column: usize| exact(bounds[column]) / exact(bounds[0]);
        Ok(Self {
            f: Matrix::exactly(&design.f),
            d: Matrix::new(3, d.width(), |row, column| d.at(row, column) * relative(column)),
            fault_band: Band::new(fault_band, design.sampling_period_s)?,
            disturbance_band: Band::new(bands[0], design.sampling_period_s)?,
            smallest_fault: exact(smallest) * in_rad,
            bound: exact(bounds[0]),
        })
    }
}

/// Figures are positive, the error does not grow, and the gap follows from beta and gamma.
fn check_figures(claimed: &Certified, channels: &Channels) -> Result<(), Refusal> {
    for (key, value) in [
        ("beta", claimed.beta),
        ("gamma", claimed.gamma),
        ("gamma_full_band", claimed.gamma_full_band),
        ("decay", claimed.decay),
    ] {
        if value <= 0.0 {
            return Err(Refusal::NotPositive {
                key: format!("performance.certified.{key}"),
                value,
            });
        }
    }
    let gap =
        exact(claimed.beta) * &channels.smallest_fault / (exact(claimed.gamma) * &channels.bound);
    if exact(claimed.gap) > gap {
        let (key, proven) = ("performance.certified.gap", approximate(&gap));
        return Err(Refusal::Claim { key, claimed: claimed.gap, proven });
    }
    check_decay("performance.certified.decay", claimed.decay)
}

fn check_decay(key: &'static str, decay: f64) -> Result<(), Refusal> {
    if decay > 1.0 {
        return Err(Refusal::Range { key: key.into(), value: [0.0, decay] });
    }
    Ok(())
}

/// Counts the inequalities of a family and keeps the smallest margin.
struct Tally {
    margin: Margin,
}

impl Tally {
    fn new(family: Family) -> Self {
        Self { margin: Margin { family, inequalities: 0, smallest_pivot: f64::INFINITY } }
    }

    /// Proves `X > 0`.
    fn prove(&mut self, x: &Matrix, combination: Combination) -> Result<(), Refusal> {
        let family = self.margin.family;
        let pivot = x.positive_definite().map_err(|reason| Refusal::Broken {
            family,
            combination,
            reason,
        })?;
        self.margin.inequalities += 1;
        self.margin.smallest_pivot = self.margin.smallest_pivot.min(pivot);
        Ok(())
    }

    /// The exact values of a stored symmetric matrix.
    fn symmetric(&self, rows: &Rows3, matrix: &'static str) -> Result<Matrix, Refusal> {
        let x = Matrix::exactly(rows);
        if x.is_symmetric() {
            return Ok(x);
        }
        Err(Refusal::NotSymmetric { family: self.margin.family, matrix })
    }

    /// The exact values of stored symmetric matrices P_i.
    fn p(&self, p: &[Rows3; RULES]) -> Result<Vec<Matrix>, Refusal> {
        p.iter().map(|p| self.symmetric(p, "P")).collect()
    }

    /// Proves `tau^2 P_i - N_i(rho)' P_k N_i(rho) > 0`.
    fn contraction(
        &mut self,
        dynamics: &ErrorDynamics,
        p: &[Matrix],
        decay: f64,
    ) -> Result<(), Refusal> {
        let decay_squared = exact(decay) * exact(decay);
        for (i, k, rho, n) in dynamics.successors() {
            let next = &(&n.transpose() * &p[k]) * n;
            let x = &p[i].times(&decay_squared) - &next;
            self.prove(&x, Combination::Successor { i, k, rho })?;
        }
        Ok(())
    }
}

fn prove_decay(
    dynamics: &ErrorDynamics,
    p: &[Rows3; RULES],
    decay: f64,
) -> Result<Margin, Refusal> {
    let mut tally = Tally::new(Family::Decay);
    let p = tally.p(p)?;
    for (i, p) in p.iter().enumerate() {
        tally.prove(p, Combination::Rule(i))?;
    }
    tally.contraction(dynamics, &p, decay)?;
    Ok(tally.margin)
}

fn prove_start_up(dynamics: &ErrorDynamics, design: &Design) -> Result<Margin, Refusal> {
    let start_up = &design.evaluation.start_up;
    check_decay("evaluation.start_up.decay", start_up.decay)?;
    let mut tally = Tally::new(Family::StartUp);
    let p = tally.p(&start_up.p)?;
    let [w_1, w_2] = design.evaluation.weights.map(exact);
    let w_r = Matrix::blocks(&[
        &[&Matrix::new(1, 1, |_, _| w_1.clone()), &Matrix::zeros(1, 1)],
        &[&Matrix::zeros(1, 1), &Matrix::new(1, 1, |_, _| w_2.clone())],
    ]);
    let w_c = &w_r * &Matrix::exactly(&design.c);
    let output = &w_c.transpose() * &w_c;
    for (i, p) in p.iter().enumerate() {
        tally.prove(&(p - &output), Combination::Rule(i))?;
    }
    tally.contraction(dynamics, &p, start_up.decay)?;

    let [right, left] = design.premise.v_y_m_per_s;
    let v_y = exact(f64::max(right.abs(), left.abs()));
    let amplitude = exact(start_up.amplitude);
    for p in &p {
        let largest = p.at(1, 1) * &v_y * &v_y;
        if amplitude < whole(0) || &amplitude * &amplitude < largest {
            return Err(Refusal::Claim {
                key: "evaluation.start_up.amplitude",
                claimed: start_up.amplitude,
                proven: approximate(&largest).sqrt(),
            });
        }
    }
    Ok(tally.margin)
}

/// Proves a certified gain: see [`Family::FaultSensitivity`]. Weighted by the membership functions,
/// `h_i h_j h+_k`, the inequalities sum up to `L(h, h+) < 0`; the error's course makes the
/// multipliers drop out, and the sum over all samples is the gain.
fn prove_gain(
    dynamics: &ErrorDynamics,
    family: Family,
    certificate: &GainCertificate,
    band: &Band,
    input: &Matrix,
    value: f64,
) -> Result<Margin, Refusal> {
    let mut tally = Tally::new(family);
    let inputs = input.width();
    let p = tally.p(&certificate.p)?;
    let (q, two_cos_theta) = prove_band(&mut tally, certificate, band)?;

    let c = Matrix::exactly(&[[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]);
    let residual = &c.transpose() * &c;
    let squared = Matrix::identity(inputs).times(&(exact(value) * exact(value)));
    let (residual, squared) = match family {
        Family::FaultSensitivity => (-&residual, squared),
        _ => (residual, -&squared),
    };
    let base = |i: usize, k: usize| {
        let corner = &(&p[i] - &q.times(&two_cos_theta)) + &residual;
        let [beside, across] = [Matrix::zeros(3, inputs), Matrix::zeros(inputs, 3)];
        Matrix::blocks(&[
            &[&corner, &beside, &q],
            &[&across, &squared, &across],
            &[&q, &beside, &-&p[k]],
        ])
    };

    let order = 6 + inputs;
    let x: Vec<Vec<Matrix>> = certificate
        .x
        .iter()
        .map(|x| {
            x.iter()
                .map(|x| match x.len() == order {
                    true => Ok(Matrix::exactly(x)),
                    false => Err(Refusal::Shape { key: "X", expected: "a row for e, input, e+" }),
                })
                .collect()
        })
        .collect::<Result<_, _>>()?;

    let multiplier = |j: usize, k: usize| &x[j][k];
    let minus_identity = -&Matrix::identity(3);
    for (n, rho) in dynamics.n.iter().zip(dynamics.rho) {
        // [N_i(rho), B, -I]
        let course: Vec<Matrix> =
            n.iter().map(|n| Matrix::blocks(&[&[n, input, &minus_identity]])).collect();
        for k in 0..RULES {
            let minus_l =
                |i: usize, j: usize| -&(&base(i, k) + &(multiplier(j, k) * &course[i]).he());
            for i in 0..RULES {
                tally.prove(&minus_l(i, i), Combination::Pair { i, j: i, k, rho })?;
                for j in i + 1..RULES {
                    let sum = &minus_l(i, j) + &minus_l(j, i);
                    tally.prove(&sum, Combination::Pair { i, j, k, rho })?;
                }
            }
        }
    }
    Ok(tally.margin)
}

/// `Q > 0` and `2 cos(theta)`, on the side of the true one where the inequality is the stronger; Q
/// with the sign that it has in the base.
fn prove_band(
    tally: &mut Tally,
    certificate: &GainCertificate,
    band: &Band,
) -> Result<(Matrix, Rational), Refusal> {
    let Some(in_band) = &certificate.band else {
        // Without Q the gain holds for all frequencies, so for any band.
        return Ok((Matrix::zeros(3, 3), whole(0)));
    };
    let family = tally.margin.family;
    let stored = exact(in_band.two_cos_theta);
    let (safe, negative) = match band {
        Band::Low(theta) => (stored <= theta.two_cos()[0], false),
        Band::High(theta) => (stored >= theta.two_cos()[1], true),
        Band::Full => (false, false),
    };
    if !safe {
        return Err(Refusal::Cosine { family, stored: in_band.two_cos_theta });
    }
    let q = tally.symmetric(&in_band.q, "Q")?;
    tally.prove(&q, Combination::Q)?;
    Ok((if negative { -&q } else { q }, stored))
}
