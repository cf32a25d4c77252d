//! The second test's filter, held against what a Kalman filter is: its mean, errors of it, and their covariance.

#![allow(clippy::unwrap_used)]

mod common;

use common::{STATED, u, y};
use steerguard_detector::{
    Configuration, Detector, Estimator, Filter, Hypothesis, Input, Measurement, Onsets, STATES,
    State, Uncertainty, Vehicle,
};

/// Where every derivative is there: turning, braking, and with something known of each parameter.
const X: [f64; STATES] =
    [20.0, 0.4, 0.3, 0.1, 0.2, 0.05, -0.04, 0.03, -0.02, 0.02, 0.01, 0.005, 0.01];
const BRAKES: Input = u(-300.0, 0.05);
/// Noise of a sensor that says nothing.
const BLIND: [f64; 2] = [1e7, 1e7];

/// A car whose drag shows, sampled so often. Its loads stay at rest: Phi leaves out what mass and speed do by them.
fn told(period_s: f64, noise: [f64; 2]) -> Configuration {
    let uncertainty = Uncertainty {
        yaw_inertia: 0.12,
        rear_cornering_stiffness: 0.09,
        steering_ratio: 0.05,
        steering_offset_rad: 0.02,
        yaw_rate_bias_rad_per_s: 0.02,
        v_x_scale: 0.03,
        ..STATED
    };
    // So high that no fault is taken in.
    let estimator = Estimator { threshold: 1e9, estimate_factor: 2.0, noise };
    let mut told = common::told(uncertainty, Some(estimator));
    told.model.sampling_period_s = period_s;
    told.model.vehicle = Vehicle {
        lateral_drag_n_s2_per_m2: 450.0,
        longitudinal_drag_n_m_s2_per_m2: 3.0,
        centre_of_gravity_height_m: 0.0,
        ..Vehicle::PAPER
    };
    told
}

/// What is stated of each state, and of the gust this; motion has no bound.
fn bounds(u: &Uncertainty, gust: f64) -> [f64; STATES] {
    [
        0.0,
        0.0,
        0.0,
        u.bank_m_per_s2,
        gust,
        u.mass,
        u.yaw_inertia,
        u.front_cornering_stiffness,
        u.rear_cornering_stiffness,
        u.steering_ratio,
        u.steering_offset_rad,
        u.yaw_rate_bias_rad_per_s,
        u.v_x_scale,
    ]
}

/// What X shows.
fn shown(x: &[f64; STATES]) -> Measurement {
    y((1.0 + x[12]) * x[0], x[2] + x[11])
}

/// A small covariance of the form `B B'`, below every cap; another for another `salt`.
fn covariance(salt: f64) -> [[f64; STATES]; STATES] {
    let b = |i: usize, j: usize| 1e-3 * ((7 * i + 3 * j) as f64 + salt).sin();
    std::array::from_fn(|i| std::array::from_fn(|j| (0..STATES).map(|k| b(i, k) * b(j, k)).sum()))
}

/// The state after a sample from X with that covariance and a change.
fn sampled(
    told: &Configuration,
    p: [[f64; STATES]; STATES],
    y: Measurement,
    change: impl FnOnce(&mut State),
) -> State {
    let mut detector = Detector::new(told).unwrap();
    detector.sample(shown(&X), BRAKES);
    let mut state = *detector.state();
    state.filter = Filter { x: X, p };
    change(&mut state);
    detector.set_state(&state).unwrap();
    detector.sample(y, BRAKES);
    *detector.state()
}

/// The force of a tyre half way between one without end and one that holds so much.
fn half_held(linear: f64, held: f64) -> f64 {
    0.5 * (linear + held * (linear / held).tanh())
}

