//! `steerguard verify`.

use std::path::Path;

use serde::Serialize;
use steerguard_designer::certificate::{self, Check};
use steerguard_designer::gains::ObserverGains;
use steerguard_designer::synthesis::Lyapunov;
use steerguard_designer::theorem4::{Theorem4, matrix};
use steerguard_designer::{Design, DesignFileError, SpecError};

use super::{input, print};
use crate::cli::VerifyArguments;
use crate::failure::{Exit, Failure};

/// Result of the re-check.
#[derive(Serialize)]
pub(super) struct Outcome {
    /// Whether every condition holds.
    pub(super) holds: bool,
    hash: String,
    margins: Check,
    statement: String,
}

impl Outcome {
    /// The result on one line.
    pub(super) fn line(&self) -> String {
        let Check { disturbance_attenuation, fault_sensitivity, stability, .. } = &self.margins;
        format!(
            "  {}  smallest eigenvalues (31) {:.2e}, (32) {:.2e}, (33) {:.2e}\n",
            if self.holds { "re-check holds  " } else { "re-check FAILS  " },
            disturbance_attenuation.smallest_eigenvalue,
            fault_sensitivity.smallest_eigenvalue,
            stability.smallest_eigenvalue,
        )
    }
}

pub(super) fn run(arguments: &VerifyArguments, json: bool) -> Result<Exit, Failure> {
    let outcome = check(&arguments.design)?;
    let text = format!("{}\n{}", outcome.line(), outcome.statement);
    print(json, &outcome, &text)?;
    Ok(if outcome.holds { Exit::Done } else { Exit::No })
}

/// Re-checks the design in the file at `path`.
pub(super) fn check(path: &Path) -> Result<Outcome, Failure> {
    let design = Design::from_json(&input::text(path)?).map_err(|error| match error {
        // A sound file that is not what it says: the answer is no.
        DesignFileError::Hash { .. } | DesignFileError::Inconsistent(_) => {
            Failure { exit: Exit::No, ..input::refused(&error, path) }
        }
        _ => input::refused(&error, path),
    })?;
    let margins = recheck(&design).map_err(Failure::bad)?;
    Ok(Outcome {
        holds: margins.holds(),
        hash: design.hash,
        margins,
        statement: design.certificate.statement,
    })
}

/// The conditions, evaluated anew from the numbers in the file.
fn recheck(design: &Design) -> Result<Check, SpecError> {
    let spec = &design.spec;
    let theorem = Theorem4::new(
        &spec.model(),
        &spec.disturbance_channel()?,
        &spec.fault_channel()?,
        &spec.multipliers(),
        spec.design.decay,
    );
    let gains = ObserverGains {
        gains: design.configuration().gains,
        h: design.vertices.map(|rule| rule.h),
    };
    let c = &design.certificate;
    let lyapunov = Lyapunov {
        p_s: c.p_s.each_ref().map(|p| matrix(p)),
        p_d: c.p_d.each_ref().map(|p| matrix(p)),
        p_f: c.p_f.each_ref().map(|p| matrix(p)),
        q_d: matrix(&c.q_d),
        q_f: matrix(&c.q_f),
        r: matrix(&c.r),
    };
    let synthesis = &design.synthesis;
    Ok(certificate::check(&theorem, &gains, &lyapunov, synthesis.gamma, synthesis.beta))
}
