//! Figures that follow from others in the file: threshold, synthesis, performance.
//!
//! In double precision, up to rounding; what a proof is about is compared exactly elsewhere.

use std::f64::consts::PI;

use crate::agreement::{ROUNDING, at_most, near, same, within};
use crate::band::Band;
use crate::read::{
    Design, Evaluation, Fault, Frozen, Gust, Level, Point, Rows3, Searched, Sight, Status,
};
use crate::refusal::Refusal;

/// Share of the drives that the confidence of a [`Level`] leaves: it holds with 95 %.
const LEFT_BY_CONFIDENCE: f64 = 0.05;
/// What the largest fault may make of e_2 = v_y - v_y^, in units of the range of v_y.
const RANGES_OF_V_Y: f64 = 4.0;
/// Squarings of a matrix until its norm is that of its spectral radius.
const SQUARINGS: i32 = 60;
/// Rounding of a spectral radius, which a defective matrix takes the cube root of.
const RADIUS_ROUNDING: f64 = 1e-5;

/// Checks all of them.
///
/// # Errors
/// [`Refusal::Disagreement`]: the first that does not follow.
pub fn check(design: &Design) -> Result<(), Refusal> {
    threshold(design)?;
    start_up(design)?;
    synthesis(design)?;
    performance(design)?;
    certified(design)?;
    sight(design)
}

/// Threshold and share from levels and margin, by kind.
fn threshold(design: &Design) -> Result<(), Refusal> {
    let (causes, specified) = (&design.threshold, &design.spec.evaluation);
    let Evaluation { threshold, uncertainty_share, .. } = design.detector.evaluation;
    same("threshold.kind", &causes.kind, &specified.threshold)?;
    same("threshold.margin", &causes.margin, &specified.margin)?;

    match (specified.covers.as_str(), causes.kind.as_str()) {
        ("random_drives", _) | ("worst_case", "adaptive") => {}
        (found, kind) => {
            return Err(Refusal::Covers { found: found.into(), kind: kind.into() });
        }
    }

    let levels = [&causes.calibration, &causes.uncertain].map(|level| level.as_ref());
    let guaranteed = causes.guaranteed.as_ref();
    let present = [
        ("calibration", levels[0].is_some()),
        ("uncertain", levels[1].is_some()),
        ("searched", !causes.searched.is_empty()),
        ("guaranteed", guaranteed.is_some()),
    ];
    let searches = specified.calibration.search_drives > 0.0;
    let margin = causes.margin;
    let files: Vec<_> = causes.recorded.iter().map(|drive| &drive.file).collect();
    let named: Vec<_> = specified.calibration.drives.iter().collect();
    same("threshold.recorded, files", &files, &named)?;
    let recorded =
        causes.recorded.iter().map(|drive| drive.level).fold(f64::NEG_INFINITY, f64::max);
    let (expected, [recomputed, share]) = match causes.kind.as_str() {
        "constant" => ([false; 4], [specified.constant.unwrap_or(f64::NAN), 0.0]),
        "calibrated" => {
            let level = levels[0].map_or(f64::NAN, |level| level.level.max(recorded));
            ([true, false, false, false], [margin * level, 0.0])
        }
        "adaptive" => {
            let [level, ratio] = levels.map(|level| level.map_or(f64::NAN, |level| level.level));
            let ratio = ratio.max(recorded);
            let ratio = match specified.covers.as_str() {
                "worst_case" => ratio.max(largest(&causes.searched).min(1.0 / margin)),
                _ => ratio,
            };
            ([true, true, searches, false], [margin * ratio * level, margin * ratio])
        }
        "guaranteed" => {
            let level = guaranteed.map_or(f64::NAN, |x| x.bound + x.discretisation.level);
            ([false, false, false, true], [margin * level, 0.0])
        }
        other => return Err(Refusal::Kind { found: other.into() }),
    };
    for ((key, present), expected) in present.into_iter().zip(expected) {
        match (present, expected) {
            (false, true) => {
                let key = format!("threshold.{key}");
                return Err(Refusal::NoCause { key, kind: causes.kind.clone() });
            }
            (true, false) => {
                let key = format!("threshold.{key}");
                return Err(Refusal::OtherCause { key, kind: causes.kind.clone() });
            }
            _ => {}
        }
    }
    near("detector.evaluation.threshold", threshold, recomputed)?;
    near("detector.evaluation.uncertainty_share", uncertainty_share, share)?;

    let second = causes.second.as_ref();
    let estimator = design.detector.estimator.as_ref();
    let runs = design.spec.estimator.enabled && specified.threshold == "adaptive";
    same("detector.estimator, whether there is one", &estimator.is_some(), &runs)?;
    same("threshold.second, whether there is one", &second.is_some(), &runs)?;
    if let Some((levels, estimator)) = second.zip(estimator) {
        let recorded = causes.recorded.iter().filter_map(|drive| drive.second);
        let simulated = levels.calibration.level.max(largest(&levels.search));
        let covered = margin * margin * recorded.fold(simulated, f64::max);
        near("detector.estimator.threshold", estimator.threshold, covered)?;
        let key = "detector.estimator.estimate_factor";
        near(key, estimator.estimate_factor, levels.in_99_of_100)?;
    }

    let discretisation = guaranteed.map(|x| &x.discretisation);
    for (key, level) in [
        ("calibration", levels[0]),
        ("uncertain", levels[1]),
        ("second.calibration", second.map(|levels| &levels.calibration)),
        ("guaranteed.discretisation", discretisation),
    ] {
        if let Some(Level { drives, exceeded_at_most, .. }) = level {
            let key = format!("threshold.{key}.exceeded_at_most");
            let recomputed = 1.0 - LEFT_BY_CONFIDENCE.powf(1.0 / drives);
            within(&key, *exceeded_at_most, recomputed, ROUNDING)?;
        }
    }
    Ok(())
}

