//! An augmented Kalman filter: the vehicle with road, wind and what is uncertain of all three (method 9).
//!
//! # Conventions
//! - State `[v_x, v_y, r, b, w, m, i, f, a, rho, o, beta, sigma]`: b the lateral gravity of the bank and w
//!   the specific side force of a gust, m/s^2; m, i, f and a the relative errors of mass, yaw inertia, front
//!   and rear stiffness; rho that of the steering ratio, o the steering offset, rad, beta the bias of the
//!   yaw-rate sensor, rad/s, sigma the relative error of the measured speed. The last four are zero unless
//!   one of them is stated.
//! - A bound that is stated counts as a standard deviation, and no estimate goes beyond it: where a measurement would
//!   take it there, it takes no error of it any further either.
//! - What a parameter does is in proportion to a force or moment F, which the filter knows to a variance Var F only.
//!   Phi has the share `1 - Var F / F^2` of it, none where that is negative: from what is but noise of the measurement
//!   in F nothing is learned. What is left, Var F times the parameter's variance, is noise that lasts.
//! - The mean and the fault move by `T_s (I + T_s A / 2 + (T_s A)^2 / 6)` times the slope, and `Phi = I +`
//!   the same times A: 3 rows, since the other states stay as they are.
//! - Covariances are symmetric to the last bit: each entry is the same products in the same order as its
//!   mirror image.

#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

use crate::algebra::{all_finite, magnitude, product};
use crate::axles::{deficit, slope_deficit};
use crate::{Gust, Measurement, Place, StateVector, TsModel, Uncertainty, Vehicle};

/// States of the filter.
pub const STATES: usize = 13;
/// Those that are there where neither steering ratio nor a zero nor a scale is uncertain.
const ALWAYS: usize = 9;
const BANK: usize = 3;
const GUST: usize = 4;
const MASS: usize = 5;
const YAW_INERTIA: usize = 6;
const FRONT: usize = 7;
const REAR: usize = 8;
const RATIO: usize = 9;
const OFFSET: usize = 10;
const YAW_RATE_BIAS: usize = 11;
const SPEED_SCALE: usize = 12;

/// The bank's random walk, over its bound, per root of s.
const BANK_WALK: f64 = 2.0;
/// Random walk of what else is stated by its bound, over the bound, per root of s.
const WALK: f64 = 0.017;
/// Noise of `dv_y/dt` and `dr/dt`, m/s^2 and rad/s^2 per root of Hz.
const SLOPE_NOISE: f64 = 0.03;
/// That of `dv_x/dt`, which grade, gears and tyres that steer add to, m/s^2 per root of Hz.
const LONGITUDINAL_NOISE: f64 = 0.1;
/// Noise of the axle forces, relative, per root of Hz.
const FORCE_NOISE: f64 = 0.02;
/// The wind's random walk, over that of the fastest gust: the variance of twice that in this time, s.
const GUST_S: f64 = 0.5;
/// Slowest speed, m/s: one that noise has made smaller would count for too much in slip.
const SLOWEST: f64 = 0.1;
/// Slip angle of the rear axle at a start, rad, and what else moves it sideways then, m/s: standard deviations.
const INITIAL_SLIP_RAD: f64 = 0.04;
const INITIAL_V_Y: f64 = 0.1;
/// Share that a tyre is taken to lose of what friction may take from it: it lies between none and all.
const LOSS: f64 = 0.5;
/// A filter whose innovation is this many standard deviations is lost: a wheel that turns by 20 degrees at
/// once makes 80 of them.
const LOST: f64 = 200.0;
/// A filter with this state or more is lost: lateral speed in m/s, and yaw rate in rad/s.
const LOST_STATE: [f64; 2] = [50.0, 20.0];

/// What the second test is told.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize), serde(deny_unknown_fields))]
pub struct Estimator {
    /// The statistic that raises the alarm, positive.
    pub threshold: f64,
    /// The statistic that the error of an estimate stays below, positive.
    pub estimate_factor: f64,
    /// Standard deviations of the noise of `[v_x, r]`, m/s and rad/s, positive.
    pub noise: [f64; 2],
}

/// What the filter knows before the sample to come.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Filter {
    /// Estimated state.
    pub x: [f64; STATES],
    /// Its covariance.
    pub p: [[f64; STATES]; STATES],
}

