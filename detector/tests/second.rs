//! The second test: what it says of a simulated vehicle, with a fault and without.

#![allow(clippy::unwrap_used)]

mod common;

use common::{STATED, u, y};
use proptest::prelude::*;
use steerguard_detector::{
    AlarmCause, Configuration, Detector, Estimator, FaultHypothesis, Input, Measurement, Output,
    Uncertainty, Vehicle, VehicleState,
};

const NOISE: [f64; 2] = [0.02, 0.002];
const PERIOD_S: f64 = 0.01;
const STEPS: u32 = 10;

/// A detector whose residual raises no alarm, with the second test or without.
fn told(estimator: Option<Estimator>) -> Configuration {
    common::told(Uncertainty { friction: Some(1.0), ..STATED }, estimator)
}

const ESTIMATOR: Estimator = Estimator { threshold: 3.0, estimate_factor: 2.0, noise: NOISE };

/// A number of mean 0 and variance 1, the sum of twelve even ones, as a function of two numbers.
fn normal(seed: u64, k: u64) -> f64 {
    let mut x = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) ^ k.wrapping_mul(0xD1B5_4A32_D192_ED03);
    let mut sum = -6.0;
    for _ in 0..12 {
        x = x.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = x;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        sum += ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64;
    }
    sum
}

/// A vehicle at 20 m/s under a weave, with measurements that have noise.
struct Drive {
    vehicle: Vehicle,
    seed: u64,
    x: VehicleState,
    k: u64,
}

impl Drive {
    fn new(seed: u64) -> Self {
        let x = VehicleState { v_x_m_per_s: 20.0, v_y_m_per_s: 0.0, r_rad_per_s: 0.0 };
        Self { vehicle: Vehicle::PAPER, seed, x, k: 0 }
    }

    /// The next sample with the road wheel off by an angle, in small steps of Euler's.
    fn sample(&mut self, fault_rad: f64) -> (Measurement, Input) {
        let t = self.k as f64 * PERIOD_S;
        let measured = y(
            self.x.v_x_m_per_s + NOISE[0] * normal(self.seed, 2 * self.k),
            self.x.r_rad_per_s + NOISE[1] * normal(self.seed, 2 * self.k + 1),
        );
        let input =
            u(self.vehicle.cruise_torque(20.0), 0.01 * (0.3 * std::f64::consts::TAU * t).sin());
        for _ in 0..STEPS {
            let true_input = Input { delta_rad: input.delta_rad + fault_rad, ..input };
            let slope = self.vehicle.derivative(self.x, true_input);
            let step = PERIOD_S / f64::from(STEPS);
            let mut x = self.x.vector();
            for (x, slope) in x.iter_mut().zip(slope) {
                *x += step * slope;
            }
            self.x = x.into();
        }
        self.k += 1;
        (measured, input)
    }
}

/// The outputs of a drive with a bias from one time until another, s.
fn driven(
    configuration: &Configuration,
    seed: u64,
    deg: f64,
    [from, until]: [f64; 2],
    end: f64,
) -> Vec<Output> {
    let mut detector = Detector::new(configuration).unwrap();
    let mut drive = Drive::new(seed);
    (0..(end / PERIOD_S) as u64)
        .map(|k| {
            let acts = (from..until).contains(&(k as f64 * PERIOD_S));
            let (y, u) = drive.sample(if acts { deg.to_radians() } else { 0.0 });
            *detector.sample(y, u)
        })
        .collect()
}

