//! The figures of a design that people ask for first.

use schemars::JsonSchema;
use serde::Serialize;
use steerguard_designer::sight::Sight;
use steerguard_designer::spec::{MethodName, ThresholdKind};
use steerguard_designer::threshold::calibration::{Level, exceeded_at_most};
use steerguard_designer::threshold::recorded::Recorded;
use steerguard_designer::threshold::{SteadyThreshold, by_cause, cause_names, recorded, searched};
use steerguard_designer::{CertifiedFigures, Design, DesignStatus, Spec, ThresholdRecord};
use steerguard_fmu::BakedDesign;
use steerguard_verify::Verdict;

use crate::output::table::aligned;
use crate::report::pictures::Pictures;
use crate::report::second::Second;
use crate::report::sight;

/// Figures of a design.
#[derive(Clone, Debug, PartialEq, JsonSchema, Serialize)]
pub struct DesignSummary {
    /// What the design may be called.
    pub status: DesignStatus,
    /// How the gains were found.
    pub method: MethodName,
    /// SHA-256 of the design file's content.
    pub hash: String,
    /// Residual of the smallest fault against that of disturbances and noise, at frozen operating
    /// points.
    pub detection_ratio: f64,
    /// RMS of the weighted residual under white sensor noise.
    pub noise_rms: f64,
    /// Certified a posteriori for the gains as stored; `None` without a certificate.
    pub certified: Option<CertifiedFigures>,
    /// The gap at frozen operating points.
    pub frozen_gap: f64,
    /// The gap that no residual generator exceeds; `None`: unbounded.
    pub limit: Option<f64>,
    /// beta, gamma and gap by the synthesis.
    pub synthesis: SynthesisSummary,
    /// Smallest eigenvalues of (31), (32), (33) for the gains, all to be positive; `None` where the
    /// gains are not those of a synthesis.
    pub margins: Option<[f64; 3]>,
    /// Largest spectral radius of the rules at the lowest and the highest speed.
    pub spectral_radii: [f64; 2],
    /// Lowest and highest speed of the design range, m/s.
    pub speeds_m_per_s: [f64; 2],
    /// J_th after the start-up.
    pub threshold: f64,
    /// What J tends to under the smallest fault of interest, at least.
    pub smallest_fault_j: f64,
    /// Factor between level and threshold.
    pub threshold_margin: f64,
    /// How the threshold was found.
    pub threshold_kind: ThresholdKind,
    /// What J stays below without a fault, by its causes.
    pub threshold_causes: Vec<Cause>,
    /// J_th in steady driving, with what is uncertain.
    pub threshold_by_cause: Vec<SteadyThreshold>,
    /// The second test.
    pub second: Second,
    /// What the detector sees in simulated drives; `None` where the first fault is one of the drive torque.
    pub sight: Option<Sight>,
}

/// What the documentation of an FMU tells of its design beyond what is baked.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Record {
    /// Of the threshold.
    pub causes: Vec<Cause>,
    /// Of the second test, sentences.
    pub second: Vec<String>,
    /// What simulated drives show.
    pub sight: Option<Sight>,
    /// What is known of drives without a fault, sentences.
    pub fault_free: Vec<String>,
    /// What is proven, sentences.
    pub statements: Vec<String>,
    /// What is neither proven nor recomputed, sentences.
    pub unchecked: Vec<String>,
    /// The specification.
    pub spec: Option<Spec>,
    /// What figures show.
    pub pictures: Option<Pictures>,
}

impl Record {
    /// That of `design`, of which a check gave this `verdict`.
    pub fn of(design: &Design, verdict: &Verdict) -> Self {
        let second = Second::of(design).sentences(design.threshold.margin);
        Self {
            causes: causes(design),
            second: second.map_or(Vec::new(), |(_, sentences)| sentences),
            sight: design.performance.sight.clone(),
            fault_free: fault_free(design),
            statements: verdict.statements.clone(),
            unchecked: verdict.unchecked.clone(),
            spec: Some(design.spec.clone()),
            pictures: Pictures::of(design).ok(),
        }
    }
}

/// What is known of drives without a fault.
fn fault_free(design: &Design) -> Vec<String> {
    let ThresholdRecord { uncertain, recorded, searched, margin, .. } = &design.threshold;
    let Some(level) = uncertain else {
        return Vec::new();
    };
    let covers = design.spec.evaluation.covers;
    let share = margin * searched::covered(level, recorded, searched, *margin, covers);
    let at_random = format!(
        "Without a fault, vehicle, road and air anywhere in what is stated: J / J_th is {:.2} in {}.",
        level.level / share,
        surely_largest(level)
    );
    let by_search = found_by_search(&design.threshold, share) + ".";
    let recorded = recorded_ratio(recorded, level, share).map(|x| x.cause + ".");
    let searched = (!searched.is_empty()).then_some(by_search);
    std::iter::once(at_random).chain(searched).chain(recorded).collect()
}