impl Filter {
    /// Before the first start of a detector.
    pub const NONE: Self = Self { x: [0.0; STATES], p: [[0.0; STATES]; STATES] };

    /// Whether a filter can have this.
    pub(crate) fn is_possible(&self) -> bool {
        all_finite(&self.x)
            && all_finite(self.p.as_flattened())
            && self.p.iter().enumerate().all(|(k, row)| row.get(k).is_some_and(|x| *x >= 0.0))
    }
}

/// What a measurement has said.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Correction {
    /// Gains on the whitened innovation, each n.
    gains: [[f64; STATES]; 2],
    /// `1 + sigma` and v_x: the measurement's slopes by speed and by its scale.
    slopes: [f64; 2],
    /// Cholesky factor of the innovation's covariance: its diagonal inverted, and what is below.
    inverse_root: [f64; 2],
    below: f64,
    /// The innovation, whitened: two standard normal numbers where there is no fault.
    pub(crate) innovation: [f64; 2],
}

impl Correction {
    /// What an error of the state shows in the innovation, beside what is shown without it, whitened.
    pub(crate) fn shown(&self, error: &[f64; STATES], directly: [f64; 2]) -> [f64; 2] {
        let [v_x, r] = measured(self.slopes, error);
        self.whitened([v_x + directly[0], r + directly[1]])
    }

    /// The speed that was expected, m/s.
    pub(crate) const fn speed(&self) -> f64 {
        self.slopes[1]
    }

    fn whitened(&self, [v_x, r]: [f64; 2]) -> [f64; 2] {
        let v_x = v_x * self.inverse_root[0];
        [v_x, (r - self.below * v_x) * self.inverse_root[1]]
    }

    /// `x` plus the gains times a whitened innovation.
    pub(crate) fn correct(&self, x: &mut [f64; STATES], innovation: [f64; 2]) {
        for (gains, innovation) in self.gains.iter().zip(innovation) {
            add(x, innovation, gains, STATES);
        }
    }
}

/// `y + a x` of the first `n` states, in place. Not inlined, as the next one: small before fast.
#[inline(never)]
fn add(y: &mut [f64; STATES], a: f64, x: &[f64; STATES], n: usize) {
    for (y, x) in y.iter_mut().zip(x).take(n) {
        *y += a * x;
    }
}

/// `x' y`.
#[inline(never)]
fn dot(x: &[f64; STATES], y: &[f64; STATES]) -> f64 {
    let mut sum = 0.0;
    for (x, y) in x.iter().zip(y) {
        sum += x * y;
    }
    sum
}

/// `H x`, 2.
fn measured([by_v_x, by_scale]: [f64; 2], x: &[f64; STATES]) -> [f64; 2] {
    [by_v_x * x[0] + by_scale * x[SPEED_SCALE], x[2] + x[YAW_RATE_BIAS]]
}

/// How errors go on from a sample to the next.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Transition {
    /// First rows of Phi.
    phi: [[f64; STATES]; 3],
    /// What 1 rad at the road wheel adds to `[v_x, v_y, r]`.
    of_fault: StateVector,
}

impl Transition {
    /// Takes an error to the next sample: of a fault of the steering that which 1 rad makes.
    pub(crate) fn advance(&self, error: &mut [f64; STATES], of_steering: bool) {
        let mut next = if of_steering { self.of_fault } else { [0.0; 3] };
        for (next, phi) in next.iter_mut().zip(&self.phi) {
            *next += dot(phi, error);
        }
        [error[0], error[1], error[2]] = next;
    }
}

/// What an axle is taken to do.
struct Axle {
    /// Lateral force, N.
    force: f64,
    /// Its slope by the slip angle, N/rad.
    slope: f64,
    /// What friction may take from the force beyond what it is taken to, N.
    at_stake: f64,
}

impl Axle {
    /// Of this stiffness in N/rad at a slip angle in rad, where friction holds so much, N.
    fn of(stiffness: f64, slip_rad: f64, held_n: f64) -> Self {
        let linear = stiffness * slip_rad;
        let used = linear / held_n;
        let missing = deficit(used);
        Self {
            force: linear * (1.0 - LOSS * missing),
            slope: stiffness * (1.0 - LOSS * slope_deficit(used)),
            at_stake: (1.0 - LOSS) * linear * missing,
        }
    }
}

