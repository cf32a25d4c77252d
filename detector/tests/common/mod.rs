//! A detector's numbers that need no solver.

#![allow(dead_code, reason = "not every test needs all")]

use steerguard_detector::{
    Actuator, Configuration, Deviations, Estimator, Evaluation, Gains, Gust, Input, Measurement,
    Staleness, TsModel, Uncertainty, Zero,
};

/// What is stated of vehicle, road and wind where nothing else is.
pub const STATED: Uncertainty = Uncertainty {
    mass: 0.11,
    yaw_inertia: 0.11,
    front_cornering_stiffness: 0.1,
    rear_cornering_stiffness: 0.1,
    bank_m_per_s2: 0.51,
    gust: Gust { speed_m_per_s: 10.0, coefficient_n_s2_per_m2: 2.64, acting_ahead_m: 0.25 },
    ..Uncertainty::NONE
};

/// A measurement in m/s and rad/s.
pub const fn y(v_x_m_per_s: f64, r_rad_per_s: f64) -> Measurement {
    Measurement { v_x_m_per_s, r_rad_per_s }
}

/// An input in N m and rad.
pub const fn u(t_eng_n_m: f64, delta_rad: f64) -> Input {
    Input { t_eng_n_m, delta_rad }
}

/// A stable observer without E: N_i keeps the lateral dynamics and contracts the measured states.
pub fn configuration() -> Configuration {
    let model = TsModel::PAPER;
    let identity = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let contraction = 0.5;
    let gains = Gains {
        n: model.vertices().map(|a| {
            [[contraction, a[0][1], 0.0], [0.0, a[1][1], 0.0], [0.0, a[2][1], contraction]]
        }),
        l: model
            .vertices()
            .map(|_| [[1.0 - contraction, 0.0], [0.0, 0.0], [0.0, 1.0 - contraction]]),
        m: identity,
        e: [[0.0; 2]; 3],
    };
    Configuration {
        model,
        hysteresis: [0.5, 0.25, 0.05],
        gains,
        evaluation: Evaluation {
            window: 40,
            weights: [1.0, 1.0],
            threshold: 1e-3,
            uncertainty_share: 1.0,
            start_up_amplitude: 0.1,
            start_up_decay: 0.97,
            debounce_samples: 1,
            alarm_hold_s: 0.0,
        },
        actuator: Actuator::NONE,
        deviations: Deviations::NONE,
        zero: Zero::default(),
        staleness: Staleness::NEVER,
        estimator: None,
    }
}

/// The same told what is uncertain, with the second test or without; its residual raises no alarm.
pub fn told(uncertainty: Uncertainty, estimator: Option<Estimator>) -> Configuration {
    let plain = configuration();
    Configuration {
        evaluation: Evaluation { threshold: 1e6, ..plain.evaluation },
        deviations: Deviations { uncertainty, ..plain.deviations },
        estimator,
        ..plain
    }
}
