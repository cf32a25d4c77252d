//! The error dynamics at frozen operating points: gains and noise, in double precision.
//!
//! At constant v_x, v_y, r the error `e = x - x^ - E D_y v` obeys (method 5)
//!
//! ```text
//! e+    = N e + M D d + M F f + (-L(h) + M G rho [0 1 0] E - M K) D_y v
//! W_r r = W_r C e + W_r (I + C E) D_y v,       N = N(h) + M G rho [0 1 0],   rho = 2 v_y
//! ```
//!
//! # Conventions
//! - Operating points: 6 speeds, 3 yaw rates, 3 lateral speeds, each evenly over S_x with its ends; speeds
//!   outermost, lateral speeds innermost.
//! - Gains are the extremes over 1001 frequencies, evenly over a band with its ends.

use std::f64::consts::PI;

use num_complex::Complex;

use crate::agreement::{same, within};
use crate::band::Band;
use crate::channel::{Channel, Channels};
use crate::exact::{Matrix, approximate};
use crate::premise;
use crate::read::{Design, Detector, Interval, Point, Rows3};
use crate::refusal::Refusal;

const SPEEDS: u32 = 6;
const YAW_RATES: u32 = 3;
const LATERAL_SPEEDS: u32 = 3;
/// Steps between frequencies across a band.
const STEPS: u32 = 1000;
/// Doublings of the horizon until a decaying error's covariance is that of all time.
const DOUBLINGS: u32 = 40;
/// Samples of the response to a step.
const RESPONSE: u32 = 4000;
/// How far a figure may be from the one recomputed, relative: both are rounded.
const ROUNDING: f64 = 1e-9;
/// Places of v_x and r in the state.
const MEASURED: [usize; 2] = [0, 2];

/// The error dynamics at an operating point.
struct Error {
    /// N.
    n: Rows3,
    /// M.
    m: Rows3,
    /// What is multiplied by D_y.
    from_noise: [[f64; 2]; 3],
    /// `I + C E`.
    feedthrough: [[f64; 2]; 2],
    /// Diagonal of W_r.
    weights: [f64; 2],
}

/// Columns of inputs: what they add to e+ and to r.
type Columns = Vec<([f64; 3], [f64; 2])>;

/// Recomputes gains and noise of `performance` from the gains of the observer.
///
/// # Errors
/// [`Refusal::Disagreement`]: the first figure that is another.
pub fn check(design: &Design) -> Result<(), Refusal> {
    let performance = &design.performance;
    let channels = Channels::new(design)?;
    let grid = grid(design);
    let points = &performance.operating_points;
    same("performance.operating_points: their number", &points.len(), &grid.len())?;

    let mut gamma = vec![0.0_f64; channels.disturbances.len()];
    let mut peak = 0.0_f64;
    let mut others = vec![f64::INFINITY; performance.other_faults.len()];
    for (index, (point, state)) in points.iter().zip(grid).enumerate() {
        let of = |key: &str| format!("performance.operating_points[{index}].{key}");
        let stored = [point.v_x_m_per_s, point.v_y_m_per_s, point.r_rad_per_s];
        for ((key, stored), value) in
            ["v_x_m_per_s", "v_y_m_per_s", "r_rad_per_s"].into_iter().zip(stored).zip(state)
        {
            within(&of(key), stored, value, ROUNDING)?;
        }
        let error = Error::new(design, state);
        let of_blocks: Vec<f64> =
            channels.disturbances.iter().map(|channel| error.gains(channel)[1]).collect();
        let Point { beta, gamma: total, noise_rms, .. } = *point;
        near(&of("beta"), beta, error.gains(&channels.fault)[0])?;
        near(&of("gamma"), total, of_blocks.iter().copied().fold(0.0, f64::hypot))?;
        near(&of("noise_rms"), noise_rms, error.noise_rms(design))?;
        peak = peak.max(error.peak_of_e_2(&channels.fault));
        for (largest, of_block) in gamma.iter_mut().zip(of_blocks) {
            *largest = largest.max(of_block);
        }
        for (index, smallest) in others.iter_mut().enumerate() {
            *smallest = smallest.min(error.gains(&Channels::fault(design, index + 1)?)[0]);
        }
    }
    if let Some(estimate) = &performance.estimate {
        let key = "performance.estimate.peak_m_per_s_per_deg";
        near(key, estimate.peak_m_per_s_per_deg, peak * PI / 180.0)?;
    }
    let gamma = gamma.into_iter().fold(0.0, f64::hypot);
    near("performance.frozen.gamma", performance.frozen.gamma, gamma)?;
    for (index, (other, beta)) in performance.other_faults.iter().zip(others).enumerate() {
        let of = |key: &str| format!("performance.other_faults[{index}].frozen.{key}");
        near(&of("beta"), other.frozen.beta, beta)?;
        near(&of("gamma"), other.frozen.gamma, gamma)?;
    }
    Ok(())
}

