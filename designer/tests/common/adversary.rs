//! Worst-found disturbances and sensor noise within their bounds, in drives of the model (7).

use rand_distr::{Distribution, Uniform};
use steerguard_designer::Design;
use steerguard_designer::analysis::operating_point::{FrozenError, OperatingPoint};
use steerguard_designer::problem::inputs::bounded_inputs;
use steerguard_detector::{
    Configuration, Detector, Deviations, Input, Measurement, Monitor, VehicleState,
};
use steerguard_world::steady_angle;

use chacha20::ChaCha8Rng;
use chacha20::rand_core::SeedableRng;
use nalgebra::{DVector, Matrix2xX, Matrix3, Matrix3xX, Vector2, Vector3};

/// Length of a drive, samples: some windows and the error's memory.
pub const SAMPLES: usize = 240;
/// Steps of the ascent, each to inputs that make J no smaller.
const ASCENT: usize = 12;

/// The columns of all inputs, in units of their bounds.
pub struct Inputs {
    /// D, 3 x n.
    d: Matrix3xX<f64>,
    /// D_y, 2 x n.
    d_y: Matrix2xX<f64>,
}

impl Inputs {
    pub fn of(design: &Design) -> Self {
        let inputs = bounded_inputs(&design.spec);
        let n = inputs.len();
        let (mut d, mut d_y) = (Matrix3xX::zeros(n), Matrix2xX::zeros(n));
        for (column, input) in inputs.iter().enumerate() {
            let of = &input.channel;
            if of.noise.ncols() == 0 {
                d.column_mut(column).copy_from(&of.direction.column(0));
            } else {
                d_y.column_mut(column).copy_from(&of.noise.column(0));
            }
        }
        Self { d, d_y }
    }

    pub fn count(&self) -> usize {
        self.d.ncols()
    }
}

/// A course of the vehicle: torque control and steering by random steps or a random sine.
pub struct Course {
    v_x: f64,
    steering: Box<dyn Fn(f64) -> f64 + Sync>,
    pub start: VehicleState,
}

impl Course {
    pub fn random(design: &Design, generator: &mut ChaCha8Rng) -> Self {
        let mut uniform = |from: f64, to: f64| Uniform::new(from, to).unwrap().sample(generator);
        let detector = &design.detector;
        let range = detector.model.range.shrunk(detector.hysteresis);
        // Evenly in 1/v_x, as the rules are.
        let v_x = 1.0 / uniform(1.0 / range.v_x.max, 1.0 / range.v_x.min);
        let full = steady_angle(&design.detector.model.vehicle, v_x, uniform(0.0, 4.0));
        let sign = if uniform(-1.0, 1.0) < 0.0 { -1.0 } else { 1.0 };
        let frequency = uniform(0.5, 8.0);
        let steering: Box<dyn Fn(f64) -> f64 + Sync> = match uniform(0.0, 3.0) {
            x if x < 1.0 => Box::new(move |_| sign * full),
            x if x < 2.0 => Box::new(move |t| full * (frequency * t).sin()),
            _ => Box::new(move |t| full * (frequency * t).sin().signum()),
        };
        Self { v_x, steering, start: [v_x, 0.0, 0.0].into() }
    }

    pub fn input(&self, design: &Design, x: VehicleState, sample: usize) -> Input {
        let vehicle = &design.detector.model.vehicle;
        let t_eng_n_m = vehicle.cruise_torque(self.v_x)
            + vehicle.effective_longitudinal_inertia_kg_m * (self.v_x - x.v_x_m_per_s);
        let delta_rad = (self.steering)(sample as f64 * design.detector.model.sampling_period_s);
        Input { t_eng_n_m, delta_rad }
    }
}

/// Inputs of a drive, of each sample in units of their bounds.
pub type Signals = Vec<DVector<f64>>;

