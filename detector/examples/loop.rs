//! The detector as a library, in the loop that a controller runs: a weave at 15 m/s, and from 2 s on a
//! wheel that stands 1 degree to the left of its command.
//!
//! The gains here are set by hand, with E = 0, and so is the threshold. `steerguard design` finds better
//! ones, says what they are worth, and writes the whole configuration as the key `detector` of its file.

use steerguard_detector::{
    Actuator, Configuration, Detector, Deviations, Evaluation, Gains, Input, Staleness, TsModel,
    VehicleState, Zero,
};

/// How much of an error of v_x and r is left after a sample.
const DECAY: f64 = 0.8;
/// When the wheel slips, s, and by how much, rad.
const FAULT_S: f64 = 2.0;
const FAULT_RAD: f64 = 0.017_453_292_519_943_295;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let model = TsModel::PAPER;
    let mut detector = Detector::new(&Configuration {
        model,
        hysteresis: [0.5, 0.25, 0.05],
        gains: gains(&model),
        evaluation: Evaluation {
            window: 40,
            weights: [0.1, 1.0],
            threshold: 0.005,
            uncertainty_share: 0.0,
            start_up_amplitude: 0.0,
            start_up_decay: 0.0,
            debounce_samples: 1,
            alarm_hold_s: 1.0,
        },
        deviations: Deviations::NONE,
        actuator: Actuator::NONE,
        zero: Zero::default(),
        staleness: Staleness::NEVER,
        estimator: None,
    })?;

    let mut x = VehicleState { v_x_m_per_s: 15.0, ..VehicleState::default() };
    let t_eng_n_m = model.vehicle.cruise_torque(x.v_x_m_per_s);
    for k in 0..400_u32 {
        let t = f64::from(k) * model.sampling_period_s;
        let command = Input { t_eng_n_m, delta_rad: 0.01 * (2.0 * t).sin() };

        let output = detector.sample(x.measured(), command);
        if output.alarm {
            println!("alarm at {t:.2} s: J = {:.5}, J_th = {:.5}", output.j_rms, output.j_th);
            return if t > FAULT_S { Ok(()) } else { Err("a false alarm".into()) };
        }

        let slipped = if t >= FAULT_S { FAULT_RAD } else { 0.0 };
        x = model.step(x, Input { delta_rad: command.delta_rad + slipped, ..command });
    }
    Err("the fault was not seen".into())
}

/// Gains with M = I that take `1 - DECAY` of an error of v_x and r back each sample.
fn gains(model: &TsModel) -> Gains {
    let vertices = model.vertices();
    Gains {
        n: vertices.map(|a| [[DECAY, a[0][1], 0.0], [0.0, a[1][1], 0.0], [0.0, a[2][1], DECAY]]),
        // M A_i - N_i M - L_i C = 0: (13).
        l: vertices
            .map(|a| [[a[0][0] - DECAY, a[0][2]], [a[1][0], a[1][2]], [a[2][0], a[2][2] - DECAY]]),
        m: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        e: [[0.0; 2]; 3],
    }
}
