//! All families, each proven by exact elimination.

use std::thread;

use crate::channel::{Channel, Channels};
use crate::decay::{check_amplitude, check_decay, prove_decay, prove_start_up};
use crate::dynamics::ErrorDynamics;
use crate::exact::{Rational, approximate, exact};
use crate::family::Family;
use crate::gains::prove_gain;
use crate::peaks::prove_peaks;
use crate::read::{APosteriori, Certified, Design, Status};
use crate::refusal::Refusal;
use crate::tally::Margin;

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

/// What holds.
pub struct Proof {
    /// The figures that are claimed as certified; none where none are.
    pub figures: Option<Figures>,
    /// Decay of the error a sample, where that is proven.
    pub decay: Option<f64>,
    /// Margins of all inequalities.
    pub margins: Vec<Margin>,
}

/// Proves all families that the file claims.
///
/// # Errors
/// [`Refusal`]: the first inequality that does not hold.
pub fn prove(design: &Design) -> Result<Proof, Refusal> {
    let dynamics = &ErrorDynamics::new(design);
    check_status(design)?;
    check_amplitude(design)?;
    let claimed =
        design.performance.certified.as_ref().zip(design.certificate.a_posteriori.as_ref());
    let mut proof = match claimed {
        Some((claimed, certificate)) => certified(dynamics, design, claimed, certificate)?,
        None => uncertified(dynamics, design)?,
    };
    proof.margins.extend(prove_peaks(dynamics, design)?);
    Ok(proof)
}

/// Figures are claimed as certified where the status says so, and only there; what is blind may be
/// either.
fn check_status(design: &Design) -> Result<(), Refusal> {
    let certified = match design.synthesis.status {
        Status::Certified => true,
        Status::Uncertified | Status::AlmostSolved => false,
        Status::Blind => design.performance.certified.is_some(),
    };
    for (key, present) in [
        ("performance.certified", design.performance.certified.is_some()),
        ("certificate.a_posteriori", design.certificate.a_posteriori.is_some()),
    ] {
        match (certified, present) {
            (true, false) => return Err(Refusal::NoCertificate { key }),
            (false, true) => return Err(Refusal::Unproven { key }),
            _ => {}
        }
    }
    Ok(())
}

/// The proof of a design that claims no figures: of decay and start-up alone.
fn uncertified(dynamics: &ErrorDynamics, design: &Design) -> Result<Proof, Refusal> {
    let start_up = prove_start_up(dynamics, design)?;
    let decay = design.performance.decay;
    // That it does not hold may be why there is no certificate.
    Ok(match prove_decay(dynamics, &design.certificate.p_s, decay) {
        Ok(margin) => Proof { figures: None, decay: Some(decay), margins: vec![margin, start_up] },
        Err(_) => Proof { figures: None, decay: None, margins: vec![start_up] },
    })
}

/// The proof of all that is claimed.
fn certified(
    dynamics: &ErrorDynamics,
    design: &Design,
    claimed: &Certified,
    certificate: &APosteriori,
) -> Result<Proof, Refusal> {
    let channels = Channels::new(design)?;
    let Channels { fault, disturbances, .. } = &channels;
    if certificate.gamma.len() != disturbances.len() {
        let expected = "a certificate for each band of the disturbances";
        return Err(Refusal::Shape { key: "certificate.a_posteriori.gamma", expected });
    }
    check_figures(claimed, certificate, &channels)?;
    let all = &Channel::stacked(disturbances);
    let mut gains = vec![(Family::FaultSensitivity, &certificate.beta, fault)];
    gains.extend(certificate.gamma.iter().zip(disturbances).enumerate().map(
        |(band, (certificate, channel))| {
            (Family::DisturbanceAttenuation(band), certificate, channel)
        },
    ));
    gains.push((Family::FullBandAttenuation, &certificate.gamma_full_band, all));

    let margins: Result<Vec<_>, _> = thread::scope(|scope| {
        let gains: Vec<_> = gains
            .into_iter()
            .map(|(family, certificate, channel)| {
                scope.spawn(move || prove_gain(dynamics, family, certificate, channel))
            })
            .collect();
        let others = [
            prove_decay(dynamics, &design.certificate.p_s, claimed.decay),
            prove_start_up(dynamics, design),
        ];
        let joined = gains
            .into_iter()
            .map(|gain| gain.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)));
        others.into_iter().chain(joined).collect()
    });
    let Certified { beta, gamma, gap, gamma_full_band, decay } = *claimed;
    Ok(Proof {
        figures: Some(Figures { beta, gamma, gap, gamma_full_band, decay }),
        decay: Some(decay),
        margins: margins?,
    })
}

/// The claimed figures follow from the gains of the certificate, and the gap from the figures.
///
/// # Errors
/// [`Refusal::Claim`]: a figure that does not.
fn check_figures(
    claimed: &Certified,
    certificate: &APosteriori,
    channels: &Channels,
) -> Result<(), Refusal> {
    for (key, value) in [
        ("beta", claimed.beta),
        ("gamma", claimed.gamma),
        ("gamma_full_band", claimed.gamma_full_band),
        ("decay", claimed.decay),
    ] {
        if value <= 0.0 {
            return Err(Refusal::NotPositive {
                key: format!("performance.certified.{key}"),
                value,
            });
        }
    }
    check_decay("performance.certified.decay", claimed.decay)?;

    let square = |x: f64| exact(x) * exact(x);
    // Of several bands: ||W_r r|| < sum of gamma_c ||d_c||, for d of norm one at most the root of
    // the sum of gamma_c^2.
    let blocks: Rational = certificate.gamma.iter().map(|block| square(block.gain)).sum();
    let (beta, full) = (certificate.beta.gain, certificate.gamma_full_band.gain);
    let gap =
        exact(claimed.beta) * &channels.smallest_fault / (exact(claimed.gamma) * &channels.bound);
    for (key, claimed, holds, proven) in [
        ("performance.certified.beta", claimed.beta, square(claimed.beta) <= square(beta), beta),
        (
            "performance.certified.gamma",
            claimed.gamma,
            square(claimed.gamma) >= blocks,
            approximate(&blocks).sqrt(),
        ),
        (
            "performance.certified.gamma_full_band",
            claimed.gamma_full_band,
            square(claimed.gamma_full_band) >= square(full),
            full,
        ),
        ("performance.certified.gap", claimed.gap, exact(claimed.gap) <= gap, approximate(&gap)),
    ] {
        if !holds {
            return Err(Refusal::Claim { key, claimed, proven });
        }
    }
    Ok(())
}