/// At X: the sum of the axle forces less the drag, their moment, and what the stiffness makes of each; and what P
/// leaves unknown of each, as a variance, by v_y and r.
fn forces(told: &Configuration, p: &[[f64; STATES]; STATES]) -> ([f64; 4], [f64; 4]) {
    let v = told.model.vehicle;
    let (l_f, l_r) = (v.front_axle_distance_m, v.rear_axle_distance_m);
    let [v_x, v_y, r] = [X[0], X[1], X[2]];
    let delta_rad = (1.0 + X[9]) * BRAKES.delta_rad + X[10];
    let friction = told.deviations.uncertainty.friction;
    let [held_f, held_r] = v.axle_loads_n(0.0).map(|load| friction.unwrap_or(1e9) * load);
    let slips = [delta_rad - (v_y + l_f * r) / v_x, (l_r * r - v_y) / v_x];
    let c_f = 2.0 * v.front_cornering_stiffness_n_per_rad * (1.0 + X[7]);
    let c_r = 2.0 * v.rear_cornering_stiffness_n_per_rad * (1.0 + X[8]);
    let [front, rear] = [half_held(c_f * slips[0], held_f), half_held(c_r * slips[1], held_r)];
    let slope = |c: f64, slip: f64, held: f64| {
        let step = 1e-6;
        (half_held(c * (slip + step), held) - half_held(c * (slip - step), held)) / (2.0 * step)
    };
    let [c_f, c_r] = [slope(c_f, slips[0], held_f), slope(c_r, slips[1], held_r)];
    let drag = v.lateral_drag_n_s2_per_m2 * v_y * v_y;
    let unknown = |by_front: f64, by_rear: f64| {
        let by_v_y = -(by_front * c_f + by_rear * c_r) / v_x;
        let by_r = (by_rear * c_r * l_r - by_front * c_f * l_f) / v_x;
        by_v_y * by_v_y * p[1][1] + 2.0 * by_v_y * by_r * p[1][2] + by_r * by_r * p[2][2]
    };
    let of = [(1.0, 1.0), (l_f, -l_r), (1.0, 0.0), (0.0, 1.0)];
    (
        [front + rear - drag, l_f * front - l_r * rear, c_f * slips[0], c_r * slips[1]],
        of.map(|(by_front, by_rear)| unknown(by_front, by_rear)),
    )
}

/// What a sample makes of an error of the state, column by column, and of a fault of 1 rad.
fn transition(
    told: &Configuration,
    p: [[f64; STATES]; STATES],
) -> ([[f64; STATES]; STATES], [f64; STATES]) {
    let error = |error: [f64; STATES]| {
        let state = sampled(told, p, shown(&X), |state| {
            state.onsets.hypotheses[0] =
                Hypothesis { onset: Some(state.onsets.samples), ..Hypothesis::default() };
            state.onsets.hypotheses[0].signatures[0].error = error;
        });
        state.onsets.hypotheses[0].signatures[0].error
    };
    let of_fault = error([0.0; STATES]);
    let mut columns = [[0.0; STATES]; STATES];
    for (k, column) in columns.iter_mut().enumerate() {
        let mut unit = [0.0; STATES];
        unit[k] = 1.0;
        *column = error(unit);
        for (x, fault) in column.iter_mut().zip(of_fault) {
            *x -= fault;
        }
    }
    (columns, of_fault)
}

/// `|found - expected|` within a share of `scale`.
#[track_caller]
fn near(found: f64, expected: f64, share: f64, scale: f64, what: &str) {
    let most = share * scale.abs();
    assert!((found - expected).abs() <= most, "{what}: {found:e}, not {expected:e} +- {most:e}");
}

#[test]
fn errors_go_on_as_the_mean_does_when_it_is_off() {
    let shift = 1e-4;
    // The mean's own derivative has a term of the second order in the period that Phi leaves out: half the period
    // times changes of A along the slope, up to 150 of A here.
    let period_s = 1e-5;
    let frictions = [None, Some(0.8)];
    for (noise, friction) in [[0.02, 0.002], BLIND].into_iter().zip(frictions) {
        let told = |period_s: f64| {
            let mut told = told(period_s, noise);
            told.deviations.uncertainty.friction = friction;
            told
        };
        let p = sampled(&told(1e-9), covariance(0.0), shown(&X), |_| {}).filter.p;
        let told = told(period_s);
        let (columns, of_fault) = transition(&told, covariance(0.0));
        // Of what a parameter does the share to which its force is known once the measurement is taken in.
        let (forces, unknown) = forces(&told, &p);
        let share = |i: usize, k: usize| {
            let of = if i > 0 { k.checked_sub(5) } else { None };
            of.and_then(|of| Some(1.0 - unknown.get(of)? / forces[of].powi(2))).unwrap_or(1.0)
        };
        let slope = |change: &dyn Fn(&mut State, f64)| {
            let mean = |shift: f64| {
                let change = |state: &mut State| change(state, shift);
                sampled(&told, covariance(0.0), shown(&X), change).filter.x
            };
            let (more, less) = (mean(shift), mean(-shift));
            std::array::from_fn::<f64, STATES, _>(|i| (more[i] - less[i]) / (2.0 * shift))
        };
        for (k, column) in columns.iter().enumerate() {
            let found = slope(&|state, shift| state.filter.x[k] += shift);
            for i in 0..STATES {
                // What an error leaves of itself is no part of what is compared.
                let own = if i == k { 1.0 } else { 0.0 };
                let what = format!("{noise:?}: state {i} by {k}");
                let scale = f64::max((column[i] - own).abs(), 0.01 * period_s);
                near(share(i, k) * (found[i] - own), column[i] - own, 3e-3, scale, &what);
            }
        }
        let found = slope(&|state, shift| state.onsets.held_rad = shift);
        for i in 0..STATES {
            let scale = f64::max(of_fault[i].abs(), 0.01 * period_s);
            near(found[i], of_fault[i], 3e-3, scale, "fault");
        }
    }
}

