//! A design that needs no solver: a stable observer without E, for tests of everything around it.

use steerguard_detector::{
    Actuator, Configuration, Deviations, Evaluation, Gains, Staleness, TsModel, Zero,
};
use steerguard_fmu::BakedDesign;

pub fn design() -> BakedDesign {
    let model = TsModel::PAPER;
    // N_i keeps the lateral dynamics and contracts the measured states.
    let contraction = 0.5;
    let gains = Gains {
        n: model.vertices().map(|a| {
            [[contraction, a[0][1], 0.0], [0.0, a[1][1], 0.0], [0.0, a[2][1], contraction]]
        }),
        l: [[[1.0 - contraction, 0.0], [0.0, 0.0], [0.0, 1.0 - contraction]]; 4],
        m: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        e: [[0.0; 2]; 3],
    };
    BakedDesign {
        hash: *b"0123456789abcdef0123456789abcdef0123456789abcdef0123456789abcdef",
        certified: true,
        blind: false,
        beta: 0.3,
        gamma: 0.01,
        gap: 30.0,
        configuration: Configuration {
            model,
            hysteresis: [0.5, 0.25, 0.05],
            gains,
            evaluation: Evaluation {
                window: 40,
                weights: [1.0, 1.0],
                threshold: 5e-3,
                uncertainty_share: 0.0,
                start_up_amplitude: 0.02,
                start_up_decay: 0.97,
                debounce_samples: 1,
                alarm_hold_s: 1.0,
            },
            deviations: Deviations::NONE,
            actuator: Actuator::NONE,
            zero: Zero::default(),
            staleness: Staleness::NEVER,
            estimator: None,
        },
    }
}