fn near(key: &str, stored: f64, recomputed: f64) -> Result<(), Refusal> {
    within(key, stored, recomputed, ROUNDING * recomputed.abs())
}

/// States `[v_x, v_y, r]` of the operating points.
fn grid(design: &Design) -> Vec<[f64; 3]> {
    let range = &design.detector.model.range;
    let spread = |Interval { min, max }: Interval, count: u32| {
        let step = (max - min) / f64::from(count - 1);
        (0..count).map(move |k| min + step * f64::from(k))
    };
    let mut states = Vec::new();
    for v_x in spread(range.v_x, SPEEDS) {
        for r in spread(range.r, YAW_RATES) {
            states.extend(spread(range.v_y, LATERAL_SPEEDS).map(|v_y| [v_x, v_y, r]));
        }
    }
    states
}

impl Error {
    fn new(design: &Design, state: [f64; 3]) -> Self {
        let Detector { model, gains, evaluation, .. } = &design.detector;
        let [v_x, v_y, r] = state;
        let (v_x_range, r_range) = (model.range.v_x, model.range.r);
        let slow = (1.0 / v_x - 1.0 / v_x_range.max) / (1.0 / v_x_range.min - 1.0 / v_x_range.max);
        let left = (r - r_range.min) / (r_range.max - r_range.min);
        let h =
            [slow * (1.0 - left), slow * left, (1.0 - slow) * (1.0 - left), (1.0 - slow) * left];
        let blend = |of: &dyn Fn(usize) -> f64| (0..h.len()).map(|i| h[i] * of(i)).sum::<f64>();

        // M G rho, which multiplies the lateral speed.
        let m_g_rho: [f64; 3] = std::array::from_fn(|row| {
            2.0 * v_y * (0..3).map(|j| gains.m[row][j] * design.g[j][0]).sum::<f64>()
        });
        let n = std::array::from_fn(|row| {
            std::array::from_fn(|column| {
                let rho = if column == 1 { m_g_rho[row] } else { 0.0 };
                rho + blend(&|i| gains.n[i][row][column])
            })
        });
        let k = premise::at(design, state);
        let from_noise = std::array::from_fn(|row| {
            std::array::from_fn(|column| {
                let m_k: f64 =
                    (0..3).map(|j| gains.m[row][j] * approximate(&k.at(j, column))).sum();
                m_g_rho[row] * gains.e[1][column] - blend(&|i| gains.l[i][row][column]) - m_k
            })
        });
        let feedthrough = [0, 1].map(|row| {
            [0, 1].map(|column| f64::from(row == column) + gains.e[MEASURED[row]][column])
        });
        Self { n, m: gains.m, from_noise, feedthrough, weights: evaluation.weights }
    }

    /// The inputs of a channel.
    fn columns(&self, channel: &Channel) -> Columns {
        let direct = columns_of::<3>(&channel.direction).into_iter();
        let noise = columns_of::<2>(&channel.noise).into_iter();
        direct
            .map(|d| (product(&self.m, &d), [0.0; 2]))
            .chain(noise.map(|v| (product(&self.from_noise, &v), product(&self.feedthrough, &v))))
            .collect()
    }

    /// Smallest and largest singular value over the channel's band; the smallest of several inputs is
    /// not asked for.
    fn gains(&self, channel: &Channel) -> [f64; 2] {
        let columns = self.columns(channel);
        let [from, to] = match &channel.band {
            Band::Low(theta) => [0.0, theta.approximate()],
            Band::High(theta) => [theta.approximate(), PI],
            Band::Full => [0.0, PI],
        };
        let step = (to - from) / f64::from(STEPS);
        let frequencies = (0..=STEPS).map(|k| from + step * f64::from(k));
        frequencies.fold([f64::INFINITY, 0.0], |[smallest, largest], w| {
            let gain = self.gain(&columns, w);
            [smallest.min(gain), largest.max(gain)]
        })
    }