#[test]
fn the_mean_moves_as_the_vehicle_with_these_parameters_does() {
    let period_s = 1e-6;
    let told = told(period_s, BLIND);
    let plain = told.model.vehicle;
    let vehicle = Vehicle {
        mass_kg: plain.mass_kg * (1.0 + X[5]),
        effective_longitudinal_inertia_kg_m: plain.effective_longitudinal_inertia_kg_m
            * (1.0 + X[5]),
        yaw_inertia_kg_m2: plain.yaw_inertia_kg_m2 * (1.0 + X[6]),
        front_cornering_stiffness_n_per_rad: plain.front_cornering_stiffness_n_per_rad
            * (1.0 + X[7]),
        rear_cornering_stiffness_n_per_rad: plain.rear_cornering_stiffness_n_per_rad * (1.0 + X[8]),
        ..plain
    };
    let fault_rad = 0.03;
    let delta_rad = (1.0 + X[9]) * BRAKES.delta_rad + X[10] + fault_rad;
    let mut slope = vehicle.derivative([X[0], X[1], X[2]].into(), Input { delta_rad, ..BRAKES });
    // Bank and gust push aside; the gust, a side force on the mass as stated, turns too.
    let ahead_m = told.deviations.uncertainty.gust.acting_ahead_m;
    slope[1] += X[3] + X[4];
    slope[2] += ahead_m * plain.mass_kg * X[4] / plain.yaw_inertia_kg_m2;
    let change = |state: &mut State| state.onsets.held_rad = fault_rad;
    let x = sampled(&told, [[0.0; STATES]; STATES], shown(&X), change).filter.x;
    for i in 0..3 {
        near((x[i] - X[i]) / period_s, slope[i], 1e-4, slope[i], &format!("state {i}"));
    }
}

#[test]
fn a_long_step_goes_where_short_ones_go() {
    let ends = |period_s: f64, steps: u32| {
        let mut told = told(period_s, BLIND);
        told.model.vehicle.centre_of_gravity_height_m = 0.5;
        let mut detector = Detector::new(&told).unwrap();
        let mut state = sampled(&told, [[0.0; STATES]; STATES], shown(&X), |_| {});
        for _ in 1..steps {
            detector.set_state(&state).unwrap();
            detector.sample(shown(&state.filter.x), BRAKES);
            state = *detector.state();
        }
        state.filter.x
    };
    let (long, short) = (ends(0.04, 1), ends(0.0005, 80));
    for i in 0..3 {
        // Third order where the slope is linear, second where it is not: products of what changes in 0.04 s.
        near(long[i], short[i], 0.01, short[i] - X[i], &format!("state {i}"));
    }
    assert_eq!(long[3..], X[3..]);
}