/// The filter of a vehicle: what no sample changes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Kalman {
    vehicle: Vehicle,
    gust: Gust,
    /// Axle forces that friction holds at the static loads, N; infinite for tyres without end.
    held_n: [f64; 2],
    load_transfer: f64,
    period_s: f64,
    noise: [f64; 2],
    /// Largest standard deviations, that of the gust 0: it is known at a start by the speed.
    deviations: [f64; STATES],
    /// States that are there.
    states: usize,
}

impl Kalman {
    /// That of a model with what is uncertain of it.
    pub(crate) fn new(model: &TsModel, u: &Uncertainty, estimator: &Estimator) -> Self {
        let vehicle = model.vehicle;
        let mut deviations = [0.0; STATES];
        deviations[BANK] = u.bank_m_per_s2;
        deviations[MASS] = u.mass;
        deviations[YAW_INERTIA] = u.yaw_inertia;
        deviations[FRONT] = u.front_cornering_stiffness;
        deviations[REAR] = u.rear_cornering_stiffness;
        deviations[RATIO] = u.steering_ratio;
        deviations[OFFSET] = u.steering_offset_rad;
        deviations[YAW_RATE_BIAS] = u.yaw_rate_bias_rad_per_s;
        deviations[SPEED_SCALE] = u.v_x_scale;
        let more = deviations.iter().skip(ALWAYS).any(|x| *x > 0.0);
        Self {
            vehicle,
            gust: u.gust,
            held_n: u.held_n(&vehicle).unwrap_or([f64::INFINITY; 2]),
            load_transfer: u.load_transfer,
            period_s: model.sampling_period_s,
            noise: estimator.noise,
            deviations,
            states: if more { STATES } else { ALWAYS },
        }
    }

    /// A filter that knows nothing but the specification.
    #[cold]
    pub(crate) fn forget(&self) -> Filter {
        let mut filter = Filter::NONE;
        for (k, (row, deviation)) in filter.p.iter_mut().zip(&self.deviations).enumerate() {
            if let Some(p) = row.get_mut(k) {
                *p = deviation * deviation;
            }
        }
        filter
    }

    /// Starts at a measurement: what has been learned of bank and parameters stays.
    pub(crate) fn start(&self, filter: &mut Filter, y: Measurement) {
        let Filter { x, p } = filter;
        for (k, row) in p.iter_mut().enumerate() {
            if k < BANK || k == GUST {
                *row = [0.0; STATES];
            }
            [row[0], row[1], row[2], row[GUST]] = [0.0; 4];
        }
        x[0] = y.v_x_m_per_s / (1.0 + x[SPEED_SCALE]);
        [x[1], x[2], x[GUST]] = [0.0, y.r_rad_per_s - x[YAW_RATE_BIAS], 0.0];
        let gust = self.gust_deviation(x[0]);
        p[0][0] = self.noise[0] * self.noise[0];
        let v_y = INITIAL_V_Y + INITIAL_SLIP_RAD * x[0];
        p[1][1] = v_y * v_y;
        p[2][2] = self.noise[1] * self.noise[1];
        p[GUST][GUST] = gust * gust;
    }

    /// Standard deviation of a gust's specific side force at a speed in m/s, m/s^2.
    fn gust_deviation(&self, v_x: f64) -> f64 {
        self.gust.side_force(v_x) / self.vehicle.mass_kg
    }

