//! The re-check of a design: the conditions of Theorem 4 evaluated anew from the numbers in the file.

use std::f64::consts::TAU;

use steerguard_designer::certificate::{self, Check};
use steerguard_designer::gains::ObserverGains;
use steerguard_designer::synthesis::Lyapunov;
use steerguard_designer::theorem4::{Band, Channel, Theorem4, matrix};
use steerguard_designer::{Design, Spec};

/// Margins of (13) and (31)-(33) for the gains and matrices of `design`.
pub fn recheck(design: &Design) -> Check {
    let spec = &design.spec;
    let gains = ObserverGains {
        gains: design.configuration().gains,
        h: design.vertices.map(|rule| rule.h),
    };
    let c = &design.certificate;
    let lyapunov = Lyapunov {
        p_s: c.p_s.each_ref().map(matrix),
        p_d: c.p_d.each_ref().map(matrix),
        p_f: c.p_f.each_ref().map(matrix),
        q_d: matrix(&c.q_d),
        q_f: matrix(&c.q_f),
        r: matrix(&c.r),
    };
    let theorem = Theorem4::new(
        &spec.model(),
        &disturbances(spec),
        &fault(spec),
        &spec.multipliers(),
        spec.design.decay,
    );
    certificate::check(&theorem, &gains, &lyapunov, design.synthesis.gamma, design.synthesis.beta)
}

/// The disturbances as one input in the unit of the first, each in proportion to its bound.
fn disturbances(spec: &Spec) -> Channel {
    let unit = spec.disturbance.first().map_or(1.0, |disturbance| disturbance.bound());
    let mut direction = spec.d();
    for (mut column, disturbance) in direction.column_iter_mut().zip(&spec.disturbance) {
        column *= disturbance.bound() / unit;
    }
    let band_hz = spec.disturbance.first().map_or([0.0, 0.0], |disturbance| disturbance.band_hz());
    Channel { direction, band: band(spec, band_hz) }
}

fn fault(spec: &Spec) -> Channel {
    let band_hz = spec.fault.first().map_or([0.0, 0.0], |fault| fault.band_hz());
    Channel { direction: spec.f(), band: band(spec, band_hz) }
}

/// A range in Hz as one in radians a sample; the specification lets it begin at 0, end at the Nyquist
/// frequency, or both.
fn band(spec: &Spec, [from, to]: [f64; 2]) -> Band {
    let period_s = spec.sampling.period_s;
    match (from == 0.0, to >= 0.5 / period_s) {
        (true, true) => Band::Full,
        (true, false) => Band::Low(TAU * to * period_s),
        (false, _) => Band::High(TAU * from * period_s),
    }
}
