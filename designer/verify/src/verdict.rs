//! What was proven, in words and figures.

use std::fmt;

use crate::band::Band;
use crate::channel::Channels;
use crate::dynamics::Residues;
use crate::proof::{Figures, Proof};
use crate::read::{Design, Fault, Guaranteed, Level, Recorded, Searched, Status};
use crate::refusal::Refusal;
use crate::tally::Margin;

/// A design that holds what it claims.
#[derive(Clone, Debug, PartialEq)]
pub struct Verdict {
    /// SHA-256 of the content.
    pub hash: String,
    /// What the design may be called.
    pub status: Status,
    /// The figures that are proven; none of a design that is not certified.
    pub figures: Option<Figures>,
    /// What is proven, one theorem each.
    pub statements: Vec<String>,
    /// What rounding left of the observer's equations.
    pub residues: Residues,
    /// How far the inequalities are from failing.
    pub margins: Vec<Margin>,
    /// What was neither proven nor recomputed: keys, and why.
    pub unchecked: Vec<String>,
}

impl Verdict {
    /// The verdict on `design` with what was proven of it.
    ///
    /// # Errors
    /// [`Refusal`] for bounds that are none.
    pub fn new(
        design: &Design,
        hash: String,
        residues: Residues,
        proof: Proof,
    ) -> Result<Self, Refusal> {
        Ok(Self {
            hash,
            status: design.synthesis.status,
            figures: proof.figures,
            statements: statements(design, &proof, &residues)?,
            residues,
            unchecked: unchecked(design, &proof),
            margins: proof.margins,
        })
    }

    /// Whether its own drives miss the smallest fault of interest.
    pub fn is_blind(&self) -> bool {
        self.status == Status::Blind
    }

    /// Whether its figures are proven.
    pub fn is_certified(&self) -> bool {
        self.figures.is_some()
    }
}

/// The theorems.
fn statements(design: &Design, proof: &Proof, residues: &Residues) -> Result<Vec<String>, Refusal> {
    let evaluation = &design.detector.evaluation;
    let mut statements = Vec::new();
    if let Some(decay) = proof.decay {
        statements.push(format!(
            "For x, x^ and the measured premise in S_x and any courses of premise and rho, the \
             error without inputs decays at least like {decay}^k."
        ));
    }
    if let Some(figures) = &proof.figures {
        statements.extend(of_figures(design, figures, &Channels::new(design)?));
    }
    statements.push(format!(
        "From e_0 = [0, v_y, 0] in S_x, without inputs, ||W_r r_j|| <= {} * {}^j.",
        evaluation.start_up_amplitude, evaluation.start_up_decay,
    ));
    statements.extend(guaranteed(design));
    statements.push(format!(
        "The stored gains satisfy the observer's equations up to {:.1e}: the error obeys its \
         equation up to an additional input no larger than that times the sum of |x|, and the \
         rounding of the detector's own arithmetic.",
        f64::max(residues.m, residues.observer_equation),
    ));
    Ok(statements)
}

/// The theorems behind the certified figures.
fn of_figures(design: &Design, figures: &Figures, channels: &Channels) -> Vec<String> {
    let Figures { beta, gap, gamma_full_band, .. } = figures;
    let [w_1, w_2] = design.detector.evaluation.weights;
    let unit = match design.spec.fault[0] {
        Fault::Steering { .. } => "rad",
        Fault::Torque { .. } => "N m",
    };
    let mut statements = vec![format!(
        "Likewise, from e_0 = 0 and with W_r = diag({w_1}, {w_2}), for any l2 fault f other than 0{}: \
         ||W_r r|| > beta ||f|| with beta = {beta} per {unit}.",
        condition(&channels.fault.band),
    )];
    statements.extend(attenuation(design, figures, channels));
    statements.push(format!(
        "Unconditionally for any l2 course d of all disturbances and bounded noise: \
         ||W_r r|| < {gamma_full_band} ||d||, in the same unit."
    ));
    statements.push(
        if design.d_y.is_some() {
            "With the bounded sensor noise v, the error is e = x - x^ - E D_y v; v counts with all \
             it does, by the injection, by E y and by the measured premise."
        } else {
            "The measurement is y = C x, without noise: what sensor noise does is in none of these, but \
             in the threshold."
        }
        .into(),
    );
    if design.spec.sampling.euler_correction {
        statements.push(
            "r is the residual of the model (7) in Euler's steps, before the detector takes what these \
             leave out of it (`sampling.euler_correction`)."
                .into(),
        );
    }
    statements.extend([
        format!("The fault-to-disturbance gap of these is at least {gap}."),
        "At constant premise and rho, beta and gamma are gains over the stated bands; where the \
         premise varies, a band limit on the input alone does not imply the condition on the error."
            .into(),
    ]);
    statements
}