/// What a share of the threshold's level comes from.
#[derive(Clone, Debug, PartialEq, JsonSchema, Serialize)]
pub struct Cause {
    /// In words.
    pub cause: String,
    /// J that it can make up; `None` where that depends on the sample.
    pub j: Option<f64>,
}

/// Figures of the synthesis.
#[derive(Clone, Copy, Debug, PartialEq, JsonSchema, Serialize)]
pub struct SynthesisSummary {
    /// Fault sensitivity, per rad or N m.
    pub beta: f64,
    /// Closed-form bound on beta.
    pub beta_bound: f64,
    /// The largest beta that the paper's problem reaches; `None` where it was not asked for.
    pub largest_beta: Option<f64>,
    /// Disturbance gain, per unit of the first disturbance.
    pub gamma: f64,
    /// beta / gamma in units of smallest fault and disturbance bound.
    pub gap: f64,
}

impl DesignSummary {
    /// The figures of `design`.
    pub fn of(design: &Design) -> Self {
        let (synthesis, performance) = (&design.synthesis, &design.performance);
        let [slow_1, slow_2, fast_1, fast_2] = performance.spectral_radii;
        Self {
            status: synthesis.status,
            method: synthesis.method,
            hash: design.hash.clone(),
            detection_ratio: performance.detection_ratio,
            noise_rms: performance.noise_rms,
            certified: performance.certified,
            frozen_gap: performance.frozen.gap,
            limit: performance.limit,
            synthesis: SynthesisSummary {
                beta: synthesis.beta,
                beta_bound: synthesis.beta_bound,
                largest_beta: synthesis.largest_beta.as_ref().map(|largest| largest.beta),
                gamma: synthesis.gamma,
                gap: synthesis.gap,
            },
            margins: design.certificate.margins.map(|margins| {
                [margins.disturbance_attenuation, margins.fault_sensitivity, margins.stability]
                    .map(|margin| margin.smallest_eigenvalue)
            }),
            spectral_radii: [slow_1.max(slow_2), fast_1.max(fast_2)],
            speeds_m_per_s: {
                let v_x = design.detector.model.range.v_x;
                [v_x.min, v_x.max]
            },
            threshold: design.detector.evaluation.threshold,
            smallest_fault_j: performance.smallest_fault_residual,
            threshold_margin: design.threshold.margin,
            threshold_kind: design.threshold.kind,
            threshold_causes: causes(design),
            threshold_by_cause: by_cause(&design.detector),
            second: Second::of(design),
            sight: performance.sight.clone(),
        }
    }

