//! Reference motions: where a vehicle that obeys its command would be (method 6).
//!
//! The linear single-track model, driven by the measured speed and the commanded angle alone: no fault
//! of the steering is in it. What is uncertain of the vehicle acts where the vehicle should be, not where
//! a fault has taken it, and a vehicle that leaves S_x although none of these motions does has been taken
//! there.
//!
//! # Conventions
//! - Cornering stiffness goes with axle load, which the driver moves to the front by braking: the motions
//!   brake too. What a fault does to the speed moves them no more than what it does to the yaw rate.
//! - Three motions: of the vehicle as modelled; with the front tyres as stiff and the rear tyres as soft as
//!   stated, as heavy, with as much of its load transferred and as little friction; and the same with the
//!   front tyres soft and the rear tyres stiff. Near its critical speed a vehicle answers by a multiple of
//!   what the model says.
//! - Tyres that end are taken for linear ones that give the same force at the slip of the sample.
//! - A motion that is unstable, or might be, is drawn to the measured yaw rate: by [`DRAWN_FROM`] of the
//!   critical speed of the worst vehicle stated not at all, at that speed by [`DRAW_PER_S`].
//! - Integrated by the trapezoidal rule, which no sampling period makes unstable.

use crate::algebra::magnitude;
use crate::axles::{Loading, deficit};
use crate::{Measurement, Vehicle, VehicleState};

/// Number of reference motions.
pub const MOTIONS: usize = 3;

/// Share of the critical speed from which on motions are drawn to the measured yaw rate.
const DRAWN_FROM: f64 = 0.6;
/// How fast at the critical speed and beyond, 1/s.
const DRAW_PER_S: f64 = 15.0;

/// A lateral motion.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ReferenceMotion {
    /// Lateral speed, m/s.
    pub v_y_m_per_s: f64,
    /// Yaw rate, rad/s.
    pub r_rad_per_s: f64,
}

impl ReferenceMotion {
    /// The state at a speed.
    pub const fn at(self, v_x_m_per_s: f64) -> VehicleState {
        let Self { v_y_m_per_s, r_rad_per_s } = self;
        VehicleState { v_x_m_per_s, v_y_m_per_s, r_rad_per_s }
    }
}

/// Coefficients of a motion's single-track model.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Coefficients {
    /// Of `dv_y/dt`, by v_y / v_x, r / v_x and delta.
    lateral: [f64; 3],
    /// Of `dr/dt`, likewise.
    yaw: [f64; 3],
}

impl Coefficients {
    /// Those of `vehicle` with its stiffnesses, front and rear, times these factors and its mass divided by
    /// `lightness`.
    fn of(vehicle: &Vehicle, [front_factor, rear_factor]: [f64; 2], lightness: f64) -> Self {
        let v = vehicle;
        let (m, i_z) = (v.mass_kg / lightness, v.yaw_inertia_kg_m2);
        let (l_f, l_r) = (v.front_axle_distance_m, v.rear_axle_distance_m);
        let c_f = 2.0 * front_factor * v.front_cornering_stiffness_n_per_rad;
        let c_r = 2.0 * rear_factor * v.rear_cornering_stiffness_n_per_rad;
        let moment = c_r * l_r - c_f * l_f;
        Self {
            lateral: [-(c_f + c_r) / m, moment / m, c_f / m],
            yaw: [moment / i_z, -(c_f * l_f * l_f + c_r * l_r * l_r) / i_z, l_f * c_f / i_z],
        }
    }
}

/// The vehicles whose motions are followed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct References {
    vehicle: Vehicle,
    /// Factors of the stiffnesses, front and rear, motion by motion.
    factors: [[f64; 2]; MOTIONS],
    /// M / M' of the heaviest vehicle stated, M' its mass: all but the first.
    lightness: f64,
    /// How many times the known transfer of axle load they have at most.
    transfer: f64,
    /// Axle forces that friction holds at the static loads, N, of all but the first; none for tyres without
    /// end.
    held_n: Option<[f64; 2]>,
    /// The first of the motions differ.
    pub(crate) distinct: usize,
    /// On tyres without end, at the static axle loads.
    at_rest: Stiffnesses,
    period_s: f64,
}

/// What the axles' stiffnesses make of the motions.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Stiffnesses {
    motions: [Coefficients; MOTIONS],
    /// The critical speed of the worst vehicle stated, m/s; none where none oversteers.
    critical_m_per_s: Option<f64>,
}

impl Stiffnesses {
    /// Stiffnesses of so many times the vehicle's, front and rear.
    fn new(vehicle: &Vehicle, factors: &[[f64; 2]; MOTIONS], lightness: f64) -> Self {
        let [_, worst, _] = *factors;
        Self {
            motions: [
                Coefficients::of(vehicle, factors[0], 1.0),
                Coefficients::of(vehicle, factors[1], lightness),
                Coefficients::of(vehicle, factors[2], lightness),
            ],
            critical_m_per_s: critical_speed(vehicle, worst, lightness),
        }
    }
}

