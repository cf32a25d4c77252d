//! The inequalities, each proven by exact elimination.

use std::fmt;
use std::thread;

use crate::Refusal;
use crate::band::Band;
use crate::channel::{Channel, Channels};
use crate::error_dynamics::{Course, ErrorDynamics};
use crate::exact::{Matrix, Rational, approximate, exact, whole};
use crate::file::{APosteriori, Certified, Design, GainCertificate, RULES, Rows3};
use crate::peak::prove_peaks;
use crate::verdict::{Figures, Margin};

/// A family of inequalities.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Family {
    /// `P_s,i > 0`, `tau^2 P_s,i - N_i(rho)' P_s,k N_i(rho) > 0`: the error decays at least like
    /// tau^k.
    Decay,
    /// `P_i - C' W_r^2 C > 0`, `tau^2 P_i - N_i(rho)' P_k N_i(rho) > 0`, `amplitude^2 >= P_i,22
    /// v_y^2`: the residual after a start, `||W_r r_j|| <= amplitude tau^j`.
    StartUp,
    /// beta: with `L_k(i, j) = base(P_i, P_k, Q) - [W_r C, D_r, 0]' [W_r C, D_r, 0] +
    /// diag(0, beta^2 I, 0) + He(X_jk [N_i(rho), B_i, -I])`, `Q > 0`, `L_k(i, i) < 0`,
    /// `L_k(i, j) + L_k(j, i) < 0`, for the first fault.
    FaultSensitivity,
    /// gamma of a band of the disturbances, counted from 0 in the order in which bands occur: the
    /// same with `[W_r C, D_r, 0]' [W_r C, D_r, 0] - diag(0, gamma^2 I, 0)`, at all vertices of K
    /// where the band holds bounded noise.
    DisturbanceAttenuation(usize),
    /// gamma of all frequencies and all disturbances: the same with Q = 0.
    FullBandAttenuation,
    /// The bound on J under one input `|w| <= 1`, counted from 0, with `S = [N, B]` and
    /// `P_h = sum h_i P_i`: `P_i, V_i > 0`, `energy P_i > V_i`, at the start `e_0' P_i e_0 < 1`, and at all
    /// vertices of the premise, rho and K `diag(lambda P_h, 1 - lambda) > S' P_k S` and
    /// `diag(V_h, gain^2) - [W_r C, D_r]' [W_r C, D_r] > S' V_k S`.
    Peak(usize),
}

impl fmt::Display for Family {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Decay => "decay",
            Self::StartUp => "start-up",
            Self::FaultSensitivity => "fault sensitivity, beta",
            Self::DisturbanceAttenuation(band) => {
                return f.pad(&format!("disturbance attenuation, gamma[{band}]"));
            }
            Self::FullBandAttenuation => "disturbance attenuation, full band",
            Self::Peak(input) => return f.pad(&format!("bound on J, input[{input}]")),
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
    /// A vertex of premise, rho and K, and the next sample's rule.
    Vertex {
        /// Vertex.
        vertex: usize,
        /// Rule of the next sample.
        k: usize,
    },
    /// A pair of rules, their successor, rho and K.
    Pair {
        /// Rule of this sample.
        i: usize,
        /// The same or another.
        j: usize,
        /// Rule of the next.
        k: usize,
        /// Slope of phi.
        rho: f64,
        /// Vertex of K; none without bounded noise.
        vertex: Option<usize>,
    },
}

impl fmt::Display for Combination {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Rule(i) => write!(f, "rule i = {i}"),
            Self::Q => write!(f, "Q > 0"),
            Self::Successor { i, k, rho } => write!(f, "rules i = {i}, k = {k}, rho = {rho}"),
            Self::Vertex { vertex, k } => write!(f, "vertex {vertex} of the premise, k = {k}"),
            Self::Pair { i, j, k, rho, vertex } => {
                write!(f, "rules i = {i}, j = {j}, k = {k}, rho = {rho}")?;
                vertex.map_or(Ok(()), |vertex| write!(f, ", vertex {vertex} of K"))
            }
        }
    }
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
    let channels = Channels::new(design)?;
    let Channels { fault, disturbances, .. } = &channels;
    if certificate.gamma.len() != disturbances.len() {
        let expected = "a certificate for each band of the disturbances";
        return Err(Refusal::Shape { key: "certificate.a_posteriori.gamma", expected });
    }
    check_figures(claimed, certificate, &channels)?;
    let all = &Channel::stacked(disturbances);
    let mut gains = vec![(Family::FaultSensitivity, &certificate.beta, fault)];
    gains.extend(certificate.gamma.iter().zip(disturbances).enumerate().map(
        |(band, (certificate, channel))| {
            (Family::DisturbanceAttenuation(band), certificate, channel)
        },
    ));
    gains.push((Family::FullBandAttenuation, &certificate.gamma_full_band, all));

    let dynamics = &ErrorDynamics::new(design);
    let margins: Result<Vec<_>, _> = thread::scope(|scope| {
        let gains: Vec<_> = gains
            .into_iter()
            .map(|(family, certificate, channel)| {
                scope.spawn(move || prove_gain(dynamics, family, certificate, channel))
            })
            .collect();
        let others = [
            prove_decay(dynamics, &design.certificate.p_s, claimed.decay),
            prove_start_up(dynamics, design),
        ];
        let joined = gains
            .into_iter()
            .map(|gain| gain.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)));
        others.into_iter().chain(joined).collect()
    });
    let mut margins = margins?;
    margins.extend(prove_peaks(dynamics, design)?);
    let Certified { beta, gamma, gap, gamma_full_band, decay } = *claimed;
    Ok((Figures { beta, gamma, gap, gamma_full_band, decay }, margins))
}

