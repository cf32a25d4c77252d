//! Decay of the error, and of the residual after a start.

use crate::dynamics::ErrorDynamics;
use crate::exact::{Matrix, approximate, exact, whole};
use crate::family::{Combination, Family};
use crate::read::{Design, RULES, Rows3};
use crate::refusal::Refusal;
use crate::tally::{Margin, Tally};

/// A decay that is one: the bound on the error neither grows nor changes its sign.
pub fn check_decay(key: &'static str, decay: f64) -> Result<(), Refusal> {
    if decay <= 0.0 || decay > 1.0 {
        return Err(Refusal::Range { key: key.into(), value: [0.0, decay] });
    }
    Ok(())
}

/// The decay of the error.
///
/// # Errors
/// [`Refusal`]: the first inequality that does not hold.
pub fn prove_decay(
    dynamics: &ErrorDynamics,
    p: &[Rows3; RULES],
    decay: f64,
) -> Result<Margin, Refusal> {
    let mut tally = Tally::new(Family::Decay);
    let p = tally.p(p)?;
    for (i, p) in p.iter().enumerate() {
        tally.prove(p, Combination::Rule(i))?;
    }
    contraction(&mut tally, dynamics, &p, decay)?;
    Ok(tally.margin)
}

/// The bound on the residual after a start.
///
/// # Errors
/// [`Refusal`]: the first inequality that does not hold.
pub fn prove_start_up(dynamics: &ErrorDynamics, design: &Design) -> Result<Margin, Refusal> {
    let decay = design.detector.evaluation.start_up_decay;
    check_decay("detector.evaluation.start_up_decay", decay)?;
    let mut tally = Tally::new(Family::StartUp);
    let p = tally.p(&design.threshold.start_up.p)?;
    let output = dynamics.output().squared();
    for (i, p) in p.iter().enumerate() {
        tally.prove(&(p - &output), Combination::Rule(i))?;
    }
    contraction(&mut tally, dynamics, &p, decay)?;
    Ok(tally.margin)
}

/// The amplitude of that bound is what its P_i make it, from any lateral speed of S_x.
///
/// # Errors
/// [`Refusal::Claim`]: it is smaller.
pub fn check_amplitude(design: &Design) -> Result<(), Refusal> {
    let [right, left] = design.detector.model.range.v_y.ends();
    let v_y = exact(f64::max(right.abs(), left.abs()));
    let claimed = design.detector.evaluation.start_up_amplitude;
    let amplitude = exact(claimed);
    for p in &design.threshold.start_up.p {
        let largest = exact(p[1][1]) * &v_y * &v_y;
        if amplitude < whole(0) || &amplitude * &amplitude < largest {
            return Err(Refusal::Claim {
                key: "detector.evaluation.start_up_amplitude",
                claimed,
                proven: approximate(&largest).sqrt(),
            });
        }
    }
    Ok(())
}

/// Proves `tau^2 P_i - N_i(rho)' P_k N_i(rho) > 0`.
fn contraction(
    tally: &mut Tally,
    dynamics: &ErrorDynamics,
    p: &[Matrix],
    decay: f64,
) -> Result<(), Refusal> {
    let decay_squared = exact(decay) * exact(decay);
    for (i, k, rho, n) in dynamics.successors() {
        let next = &(&n.transpose() * &p[k]) * n;
        let x = &p[i].times(&decay_squared) - &next;
        tally.prove(&x, Combination::Successor { i, k, rho })?;
    }
    Ok(())
}
