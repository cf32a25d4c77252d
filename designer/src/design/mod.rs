//! From specification to design.

pub mod file;

use clarabel::solver::SolverStatus;
use steerguard_detector::{C, Configuration, ConfigurationError, Evaluation, RULES};

use crate::analysis::certificate::{Check, check, error_dynamics};
use crate::analysis::estimate::EstimateFigures;
use crate::analysis::frequency::{detection_ratio, frozen, limit};
use crate::analysis::operating_point::{OperatingPoint, fixed, spectral_radius};
use crate::analysis::start_up;
use crate::analysis::worth::Worth;
use crate::design::file::{
    AttenuationRecord, Certificate, Constants, Design, DesignFileError, DesignStatus, FORMAT,
    FaultFigures, FrozenRecord, LargestBeta, Performance, Rule, StartUpRecord, SynthesisRecord,
    ThresholdRecord,
};
use crate::document::Mistakes;
use crate::lmi::matrix::{Matrix, nested, rows};
use crate::problem::band::Band;
use crate::problem::inputs::{self, Inputs};
use crate::problem::model;
use crate::progress::Step;
use crate::search::{SearchRecord, search};
use crate::sight::{Sight, sight};
use crate::spec::{MethodName, Spec, ThresholdKind};
use crate::synthesis::gains::ObserverGains;
use crate::synthesis::obstacle::{Obstacle, diagnose};
use crate::synthesis::solve::{AttenuationMatrices, Goal, NoSolution, Synthesis, solve};
use crate::synthesis::theorem4::Theorem4;
use crate::threshold::guaranteed::PeakCertificate;
use crate::threshold::recorded::RecordedDrive;
use crate::threshold::second::SecondLevels;
use crate::threshold::{self, Threshold, ThresholdError};

/// The start-up term may be forgotten once below this share of the smallest fault's residual.
const NEGLIGIBLE: f64 = 0.1;
/// The solver, for the record.
const SOLVER: &str = "clarabel 0.11";