    /// Largest singular value of `W_r (C (z I - N)^-1 B + D)` at `z = exp(jw)`.
    fn gain(&self, columns: &Columns, w: f64) -> f64 {
        let z = Complex::from_polar(1.0, w);
        let resolvent = inverse(&std::array::from_fn(|row| {
            std::array::from_fn(|column| {
                let z = if row == column { z } else { Complex::ZERO };
                z - self.n[row][column]
            })
        }));
        // X X' of the transfer matrix X, 2 x 2.
        let (mut first, mut second, mut both) = (0.0, 0.0, Complex::ZERO);
        for (b, d) in columns {
            let [v_x, r] = [0, 1].map(|output| {
                let row = &resolvent[MEASURED[output]];
                let through: Complex<f64> = row.iter().zip(b).map(|(x, b)| x * b).sum();
                (through + d[output]) * self.weights[output]
            });
            first += v_x.norm_sqr();
            second += r.norm_sqr();
            both += v_x * r.conj();
        }
        let (mean, half) = ((first + second) / 2.0, (first - second) / 2.0);
        (mean + half.hypot(both.norm())).sqrt()
    }

    /// Largest magnitude of the error's second component after a unit step of the fault.
    fn peak_of_e_2(&self, fault: &Channel) -> f64 {
        let [step] = columns_of::<3>(&fault.direction)[..] else { return f64::NAN };
        let step = product(&self.m, &step);
        let mut e = [0.0; 3];
        let mut peak = 0.0_f64;
        for _ in 0..RESPONSE {
            let through = product(&self.n, &e);
            e = std::array::from_fn(|k| through[k] + step[k]);
            peak = peak.max(e[1].abs());
        }
        peak
    }

    /// RMS of the weighted residual under the specified white noise.
    fn noise_rms(&self, design: &Design) -> f64 {
        let noise = &design.spec.noise;
        let std = [noise.v_x.white_std_m_per_s, noise.r.white_std_rad_per_s];
        let b = self.from_noise.map(|row| [row[0] * std[0], row[1] * std[1]]);
        // Covariance sum of N^k B B' N'^k, the horizon doubled again and again.
        let mut covariance: Rows3 = std::array::from_fn(|row| {
            std::array::from_fn(|column| b[row][0] * b[column][0] + b[row][1] * b[column][1])
        });
        let mut power = self.n;
        for _ in 0..DOUBLINGS {
            let later = multiply(&multiply(&power, &covariance), &transposed(&power));
            for (sum, later) in covariance.as_flattened_mut().iter_mut().zip(later.as_flattened()) {
                *sum += later;
            }
            power = multiply(&power, &power);
        }
        let variance = |output: usize| {
            let place = MEASURED[output];
            let direct: f64 = (0..2).map(|j| (self.feedthrough[output][j] * std[j]).powi(2)).sum();
            self.weights[output].powi(2) * (covariance[place][place] + direct)
        };
        (variance(0) + variance(1)).sqrt()
    }
}

/// The columns of a matrix with R rows.
fn columns_of<const R: usize>(x: &Matrix) -> Vec<[f64; R]> {
    (0..x.width())
        .map(|column| std::array::from_fn(|row| approximate(&x.at(row, column))))
        .collect()
}

fn product<const R: usize, const K: usize>(x: &[[f64; K]; R], y: &[f64; K]) -> [f64; R] {
    x.each_ref().map(|row| row.iter().zip(y).map(|(x, y)| x * y).sum())
}

fn multiply(x: &Rows3, y: &Rows3) -> Rows3 {
    x.map(|row| std::array::from_fn(|column| (0..3).map(|j| row[j] * y[j][column]).sum()))
}

fn transposed(x: &Rows3) -> Rows3 {
    std::array::from_fn(|row| std::array::from_fn(|column| x[column][row]))
}

/// By cofactors; not finite for a singular matrix.
fn inverse(x: &[[Complex<f64>; 3]; 3]) -> [[Complex<f64>; 3]; 3] {
    // Rows and columns taken round in a circle give each cofactor its sign.
    let cofactor = |row: usize, column: usize| {
        let [a, b] = [(row + 1) % 3, (row + 2) % 3];
        let [c, d] = [(column + 1) % 3, (column + 2) % 3];
        x[a][c] * x[b][d] - x[a][d] * x[b][c]
    };
    let determinant: Complex<f64> = (0..3).map(|column| x[0][column] * cofactor(0, column)).sum();
    std::array::from_fn(|row| std::array::from_fn(|column| cofactor(column, row) / determinant))
}