    /// Takes in a measurement; none where the filter is lost, which then holds nothing of use.
    pub(crate) fn update(&self, filter: &mut Filter, y: Measurement) -> Option<Correction> {
        let Filter { x, p } = filter;
        let slopes = [1.0 + x[SPEED_SCALE], x[0]];
        let mut of = [[0.0; STATES]; 2];
        let [of_v_x, of_r] = &mut of;
        for ((of_v_x, of_r), row) in of_v_x.iter_mut().zip(of_r.iter_mut()).zip(p.iter()) {
            [*of_v_x, *of_r] = measured(slopes, row);
        }
        let [s_11, s_12] = measured(slopes, of_v_x);
        let [_, s_22] = measured(slopes, of_r);
        let root_1 = libm::sqrt(s_11 + self.noise[0] * self.noise[0]);
        let below = s_12 / root_1;
        let root_2 = libm::sqrt(s_22 + self.noise[1] * self.noise[1] - below * below);
        let inverse_root = [1.0 / root_1, 1.0 / root_2];
        for (of_v_x, of_r) in of_v_x.iter_mut().zip(of_r.iter_mut()) {
            *of_v_x *= inverse_root[0];
            *of_r = (*of_r - below * *of_v_x) * inverse_root[1];
        }
        let mut correction =
            Correction { gains: of, slopes, inverse_root, below, innovation: [0.0; 2] };
        let v_x = y.v_x_m_per_s - slopes[0] * x[0];
        let r = y.r_rad_per_s - x[2] - x[YAW_RATE_BIAS];
        correction.innovation = correction.whitened([v_x, r]);
        let [v_x, r] = correction.innovation;
        let [largest_v_y, largest_r] = LOST_STATE;
        let sound = v_x * v_x + r * r < LOST * LOST
            && magnitude(x[1]) < largest_v_y
            && magnitude(x[2]) < largest_r
            && p.iter().enumerate().all(|(k, row)| row.get(k).is_some_and(|p| *p >= 0.0));
        if !sound {
            return None;
        }
        correction.correct(x, correction.innovation);
        for gains in &correction.gains {
            for (row, gain) in p.iter_mut().zip(gains).take(self.states) {
                add(row, -gain, gains, self.states);
            }
        }
        self.bound(x, &mut correction);
        Some(correction)
    }