#[test]
fn a_bias_is_found_at_once_with_its_size_and_its_onset() {
    for (seed, deg) in [(1, 1.0), (2, -1.0), (3, 0.5), (4, 3.0)] {
        let outputs = driven(&told(Some(ESTIMATOR)), seed, deg, [5.0, 60.0], 8.0);
        assert!(outputs[..500].iter().all(|x| !x.alarm), "none before");
        let first = outputs.iter().position(|x| x.alarm).unwrap();
        assert!(first <= 515, "{deg} deg after {} samples", first - 500);
        assert_eq!(outputs[first].alarm_cause, AlarmCause::SecondTest);
        assert!(outputs[first..].iter().all(|x| x.alarm), "it stays");
        let late = outputs[530].estimate.unwrap();
        let error = (late.fault_rad.to_degrees() - deg).abs();
        // This car's tyres have no end, and the filter takes them to lose half of what a friction of 1 takes.
        let v = Vehicle::PAPER;
        let linear = 2.0 * v.front_cornering_stiffness_n_per_rad * deg.to_radians();
        let used = linear / v.axle_loads_n(0.0)[0];
        let half_lost = 0.5 * (1.0 - used.tanh() / used) * f64::abs(deg);
        assert!(error < 0.25 + half_lost, "{deg} deg: {late:?}");
        assert!(error <= late.bound_rad.to_degrees(), "{deg} deg: {late:?}");
        assert!((490..=512).contains(&late.onset), "{late:?}");
    }
}

#[test]
fn what_has_stepped_is_named() {
    for (seed, fault_rad, r_rad_per_s, hypothesis) in [
        (1, 0.02, 0.0, FaultHypothesis::Steering),
        (2, -0.1, 0.0, FaultHypothesis::Steering),
        (3, 0.0, 0.1, FaultHypothesis::YawRateSensor),
        (4, 0.0, -0.06, FaultHypothesis::YawRateSensor),
    ] {
        let mut detector = Detector::new(&told(Some(ESTIMATOR))).unwrap();
        let mut drive = Drive::new(seed);
        let mut named = None;
        for k in 0..530 {
            let acts = if k < 500 { 0.0 } else { 1.0 };
            let (mut y, u) = drive.sample(acts * fault_rad);
            y.r_rad_per_s += acts * r_rad_per_s;
            let output = *detector.sample(y, u);
            assert!(k >= 500 || output.estimate.is_none(), "seed {seed}, sample {k}");
            named =
                named.or(output.estimate.map(|x| x.hypothesis)).map(|x| match output.estimate {
                    Some(now) if x == FaultHypothesis::Undecided => now.hypothesis,
                    _ => x,
                });
        }
        assert_eq!(named, Some(hypothesis), "seed {seed}");
    }
}

#[test]
fn the_alarm_ends_after_the_fault() {
    let hold_s = 1.0;
    let mut configuration = told(Some(ESTIMATOR));
    configuration.evaluation.alarm_hold_s = hold_s;
    for (seed, deg) in [(1, 0.5), (2, 2.0), (3, -6.0)] {
        let outputs = driven(&configuration, seed, deg, [5.0, 10.0], 14.0);
        let alarms: Vec<bool> = outputs.iter().map(|x| x.alarm).collect();
        let first = alarms.iter().position(|x| *x).unwrap();
        assert!(alarms[first..1000].iter().all(|x| *x), "{deg} deg: it stays while the fault does");
        let last = alarms.iter().rposition(|x| *x).unwrap();
        assert!(last < 1000 + ((hold_s + 1.0) / PERIOD_S) as usize, "{deg} deg: until {last}");
        assert_eq!(outputs[last + 1].estimate, None);
    }
}

#[test]
fn without_it_nothing_is_different() {
    let (with, without) = (told(Some(ESTIMATOR)), told(None));
    let with = driven(&with, 1, 0.0, [5.0, 6.0], 10.0);
    let without = driven(&without, 1, 0.0, [5.0, 6.0], 10.0);
    for (with, without) in with.iter().zip(&without) {
        assert!(with.second_ratio < 1.0);
        assert_eq!(Output { second_ratio: 0.0, ..*with }, *without);
    }
}

