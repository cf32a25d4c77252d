//! The bound on J of a guaranteed threshold (method 6).
//!
//! For an input w, `|w| <= 1`, the first inequality of [`Family::Peak`] keeps the error in the set
//! `e' P_h e <= 1`, where its start lies. Along its course the second one sums up over the window of
//! n samples to `n J^2 <= n gain^2 + V`, with V of the window's first sample at most `energy`. Both are
//! concave in (h, S) and affine in P_k and V_k: they hold everywhere if they do at the vertices. By
//! superposition, J under all inputs is at most the sum of J under each, and with a lateral speed at the
//! start at most the start-up term more.
//!
//! # Vertices
//! Without noise: the rules, at both ends of rho. With noise, K and h are tied by the speed, see
//! [`premise::speed_memberships`]; v_y and r in K are free.

use crate::agreement::same;
use crate::channel::{BoundedInput, bounded_inputs, positive};
use crate::dynamics::{Course, ErrorDynamics};
use crate::exact::{Matrix, Rational, approximate, exact, whole};
use crate::family::{Combination, Family};
use crate::premise;
use crate::read::{Design, Guaranteed, PeakCertificate, RULES};
use crate::refusal::Refusal;
use crate::tally::{Margin, Tally};

/// Value of `threshold.kind` that this is about.
const GUARANTEED: &str = "guaranteed";

/// Proves the claim of a guaranteed threshold; nothing for other kinds.
///
/// # Errors
/// [`Refusal`]: the first inequality or claim that does not hold.
pub fn prove_peaks(dynamics: &ErrorDynamics, design: &Design) -> Result<Vec<Margin>, Refusal> {
    let (claimed, certificates) = (&design.threshold.guaranteed, &design.certificate.peaks);
    if design.threshold.kind != GUARANTEED {
        return Ok(Vec::new());
    }
    let inputs = bounded_inputs(design)?;
    let missing = |key| Refusal::NoCertificate { key };
    let claimed = claimed.as_ref().ok_or(missing("threshold.guaranteed"))?;
    let certificates = certificates.as_ref().ok_or(missing("certificate.peaks"))?;
    for (key, count) in [
        ("threshold.guaranteed.inputs", claimed.inputs.len()),
        ("certificate.peaks", certificates.len()),
    ] {
        if count != inputs.len() {
            return Err(Refusal::Shape {
                key,
                expected: "one for each disturbance and bounded noise",
            });
        }
    }
    check_claims(design, claimed, certificates, &inputs)?;
    let memberships = premise::speed_memberships(design);
    let proofs = inputs.iter().zip(certificates).enumerate();
    proofs
        .map(|(index, (input, certificate))| {
            let vertices = vertices(dynamics, input, &memberships);
            prove_peak(dynamics, Family::Peak(index), input, certificate, &vertices)
        })
        .collect()
}

/// The claimed figures follow from the certificates, and the threshold from the figures.
fn check_claims(
    design: &Design,
    claimed: &Guaranteed,
    certificates: &[PeakCertificate],
    inputs: &[BoundedInput],
) -> Result<(), Refusal> {
    let window = positive("detector.evaluation.window", design.detector.evaluation.window)?;
    let mut sum = whole(0);
    for ((claim, certificate), input) in claimed.inputs.iter().zip(certificates).zip(inputs) {
        let of = |x| format!("threshold.guaranteed.inputs: {x}");
        same(&of("name"), &claim.name, &input.name)?;
        same(&of("bound"), &claim.bound, &input.bound)?;
        let (gain, j) = (exact(certificate.gain), exact(claim.j));
        let squared = &gain * &gain + exact(certificate.energy) / &window;
        if claim.j < 0.0 || &j * &j < squared {
            return Err(Refusal::Claim {
                key: "threshold.guaranteed.inputs: j",
                claimed: claim.j,
                proven: approximate(&squared).sqrt(),
            });
        }
        sum += j;
    }
    let Guaranteed { bound, .. } = *claimed;
    let threshold = design.detector.evaluation.threshold;
    for (key, claimed, proven) in [
        ("threshold.guaranteed.bound", bound, sum),
        ("detector.evaluation.threshold", threshold, exact(bound)),
    ] {
        if exact(claimed) < proven {
            return Err(Refusal::Claim { key, claimed, proven: approximate(&proven) });
        }
    }
    Ok(())
}