/// The claimed figures follow from the gains of the certificate, and the gap from the figures.
///
/// # Errors
/// [`Refusal::Claim`]: a figure that does not.
fn check_figures(
    claimed: &Certified,
    certificate: &APosteriori,
    channels: &Channels,
) -> Result<(), Refusal> {
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
    check_decay("performance.certified.decay", claimed.decay)?;

    let square = |x: f64| exact(x) * exact(x);
    // Of several bands: ||W_r r|| < sum of gamma_c ||d_c||, for d of norm one at most the root of
    // the sum of gamma_c^2.
    let blocks: Rational = certificate.gamma.iter().map(|block| square(block.gain)).sum();
    let (beta, full) = (certificate.beta.gain, certificate.gamma_full_band.gain);
    let gap =
        exact(claimed.beta) * &channels.smallest_fault / (exact(claimed.gamma) * &channels.bound);
    for (key, claimed, holds, proven) in [
        ("performance.certified.beta", claimed.beta, square(claimed.beta) <= square(beta), beta),
        (
            "performance.certified.gamma",
            claimed.gamma,
            square(claimed.gamma) >= blocks,
            approximate(&blocks).sqrt(),
        ),
        (
            "performance.certified.gamma_full_band",
            claimed.gamma_full_band,
            square(claimed.gamma_full_band) >= square(full),
            full,
        ),
        ("performance.certified.gap", claimed.gap, exact(claimed.gap) <= gap, approximate(&gap)),
    ] {
        if !holds {
            return Err(Refusal::Claim { key, claimed, proven });
        }
    }
    Ok(())
}

/// The bound on the error neither grows nor changes its sign.
fn check_decay(key: &'static str, decay: f64) -> Result<(), Refusal> {
    if decay <= 0.0 || decay > 1.0 {
        return Err(Refusal::Range { key: key.into(), value: [0.0, decay] });
    }
    Ok(())
}

/// Counts the inequalities of a family and keeps the smallest margin.
pub(crate) struct Tally {
    pub(crate) margin: Margin,
}

impl Tally {
    pub(crate) fn new(family: Family) -> Self {
        Self { margin: Margin { family, inequalities: 0, smallest_pivot: f64::INFINITY } }
    }

    /// Proves `X > 0`.
    pub(crate) fn prove(&mut self, x: &Matrix, combination: Combination) -> Result<(), Refusal> {
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
    pub(crate) fn p(&self, p: &[Rows3; RULES]) -> Result<Vec<Matrix>, Refusal> {
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
    let output = dynamics.output().squared();
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

/// Proves the gain of a certificate: see [`Family::FaultSensitivity`]. Weighted by the membership
/// functions, `h_i h_j h+_k`, the inequalities sum up to `L(h, h+) < 0`; the error's course makes
/// the multipliers drop out, and the sum over all samples is the gain.
fn prove_gain(
    dynamics: &ErrorDynamics,
    family: Family,
    certificate: &GainCertificate,
    channel: &Channel,
) -> Result<Margin, Refusal> {
    let mut tally = Tally::new(family);
    let base = base(&mut tally, dynamics, certificate, channel)?;
    let order = 6 + channel.inputs();
    if certificate.x.iter().flatten().any(|x| x.len() != order) {
        return Err(Refusal::Shape { key: "X", expected: "a row for e, input, e+" });
    }
    let x = certificate.x.each_ref().map(|x| x.each_ref().map(|x| Matrix::exactly(x)));
    for course in dynamics.courses(channel) {
        let Course { rho, vertex, by_rule } = &course;
        for k in 0..RULES {
            let minus_l = |i: usize, j: usize| -&(&base[i][k] + &(&x[j][k] * &by_rule[i]).he());
            for i in 0..RULES {
                for j in i..RULES {
                    let sum = match i == j {
                        true => minus_l(i, i),
                        false => &minus_l(i, j) + &minus_l(j, i),
                    };
                    let place = Combination::Pair { i, j, k, rho: *rho, vertex: *vertex };
                    tally.prove(&sum, place)?;
                }
            }
        }
    }
    Ok(tally.margin)
}

/// `base(P_i, P_k, Q) +- ([W_r C, D_r, 0]' [W_r C, D_r, 0] - diag(0, gain^2 I, 0))` by i and k.
fn base(
    tally: &mut Tally,
    dynamics: &ErrorDynamics,
    certificate: &GainCertificate,
    channel: &Channel,
) -> Result<Vec<Vec<Matrix>>, Refusal> {
    let p = tally.p(&certificate.p)?;
    let (q, two_cos_theta) = prove_band(tally, certificate, &channel.band)?;
    let inputs = channel.inputs();
    let [beside, across] = [Matrix::zeros(3, inputs), Matrix::zeros(inputs, 3)];

    let squared =
        Matrix::identity(inputs).times(&(exact(certificate.gain) * exact(certificate.gain)));
    let squared = Matrix::blocks(&[&[&Matrix::zeros(3, 3), &beside], &[&across, &squared]]);
    let quadratic = &dynamics.output_with(channel).squared() - &squared;
    let quadratic =
        if tally.margin.family == Family::FaultSensitivity { -&quadratic } else { quadratic };
    let no_input = Matrix::zeros(inputs, inputs);
    let of = |p_i: &Matrix, p_k: &Matrix| {
        let corner = p_i - &q.times(&two_cos_theta);
        let now = &Matrix::blocks(&[&[&corner, &beside], &[&across, &no_input]]) + &quadratic;
        let course = Matrix::blocks(&[&[&q], &[&across]]);
        Matrix::blocks(&[&[&now, &course], &[&course.transpose(), &-p_k]])
    };
    Ok(p.iter().map(|p_i| p.iter().map(|p_k| of(p_i, p_k)).collect()).collect())
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