/// The largest that a search found; 0 of none.
fn largest(searched: &[Searched]) -> f64 {
    searched.iter().map(|found| found.level).fold(0.0, f64::max)
}

/// The start-up term is that of its matrices, from the largest lateral speed of S_x.
fn start_up(design: &Design) -> Result<(), Refusal> {
    let [right, left] = design.detector.model.range.v_y.ends();
    let p_22 = design.threshold.start_up.p.iter().map(|p| p[1][1]).fold(0.0, f64::max);
    let amplitude = p_22.sqrt() * f64::max(right.abs(), left.abs());
    let stored = design.detector.evaluation.start_up_amplitude;
    near("detector.evaluation.start_up_amplitude", stored, amplitude)
}

/// The smallest fault of interest, rad or N m.
fn smallest(fault: &Fault) -> f64 {
    match fault {
        Fault::Steering { smallest_deg, .. } => smallest_deg * PI / 180.0,
        Fault::Torque { smallest_n_m, .. } => *smallest_n_m,
    }
}

fn synthesis(design: &Design) -> Result<(), Refusal> {
    let (synthesis, spec) = (&design.synthesis, &design.spec);
    same("synthesis.method", &synthesis.method, &spec.design.method)?;
    let bound = spec.disturbance[0].bound();
    let gap = synthesis.beta * smallest(&spec.fault[0]) / (synthesis.gamma * bound);
    near("synthesis.gap", synthesis.gap, gap)?;

    // ||W_r C V'|| / |alpha_f + exp(jw)|, monotonic over a band.
    let ([w_1, w_2], [v]) = (design.detector.evaluation.weights, synthesis.v);
    let alpha = synthesis.alpha_f;
    let band_hz = spec.fault[0].band_hz();
    let ends = match Band::new(band_hz, design.detector.model.sampling_period_s)? {
        Band::Low(theta) => [0.0, theta.approximate()],
        Band::High(theta) => [theta.approximate(), PI],
        Band::Full => [0.0, PI],
    };
    let largest = ends
        .map(|w| (alpha * alpha + 2.0 * alpha * w.cos() + 1.0).sqrt())
        .into_iter()
        .fold(0.0, f64::max);
    let beta_bound = f64::hypot(w_1 * v[0], w_2 * v[2]) / largest;
    near("synthesis.beta_bound", synthesis.beta_bound, beta_bound)
}