/// What is neither proven nor recomputed.
fn unchecked(design: &Design, proof: &Proof) -> Vec<String> {
    let threshold = &design.threshold;
    let mut unchecked = vec![
        "`spec`: that vehicle, bounds and noise are those of the car".to_owned(),
        "`performance`: every `limit`, and `beta_at_least` and `gamma_at_most`, which bound what lies \
         between the frequencies of a grid"
            .to_owned(),
        "`synthesis` and the matrices of (31)-(33) in `certificate`: how the gains were found"
            .to_owned(),
    ];
    for (key, level) in [
        ("calibration", threshold.calibration.as_ref()),
        ("uncertain", threshold.uncertain.as_ref()),
        ("second.calibration", threshold.second.as_ref().map(|x| &x.calibration)),
        ("guaranteed.discretisation", threshold.guaranteed.as_ref().map(|x| &x.discretisation)),
    ] {
        if let Some(Level { level, drives, .. }) = level {
            unchecked.push(format!(
                "`threshold.{key}.level`: {level}, the largest of {drives} simulated drives"
            ));
        }
    }
    unchecked.extend(threshold.recorded.iter().map(|Recorded { file, sha256, level, second }| {
        let second = second.map_or(String::new(), |second| format!(", {second} of the second test"));
        format!(
            "`threshold.recorded`, `{file}` (SHA-256 {sha256}): {level}{second}, the largest of that recorded \
             drive, and that the car had no fault in it"
        )
    }));
    let found = |key: &str, Searched { family, level, drives }: &Searched| {
        format!(
            "`threshold.{key}`, family `{family}`: {level}, the largest that a search of {drives} drives found"
        )
    };
    unchecked.extend(threshold.searched.iter().map(|of_family| found("searched", of_family)));
    if let Some(levels) = &threshold.second {
        unchecked.push(format!(
            "`threshold.second.in_99_of_100`: {}, what these drives stay below in 99 of 100 seconds",
            levels.in_99_of_100
        ));
        let of_families = levels.search.iter();
        unchecked.extend(of_families.map(|of_family| found("second.search", of_family)));
    }
    if let Some(sight) = &design.performance.sight {
        let (mut seen, mut straight) = (0, 0);
        for course in sight.judged() {
            straight += 1;
            seen += usize::from(course.faults.first().is_some_and(|fault| fault.seen));
        }
        unchecked.push(format!(
            "`performance.sight`: that the smallest fault was seen on {seen} of {straight} straight \
             courses, and what else simulated drives show"
        ));
    }
    if threshold.kind == "constant" {
        unchecked.push("`spec.evaluation.constant`: the threshold, as specified".to_owned());
    }
    if proof.decay.is_none() {
        unchecked.push("`certificate.P_s`: it does not prove the decay of the error".to_owned());
    }
    unchecked
}

/// What a guaranteed threshold covers.
fn guaranteed(design: &Design) -> Option<String> {
    let Guaranteed { bound, inputs, discretisation } = design.threshold.guaranteed.as_ref()?;
    let inputs: Vec<String> =
        inputs.iter().map(|x| format!("{} ({}): {}", x.name, x.bound, x.j)).collect();
    Some(format!(
        "Without a fault, for x, x^ and the measured premise in S_x, any courses of premise and rho, \
         from a start of the observer on, and with every input within its bound at every sample: \
         J < {bound} plus the start-up term, the sum of what each can do: {}. This is of the model \
         (7); the {} that the threshold holds for its discretisation are simulated.",
        inputs.join(", "),
        discretisation.level,
    ))
}

/// gamma of each band of the disturbances, and of all.
fn attenuation(design: &Design, figures: &Figures, channels: &Channels) -> Vec<String> {
    let blocks = design.certificate.a_posteriori.iter().flat_map(|x| &x.gamma);
    let mut statements: Vec<String> = blocks
        .zip(&channels.disturbances)
        .map(|(certificate, channel)| {
            format!(
                "Likewise, for any l2 course d of {}{}: ||W_r r|| < {} ||d|| per unit of the first \
                 disturbance, d the 2-norm of the stack with each in proportion to its bound.",
                channel.names.join(", "),
                condition(&channel.band),
                certificate.gain,
            )
        })
        .collect();
    statements.push(match channels.disturbances.len() {
        1 => format!("So gamma = {} for all disturbances.", figures.gamma),
        _ => format!(
            "For all of them at once, the part of the error from each band on its band's \
             condition: ||W_r r|| < gamma ||d|| with gamma = {}, the root of the sum of squares.",
            figures.gamma,
        ),
    });
    statements
}

/// The condition on the error in a band.
fn condition(band: &Band) -> String {
    let (theta, relation) = match band {
        Band::Low(theta) => (theta.approximate(), "<="),
        Band::High(theta) => (theta.approximate(), ">="),
        Band::Full => return String::new(),
    };
    format!(" whose error obeys sum (e+ - e)(e+ - e)' {relation} 4 sin^2({theta:.6} / 2) sum e e'")
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.figures {
            Some(Figures { beta, gamma, gap, gamma_full_band, decay }) => {
                writeln!(f, "certified: design {}", self.hash)?;
                writeln!(
                    f,
                    "  gap {gap:.4} = beta {beta:.6} to gamma {gamma:.6}, in units of smallest fault \
                     and bounds"
                )?;
                writeln!(
                    f,
                    "  gamma of the full band {gamma_full_band:.6}, decay {decay} a sample"
                )?;
            }
            None => writeln!(f, "not certified, as it says of itself: design {}", self.hash)?,
        }
        if self.is_blind() {
            writeln!(
                f,
                "blind, as it says of itself: its drives miss the smallest fault of interest straight \
                 ahead"
            )?;
        }
        writeln!(f, "proven in exact arithmetic, for the gains as stored:")?;
        for statement in &self.statements {
            writeln!(f, "  - {statement}")?;
        }
        writeln!(
            f,
            "recomputed: model, `detector`, threshold and share, gains at frozen operating points, noise, \
             ratios and gaps"
        )?;
        writeln!(f, "neither proven nor recomputed:")?;
        for statement in &self.unchecked {
            writeln!(f, "  - {statement}")?;
        }
        writeln!(f, "margins: smallest pivot relative to its diagonal element")?;
        for Margin { family, inequalities, smallest_pivot } in &self.margins {
            writeln!(f, "  {family:<36}{inequalities:>4} inequalities  {smallest_pivot:.1e}")?;
        }
        Ok(())
    }
}