    /// Aligned lines for people; `proof` is what a check of the design file said.
    pub fn text(&self, proof: Option<&str>) -> String {
        let [slow, fast] = self.speeds_m_per_s;
        let [at_slow, at_fast] = self.spectral_radii;
        let synthesis = &self.synthesis;
        let row = |name: &str, value: String, remark: String| vec![name.to_owned(), value, remark];
        let mut rows = vec![
            row("status", self.status_in_words(), proof.unwrap_or_default().into()),
            row(
                "detection ratio",
                format!("{:.3}", self.detection_ratio),
                format!("smallest fault to disturbance and noise (RMS {:.6})", self.noise_rms),
            ),
        ];
        if let Some(certified) = &self.certified {
            rows.push(row(
                "certified gap",
                format!("{:.3}", certified.gap),
                format!("beta {:.6}, gamma {:.6}", certified.beta, certified.gamma),
            ));
        }
        let limit = match self.limit {
            Some(limit) => format!("no residual generator exceeds {limit:.3}"),
            None => "unbounded in theory: fewer disturbances than sensors".into(),
        };
        rows.push(row("frozen gap", format!("{:.3}", self.frozen_gap), limit));
        let largest = synthesis
            .largest_beta
            .map_or(String::new(), |beta| format!(", largest found {beta:.6}"));
        rows.push(row(
            "synthesis gap",
            format!("{:.3}", synthesis.gap),
            format!(
                "beta {:.6} (bound {:.6}{largest}), gamma {:.6}",
                synthesis.beta, synthesis.beta_bound, synthesis.gamma
            ),
        ));
        if let Some([at_31, at_32, at_33]) = self.margins {
            rows.push(row(
                "least eigenvalue",
                format!("{:.2e}", at_31.min(at_32).min(at_33)),
                format!("(31) {at_31:.2e}, (32) {at_32:.2e}, (33) {at_33:.2e}"),
            ));
        }
        rows.push(row(
            "spectral radius",
            format!("{:.4}", at_slow.max(at_fast)),
            format!("{at_slow:.4} at {slow} m/s, {at_fast:.4} at {fast} m/s"),
        ));
        rows.push(row(
            "threshold J_th",
            format!("{:.6}", self.threshold),
            match self.threshold_kind {
                ThresholdKind::Constant => "as specified".into(),
                ThresholdKind::Adaptive => format!(
                    "{} x what J can be without a fault, sample by sample:",
                    self.threshold_margin
                ),
                _ => format!("{} x what J can be without a fault:", self.threshold_margin),
            },
        ));
        rows.extend(self.threshold_causes.iter().map(|Cause { cause, j }| {
            row("", j.map_or(String::new(), |j| format!("{j:.6}")), cause.clone())
        }));
        rows.push(row(
            "smallest fault",
            format!("{:.6}", self.smallest_fault_j),
            "J that it tends to, at least".into(),
        ));
        if let Some((threshold, sentences)) = self.second.sentences(self.threshold_margin) {
            let mut value = threshold.map_or(String::new(), |x| format!("{x:.3}"));
            let mut name = "second test";
            for sentence in sentences {
                rows.push(row(name, std::mem::take(&mut value), sentence));
                name = "";
            }
        }
        let mut text = aligned(&rows, "  ");
        if self.threshold_kind == ThresholdKind::Adaptive {
            text += "  J_th in steady driving by cause, x 1e-3\n";
            text += &aligned(&transposed(&cause_rows(&self.threshold_by_cause)), "    ");
        }
        if let Some(sight) = &self.sight {
            text += &format!("  {}\n", sight::HEADING);
            text += &aligned(&sight::rows(sight), "    ");
            text.extend(sight::remarks(sight).into_iter().map(|remark| format!("    {remark}\n")));
        }
        text
    }

    /// Whether there is a proof counts for what is blind too.
    fn status_in_words(&self) -> String {
        match (self.status, &self.certified) {
            (DesignStatus::Blind, Some(_)) => "certified, BLIND".into(),
            (DesignStatus::Blind, None) => "not certified, BLIND".into(),
            (other, _) => status(other).into(),
        }
    }
}

/// The shares of the threshold's level, and what a search found of it.
pub fn causes(design: &Design) -> Vec<Cause> {
    let threshold = &design.threshold;
    let mut causes = Vec::new();
    match (&threshold.calibration, &threshold.uncertain) {
        (Some(level), Some(ratio)) => {
            let covers = design.spec.evaluation.covers;
            let ThresholdRecord { recorded, searched, margin, .. } = threshold;
            let share = searched::covered(ratio, recorded, searched, *margin, covers);
            let cause =
                format!("noise and disturbances: {share:.3} x {} of the vehicle", largest(level));
            causes.push(Cause { cause, j: Some(share * level.level) });
            let cause = format!(
                "what is uncertain, at this sample: {share:.3} x its bound; J / J_th is {:.3} in {}",
                ratio.level / (threshold.margin * share),
                surely_largest(ratio)
            );
            causes.push(Cause { cause, j: None });
            causes.extend(recorded_ratio(recorded, ratio, margin * share));
            if !threshold.searched.is_empty() {
                let cause = found_by_search(threshold, threshold.margin * share);
                causes.push(Cause { cause, j: None });
            }
        }
        (Some(level), None) => {
            causes.push(Cause { cause: surely_largest(level), j: Some(level.level) });
            let worst = recorded::largest(&threshold.recorded);
            causes.extend(worst.map(|worst| Cause {
                cause: worst_recorded(worst, &threshold.recorded, level),
                j: Some(worst.level),
            }));
        }
        _ => {}
    }
    if let Some(guaranteed) = &threshold.guaranteed {
        causes.extend(guaranteed.inputs.iter().map(|input| Cause {
            cause: format!("proven: {}, up to {} {}", input.name, input.bound, input.unit),
            j: Some(input.j),
        }));
        let level = &guaranteed.discretisation;
        let drives = level.drives;
        let cause = format!("simulated: discretisation, largest of {drives} undisturbed drives");
        causes.push(Cause { cause, j: Some(level.level) });
    }
    causes
}

