//! Steering-fault detector: what runs each sample.
//!
//! A Takagi-Sugeno observer with nonlinear consequents estimates the vehicle state from speed, yaw
//! rate and the commanded input; the windowed RMS of its residual against a threshold raises the
//! alarm. Gains come from outside, as numbers in a [`Configuration`].
//!
//! # Conventions
//! - Axes ISO 8855: x forward, y left, yaw rate counter-clockwise. SI units throughout.
//! - State `x = [v_x, v_y, r]` ([`VehicleState`]), measurement `y = C x = [v_x, r]` ([`Measurement`]),
//!   input `u = [T_eng, delta]` ([`Input`]). Of a command, delta is what the [`Actuator`] makes of it.
//! - J and what it is held against have the unit of `W_r r`, which the weights W_r give it.
//! - Sample k holds `y_k` and the input `u_k` that acts from sample k to k + 1. The residual `r_k`
//!   uses `y_k` and nothing later.
//! - Matrices are arrays of rows.
//! - Only `+ - * /` and `sqrt`, in a fixed order: results are bit-identical on every platform.
//! - Numbers in brackets are equations of Wang et al., IFAC CESCIT 2021,
//!   doi 10.1016/j.ifacol.2021.10.033; "corrected" and "method N" refer to `docs/method`.

#![no_std]
#![forbid(unsafe_code)]

mod actuator;
mod algebra;
mod axles;
mod configuration;
mod detector;
mod deviation;
mod evaluation;
mod filter;
mod observer;
mod onset;
mod range;
mod reference;
mod sensors;
mod signals;
mod steady;
mod ts_model;
mod vehicle;

pub use actuator::{Actuator, ActuatorState, MAX_DELAY_SAMPLES};
pub use axles::Loading;
pub use configuration::{Configuration, ConfigurationError, LEAST};
pub use detector::{
    AlarmCause, Detector, Initialisation, LARGEST_ESTIMATE, Monitor, Output, State, StateCause,
    StateError,
};
pub use deviation::{CAUSES, Cause, Deviations, Gust, Place, Responses, Uncertainty};
pub use evaluation::{Evaluation, MAX_WINDOW, RELEASE, Rms, StartUp};
pub use filter::{Estimator, Filter, STATES};
pub use observer::{Gains, Observer};
pub use onset::{
    EXPLANATIONS, FaultEstimate, FaultHypothesis, HYPOTHESES, Hypothesis, Onsets, Signature,
};
pub use range::{Interval, OperatingRange};
pub use reference::{MOTIONS, ReferenceMotion, critical_speed};
pub use sensors::{Jump, Signal, Staleness, Zero};
pub use signals::{Input, Measurement, StateVector, VehicleState};
pub use steady::{SteadyResponse, steady_response};
pub use ts_model::{C, RULES, TsModel};
pub use vehicle::{GRAVITY_M_PER_S2, Vehicle};
