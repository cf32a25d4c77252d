//! `steerguard verify`: the exact proof check of `steerguard-verify`, in the dress of this command.

use schemars::JsonSchema;
use serde::Serialize;
use steerguard_verify::{Figures, Refusal, Verdict};

use super::input;
use super::print::print;
use super::text::read_text;
use crate::cli::arguments::VerifyArguments;
use crate::cli::failure::{Exit, Failure};
use crate::cli::progress::Progress;

/// What was proven, for machines.
#[derive(JsonSchema, Serialize)]
pub(super) struct Verified {
    /// SHA-256 of the design file's content.
    hash: String,
    /// Whether the design's own drives miss the smallest fault of interest.
    blind: bool,
    #[serde(flatten)]
    figures: Option<Certified>,
    #[serde(flatten)]
    proof: Proof,
    /// What is proven, in sentences.
    statements: Vec<String>,
    /// What is neither proven nor recomputed.
    unchecked: Vec<String>,
}

/// The figures that are proven.
#[derive(JsonSchema, Serialize)]
struct Certified {
    /// Smallest gain from the fault over its band, per rad or N m.
    beta: f64,
    /// Largest gain from the disturbances over their band, per unit of the first.
    gamma: f64,
    /// beta / gamma, each channel in units of its smallest fault and of its bound.
    gap: f64,
    /// gamma of all frequencies.
    gamma_full_band: f64,
    /// The error decays at least like decay^k, sample by sample.
    decay: f64,
}

impl From<Figures> for Certified {
    fn from(figures: Figures) -> Self {
        let Figures { beta, gamma, gap, gamma_full_band, decay } = figures;
        Self { beta, gamma, gap, gamma_full_band, decay }
    }
}

/// The extent of a proof, or why there is none.
#[derive(JsonSchema, Serialize)]
pub(super) struct Proof {
    /// Whether the certified figures are proven.
    pub(super) holds: bool,
    /// How many matrix inequalities were checked in exact arithmetic.
    inequalities: usize,
    /// The smallest pivot of all their factorisations, positive; null where there is none.
    smallest_pivot: Option<f64>,
    /// Why there is no proof; null where there is one.
    refusal: Option<String>,
}

impl Proof {
    /// What the check of a design file said.
    pub(super) fn of(checked: &Result<Verdict, Refusal>) -> Self {
        match checked {
            Ok(verdict) => Self {
                holds: verdict.is_certified(),
                inequalities: verdict.margins.iter().map(|margin| margin.inequalities).sum(),
                smallest_pivot: verdict.margins.iter().map(|m| m.smallest_pivot).reduce(f64::min),
                refusal: None,
            },
            Err(refusal) => Self {
                holds: false,
                inequalities: 0,
                smallest_pivot: None,
                refusal: Some(refusal.to_string()),
            },
        }
    }

    /// The same in words.
    pub(super) fn text(&self) -> String {
        match &self.refusal {
            None if self.holds => format!("{} inequalities in exact arithmetic", self.inequalities),
            None => format!("{} inequalities, none of them about gains", self.inequalities),
            Some(refusal) => format!("FAILS: {refusal}"),
        }
    }
}

pub(super) fn run(arguments: &VerifyArguments, json: bool) -> Result<Exit, Failure> {
    let path = &arguments.design;
    let progress = Progress::saying("proving the design file");
    let checked = steerguard_verify::verify(&read_text(path)?);
    drop(progress);
    let proof = Proof::of(&checked);
    let verdict = checked.map_err(|refusal| input::refused(refusal, path))?;
    let (text, blind) = (verdict.to_string(), verdict.is_blind());
    let exit = if verdict.is_certified() && !blind { Exit::Done } else { Exit::No };
    let Verdict { hash, figures, statements, unchecked, .. } = verdict;
    let figures = figures.map(Certified::from);
    print(json, &Verified { hash, blind, figures, proof, statements, unchecked }, &text)?;
    Ok(exit)
}