#[test]
fn a_measurement_counts_by_its_covariance() {
    // So short that nothing moves between samples.
    let noise = [0.02, 0.002];
    let told = told(1e-9, noise);
    let h = |j: usize| match j {
        0 => [1.0 + X[12], 0.0],
        2 => [0.0, 1.0],
        11 => [0.0, 1.0],
        12 => [X[0], 0.0],
        _ => [0.0, 0.0],
    };
    for salt in [0.0, 1.0, 2.0] {
        let p = covariance(salt);
        let ph = |i: usize, m: usize| (0..STATES).map(|j| p[i][j] * h(j)[m]).sum::<f64>();
        let s = |m: usize, n: usize| (0..STATES).map(|i| h(i)[m] * ph(i, n)).sum::<f64>();
        let (s_11, s_12, s_22) =
            (s(0, 0) + noise[0] * noise[0], s(0, 1), s(1, 1) + noise[1] * noise[1]);
        let determinant = s_11 * s_22 - s_12 * s_12;
        let gains = |i: usize| {
            let (a, b) = (ph(i, 0), ph(i, 1));
            [(a * s_22 - b * s_12) / determinant, (b * s_11 - a * s_12) / determinant]
        };
        let off = [0.03, -0.004];
        let seen = shown(&X);
        let seen = y(seen.v_x_m_per_s + off[0], seen.r_rad_per_s + off[1]);
        let Filter { x, p: found } = sampled(&told, p, seen, |_| {}).filter;
        for i in 0..STATES {
            let [of_v_x, of_r] = gains(i);
            let moved = of_v_x * off[0] + of_r * off[1];
            near(x[i] - X[i], moved, 1e-6, 0.03, &format!("state {i}"));
            for j in 0..STATES {
                let expected = p[i][j] - of_v_x * ph(j, 0) - of_r * ph(j, 1);
                near(found[i][j], expected, 1e-3, 1e-5, &format!("covariance {i}, {j}"));
            }
        }
    }
}

#[test]
fn covariances_go_on_as_errors_do_and_noise_adds() {
    let period_s = 0.01;
    let told = told(period_s, BLIND);
    let u = told.deviations.uncertainty;
    let v = told.model.vehicle;
    let ([_, _, front, rear], _) = forces(&told, &covariance(0.0));
    // Each is uncertain by 2 % per root of Hz, and the slopes of v_y and r by 0.03 beside that.
    let variance = |by_front: f64, by_rear: f64| {
        (0.02 * front * by_front).powi(2) + (0.02 * rear * by_rear).powi(2)
    };
    let (mass, inertia) = (v.mass_kg * (1.0 + X[5]), v.yaw_inertia_kg_m2 * (1.0 + X[6]));
    let (to_front, to_rear) = (v.front_axle_distance_m / inertia, v.rear_axle_distance_m / inertia);
    let gust = u.gust.side_force(X[0]) / v.mass_kg;
    let mut expected = [[0.0; STATES]; STATES];
    expected[0][0] = 0.1 * 0.1;
    expected[1][1] = 0.03 * 0.03 + variance(1.0 / mass, 1.0 / mass);
    expected[2][2] = 0.03 * 0.03 + variance(to_front, to_rear);
    let both = [front * front * to_front, -rear * rear * to_rear].map(|x| 0.02 * 0.02 * x / mass);
    expected[1][2] = both[0] + both[1];
    expected[2][1] = expected[1][2];
    expected[3][3] = (2.0 * u.bank_m_per_s2).powi(2);
    expected[4][4] = gust * gust * 2.0 / 0.5;
    for (k, bound) in bounds(&u, gust).into_iter().enumerate().skip(5) {
        expected[k][k] = (0.017 * bound).powi(2);
    }

    for salt in [0.0, 1.0] {
        let p = covariance(salt);
        let (columns, _) = transition(&told, p);
        // Products of what is unknown of a force and of its parameter.
        let (_, unknown) = forces(&told, &p);
        let product = |k: usize| unknown[k] * p[5 + k][5 + k];
        let (of_front, of_rear) = (product(2), product(3));
        let mut expected = expected;
        expected[1][1] += (of_front + of_rear + product(0)) / (mass * mass);
        expected[2][2] += to_front * to_front * of_front + to_rear * to_rear * of_rear;
        expected[2][2] += product(1) / (inertia * inertia);
        let both = (to_front * of_front - to_rear * of_rear) / mass;
        expected[1][2] += both;
        expected[2][1] += both;
        let after = sampled(&told, p, shown(&X), |_| {}).filter.p;
        for i in 0..STATES {
            for j in 0..STATES {
                let moved: f64 = (0..STATES)
                    .flat_map(|k| (0..STATES).map(move |l| (k, l)))
                    .map(|(k, l)| columns[k][i] * p[k][l] * columns[l][j])
                    .sum();
                let noise = period_s * expected[i][j];
                // The sums have some hundred terms of 1e-5.
                let most = 1e-14 + 1e-6 * noise.abs();
                near(after[i][j] - moved, noise, 1.0, most, &format!("{i}, {j}"));
            }
        }
    }
}