/// What recorded drives say of a threshold with so much of level and bound, beside those at random.
fn recorded_ratio(recorded: &[Recorded], at_random: &Level, share: f64) -> Option<Cause> {
    let worst = recorded::largest(recorded)?;
    let mut cause = format!(
        "J / J_th is {:.3} in {}",
        worst.level / share,
        worst_recorded(worst, recorded, at_random)
    );
    if worst.level > 1.0 {
        cause += "; what [uncertainty] states does not explain that drive: see `steerguard replay`";
    } else if worst.level > at_random.level {
        cause += "; it raises the threshold";
    }
    Some(Cause { cause, j: None })
}

/// The worst recorded drive, and what the largest of recorded and simulated ones says of the next one.
fn worst_recorded(worst: &Recorded, recorded: &[Recorded], simulated: &Level) -> String {
    let all = recorded.len() + simulated.drives;
    format!(
        "the worst of {} recorded fault-free drives ({}); a further one, of these and the simulated ones, \
         exceeds the largest with {:.2} % at most, of these alone with {:.0} % (95 % confidence)",
        recorded.len(),
        worst.file,
        100.0 * exceeded_at_most(all),
        100.0 * exceeded_at_most(recorded.len())
    )
}

/// What a search found of a threshold with so much of level and bound.
fn found_by_search(threshold: &ThresholdRecord, share: f64) -> String {
    let drives = searched::drives(&threshold.searched);
    let ratio = searched::largest(&threshold.searched) / share;
    let mut found = format!(
        "J / J_th is {ratio:.3} in the worst fault-free drive that a search of {drives} found"
    );
    if ratio > 1.0 && share < 1.0 {
        found += ", which evaluation.covers = \"worst_case\" would cover";
    } else if ratio > 1.0 {
        found += ", more than the whole bound, which is one to first order only";
    }
    found
}

fn largest(level: &Level) -> String {
    format!("the largest J of {} simulated fault-free drives", level.drives)
}

/// With what the largest of that many drives says of the next one.
fn surely_largest(level: &Level) -> String {
    format!(
        "the worst of {} simulated fault-free drives, exceeded by a further one with {:.2} % at most \
         (95 % confidence)",
        level.drives,
        100.0 * level.exceeded_at_most
    )
}

/// A head, then a row a point: speed, lateral acceleration, each cause that raises the threshold at one of
/// them, J_th and the J of the smallest fault, J in thousandths.
pub fn cause_rows(points: &[SteadyThreshold]) -> Vec<Vec<String>> {
    let raises = |k: usize| points.iter().any(|point| point.uncertainties[k] > 0.0);
    let names = cause_names();
    let causes: Vec<usize> = (0..names.len()).filter(|&k| raises(k)).collect();
    let head = ["v_x m/s", "a_y m/s^2", "level"].into_iter();
    let head = head.chain(causes.iter().map(|&k| names[k])).chain(["J_th", "smallest fault"]);
    let rows = points.iter().map(|point| {
        let speed = [point.v_x_m_per_s, point.lateral_acceleration_m_per_s2];
        let levels = std::iter::once(point.level)
            .chain(causes.iter().map(|&k| point.uncertainties[k]))
            .chain([point.j_th, point.smallest_fault_j]);
        let cells = speed.map(|x| format!("{x:.1}")).into_iter();
        cells.chain(levels.map(|j| format!("{:.2}", 1e3 * j))).collect()
    });
    std::iter::once(head.map(String::from).collect()).chain(rows).collect()
}

/// The table with a row a column: what is told of a point stands below it.
fn transposed(rows: &[Vec<String>]) -> Vec<Vec<String>> {
    let columns = rows.first().map_or(0, Vec::len);
    let cell = |row: &Vec<String>, column: usize| row.get(column).cloned().unwrap_or_default();
    (0..columns).map(|column| rows.iter().map(|row| cell(row, column)).collect()).collect()
}

/// A status in words.
pub fn status(status: DesignStatus) -> &'static str {
    match status {
        DesignStatus::Certified => "certified",
        DesignStatus::Uncertified => "not certified",
        DesignStatus::AlmostSolved => "almost solved, not certified",
        DesignStatus::Blind => "blind: its drives miss the smallest fault of interest",
    }
}

/// What is baked into the FMU.
///
/// # Errors
/// The design's hash, if it is not the 64 digits of a SHA-256.
pub fn baked(design: &Design) -> Result<BakedDesign, String> {
    let certified = design.performance.certified.as_ref();
    Ok(BakedDesign {
        hash: design.hash.as_bytes().try_into().map_err(|_| design.hash.clone())?,
        certified: certified.is_some(),
        blind: design.synthesis.status == DesignStatus::Blind,
        beta: certified.map_or(0.0, |x| x.beta),
        gamma: certified.map_or(0.0, |x| x.gamma),
        gap: certified.map_or(0.0, |x| x.gap),
        configuration: design.detector,
    })
}