/// Runs the model (7) with the detector and returns the largest excess of J over the start-up term
/// while it monitors.
pub fn largest_j(design: &Design, inputs: &Inputs, course: &Course, signals: &Signals) -> f64 {
    // In the model's own world Euler's steps leave nothing out.
    let configuration = Configuration { deviations: Deviations::NONE, ..design.configuration() };
    let mut detector = Detector::new(&configuration).unwrap();
    let mut x = course.start;
    let mut largest = 0.0_f64;
    for (sample, w) in signals.iter().enumerate() {
        let u = course.input(design, x, sample);
        let v = &inputs.d_y * w;
        let y =
            Measurement { v_x_m_per_s: x.v_x_m_per_s + v[0], r_rad_per_s: x.r_rad_per_s + v[1] };
        let output = detector.sample(y, u);
        if output.monitor == Monitor::Monitoring {
            let start_up = output.j_th - configuration.evaluation.threshold;
            largest = largest.max(output.j_rms - start_up);
        }
        let d = &inputs.d * w;
        let next = configuration.model.step(x, u).vector();
        x = [next[0] + d[0], next[1] + d[1], next[2] + d[2]].into();
    }
    largest
}

/// The error along a course without inputs: `e+ = N e + B w`, `W_r r = W_r C e + D_r w` sample by sample.
struct Error {
    n: Matrix3<f64>,
    b: Matrix3xX<f64>,
    feedthrough: Matrix2xX<f64>,
}

/// Signals at their bounds that make J of a window that ends with the drive as large as an ascent
/// from `signals` finds: w -> sign(T'T w), T from the signals to the window's residuals.
pub fn worst(design: &Design, inputs: &Inputs, course: &Course, mut signals: Signals) -> Signals {
    let configuration = design.configuration();
    let e = &configuration.evaluation;
    let mut x = course.start;
    let errors: Vec<Error> = (0..signals.len())
        .map(|sample| {
            let at = FrozenError::new(
                &OperatingPoint::new(&configuration.model, x.vector()),
                &configuration.gains,
                e.weights,
            );
            x = configuration.model.step(x, course.input(design, x, sample));
            Error {
                n: at.n,
                b: at.m * &inputs.d + at.from_noise * &inputs.d_y,
                feedthrough: at.feedthrough * &inputs.d_y,
            }
        })
        .collect();
    let [w_v_x, w_r] = e.weights;
    let output = |e: &Vector3<f64>| Vector2::new(w_v_x * e[0], w_r * e[2]);
    let transposed = |r: &Vector2<f64>| Vector3::new(w_v_x * r[0], 0.0, w_r * r[1]);
    let window = signals.len() - e.window..signals.len();
    for _ in 0..ASCENT {
        let mut state = Vector3::zeros();
        let mut residuals = Vec::with_capacity(signals.len());
        for (error, w) in errors.iter().zip(&signals) {
            residuals.push(output(&state) + &error.feedthrough * w);
            state = error.n * state + &error.b * w;
        }
        let mut adjoint = Vector3::zeros();
        for sample in (0..signals.len()).rev() {
            let error = &errors[sample];
            let r = if window.contains(&sample) { residuals[sample] } else { Vector2::zeros() };
            let gradient = error.b.tr_mul(&adjoint) + error.feedthrough.tr_mul(&r);
            signals[sample] = gradient.map(|x| if x < 0.0 { -1.0 } else { 1.0 });
            adjoint = error.n.transpose() * adjoint + transposed(&r);
        }
    }
    signals
}

/// Drive number `index`: its course, and signals that an ascent made as bad as it could; of every
/// tenth drive random ones within the bounds.
pub fn drive(design: &Design, inputs: &Inputs, index: u64) -> (Course, Signals) {
    let mut generator = ChaCha8Rng::seed_from_u64(index);
    let course = Course::random(design, &mut generator);
    let n = inputs.count();
    let mut random = || {
        DVector::from_fn(n, |_, _| {
            Uniform::new_inclusive(-1.0, 1.0).unwrap().sample(&mut generator)
        })
    };
    let signals: Signals = match index % 10 {
        0 => return (course, (0..SAMPLES).map(|_| random()).collect()),
        1..=3 => (0..SAMPLES).map(|_| random()).collect(),
        // Constant, of random signs: the ascent begins from what slow errors add up.
        _ => {
            let constant = random().map(f64::signum);
            vec![constant; SAMPLES]
        }
    };
    let signals = worst(design, inputs, &course, signals);
    (course, signals)
}