fn performance(design: &Design) -> Result<(), Refusal> {
    let (performance, spec) = (&design.performance, &design.spec);
    let of = |key: &str| format!("performance.{key}");
    let bound = spec.disturbance[0].bound();
    let smallest_fault = smallest(&spec.fault[0]);
    let noise_rms = performance.noise_rms;
    let frozen = &performance.frozen;
    figures(&of("frozen"), frozen, smallest_fault, bound)?;
    let ratio = detection_ratio(frozen, noise_rms, smallest_fault, bound);
    near(&of("detection_ratio"), performance.detection_ratio, ratio)?;
    let residual = frozen.beta * smallest_fault;
    near(&of("smallest_fault_residual"), performance.smallest_fault_residual, residual)?;

    // Stated, or else searched.
    let method = &spec.design;
    let by_second = method.decay_per_s.map(|x| (-x * spec.sampling.period_s).exp());
    if let Some(stated) = method.decay.or(by_second) {
        near(&of("decay"), performance.decay, stated)?;
    }
    estimate(design)?;

    // Every figure is the worst of the points'.
    let points = &performance.operating_points;
    let largest = |of: fn(&Point) -> f64| points.iter().map(of).fold(0.0, f64::max);
    near(&of("noise_rms"), noise_rms, largest(|point| point.noise_rms))?;
    let beta = points.iter().map(|point| point.beta).fold(f64::INFINITY, f64::min);
    near(&of("frozen.beta"), frozen.beta, beta)?;
    // Of several bands, each is at its worst at a point of its own.
    at_most(&of("operating_points: gamma"), largest(|point| point.gamma), frozen.gamma)?;
    let limit = points.iter().filter_map(|point| point.limit).reduce(f64::min);
    same(&of("limit"), &performance.limit, &limit)?;
    for (index, point) in points.iter().enumerate() {
        let ratio = point.beta * smallest_fault / (point.gamma * bound).hypot(point.noise_rms);
        let key = of(&format!("operating_points[{index}].detection_ratio"));
        near(&key, point.detection_ratio, ratio)?;
    }

    let others = &performance.other_faults;
    same(&of("other_faults: their number"), &others.len(), &(spec.fault.len() - 1))?;
    for (index, (other, fault)) in others.iter().zip(&spec.fault[1..]).enumerate() {
        let of = |key: &str| of(&format!("other_faults[{index}].{key}"));
        same(&of("fault"), &other.fault, fault)?;
        figures(&of("frozen"), &other.frozen, smallest(fault), bound)?;
        let ratio = detection_ratio(&other.frozen, noise_rms, smallest(fault), bound);
        near(&of("detection_ratio"), other.detection_ratio, ratio)?;
    }

    for (i, (stored, n)) in
        performance.spectral_radii.iter().zip(&design.detector.gains.n).enumerate()
    {
        let key = of(&format!("spectral_radii[{i}]"));
        within(&key, *stored, spectral_radius(n), RADIUS_ROUNDING)?;
    }
    Ok(())
}

/// Cap and size of what the first fault does to the estimate; the peak itself is recomputed with the
/// gains at frozen operating points.
fn estimate(design: &Design) -> Result<(), Refusal> {
    let of = |key: &str| format!("performance.estimate.{key}");
    let estimate = design.performance.estimate.as_ref();
    let largest_deg = match &design.spec.fault[0] {
        Fault::Steering { largest_deg, .. } => Some(*largest_deg),
        Fault::Torque { .. } => None,
    };
    same(
        "performance.estimate: whether there is one",
        &estimate.is_some(),
        &largest_deg.is_some(),
    )?;
    if let Some((estimate, largest_deg)) = estimate.zip(largest_deg) {
        let [right, left] = design.spec.operating_range.v_y_m_per_s;
        let range = f64::min(left, -right);
        let cap = RANGES_OF_V_Y * range / largest_deg;
        near(&of("cap_m_per_s_per_deg"), estimate.cap_m_per_s_per_deg, cap)?;
        let leaves = range / estimate.peak_m_per_s_per_deg;
        near(&of("leaves_range_from_deg"), estimate.leaves_range_from_deg, leaves)?;
    }
    Ok(())
}

/// Frozen figures among themselves.
fn figures(key: &str, frozen: &Frozen, smallest_fault: f64, bound: f64) -> Result<(), Refusal> {
    let gap = frozen.beta * smallest_fault / (frozen.gamma * bound);
    near(&format!("{key}.gap"), frozen.gap, gap)?;
    at_most(&format!("{key}.beta_at_least"), frozen.beta_at_least, frozen.beta)?;
    // Without a bound between the frequencies there is none to keep.
    let Some(bound) = frozen.gamma_at_most else { return Ok(()) };
    at_most(&format!("{key}.gamma"), frozen.gamma, bound)
}

/// `beta x smallest fault / sqrt((gamma x bound)^2 + noise_rms^2)`.
fn detection_ratio(frozen: &Frozen, noise_rms: f64, smallest_fault: f64, bound: f64) -> f64 {
    frozen.beta * smallest_fault / (frozen.gamma * bound).hypot(noise_rms)
}

/// The certified figures among themselves and against the frozen ones.
fn certified(design: &Design) -> Result<(), Refusal> {
    if let Some(claimed) = &design.performance.certified {
        let (frozen, spec) = (&design.performance.frozen, &design.spec);
        let bound = spec.disturbance[0].bound();
        let gap = claimed.beta * smallest(&spec.fault[0]) / (claimed.gamma * bound);
        near("performance.certified.gap", claimed.gap, gap)?;
        same("performance.certified.decay", &claimed.decay, &design.performance.decay)?;
        // A proof covers every operating point.
        at_most("performance.certified.beta", claimed.beta, frozen.beta)?;
        at_most("performance.frozen.gamma", frozen.gamma, claimed.gamma)?;
    }
    Ok(())
}

