//! What the responses to deviations come to where the vehicle goes on as it is.

use crate::deviation::{Standing, size};
use crate::{
    CAUSES, Configuration, Evaluation, Input, MOTIONS, Observer, Place, ReferenceMotion, Responses,
    VehicleState,
};

/// What a detector's responses come to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SteadyResponse {
    /// `||W_r r||` of each cause at its bound, in the order of [`Cause::ALL`]; of those along the
    /// reference motions the largest.
    pub by_cause: [f64; CAUSES],
    /// `||W_r r||` of the smallest fault of interest.
    pub fault: f64,
}

/// The responses of a detector with `configuration` after `samples` at the state `x` and input `u`, the
/// reference motions having come to rest there.
pub fn steady_response(
    configuration: &Configuration,
    x: VehicleState,
    u: Input,
    samples: u32,
) -> SteadyResponse {
    let Configuration { model, gains, evaluation, deviations, .. } = configuration;
    let observer = Observer::new(*model, *gains);
    let uncertainty = &deviations.uncertainty;
    let references = uncertainty.references(&model.vehicle, model.sampling_period_s);
    let raising = Evaluation { uncertainty_share: 1.0, ..*evaluation };
    let standing = Standing::new(deviations, &observer, &raising, references.distinct);
    let h = observer.membership(x.measured());
    let (n, l) = (observer.n(&h), observer.l(&h));
    let VehicleState { v_x_m_per_s, v_y_m_per_s, r_rad_per_s } = x;
    let mut place = Place {
        x,
        u,
        slowest_behind_rad: 0.0,
        loading: uncertainty.loading(
            &model.vehicle,
            v_x_m_per_s,
            model.vehicle.cruise_torque(v_x_m_per_s),
            0.0,
        ),
        motions: [ReferenceMotion { v_y_m_per_s, r_rad_per_s }; MOTIONS],
    };
    let mut responses = Responses::NONE;
    for _ in 0..samples {
        responses.advance(&standing, deviations, &observer, &n, &l, &place);
        references.advance(&mut place.motions, x.measured(), u.delta_rad, &place.loading);
    }
    SteadyResponse {
        by_cause: responses.levels_by_cause(deviations, &observer, evaluation, v_x_m_per_s),
        fault: size(evaluation, responses.fault),
    }
}