#[test]
fn axle_forces_are_uncertain_by_friction_load_and_a_late_actuator() {
    let (period_s, lag_s) = (0.01, 0.1);
    // Variance that a sample adds to v_y beside what goes on of the covariance, of which there is none.
    let added = |change: &dyn Fn(&mut Uncertainty)| {
        let mut told = told(period_s, BLIND);
        told.model.vehicle.centre_of_gravity_height_m = 0.5;
        change(&mut told.deviations.uncertainty);
        let mut detector = Detector::new(&told).unwrap();
        detector.sample(shown(&X), Input { delta_rad: 0.0, ..BRAKES });
        let mut state = *detector.state();
        state.filter = Filter { x: X, p: [[0.0; STATES]; STATES] };
        detector.set_state(&state).unwrap();
        detector.sample(shown(&X), BRAKES);
        detector.state().filter.p[1][1]
    };
    let v = Vehicle { centre_of_gravity_height_m: 0.5, ..told(period_s, BLIND).model.vehicle };
    let longitudinal = (BRAKES.t_eng_n_m - v.longitudinal_drag_n_m_s2_per_m2 * X[0] * X[0])
        / (v.effective_longitudinal_inertia_kg_m * (1.0 + X[5]));
    let loads = v.load_factors(longitudinal);
    let stiffness = [
        2.0 * v.front_cornering_stiffness_n_per_rad * loads[0] * (1.0 + X[7]),
        2.0 * v.rear_cornering_stiffness_n_per_rad * loads[1] * (1.0 + X[8]),
    ];
    let delta_rad = (1.0 + X[9]) * BRAKES.delta_rad + X[10];
    let forces = [
        stiffness[0] * (delta_rad - (X[1] + v.front_axle_distance_m * X[2]) / X[0]),
        stiffness[1] * (v.rear_axle_distance_m * X[2] - X[1]) / X[0],
    ];
    let mass = v.mass_kg * (1.0 + X[5]);
    // With a share that is lost, and may be so once more, of which a share moves.
    let of_forces = |lost: [f64; 2], moved: [f64; 2]| {
        let variance = |k: usize| {
            let left = forces[k] * (1.0 - lost[k]);
            (forces[k].abs() * lost[k] + left.abs() * moved[k]).powi(2) + (0.02 * left).powi(2)
        };
        period_s * (0.03 * 0.03 + (variance(0) + variance(1)) / (mass * mass))
    };
    let plain = added(&|_| {});
    near(plain, of_forces([0.0; 2], [0.0; 2]), 1e-9, plain, "noise alone");

    // Half of what is missing of a linear tyre's force where friction ends, and of the load that moves.
    let friction = [0, 1].map(|k| {
        let asked = forces[k] / (loads[k] * v.axle_loads_n(0.0)[k]);
        0.5 * (1.0 - asked.tanh() / asked)
    });
    let moved = loads.map(|load| 0.2 * (load - 1.0).abs());
    // The share that friction leaves is an approximation of its own, to 0.7 % of the force: here to 2 % of it.
    let found = added(&|u| u.friction = Some(1.0));
    near(found, of_forces(friction, [0.0; 2]), 0.02, found, "friction");
    let found = added(&|u| u.load_transfer = 0.2);
    near(found, of_forces([0.0; 2], moved), 1e-9, found, "load");
    let found = added(&|u| (u.friction, u.load_transfer) = (Some(1.0), 0.2));
    near(found, of_forces(friction, moved), 0.02, found, "both");

    // The slowest actuator has just begun to follow: its mean over the sample.
    let late_rad = BRAKES.delta_rad * lag_s / period_s * (1.0 - (-period_s / lag_s).exp());
    let found = added(&|u| u.actuator_lag_s = lag_s) - plain;
    near(found, period_s * (stiffness[0] * late_rad / mass).powi(2), 1e-6, found, "actuator");
}