    /// Goes on to the next sample, with the road wheel off by `fault_rad`.
    pub(crate) fn predict(&self, filter: &mut Filter, place: &Place, fault_rad: f64) -> Transition {
        let Place { u, slowest_behind_rad, .. } = *place;
        let n = self.states;
        let t = self.period_s;
        let v = &self.vehicle;
        let Filter { x, p } = filter;
        let [v_x, v_y, r] = [x[0].max(SLOWEST), x[1], x[2]];
        let gust = self.gust_deviation(v_x);
        self.cap(p, gust);

        let (l_f, l_r) = (v.front_axle_distance_m, v.rear_axle_distance_m);
        let (c_x, c_y) = (v.longitudinal_drag_n_m_s2_per_m2, v.lateral_drag_n_s2_per_m2);
        let errors = [1.0 + x[MASS], 1.0 + x[YAW_INERTIA], 1.0 + x[FRONT], 1.0 + x[REAR]];
        let lightness = 1.0 / (v.mass_kg * errors[0]);
        let nimbleness = 1.0 / (v.yaw_inertia_kg_m2 * errors[1]);
        let quickness = 1.0 / (v.effective_longitudinal_inertia_kg_m * errors[0]);
        let longitudinal = (u.t_eng_n_m - c_x * v_x * v_x) * quickness;
        // Of the torque: what the measured speed says of it comes late.
        let [front_load, rear_load] = v.load_factors(longitudinal);
        let linear = [
            2.0 * v.front_cornering_stiffness_n_per_rad * front_load * errors[2],
            2.0 * v.rear_cornering_stiffness_n_per_rad * rear_load * errors[3],
        ];
        let delta_rad = (1.0 + x[RATIO]) * u.delta_rad + x[OFFSET] + fault_rad;
        let slip_f = delta_rad - (v_y + l_f * r) / v_x;
        let slip_r = (l_r * r - v_y) / v_x;
        let Axle { force: front, slope: c_f, at_stake: front_at_stake } =
            Axle::of(linear[0], slip_f, front_load * self.held_n[0]);
        let Axle { force: rear, slope: c_r, at_stake: rear_at_stake } =
            Axle::of(linear[1], slip_r, rear_load * self.held_n[1]);
        let drag = c_y * v_y * v_y;
        let across = front + rear - drag;
        let moment = l_f * front - l_r * rear;
        let turning = l_f * c_f - l_r * c_r;
        let turned_by_gust = self.gust.acting_ahead_m * v.mass_kg / v.yaw_inertia_kg_m2;
        let slope = [
            longitudinal + v_y * r,
            across * lightness - v_x * r + x[BANK] + x[GUST],
            moment * nimbleness + turned_by_gust * x[GUST],
        ];

        // A: of [v_x, v_y, r] that of the vehicle, then by the other states.
        let of_steering = [0.0, c_f * lightness, l_f * c_f * nimbleness];
        let (front_by_v_x, rear_by_v_x) =
            (c_f * (v_y + l_f * r) / (v_x * v_x), c_r * (v_y - l_r * r) / (v_x * v_x));
        let moment_by_v_y = -turning / v_x;
        // Of forces and moment, of all but the parameters.
        let variance = |by_v_y: f64, by_r: f64| {
            let of_both = 2.0 * by_v_y * by_r * p[1][2];
            let variance = by_v_y * by_v_y * p[1][1] + of_both + by_r * by_r * p[2][2];
            variance.max(0.0) / (v_x * v_x)
        };
        let mut unknown = [
            variance(c_f + c_r, turning),
            variance(turning, l_f * l_f * c_f + l_r * l_r * c_r),
            variance(c_f, l_f * c_f),
            variance(c_r, -l_r * c_r),
        ];
        let mut known = [across, moment, c_f * slip_f, c_r * slip_r];
        let parameters = p.iter().enumerate().skip(MASS);
        for ((known, unknown), (k, row)) in known.iter_mut().zip(&mut unknown).zip(parameters) {
            let square = *known * *known;
            *known *= if square > *unknown { 1.0 - *unknown / square } else { 0.0 };
            *unknown *= row.get(k).copied().unwrap_or(0.0);
        }
        let [of_mass, of_inertia, of_front, of_rear] = known;

        let mut a = [[0.0; STATES]; 3];
        [a[0][0], a[0][1], a[0][2]] = [-2.0 * c_x * v_x * quickness, r, v_y];
        a[0][MASS] = -longitudinal / errors[0];
        a[1][0] = (front_by_v_x + rear_by_v_x) * lightness - r;
        a[1][1] = (-(c_f + c_r) / v_x - 2.0 * c_y * v_y) * lightness;
        a[1][2] = moment_by_v_y * lightness - v_x;
        [a[1][BANK], a[1][GUST]] = [1.0, 1.0];
        a[1][MASS] = -of_mass * lightness / errors[0];
        a[1][FRONT] = of_front * lightness / errors[2];
        a[1][REAR] = of_rear * lightness / errors[3];
        a[2][0] = (l_f * front_by_v_x - l_r * rear_by_v_x) * nimbleness;
        a[2][1] = moment_by_v_y * nimbleness;
        a[2][2] = -(l_f * l_f * c_f + l_r * l_r * c_r) / v_x * nimbleness;
        a[2][GUST] = turned_by_gust;
        a[2][YAW_INERTIA] = -of_inertia * nimbleness / errors[1];
        a[2][FRONT] = l_f * of_front * nimbleness / errors[2];
        a[2][REAR] = -l_r * of_rear * nimbleness / errors[3];
        for (row, of_steering) in a.iter_mut().zip(of_steering) {
            [row[RATIO], row[OFFSET]] = [of_steering * u.delta_rad, of_steering];
        }

        let held = held(&a, t);
        let mut phi = [[0.0; STATES]; 3];
        for (i, (phi, held)) in phi.iter_mut().zip(&held).enumerate() {
            for (held, a) in held.iter().zip(&a) {
                add(phi, *held, a, n);
            }
            if let Some(phi) = phi.get_mut(i) {
                *phi += 1.0;
            }
        }
        let moved = product(&held, &slope);
        for (x, moved) in x.iter_mut().zip(moved) {
            *x += moved;
        }

        // Phi P, then its product with Phi'.
        let mut rows = [[0.0; STATES]; 3];
        for (row, phi) in rows.iter_mut().zip(&phi) {
            for (phi, p) in phi.iter().zip(p.iter()).take(n) {
                add(row, *phi, p, n);
            }
        }
        let mut block = [[0.0; 3]; 3];
        for (block, row) in block.iter_mut().zip(&rows) {
            *block = phi.each_ref().map(|phi| dot(phi, row));
        }
        let mirrored = rows[0].iter().zip(&rows[1]).zip(&rows[2]);
        for (row, ((of_v_x, of_v_y), of_r)) in p.iter_mut().zip(mirrored).skip(3) {
            [row[0], row[1], row[2]] = [*of_v_x, *of_v_y, *of_r];
        }
        for (row, (of, block)) in p.iter_mut().zip(rows.iter().zip(symmetric(block))) {
            *row = *of;
            [row[0], row[1], row[2]] = block;
        }

        // What is not modelled.
        let [by_mass, by_inertia, by_front, by_rear] = unknown;
        let uncertain = |force: f64, load: f64, at_stake: f64| {
            let transferred = self.load_transfer * (load - 1.0) * force;
            let noise = FORCE_NOISE * force;
            let lasting = magnitude(at_stake) + magnitude(transferred);
            noise * noise + lasting * lasting
        };
        let behind = c_f * slowest_behind_rad;
        let front = uncertain(front, front_load, front_at_stake) + by_front + behind * behind;
        let rear = uncertain(rear, rear_load, rear_at_stake) + by_rear;
        let slopes = SLOPE_NOISE * SLOPE_NOISE;
        let both = (l_f * front - l_r * rear) * lightness * nimbleness;
        let bank = BANK_WALK * self.deviations[BANK];
        p[0][0] += t * LONGITUDINAL_NOISE * LONGITUDINAL_NOISE;
        let turned = l_f * l_f * front + l_r * l_r * rear + by_inertia;
        p[1][1] += t * (slopes + (front + rear + by_mass) * lightness * lightness);
        p[2][2] += t * (slopes + turned * nimbleness * nimbleness);
        p[1][2] += t * both;
        p[2][1] += t * both;
        p[BANK][BANK] += t * bank * bank;
        p[GUST][GUST] += t * gust * gust * 2.0 / GUST_S;
        for (k, (row, deviation)) in p.iter_mut().zip(&self.deviations).enumerate().skip(MASS) {
            if let Some(p) = row.get_mut(k) {
                *p += t * WALK * WALK * deviation * deviation;
            }
        }
        Transition { phi, of_fault: product(&held, &of_steering) }
    }