#[test]
fn what_is_learned_stays_through_a_start() {
    let mut detector = Detector::new(&told(Some(ESTIMATOR))).unwrap();
    let mut drive = Drive::new(1);
    let mut run = |detector: &mut Detector, samples: u32| {
        for _ in 0..samples {
            let (y, u) = drive.sample(0.0);
            detector.sample(y, u);
        }
    };
    run(&mut detector, 2000);
    let before = detector.state().filter;
    detector.sample(y(f64::NAN, 0.0), u(0.0, 0.0));
    run(&mut detector, 1);
    let after = detector.state().filter;
    // Bank and parameters: the states from the fourth on but the gust.
    for k in (3..9).filter(|k| *k != 4) {
        assert_eq!(before.x[k], after.x[k], "{k}");
    }
    assert_eq!(detector.state().onsets.samples, 1);
}

#[test]
fn a_lost_filter_starts_anew() {
    let mut detector = Detector::new(&told(Some(ESTIMATOR))).unwrap();
    let mut drive = Drive::new(1);
    for k in 0..400 {
        let (mut y, u) = drive.sample(0.0);
        if k == 300 {
            y.v_x_m_per_s += 5.0;
            y.r_rad_per_s = 0.5;
        }
        detector.sample(y, u);
        let state = detector.state();
        assert!(state.filter.x.iter().all(|x| x.is_finite()));
        assert!(state.filter.x[0] > 10.0 && state.filter.x[0] < 30.0);
    }
    assert!(detector.output().second_ratio < 1.0);
}

proptest! {
    /// Whatever is measured and commanded, the covariance stays symmetric to the last bit and bounded.
    #[test]
    fn covariances_stay_symmetric_and_bounded(
        seed in any::<u64>(),
        level in prop::sample::select(vec![0.1_f64, 1.0, 10.0, 100.0]),
        steering_ratio in prop::sample::select(vec![0.0, 0.1]),
    ) {
        let mut configuration = told(Some(ESTIMATOR));
        configuration.deviations.uncertainty.steering_ratio = steering_ratio;
        let bounds = configuration.deviations.uncertainty;
        let mut detector = Detector::new(&configuration).unwrap();
        for k in 0..400_u64 {
            let n = |j: u64| level * normal(seed, 4 * k + j);
            detector.sample(
                y(17.0 + 5.0 * (n(0) / 10.0).sin(), 0.3 * (n(1) / 10.0).sin()),
                u(300.0 * n(2), 0.5 * n(3).sin()),
            );
            let filter = detector.state().filter;
            for i in 0..filter.p.len() {
                prop_assert!(filter.p[i][i] >= 0.0, "{i}: {}", filter.p[i][i]);
                for j in 0..i {
                    prop_assert_eq!(filter.p[i][j].to_bits(), filter.p[j][i].to_bits());
                    let product = filter.p[i][i] * filter.p[j][j];
                    prop_assert!(filter.p[i][j] * filter.p[i][j] <= product * (1.0 + 1e-6) + 1e-30);
                }
            }
            let largest = [bounds.mass, bounds.yaw_inertia, bounds.front_cornering_stiffness];
            for (x, largest) in [5, 6, 7].into_iter().zip(largest) {
                prop_assert!(filter.p[x][x].sqrt() <= 1.01 * largest);
                prop_assert!(filter.x[x].abs() <= 0.5);
            }
            prop_assert!(detector.output().second_ratio.is_finite());
        }
    }

    /// A detector goes on from a state as the one that left it, bit for bit.
    #[test]
    fn a_state_goes_on_where_it_was(seed in any::<u64>(), at in 100_usize..900) {
        let configuration = told(Some(ESTIMATOR));
        let mut detector = Detector::new(&configuration).unwrap();
        let mut drive = Drive::new(seed);
        let samples: Vec<_> = (0..1000).map(|k| drive.sample(if k > 600 { 0.02 } else { 0.0 })).collect();
        for (y, u) in &samples[..at] {
            detector.sample(*y, *u);
        }
        let mut other = Detector::new(&configuration).unwrap();
        other.set_state(detector.state()).unwrap();
        for (y, u) in &samples[at..] {
            prop_assert_eq!(*detector.sample(*y, *u), *other.sample(*y, *u));
        }
    }
}