#[test]
fn no_more_is_unknown_than_at_first() {
    let told = told(1e-9, BLIND);
    let u = told.deviations.uncertainty;
    let gust = u.gust.side_force(X[0]) / told.model.vehicle.mass_kg;
    let bounds = bounds(&u, gust);
    let mut p = covariance(0.0).map(|row| row.map(|x| 1e6 * x));
    // One that is known better stays, and so does what it has in common with states that have no bound.
    for row in &mut p {
        row[5] *= 1e-4;
    }
    p[5] = p[5].map(|x| 1e-4 * x);
    let after = sampled(&told, p, shown(&X), |_| {}).filter.p;
    let factor = |k: usize| match k {
        0..3 => 1.0,
        _ => f64::min(1.0, bounds[k] / p[k][k].sqrt()),
    };
    assert!(factor(5) == 1.0 && factor(6) < 1.0);
    for i in 0..STATES {
        for j in 0..STATES {
            let expected = factor(i) * factor(j) * p[i][j];
            let scale = f64::max(expected.abs(), 1e-3);
            near(after[i][j], expected, 1e-6, scale, &format!("{i}, {j}"));
        }
    }
}

#[test]
fn a_start_forgets_the_motion_and_keeps_the_rest() {
    let noise = [0.02, 0.002];
    let mut told = told(1e-12, noise);
    // A storm, whose variance is more than twice its deviation.
    told.deviations.uncertainty.gust.coefficient_n_s2_per_m2 *= 10.0;
    let p = covariance(0.0);
    let seen = y(18.0, 0.2);
    let Filter { x, p: found } =
        sampled(&told, p, seen, |state| state.onsets = Onsets::NONE).filter;
    let mut expected = X;
    (expected[0], expected[1], expected[2], expected[4]) = (18.0 / 1.01, 0.0, 0.2 - 0.005, 0.0);
    let gust = told.deviations.uncertainty.gust.side_force(expected[0]) / Vehicle::PAPER.mass_kg;
    let first = [noise[0], 0.1 + 0.04 * expected[0], noise[1], 0.0, gust];
    for i in 0..STATES {
        near(x[i], expected[i], 1e-7, 1.0, &format!("state {i}"));
        for j in 0..STATES {
            let motion = [i, j].iter().any(|k| [0, 1, 2, 4].contains(k));
            let expected = match (motion, i == j) {
                (true, true) => first[i] * first[i],
                (true, false) => 0.0,
                (false, _) => p[i][j],
            };
            let scale = f64::max(expected.abs(), 1e-5);
            near(found[i][j], expected, 1e-3, scale, &format!("{i}, {j}"));
        }
    }
}

#[test]
fn a_filter_that_cannot_be_is_lost() {
    let noise = [0.02, 0.002];
    let told = told(1e-9, noise);
    let starts = |off: [f64; 2], change: &dyn Fn(&mut State)| {
        let seen = shown(&X);
        let seen = y(seen.v_x_m_per_s + off[0] * noise[0], seen.r_rad_per_s + off[1] * noise[1]);
        let state = sampled(&told, [[0.0; STATES]; STATES], seen, |state| {
            change(state);
            state.onsets.samples = 100;
        });
        state.onsets.samples == 1
    };
    let as_it_is = |_: &mut State| {};
    // Innovations of 200 standard deviations together.
    for (off, lost) in [
        ([199.0, 0.0], false),
        ([201.0, 0.0], true),
        ([0.0, 199.0], false),
        ([0.0, -201.0], true),
        ([140.0, 140.0], false),
        ([143.0, -143.0], true),
    ] {
        assert_eq!(starts(off, &as_it_is), lost, "{off:?}");
    }
    for (v_y, lost) in [(49.9, false), (-49.9, false), (50.0, true), (-50.1, true)] {
        assert_eq!(starts([0.0; 2], &|state| state.filter.x[1] = v_y), lost, "{v_y} m/s");
    }
}

#[test]
fn innovations_of_two_hundred_deviations_are_too_many_to_the_last_bit() {
    // Powers of two, so that nothing is rounded.
    let noise = [1.0 / 64.0, 1.0 / 512.0];
    let told = told(1e-9, noise);
    let lost = |deviations: f64| {
        let change = |state: &mut State| {
            (state.filter.x[2], state.filter.x[11], state.filter.x[12]) = (0.25, 0.0, 0.0);
            state.onsets.samples = 100;
        };
        let seen = y(X[0] + deviations * noise[0], 0.25);
        sampled(&told, [[0.0; STATES]; STATES], seen, change).onsets.samples == 1
    };
    assert!(lost(200.0) && lost(-200.0) && !lost(199.5) && !lost(-199.5));
}

