//! What was proven, in words and figures.

use std::fmt;

use crate::Refusal;
use crate::band::Band;
use crate::channel::Channels;
use crate::file::{Design, Fault, Guaranteed};
use crate::proof::Family;

/// A proven design.
#[derive(Clone, Debug, PartialEq)]
pub struct Verdict {
    /// SHA-256 of the content.
    pub hash: String,
    /// The figures that hold.
    pub figures: Figures,
    /// What they mean, one theorem each.
    pub statements: Vec<String>,
    /// What rounding left of the observer's equations.
    pub residues: Residues,
    /// How far the inequalities are from failing.
    pub margins: Vec<Margin>,
}

/// Certified figures.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Figures {
    /// Smallest gain from the first fault, per rad or N m.
    pub beta: f64,
    /// Largest gain from disturbances and bounded noise, per unit of the first disturbance.
    pub gamma: f64,
    /// `beta / gamma`, each channel in units of its smallest fault and of its bound.
    pub gap: f64,
    /// gamma of all frequencies.
    pub gamma_full_band: f64,
    /// Decay of the error a sample.
    pub decay: f64,
}

/// Largest elements of what rounding left of the observer's equations.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Residues {
    /// `M - (I + E C)` (11).
    pub m: f64,
    /// `M A_i - N_i M - L_i C` (13).
    pub observer_equation: f64,
    /// `L_i - (H_i - N_i E)` (34), corrected.
    pub l: f64,
}

/// The smallest margin of a family.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Margin {
    /// Which.
    pub family: Family,
    /// Number of inequalities, all proven.
    pub inequalities: usize,
    /// Smallest pivot of their eliminations relative to its diagonal element, in (0, 1], rounded
    /// for print: the proof is its exact sign.
    pub smallest_pivot: f64,
}

impl Verdict {
    pub(crate) fn new(
        design: &Design,
        hash: String,
        figures: Figures,
        residues: Residues,
        margins: Vec<Margin>,
    ) -> Result<Self, Refusal> {
        let channels = Channels::new(design)?;
        let statements = statements(design, &figures, &residues, &channels);
        Ok(Self { hash, figures, statements, residues, margins })
    }
}

/// The theorems.
fn statements(
    design: &Design,
    figures: &Figures,
    residues: &Residues,
    channels: &Channels,
) -> Vec<String> {
    let Figures { beta, gap, gamma_full_band, decay, .. } = figures;
    let start_up = &design.evaluation.start_up;
    let [w_1, w_2] = design.evaluation.weights;
    let unit = match design.spec.fault[0] {
        Fault::Steering { .. } => "rad",
        Fault::Torque { .. } => "N m",
    };
    let mut statements = vec![
        format!(
            "For x, x^ and the measured premise in S_x and any courses of premise and rho, the \
             error without inputs decays at least like {decay}^k."
        ),
        format!(
            "Likewise, from e_0 = 0 and with W_r = diag({w_1}, {w_2}), for any l2 fault f{}: \
             ||W_r r|| > beta ||f|| with beta = {beta} per {unit}.",
            condition(&channels.fault.band),
        ),
    ];
    statements.extend(attenuation(design, figures, channels));
    statements.push(format!(
        "Unconditionally for any l2 course d of all disturbances and bounded noise: \
         ||W_r r|| < {gamma_full_band} ||d||, in the same unit."
    ));
    if design.d_y.is_some() {
        statements.push(
            "With the bounded sensor noise v, the error is e = x - x^ - E D_y v; v counts with all \
             it does, by the injection, by E y and by the measured premise."
                .into(),
        );
    }
    statements.extend([
        format!("The fault-to-disturbance gap of these is at least {gap}."),
        "At constant premise and rho, beta and gamma are gains over the stated bands; where the \
         premise varies, a band limit on the input alone does not imply the condition on the error."
            .into(),
        format!(
            "From e_0 = [0, v_y, 0] in S_x, without inputs, ||W_r r_j|| <= {} * {}^j.",
            start_up.amplitude, start_up.decay,
        ),
    ]);
    statements.extend(guaranteed(design));
    statements.extend([format!(
        "The stored gains satisfy the observer's equations up to {:.1e}: the error obeys its \
             equation up to an additional input no larger than that times the sum of |x|, and \
             the rounding of the detector's own arithmetic.",
        f64::max(residues.m, residues.observer_equation),
    )]);
    statements
}

/// What a guaranteed threshold covers.
fn guaranteed(design: &Design) -> Option<String> {
    let Guaranteed { bound, inputs, discretisation } = design.evaluation.guaranteed.as_ref()?;
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
        let Figures { beta, gamma, gap, gamma_full_band, decay } = self.figures;
        writeln!(f, "certified: design {}", self.hash)?;
        writeln!(
            f,
            "  gap {gap:.4} = beta {beta:.6} to gamma {gamma:.6}, in units of smallest \
                     fault and bounds"
        )?;
        writeln!(f, "  gamma of the full band {gamma_full_band:.6}, decay {decay} a sample")?;
        writeln!(f, "proven in exact arithmetic, for the gains as stored:")?;
        for statement in &self.statements {
            writeln!(f, "  - {statement}")?;
        }
        writeln!(f, "margins: smallest pivot relative to its diagonal element")?;
        for Margin { family, inequalities, smallest_pivot } in &self.margins {
            writeln!(f, "  {family:<36}{inequalities:>4} inequalities  {smallest_pivot:.1e}")?;
        }
        Ok(())
    }
}