/// Why there is no design.
#[derive(Debug, thiserror::Error)]
pub enum DesignError {
    /// The specification is not possible.
    #[error(transparent)]
    Spec(#[from] Mistakes),
    /// Other drives than the specification's.
    #[error("evaluation.calibration.drives: {named:?} are to be read and handed to the designer")]
    Drives {
        /// Those of the specification.
        named: Vec<String>,
    },
    /// The conditions contradict each other.
    #[error("the specification is infeasible: {0}")]
    Infeasible(Obstacle),
    /// The solver gave up on a problem that has a solution.
    #[error("the solver gave up on the smallest gamma for beta = {beta}: {reason}")]
    Solver {
        /// beta asked for.
        beta: f64,
        /// What the solver said.
        reason: NoSolution,
    },
    /// The residual has no bound after a start.
    #[error(
        "no decaying bound on the residual after a start was found: raise design.decay or leave it out, \
         or narrow operating_range.v_x_m_per_s"
    )]
    StartUp,
    /// There is no threshold.
    #[error(transparent)]
    Threshold(#[from] ThresholdError),
    /// The detector refuses the numbers found.
    #[error(transparent)]
    Configuration(#[from] ConfigurationError),
    /// A number that JSON cannot hold.
    #[error(transparent)]
    Json(#[from] serde_json::Error),
    /// A design that does not read back.
    #[error(transparent)]
    File(#[from] DesignFileError),
}

/// Designs a detector for `spec`, whose threshold counts no recorded drives: [`design_with_drives`].
///
/// # Errors
/// As there.
pub fn design(spec: &Spec, progress: &mut dyn FnMut(Step)) -> Result<Design, DesignError> {
    design_with_drives(spec, &[], progress)
}

/// Designs a detector for `spec` with the recorded `drives` of `evaluation.calibration.drives`, in their
/// order; `progress` hears of every step. The same specification and drives give the same design, bit for
/// bit.
///
/// # Errors
/// [`DesignError`]: a specification that is refused, infeasible (with the condition that stands in
/// the way), or one that the numerics cannot master; other drives than the specification names.
pub fn design_with_drives(
    spec: &Spec,
    drives: &[RecordedDrive],
    progress: &mut dyn FnMut(Step),
) -> Result<Design, DesignError> {
    spec.check()?;
    let named = &spec.evaluation.calibration.drives;
    if !drives.iter().map(|drive| &drive.file).eq(named) {
        return Err(DesignError::Drives { named: named.clone() });
    }
    let model = model::model(spec);
    let inputs = Inputs::of(spec)?;

    let found = found(spec, &inputs, progress)?;
    let Found { gains, p_s, synthesis, theorem, worth, .. } = &found;
    let (certified, a_posteriori) = worth.certified.clone().unzip();
    // The matrices of (31) and (32), where the gains are those that they were found with.
    let of_theorem = found.check.map(|_| &synthesis.lyapunov);

    let smallest_fault_residual = worth.frozen.beta * inputs.smallest_fault;
    let Evaluated { detector, threshold, peaks, sight } =
        evaluate(spec, drives, theorem, (gains, p_s), smallest_fault_residual, progress)?;

    let design = Design {
        format: FORMAT.into(),
        constants: Constants::USED,
        detector,
        vertices: std::array::from_fn(|i| Rule {
            a: model.vertices()[i],
            n: gains.gains.n[i],
            l: gains.gains.l[i],
            h: gains.h[i],
        }),
        b: model.b(),
        g: model.g_phi().map(|g| [g]),
        c: C,
        d: nested(&model::d(spec)),
        d_y: Some(inputs::d_y(spec)).filter(|d_y| d_y.ncols() > 0).map(|d_y| nested(&d_y)),
        f: nested(&model::f(spec)),
        threshold,
        synthesis: SynthesisRecord {
            method: spec.design.method,
            alpha_d: theorem.alpha_d,
            alpha_f: theorem.alpha_f,
            v: nested(&theorem.v),
            gamma: synthesis.gamma,
            beta: synthesis.beta,
            beta_bound: theorem.beta_bound(),
            gap: synthesis.beta * inputs.smallest_fault / (synthesis.gamma * inputs.bound),
            solver: SOLVER.into(),
            status: unproven(synthesis.status),
            unproven: None,
            solver_status: format!("{:?}", synthesis.status),
            iterations: synthesis.iterations,
            largest_beta: found.largest_beta.clone(),
            search: found.search,
        },
        performance: Performance {
            limit: worth.points.iter().filter_map(|x| x.limit).reduce(f64::min),
            detection_ratio: worth.detection_ratio(&inputs),
            noise_rms: worth.noise_rms,
            frozen: FrozenRecord::new(worth.frozen, inputs.smallest_fault, inputs.bound),
            certified,
            norm:
                "2-norm of the stacked disturbances of a band, each in proportion to its bound, to \
                   the 2-norm of the weighted residual; of several bands the root of the sum of \
                   squares"
                    .into(),
            spectral_radii: gains.gains.n.map(|n| spectral_radius(&fixed(&n))),
            smallest_fault_residual,
            decay: theorem.decay,
            estimate: estimate_cap(spec)
                .map(|cap| EstimateFigures::of(&model, &gains.gains, &inputs.fault, cap)),
            operating_points: worth.points.clone(),
            other_faults: other_faults(spec, gains, worth, &inputs)?,
            sight,
        },
        certificate: Certificate {
            statement: of_theorem.map(|_| statement(theorem)),
            p_s: found.p_s.each_ref().map(rows),
            attenuation: of_theorem.map(|lyapunov| {
                let of_band = |x: &AttenuationMatrices| AttenuationRecord {
                    gamma: x.gamma,
                    p_d: x.p.each_ref().map(rows),
                    q_d: rows(&x.q),
                };
                lyapunov.attenuation.iter().map(of_band).collect()
            }),
            p_f: of_theorem.map(|lyapunov| lyapunov.p_f.each_ref().map(rows)),
            q_f: of_theorem.map(|lyapunov| rows(&lyapunov.q_f)),
            r: of_theorem.map(|lyapunov| rows(&lyapunov.r)),
            margins: found.check,
            a_posteriori,
            peaks,
        },
        spec: spec.clone(),
        hash: String::new(),
    };
    design.detector.check()?;
    sign(design)
}

/// Gains, and how they were found.
struct Found {
    gains: ObserverGains,
    /// P_s,i that prove their decay.
    p_s: [Matrix; RULES],
    /// What they are of, or what the search went on from.
    synthesis: Synthesis,
    /// With the multipliers of that synthesis.
    theorem: Theorem4,
    /// What the gains are worth.
    worth: Worth,
    /// Of method "paper".
    largest_beta: Option<LargestBeta>,
    /// (13), (31)-(33) for the gains, where they are those of the synthesis.
    check: Option<Check>,
    /// Of method "gap".
    search: Option<SearchRecord>,
    /// Of method "gap": see [`crate::search::Found`].
    merit: f64,
    is_refined: bool,
}

/// Gains by the method asked for, with the first decay rate that has a certified design; where none
/// has, the best there is.
fn found(
    spec: &Spec,
    inputs: &Inputs,
    progress: &mut dyn FnMut(Step),
) -> Result<Found, DesignError> {
    let mut best: Option<Found> = None;
    let mut refused = None;
    for decay in spec.design.decays(spec.sampling.period_s) {
        let theorem = Theorem4::of(spec, inputs, decay);
        let found = match spec.design.method {
            MethodName::Paper => return paper(spec, &theorem, inputs, progress),
            MethodName::Gap => by_gap(spec, &theorem, inputs, progress),
        };
        match found {
            Some(found) if found.is_refined => return Ok(found),
            Some(found) if best.as_ref().is_none_or(|best| found.merit > best.merit) => {
                best = Some(found);
            }
            Some(_) => {}
            None => refused = refused.or(Some(theorem)),
        }
    }
    match (best, refused) {
        (Some(found), _) => Ok(found),
        (None, Some(theorem)) => Err(infeasible(spec, &theorem)),
        (None, None) => Err(DesignError::StartUp),
    }
}

/// Method "paper": Theorem 4 with the given multipliers.
fn paper(
    spec: &Spec,
    theorem: &Theorem4,
    inputs: &Inputs,
    progress: &mut dyn FnMut(Step),
) -> Result<Found, DesignError> {
    progress(Step::LargestBeta);
    let largest = largest_beta(spec, theorem)?;
    progress(Step::SmallestGamma);
    let synthesis = smallest_gamma(spec, theorem, largest.beta)?;
    progress(Step::Check);
    let Synthesis { gains, lyapunov, beta, .. } = &synthesis;
    let check = check(theorem, gains, lyapunov, *beta);
    progress(Step::Certify);
    Ok(Found {
        gains: *gains,
        worth: Worth::of(gains, theorem, &model::model(spec), inputs),
        p_s: lyapunov.p_s.clone(),
        check: Some(check),
        theorem: theorem.clone(),
        largest_beta: Some(LargestBeta {
            gamma: largest.gamma,
            beta: largest.beta,
            solver_status: format!("{:?}", largest.status),
            iterations: largest.iterations,
        }),
        search: None,
        merit: 0.0,
        is_refined: true,
        synthesis,
    })
}

/// Method "gap": the search. None where no synthesis has a solution.
fn by_gap(
    spec: &Spec,
    theorem: &Theorem4,
    inputs: &Inputs,
    progress: &mut dyn FnMut(Step),
) -> Option<Found> {
    let cap = estimate_cap(spec);
    let found = search(theorem, &model::model(spec), inputs, &spec.design, cap, progress)?;
    Some(Found {
        gains: found.gains,
        p_s: found.p_s,
        worth: found.worth,
        synthesis: found.synthesis,
        theorem: found.theorem,
        largest_beta: None,
        check: None,
        search: Some(found.record),
        merit: found.merit,
        is_refined: found.is_refined,
    })
}

/// Cap on e_2 after a step of the fault that is designed for.
fn estimate_cap(spec: &Spec) -> Option<f64> {
    spec.fault[0].estimate_cap(spec.operating_range.v_y_m_per_s)
}

/// What stands in the way of a synthesis.
fn infeasible(spec: &Spec, theorem: &Theorem4) -> DesignError {
    let gamma = match spec.design.method {
        MethodName::Paper => Some(spec.design.gamma),
        MethodName::Gap => None,
    };
    DesignError::Infeasible(diagnose(theorem, gamma, spec.design.beta_fraction))
}

/// The figures of the faults that the gains were not made for.
fn other_faults(
    spec: &Spec,
    gains: &ObserverGains,
    worth: &Worth,
    inputs: &Inputs,
) -> Result<Vec<FaultFigures>, Mistakes> {
    let points = OperatingPoint::grid(&model::model(spec));
    let channels = inputs::fault_channels(spec)?;
    let others = spec.fault.iter().zip(channels).skip(1);
    let figures = others.map(|(fault, channel)| {
        let inputs = Inputs { fault: channel, smallest_fault: fault.smallest(), ..inputs.clone() };
        let frozen = frozen(&points, &gains.gains, &inputs);
        let limits = points.iter().filter_map(|point| limit(point, &inputs));
        let noise_rms = worth.noise_rms;
        FaultFigures {
            fault: *fault,
            limit: limits.reduce(f64::min),
            detection_ratio: detection_ratio(frozen.beta, frozen.gamma, noise_rms, &inputs),
            frozen: FrozenRecord::new(frozen, inputs.smallest_fault, inputs.bound),
        }
    });
    Ok(figures.collect())
}

/// Gives the design its status and hash. Only the proof of the very file grants "certified"; without
/// it, no figure is claimed. What is blind is called so in either case.
fn sign(mut design: Design) -> Result<Design, DesignError> {
    let blind = design.performance.sight.as_ref().is_some_and(|sight| sight.blind.is_some());
    let or_blind = |status| if blind { DesignStatus::Blind } else { status };
    let unproven = design.synthesis.status;
    design.synthesis.status = or_blind(DesignStatus::Certified);
    design.hash = design.computed_hash()?;
    if let Err(refusal) = steerguard_verify::verify(&design.to_json()?) {
        design.synthesis.status = or_blind(unproven);
        design.synthesis.unproven = Some(refusal.to_string());
        design.performance.certified = None;
        design.certificate.a_posteriori = None;
        design.hash = design.computed_hash()?;
    }
    // What is handed on is what the file holds, bit for bit.
    Ok(Design::from_json(&design.to_json()?)?)
}

/// The paper's problem: the largest beta subject to (31)-(33) with the given gamma.
fn largest_beta(spec: &Spec, theorem: &Theorem4) -> Result<Synthesis, DesignError> {
    let gamma = spec.design.gamma;
    solve(theorem, Goal::LargestBeta { gamma: Some(gamma) }).map_err(|_| infeasible(spec, theorem))
}

/// The well-posed problem: the smallest gamma subject to (31)-(33), with beta just inside its bound.
fn smallest_gamma(
    spec: &Spec,
    theorem: &Theorem4,
    largest_beta: f64,
) -> Result<Synthesis, DesignError> {
    let fraction = spec.design.beta_fraction;
    // A tight gamma keeps beta away from the bound; then the largest beta takes its place.
    let reached = largest_beta >= fraction * theorem.beta_bound();
    let beta = fraction * if reached { theorem.beta_bound() } else { largest_beta };
    solve(theorem, Goal::SmallestGamma { beta: Some(beta) })
        .map_err(|reason| DesignError::Solver { beta, reason })
}

/// What the detector is told, and what its threshold rests on.
struct Evaluated {
    detector: Configuration,
    threshold: ThresholdRecord,
    /// What proves a guaranteed threshold.
    peaks: Option<Vec<PeakCertificate>>,
    sight: Option<Sight>,
}

/// Start-up bound and threshold.
fn evaluate(
    spec: &Spec,
    drives: &[RecordedDrive],
    theorem: &Theorem4,
    (gains, p_s): (&ObserverGains, &[Matrix; RULES]),
    smallest_fault_residual: f64,
    progress: &mut dyn FnMut(Step),
) -> Result<Evaluated, DesignError> {
    progress(Step::StartUp);
    let e = &spec.evaluation;
    let without_threshold = Evaluation {
        window: e.window(spec.sampling.period_s),
        weights: e.weights,
        threshold: 1.0,
        uncertainty_share: 0.0,
        start_up_amplitude: 0.0,
        start_up_decay: 0.0,
        debounce_samples: e.debounce_samples,
        alarm_hold_s: e.alarm_hold_s,
    };
    let model = model::model(spec);
    let v_y = spec.operating_range.range().v_y.magnitude();
    let of_uncertain = match e.threshold {
        ThresholdKind::Adaptive => {
            let vehicles: Vec<_> = spec.uncertainty.corners(&spec.vehicle).collect();
            start_up::of_vehicles(&vehicles, &model, &gains.gains, &without_threshold, v_y)
        }
        _ => Vec::new(),
    };
    let bound = start_up::bound(
        &error_dynamics(theorem, gains),
        theorem.decay,
        p_s,
        &without_threshold,
        v_y,
        &of_uncertain,
        NEGLIGIBLE * smallest_fault_residual,
    )
    .ok_or(DesignError::StartUp)?;

    let configuration = Configuration {
        model,
        hysteresis: spec.operating_range.hysteresis(),
        gains: gains.gains,
        evaluation: Evaluation {
            start_up_amplitude: bound.amplitude,
            start_up_decay: bound.decay,
            ..without_threshold
        },
        deviations: model::deviations(spec),
        actuator: spec.actuator.actuator(),
        zero: spec.sensors.zero(),
        staleness: model::staleness(spec),
        estimator: None,
    };
    let found = threshold::threshold(spec, drives, theorem, gains, &configuration, progress)?;
    let Threshold { threshold, uncertainty_share, .. } = found;
    let evaluation = Evaluation { threshold, uncertainty_share, ..configuration.evaluation };
    let of_second = |x: &SecondLevels| {
        model::estimator(spec, x.threshold(e.margin, &found.recorded), x.in_99_of_100)
    };
    let estimator = found.second.as_ref().and_then(of_second);
    let detector = Configuration { evaluation, estimator, ..configuration };
    progress(Step::Sight);
    let sight = sight(spec, &detector, &found)?;
    let Threshold { calibration, uncertain, recorded, searched, second, guaranteed, peaks, .. } =
        found;
    let causes = ThresholdRecord {
        kind: e.threshold,
        margin: e.margin,
        start_up: StartUpRecord { p: bound.p.each_ref().map(rows), margin: bound.margin },
        calibration,
        uncertain,
        recorded,
        searched,
        second,
        guaranteed,
    };
    Ok(Evaluated { detector, threshold: causes, peaks, sight })
}

/// What a design may be called without a proof.
fn unproven(solver: SolverStatus) -> DesignStatus {
    match solver {
        SolverStatus::AlmostSolved => DesignStatus::AlmostSolved,
        _ => DesignStatus::Uncertified,
    }
}

/// What (31)-(33) prove.
fn statement(theorem: &Theorem4) -> String {
    let input = |name: &str, band: Band| match band {
        Band::Low(theta) => format!(
            "any l2 input {name} whose error e obeys \
             sum (e+ - e)(e+ - e)' <= 4 sin^2({theta:.6} / 2) sum e e'"
        ),
        Band::High(theta) => format!(
            "any l2 input {name} whose error e obeys \
             sum (e+ - e)(e+ - e)' >= 4 sin^2({theta:.6} / 2) sum e e'"
        ),
        Band::Full => format!("any l2 input {name}"),
    };
    let bands = theorem.disturbances.iter().map(|channel| input("d", channel.band));
    format!(
        "If the margins hold: for x and x^ in S_x and any course of the premise, the error decays \
         at least like {}^k; with e_0 = 0, ||W_r r|| < gamma ||d|| for {}; ||W_r r|| > beta ||f|| for \
         {}. Checked in double precision against a stated rounding allowance, not in exact \
         arithmetic.",
        theorem.decay,
        bands.collect::<Vec<_>>().join(", and with its own gamma "),
        input("f", theorem.fault.band),
    )
}

#[cfg(test)]
mod tests {
    use steerguard_verify::{Status, verify};

    use super::*;

    /// A certificate that its proof refutes leaves a design that claims no figures, and says why.
    #[test]
    fn a_design_without_proof_claims_nothing() -> Result<(), DesignError> {
        let proven = Design::from_json(include_str!("../../verify/tests/fixtures/paper.json"))?;
        let mut design = proven.clone();
        design.synthesis.status = DesignStatus::AlmostSolved;
        for gain in design.certificate.a_posteriori.iter_mut().map(|x| &mut x.beta.gain) {
            *gain *= 1.01;
        }
        let signed = sign(design)?;
        assert_eq!(signed.synthesis.status, DesignStatus::AlmostSolved);
        let missed = signed.synthesis.unproven.as_deref().unwrap_or_default();
        assert!(missed.contains("fault sensitivity, beta"), "{missed}");
        assert_eq!(signed.performance.certified, None);
        assert_eq!(signed.certificate.a_posteriori, None);
        assert_eq!(signed.detector, proven.detector);
        let verdict = verify(&signed.to_json()?).unwrap_or_else(|refusal| panic!("{refusal}"));
        assert_eq!((verdict.status, verdict.figures), (Status::AlmostSolved, None));
        assert_eq!(sign(proven.clone())?, proven);
        Ok(())
    }
}