impl References {
    /// Those of a vehicle with relative uncertainties of its front and rear stiffness, of its mass and of the
    /// transfer of axle load, on tyres of which friction holds so much, in N at the static axle loads.
    pub(crate) fn new(
        vehicle: &Vehicle,
        [c_f, c_r]: [f64; 2],
        [mass, load_transfer]: [f64; 2],
        held_n: Option<[f64; 2]>,
        period_s: f64,
    ) -> Self {
        let softest = |c: f64| (1.0 - c).max(0.1);
        let factors = [[1.0, 1.0], [1.0 + c_f, softest(c_r)], [softest(c_f), 1.0 + c_r]];
        let uncertain = c_f.max(c_r).max(mass).max(load_transfer);
        // M' = M / (1 - mass).
        let lightness = (1.0 - mass).max(0.1);
        Self {
            vehicle: *vehicle,
            factors,
            lightness,
            transfer: 1.0 + load_transfer,
            held_n,
            distinct: if uncertain > 0.0 || held_n.is_some() { MOTIONS } else { 1 },
            at_rest: Stiffnesses::new(vehicle, &factors, lightness),
            period_s,
        }
    }

    /// At a speed in m/s and an angle at the road wheel in rad.
    fn stiffnesses(
        &self,
        motions: &[ReferenceMotion; MOTIONS],
        v_x_m_per_s: f64,
        delta_rad: f64,
        loading: &Loading,
    ) -> Stiffnesses {
        let mut factors = self.factors;
        if let Some(held) = self.held_n {
            // Of the force that a tyre without end would give at this slip, what friction leaves.
            for (factors, motion) in factors.iter_mut().zip(motions).skip(1) {
                let forces = self.vehicle.axle_forces(motion.at(v_x_m_per_s), delta_rad);
                for (((factor, force), aside), held) in
                    factors.iter_mut().zip(forces).zip(loading.aside_n).zip(held)
                {
                    let most = magnitude(*factor * force) + aside;
                    *factor *= 1.0 - deficit(most / held);
                }
            }
        }
        let driven = loading.driven_m_per_s2();
        let most = self.vehicle.load_factors(self.transfer * driven);
        let loads = [self.vehicle.load_factors(driven), most, most];
        for ([front, rear], [front_load, rear_load]) in factors.iter_mut().zip(loads) {
            *front *= front_load;
            *rear *= rear_load;
        }
        Stiffnesses::new(&self.vehicle, &factors, self.lightness)
    }
}

impl Stiffnesses {
    /// How fast motions are drawn to the measured yaw rate at a speed, 1/s.
    fn draw_per_s(&self, v_x: f64) -> f64 {
        self.critical_m_per_s.map_or(0.0, |critical| {
            let share = (v_x / critical - DRAWN_FROM) / (1.0 - DRAWN_FROM);
            DRAW_PER_S * share.clamp(0.0, 1.0)
        })
    }
}

impl References {
    /// Takes the motions on by a sample, from measurement, angle at the road wheel in rad and what loads
    /// the axles.
    pub(crate) fn advance(
        &self,
        motions: &mut [ReferenceMotion; MOTIONS],
        y: Measurement,
        delta_rad: f64,
        loading: &Loading,
    ) {
        let Measurement { v_x_m_per_s: v_x, r_rad_per_s: r } = y;
        let half = 0.5 * self.period_s;
        let here;
        let stiffnesses = if self.vehicle.centre_of_gravity_height_m > 0.0 || self.held_n.is_some()
        {
            here = self.stiffnesses(motions, v_x, delta_rad, loading);
            &here
        } else {
            &self.at_rest
        };
        let draw = stiffnesses.draw_per_s(v_x);
        for (motion, coefficients) in
            motions.iter_mut().zip(&stiffnesses.motions).take(self.distinct)
        {
            let Coefficients { lateral, yaw } = coefficients;
            // x' = A x + b over half a period, on both sides of (I - A) x+ = (I + A) x + 2 b.
            let a_11 = half * lateral[0] / v_x;
            let a_12 = half * (lateral[1] / v_x - v_x);
            let a_21 = half * yaw[0] / v_x;
            let a_22 = half * (yaw[1] / v_x - draw);
            let b_1 = half * lateral[2] * delta_rad;
            let b_2 = half * (yaw[2] * delta_rad + draw * r);
            let ReferenceMotion { v_y_m_per_s: v_y, r_rad_per_s: r } = *motion;
            let right_1 = v_y + a_11 * v_y + a_12 * r + 2.0 * b_1;
            let right_2 = r + a_21 * v_y + a_22 * r + 2.0 * b_2;
            let determinant = (1.0 - a_11) * (1.0 - a_22) - a_12 * a_21;
            *motion = ReferenceMotion {
                v_y_m_per_s: ((1.0 - a_22) * right_1 + a_12 * right_2) / determinant,
                r_rad_per_s: (a_21 * right_1 + (1.0 - a_11) * right_2) / determinant,
            };
        }
        if let [first, others @ ..] = motions
            && self.distinct == 1
        {
            others.fill(*first);
        }
    }
}

/// Critical speed in m/s of the linear single-track model of `vehicle` with its stiffnesses, front and rear,
/// times these factors and its mass divided by `lightness`; none where it does not oversteer. Rajamani (2012),
/// 3.3.
pub fn critical_speed(vehicle: &Vehicle, [front, rear]: [f64; 2], lightness: f64) -> Option<f64> {
    let v = vehicle;
    let (l_f, l_r) = (v.front_axle_distance_m, v.rear_axle_distance_m);
    let c_f = front * v.front_cornering_stiffness_n_per_rad;
    let c_r = rear * v.rear_cornering_stiffness_n_per_rad;
    let oversteer = c_f * l_f - c_r * l_r;
    let wheelbase = l_f + l_r;
    (oversteer > 0.0).then(|| {
        let square = 2.0 * c_f * c_r * wheelbase * wheelbase * lightness / (v.mass_kg * oversteer);
        libm::sqrt(square)
    })
}
