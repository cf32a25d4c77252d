//! `steerguard verify`: the exact proof check of `steerguard-verify`, in the dress of this command.

use serde::Serialize;
use steerguard_verify::{Refusal, Verdict};

use super::{input, print};
use crate::cli::arguments::VerifyArguments;
use crate::cli::failure::{Exit, Failure};

/// What was proven, for machines.
#[derive(Serialize)]
struct Outcome {
    hash: String,
    beta: f64,
    gamma: f64,
    gap: f64,
    gamma_full_band: f64,
    decay: f64,
    #[serde(flatten)]
    proof: Proof,
    statements: Vec<String>,
}

/// The extent of a proof, or why there is none.
#[derive(Serialize)]
pub(super) struct Proof {
    /// Whether every inequality is proven.
    pub(super) holds: bool,
    inequalities: usize,
    smallest_pivot: Option<f64>,
    refusal: Option<String>,
}

impl Proof {
    /// What the check of a design file said.
    pub(super) fn of(checked: &Result<Verdict, Refusal>) -> Self {
        match checked {
            Ok(verdict) => Self {
                holds: true,
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
            None => format!("{} inequalities in exact arithmetic", self.inequalities),
            Some(refusal) => format!("FAILS: {refusal}"),
        }
    }
}

pub(super) fn run(arguments: &VerifyArguments, json: bool) -> Result<Exit, Failure> {
    let path = &arguments.design;
    let checked = steerguard_verify::verify(&input::text(path)?);
    let proof = Proof::of(&checked);
    let verdict = checked.map_err(|refusal| {
        let failure = match refusal {
            Refusal::Unreadable(_) | Refusal::Format { .. } => Failure::bad(refusal),
            other => Failure::no(other),
        };
        failure.at(path.display()).help("`steerguard design` makes design files; do not edit them")
    })?;
    let text = verdict.to_string();
    let Verdict { hash, figures, statements, .. } = verdict;
    let outcome = Outcome {
        hash,
        beta: figures.beta,
        gamma: figures.gamma,
        gap: figures.gap,
        gamma_full_band: figures.gamma_full_band,
        decay: figures.decay,
        proof,
        statements,
    };
    print(json, &outcome, &text)?;
    Ok(Exit::Done)
}