/// A vertex of the membership functions and of the error dynamics.
struct Vertex {
    /// h.
    membership: [Rational; RULES],
    /// `S = [N, B]`, 3 x 4.
    step: Matrix,
}

/// All vertices for one input.
fn vertices(
    dynamics: &ErrorDynamics,
    input: &BoundedInput,
    memberships: &[[Rational; 2]; 4],
) -> Vec<Vertex> {
    let rules = (0..RULES).map(|i| std::array::from_fn(|k| whole(i64::from(i == k))));
    let rules: Vec<[Rational; RULES]> = rules.collect();
    let mut vertices: Vec<Vertex> = Vec::new();
    for Course { vertex, by_rule, .. } in dynamics.courses(&input.channel) {
        let shares = match vertex {
            None => rules.clone(),
            Some(vertex) => {
                let of_speed = &memberships[vertex / premise::VERTICES_OF_SPEED];
                of_speed.iter().flat_map(at_both_ends_of_r).collect()
            }
        };
        for membership in shares {
            let blend = by_rule
                .iter()
                .zip(&membership)
                .fold(Matrix::zeros(3, 7), |sum, (course, h)| &sum + &course.times(h));
            let step = Matrix::new(3, 4, |row, column| blend.at(row, column));
            // One signal's column of K does not depend on all that K does.
            let same = |x: &Vertex| x.membership == membership && x.step == step;
            if !vertices.iter().any(same) {
                vertices.push(Vertex { membership, step });
            }
        }
    }
    vertices
}

/// h of the rules where those of the lowest speed have the share `slow`: at the lowest and the highest
/// r.
fn at_both_ends_of_r(slow: &Rational) -> [[Rational; RULES]; 2] {
    let (fast, none) = (whole(1) - slow, whole(0));
    [
        [slow.clone(), none.clone(), fast.clone(), none.clone()],
        [none.clone(), slow.clone(), none, fast],
    ]
}

/// See [`Family::Peak`].
fn prove_peak(
    dynamics: &ErrorDynamics,
    family: Family,
    input: &BoundedInput,
    certificate: &PeakCertificate,
    vertices: &[Vertex],
) -> Result<Margin, Refusal> {
    let PeakCertificate { lambda, gain, energy, .. } = *certificate;
    if !(0.0..=1.0).contains(&lambda) {
        return Err(Refusal::Range {
            key: "certificate.peaks: lambda".into(),
            value: [0.0, lambda],
        });
    }
    let mut tally = Tally::new(family);
    let (p, v) = (tally.p(&certificate.p)?, tally.p(&certificate.v)?);
    let start = dynamics.start(&input.channel);
    for (i, (p, v)) in p.iter().zip(&v).enumerate() {
        for x in [p, v, &(&p.times(&exact(energy)) - v)] {
            tally.prove(x, Combination::Rule(i))?;
        }
        if start.width() > 0 {
            let at_start = &(&start.transpose() * p) * &start;
            tally.prove(&(&Matrix::identity(1) - &at_start), Combination::Rule(i))?;
        }
    }
    let squared = dynamics.output_with(&input.channel).squared();
    let (lambda, gain) = (exact(lambda), exact(gain));
    let [of_invariance, of_dissipation] =
        [whole(1) - &lambda, &gain * &gain].map(|x| Matrix::identity(1).times(&x));
    for (vertex, Vertex { membership, step }) in vertices.iter().enumerate() {
        let now_p = with_input(&blend(&p, membership).times(&lambda), &of_invariance);
        let now_v = &with_input(&blend(&v, membership), &of_dissipation) - &squared;
        for k in 0..RULES {
            for (now, next) in [(&now_p, &p[k]), (&now_v, &v[k])] {
                let next = &(&step.transpose() * next) * step;
                tally.prove(&(now - &next), Combination::Vertex { vertex, k })?;
            }
        }
    }
    Ok(tally.margin)
}

/// `sum h_i X_i`.
fn blend(x: &[Matrix], membership: &[Rational; RULES]) -> Matrix {
    x.iter().zip(membership).fold(Matrix::zeros(3, 3), |sum, (x, h)| &sum + &x.times(h))
}

/// `diag(X, input)`.
fn with_input(x: &Matrix, input: &Matrix) -> Matrix {
    Matrix::blocks(&[&[x, &Matrix::zeros(3, 1)], &[&Matrix::zeros(1, 3), input]])
}
