//! The gains: beta of the fault, gamma of the disturbances (method 5.3).

use crate::band::Band;
use crate::channel::Channel;
use crate::dynamics::{Course, ErrorDynamics};
use crate::exact::{Matrix, Rational, exact, whole};
use crate::family::{Combination, Family};
use crate::read::{GainCertificate, RULES};
use crate::refusal::Refusal;
use crate::tally::{Margin, Tally};

/// Proves the gain of a certificate: see [`Family::FaultSensitivity`]. Weighted by the membership
/// functions, `h_i h_j h+_k`, the inequalities sum up to `L(h, h+) < 0`; the error's course makes
/// the multipliers drop out, and the sum over all samples is the gain.
///
/// # Errors
/// [`Refusal`]: the first inequality that does not hold.
pub fn prove_gain(
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