/// What bank and wind look like, and that the status is what the drives say; not the drives.
fn sight(design: &Design) -> Result<(), Refusal> {
    let sight = design.performance.sight.as_ref();
    let smallest_deg = match design.spec.fault[0] {
        Fault::Steering { smallest_deg, .. } => Some(smallest_deg),
        Fault::Torque { .. } => None,
    };
    same("performance.sight: whether there is one", &sight.is_some(), &smallest_deg.is_some())?;
    let missed = match (sight, smallest_deg) {
        (Some(sight), Some(smallest_deg)) => {
            let key = "performance.sight.bank_and_wind_deg";
            near(key, sight.bank_and_wind_deg, bank_and_wind_deg(design))?;
            missed(sight, smallest_deg)?
        }
        _ => false,
    };
    let blind = sight.is_some_and(|sight| sight.blind.is_some());
    same("performance.sight.blind: whether it is", &blind, &missed)?;
    let status = design.synthesis.status == Status::Blind;
    same("synthesis.status: whether it is \"blind\"", &status, &missed)
}

/// Whether the smallest fault, of `smallest_deg`, is missed straight ahead at some speed.
fn missed(sight: &Sight, smallest_deg: f64) -> Result<bool, Refusal> {
    let mut seen = Vec::new();
    for (index, course) in sight.judged().enumerate() {
        let key = format!("performance.sight.courses: straight {index}, its first fault_deg");
        let first = course.faults.first();
        near(&key, first.map_or(f64::NAN, |fault| fault.fault_deg), smallest_deg)?;
        seen.extend(first.map(|fault| fault.seen));
    }
    same("performance.sight.courses: whether one is straight", &!seen.is_empty(), &true)?;
    Ok(seen.contains(&false))
}

/// The road-wheel angle that bank and gust at their bounds look like, straight and steady, deg: method 12.
fn bank_and_wind_deg(design: &Design) -> f64 {
    let model = &design.detector.model;
    let uncertainty = &design.detector.deviations.uncertainty;
    let Gust { speed_m_per_s: w, coefficient_n_s2_per_m2, acting_ahead_m } = uncertainty.gust;
    let v = &model.vehicle;
    let (l_f, l_r) = (v.front_axle_distance_m, v.rear_axle_distance_m);
    let (c_f, c_r) = (v.front_cornering_stiffness_n_per_rad, v.rear_cornering_stiffness_n_per_rad);
    let understeer = v.mass_kg * (l_r * c_r - l_f * c_f) / (2.0 * c_f * c_r * (l_f + l_r));
    let force = coefficient_n_s2_per_m2 * w * model.range.v_x.max.hypot(w);
    let [front, rear] = [(l_r + acting_ahead_m) / c_f, (l_f - acting_ahead_m) / c_r];
    let of_gust = force * (front - rear) / (2.0 * (l_f + l_r));
    (understeer * uncertainty.bank_m_per_s2).abs().to_degrees() + of_gust.abs().to_degrees()
}

/// The largest magnitude of an eigenvalue: `||N^(2^k)||^(1 / 2^k)`.
fn spectral_radius(n: &Rows3) -> f64 {
    let norm = |x: &Rows3| x.as_flattened().iter().map(|x| x * x).sum::<f64>().sqrt();
    let mut power = *n;
    let mut logarithm = 0.0;
    for k in 0..SQUARINGS {
        let size = norm(&power);
        if size == 0.0 {
            return 0.0;
        }
        logarithm += size.ln() / 2_f64.powi(k);
        let x = power.map(|row| row.map(|x| x / size));
        power =
            x.map(|row| std::array::from_fn(|column| (0..3).map(|j| row[j] * x[j][column]).sum()));
    }
    logarithm.exp()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spectral_radius_is_that_of_the_eigenvalues() {
        // Eigenvalues 0.5 and 0.9 exp(+-j); then three times 0.5, defective.
        let (c, s) = (0.9 * 1_f64.cos(), 0.9 * 1_f64.sin());
        for (n, radius) in [
            ([[c, s, 3.0], [-s, c, -2.0], [0.0, 0.0, 0.5]], 0.9),
            ([[0.5, 100.0, 0.0], [0.0, 0.5, 100.0], [0.0, 0.0, 0.5]], 0.5),
            ([[0.0; 3]; 3], 0.0),
        ] {
            assert!((spectral_radius(&n) - radius).abs() < 1e-12, "{n:?}");
        }
    }
}