#[test]
fn a_yaw_rate_that_cannot_be_is_lost() {
    // A sensor that says nothing of it: the innovation is small.
    let told = told(1e-9, [0.02, 1e7]);
    for (r, lost) in [(19.9, false), (-19.9, false), (20.0, true), (-20.1, true)] {
        let state = sampled(&told, [[0.0; STATES]; STATES], shown(&X), |state| {
            state.filter.x[2] = r;
            state.onsets.samples = 100;
        });
        assert_eq!(state.onsets.samples == 1, lost, "{r} rad/s");
    }
}

#[test]
fn nothing_is_off_by_more_than_is_stated() {
    let told = told(1e-9, BLIND);
    let u = told.deviations.uncertainty;
    let bounds = bounds(&u, u.gust.side_force(X[0]) / told.model.vehicle.mass_kg);
    for sign in [1.0, -1.0] {
        let off = |share: f64| {
            let change = |state: &mut State| {
                for (x, bound) in state.filter.x.iter_mut().zip(bounds).skip(3) {
                    *x = sign * share * bound;
                }
            };
            sampled(&told, [[0.0; STATES]; STATES], shown(&X), change).filter.x
        };
        for (k, bound) in bounds.into_iter().enumerate().skip(3) {
            for (share, kept) in [(2.0, 1.0), (1.01, 1.0), (0.99, 0.99)] {
                near(off(share)[k], sign * kept * bound, 1e-12, bound, &format!("{share}: {k}"));
            }
        }
    }
}

#[test]
fn what_noise_alone_shows_teaches_nothing_of_the_vehicle() {
    // Straight and steady: forces and moment are noise. A filter that takes its own estimates for forces learns from
    // it that the car is nimble, down to half its yaw inertia within a minute.
    let told = Configuration {
        estimator: Some(Estimator { threshold: 1e9, estimate_factor: 2.0, noise: [0.02, 0.002] }),
        ..common::told(STATED, None)
    };
    let mut detector = Detector::new(&told).unwrap();
    let cruise = Input { t_eng_n_m: told.model.vehicle.cruise_torque(20.0), delta_rad: 0.0 };
    // Irrational turns: neither repeats nor has a mean.
    let noise = |k: u32, turns: f64| 1.7 * ((f64::from(k) * turns).fract() - 0.5) * 2.0;
    for k in 0..6000 {
        let (v_x, r) = (0.02 * noise(k, 2_f64.sqrt()), 0.002 * noise(k, 3_f64.sqrt()));
        detector.sample(y(20.0 + v_x, r), cruise);
    }
    let Filter { x, p } = detector.state().filter;
    for (k, bound) in bounds(&STATED, 0.0).into_iter().enumerate().skip(5).take(4) {
        assert!(x[k].abs() <= 0.5 * bound, "{k}: {} of {bound}", x[k]);
        assert!(p[k][k].sqrt() >= 0.8 * bound, "{k}: known to {} of {bound}", p[k][k].sqrt());
    }
}

#[test]
fn a_filter_that_none_can_have_had_is_refused() {
    let mut detector = Detector::new(&told(0.01, BLIND)).unwrap();
    detector.sample(shown(&X), BRAKES);
    let spoil: [fn(&mut Filter); 3] =
        [|x| x.x[12] = f64::NAN, |x| x.p[3][7] = f64::INFINITY, |x| x.p[12][12] = -1e-30];
    for spoil in spoil {
        let mut state = *detector.state();
        spoil(&mut state.filter);
        assert!(detector.set_state(&state).is_err());
    }
    let mut state = *detector.state();
    state.filter.p[12] = [0.0; STATES];
    detector.set_state(&state).unwrap();
}

#[test]
fn before_the_first_start_only_the_specification_is_known() {
    let told = told(0.01, BLIND);
    let u = told.deviations.uncertainty;
    let detector = Detector::new(&told).unwrap();
    let Filter { x, p } = detector.state().filter;
    assert_eq!(x, [0.0; STATES]);
    // Motion and gust are known by the first measurement.
    let bounds = bounds(&u, 0.0);
    for (i, row) in p.iter().enumerate() {
        for (j, found) in row.iter().enumerate() {
            let expected = if i == j { bounds[i] * bounds[i] } else { 0.0 };
            assert_eq!(*found, expected, "{i}, {j}");
        }
    }
}