    /// What is stated of each state but the motion, with that of a `gust`.
    const fn bounds(&self, gust: f64) -> [f64; STATES] {
        let mut bounds = self.deviations;
        bounds[GUST] = gust;
        bounds
    }

    /// Keeps estimates within what is stated.
    fn bound(&self, x: &mut [f64; STATES], correction: &mut Correction) {
        let bounds = self.bounds(self.gust_deviation(x[0].max(SLOWEST)));
        let [of_v_x, of_r] = &mut correction.gains;
        let states = x.iter_mut().zip(of_v_x.iter_mut().zip(of_r)).zip(bounds);
        for ((x, (of_v_x, of_r)), bound) in states.skip(BANK) {
            let within = x.max(-bound).min(bound);
            if within != *x {
                *x = within;
                [*of_v_x, *of_r] = [0.0; 2];
            }
        }
    }

    /// Scales covariances so that no more is unknown of bank, parameters and a `gust` than was at first.
    fn cap(&self, p: &mut [[f64; STATES]; STATES], gust: f64) {
        let mut factors = [1.0; STATES];
        let mut caps = false;
        let diagonal = p.iter().enumerate().map(|(k, row)| row.get(k).copied().unwrap_or(0.0));
        let states = factors.iter_mut().zip(diagonal).zip(self.bounds(gust));
        for ((factor, variance), bound) in states.skip(BANK) {
            let largest = bound * bound;
            if variance > largest {
                *factor = libm::sqrt(largest / variance);
                caps = true;
            }
        }
        if caps {
            for (row, i) in p.iter_mut().zip(&factors) {
                for (p, j) in row.iter_mut().zip(&factors) {
                    *p *= i * j;
                }
            }
        }
    }
}

/// `T (I + T A / 2 + (T A)^2 / 6)` for the first three columns of A: what a slope leaves after a period T.
fn held(a: &[[f64; STATES]; 3], period_s: f64) -> [[f64; 3]; 3] {
    let block = a.map(|row| [row[0], row[1], row[2]].map(|x| period_s * x));
    let mut held = [[0.0; 3]; 3];
    for (i, (held, row)) in held.iter_mut().zip(&block).enumerate() {
        for (of, factor) in block.iter().zip(row) {
            for (held, of) in held.iter_mut().zip(of) {
                *held += factor * of / 6.0;
            }
        }
        for (j, (held, of)) in held.iter_mut().zip(row).enumerate() {
            *held = period_s * (*held + of / 2.0 + if i == j { 1.0 } else { 0.0 });
        }
    }
    held
}

/// `(X + X') / 2`.
fn symmetric([[a, b, c], [d, e, f], [g, h, i]]: [[f64; 3]; 3]) -> [[f64; 3]; 3] {
    let (b, c, f) = (0.5 * (b + d), 0.5 * (c + g), 0.5 * (f + h));
    [[a, b, c], [b, e, f], [c, f, i]]
}
