//! Where the vehicle departs from the model (7), and what that does to the residual.
//!
//! # Conventions
//! - A deviation `w` is what one sampling period adds to the state beside (7). The error answers with
//!   `e+ = N(h) e + M w` (13), to first order in e: a response is that e, 3 x 1.
//! - Three kinds: what is known, Euler's remainder and the transfer of axle load, which is taken out of the
//!   residual; uncertainties, known by their bounds, which raise the threshold; the smallest fault of
//!   interest, which says what the threshold still lets through. method 6.
//! - A slope d that acts over a whole period adds `(I + T_s J / 2) T_s d`, J the model's Jacobian: the
//!   vehicle has moved on by it when the period ends.

#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

use crate::algebra::{magnitude, product, sum};
use crate::axles::{Loading, deficit};
use crate::reference::{MOTIONS, ReferenceMotion, References};
use crate::{Actuator, Evaluation, Input, Observer, Rms, StateVector, Vehicle, VehicleState};

/// What is not known of vehicle, road, air and sensors: bounds, not negative, 0 for what is known.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize), serde(deny_unknown_fields))]
pub struct Uncertainty {
    /// Largest `|M_v / M_v' - 1|` of the true mass M_v'; I_e goes with the mass.
    pub mass: f64,
    /// Largest `|I_z / I_z' - 1|` of the true yaw inertia I_z'.
    pub yaw_inertia: f64,
    /// Largest `|C_f' / C_f - 1|` of the true stiffness C_f'.
    pub front_cornering_stiffness: f64,
    /// Largest `|C_r' / C_r - 1|` of the true stiffness C_r'.
    pub rear_cornering_stiffness: f64,
    /// Smallest friction between tyre and road, positive; none for tyres without end.
    pub friction: Option<f64>,
    /// Largest relative error of the known transfer of axle load.
    pub load_transfer: f64,
    /// Lateral component of gravity on the steepest bank, m/s^2.
    pub bank_m_per_s2: f64,
    /// Fastest gust across the road.
    pub gust: Gust,
    /// Largest lag of the actuator beyond the one modelled, s.
    pub actuator_lag_s: f64,
    /// Longest dead time of the actuator beyond the one modelled, s.
    pub actuator_delay_s: f64,
    /// Largest relative error of the steering ratio.
    pub steering_ratio: f64,
    /// Largest offset of the road wheel from where it is commanded to be, rad.
    pub steering_offset_rad: f64,
    /// Largest bias of the yaw-rate sensor, rad/s.
    pub yaw_rate_bias_rad_per_s: f64,
    /// Largest relative error of the measured speed.
    pub v_x_scale: f64,
}

/// A gust across the road: side force `coefficient w sqrt(v_x^2 + w^2)`, `w` its speed.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize), serde(deny_unknown_fields))]
pub struct Gust {
    /// Speed w, m/s.
    pub speed_m_per_s: f64,
    /// Density of air / 2 times frontal area times side-force derivative, N/(m/s)^2.
    pub coefficient_n_s2_per_m2: f64,
    /// Where the force acts ahead of the centre of gravity, m; of either sign.
    pub acting_ahead_m: f64,
}

impl Gust {
    /// Still air.
    pub const NONE: Self =
        Self { speed_m_per_s: 0.0, coefficient_n_s2_per_m2: 0.0, acting_ahead_m: 0.0 };

    /// Side force in N at speed `v_x` in m/s.
    pub fn side_force(&self, v_x: f64) -> f64 {
        let w = self.speed_m_per_s;
        self.coefficient_n_s2_per_m2 * w * libm::sqrt(v_x * v_x + w * w)
    }

    fn blows(&self) -> bool {
        self.speed_m_per_s > 0.0 && self.coefficient_n_s2_per_m2 > 0.0
    }
}

/// Where the vehicle is at a sample, as far as measured, estimated and commanded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// State, the lateral speed estimated.
    pub x: VehicleState,
    /// Input, the angle that of the actuator.
    pub u: Input,
    /// The angle of the slowest actuator less that angle, rad.
    pub slowest_behind_rad: f64,
    /// What loads the axles.
    pub loading: Loading,
    /// Reference motions, where what is uncertain of the vehicle acts.
    pub motions: [ReferenceMotion; MOTIONS],
}

/// The uncertainties by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cause {
    /// Mass.
    Mass,
    /// Yaw inertia.
    YawInertia,
    /// Front stiffness.
    FrontStiffness,
    /// Rear stiffness.
    RearStiffness,
    /// Tyres that saturate.
    Friction,
    /// Transfer of axle load: of what size, when, and where the vehicle is.
    LoadTransfer,
    /// Bank of the road.
    Bank,
    /// Gust.
    Gust,
    /// A slower actuator.
    Actuator,
    /// Steering ratio.
    SteeringRatio,
    /// Steering offset.
    SteeringOffset,
    /// What the front stiffness makes of the axle force that bank and gust ask for.
    FrontUnderSideForce,
    /// What the rear stiffness makes of it.
    RearUnderSideForce,
    /// Bias of the yaw-rate sensor.
    YawRateBias,
    /// Error of the measured speed.
    SpeedScale,
}

/// Number of causes.
pub const CAUSES: usize = 15;
/// The first causes act along the reference motions,
const ALONG: usize = 6;
/// the next on the vehicle wherever it is,
const COMMON: usize = 7;
/// and the last on the measurement.
const SENSED: usize = 2;

impl Cause {
    /// In the order in which they are told.
    pub const ALL: [Self; CAUSES] = [
        Self::Mass,
        Self::YawInertia,
        Self::FrontStiffness,
        Self::RearStiffness,
        Self::Friction,
        Self::LoadTransfer,
        Self::Bank,
        Self::Gust,
        Self::Actuator,
        Self::SteeringRatio,
        Self::SteeringOffset,
        Self::FrontUnderSideForce,
        Self::RearUnderSideForce,
        Self::YawRateBias,
        Self::SpeedScale,
    ];
}

impl Uncertainty {
    /// Everything is known.
    pub const NONE: Self = Self {
        mass: 0.0,
        yaw_inertia: 0.0,
        front_cornering_stiffness: 0.0,
        rear_cornering_stiffness: 0.0,
        friction: None,
        load_transfer: 0.0,
        bank_m_per_s2: 0.0,
        gust: Gust::NONE,
        actuator_lag_s: 0.0,
        actuator_delay_s: 0.0,
        steering_ratio: 0.0,
        steering_offset_rad: 0.0,
        yaw_rate_bias_rad_per_s: 0.0,
        v_x_scale: 0.0,
    };

    /// The reference motions of `vehicle`.
    pub(crate) fn references(&self, vehicle: &Vehicle, period_s: f64) -> References {
        let stiffnesses = [self.front_cornering_stiffness, self.rear_cornering_stiffness];
        References::new(
            vehicle,
            stiffnesses,
            [self.mass, self.load_transfer],
            self.held_n(vehicle),
            period_s,
        )
    }

    /// The slowest that an `actuator` may be.
    pub fn slowest(&self, actuator: &Actuator) -> Actuator {
        Actuator {
            lag_s: actuator.lag_s + self.actuator_lag_s,
            delay_s: actuator.delay_s + self.actuator_delay_s,
            ..*actuator
        }
    }

    /// Axle forces in N, front and rear, that the least friction holds at the static loads; none for tyres
    /// without end.
    pub(crate) fn held_n(&self, vehicle: &Vehicle) -> Option<[f64; 2]> {
        let friction = self.friction?;
        Some(vehicle.axle_loads_n(0.0).map(|load| friction * load))
    }

    /// Whether bank or gust push the vehicle aside.
    fn pushes(&self) -> bool {
        self.bank_m_per_s2 > 0.0 || self.gust.blows()
    }

    /// What loads the axles of `vehicle` at speed `v_x` in m/s, under a drive torque in N m, at the measured
    /// longitudinal acceleration in m/s^2.
    pub(crate) fn loading(
        &self,
        vehicle: &Vehicle,
        v_x: f64,
        t_eng_n_m: f64,
        a_x_m_per_s2: f64,
    ) -> Loading {
        let asked = t_eng_n_m - vehicle.cruise_torque(v_x);
        Loading {
            a_x_m_per_s2,
            asked_m_per_s2: asked / vehicle.effective_longitudinal_inertia_kg_m,
            factors: vehicle.load_factors(a_x_m_per_s2),
            aside_n: self.aside_n(vehicle, v_x),
        }
    }

    /// Whether a cause is more than nothing.
    fn acts(&self, cause: Cause, vehicle: &Vehicle) -> bool {
        let side_force = self.pushes();
        let transfers = vehicle.centre_of_gravity_height_m > 0.0;
        let [front, rear] = [self.front_cornering_stiffness, self.rear_cornering_stiffness];
        match cause {
            Cause::Mass => self.mass > 0.0,
            Cause::YawInertia => self.yaw_inertia > 0.0,
            Cause::FrontStiffness => front > 0.0,
            Cause::RearStiffness => rear > 0.0,
            Cause::Friction => self.friction.is_some(),
            Cause::LoadTransfer => transfers,
            Cause::Bank => self.bank_m_per_s2 > 0.0,
            Cause::Gust => self.gust.blows(),
            Cause::Actuator => self.actuator_lag_s > 0.0 || self.actuator_delay_s > 0.0,
            Cause::SteeringRatio => self.steering_ratio > 0.0,
            Cause::SteeringOffset => self.steering_offset_rad > 0.0,
            Cause::FrontUnderSideForce => side_force && (front > 0.0 || transfers),
            Cause::RearUnderSideForce => side_force && (rear > 0.0 || transfers),
            Cause::YawRateBias => self.yaw_rate_bias_rad_per_s > 0.0,
            Cause::SpeedScale => self.v_x_scale > 0.0,
        }
    }

    /// What a front and a rear axle force in N add to x' (1), of the lightest vehicle with the least yaw
    /// inertia: m/s^2, m/s^2, rad/s^2. The products of uncertainties are in it.
    fn of_forces(&self, vehicle: &Vehicle, front: f64, rear: f64) -> StateVector {
        let (l_f, l_r) = (vehicle.front_axle_distance_m, vehicle.rear_axle_distance_m);
        [
            0.0,
            (1.0 + self.mass) * (front + rear) / vehicle.mass_kg,
            (1.0 + self.yaw_inertia) * (l_f * front - l_r * rear) / vehicle.yaw_inertia_kg_m2,
        ]
    }

    /// What each cause that acts along a motion adds to x', at `x` of that motion; `modelled` are the axle
    /// forces in N at which the known transfer of axle load is taken, `held_n` those that friction holds.
    fn along(
        &self,
        vehicle: &Vehicle,
        place: &Place,
        x: VehicleState,
        modelled: [f64; 2],
        held_n: Option<[f64; 2]>,
    ) -> [StateVector; ALONG] {
        let Place { u, loading, .. } = *place;
        let Loading { a_x_m_per_s2: a_x, asked_m_per_s2, factors: loads, aside_n } = loading;
        let [_, v_y, _] = x.vector();
        let (m, i_z) = (vehicle.mass_kg, vehicle.yaw_inertia_kg_m2);
        let (l_f, l_r) = (vehicle.front_axle_distance_m, vehicle.rear_axle_distance_m);
        let at_rest = vehicle.axle_forces(x, u.delta_rad);
        let [front, rear] = [at_rest[0] * loads[0], at_rest[1] * loads[1]];
        let drag = vehicle.lateral_drag_n_s2_per_m2 * v_y * v_y;
        let saturated = held_n.map_or([0.0; 3], |[front_held, rear_held]| {
            // Force and load go together: the share that is missing is that at rest.
            let missing = |at_rest: f64, aside: f64, held: f64| {
                let most = magnitude(at_rest) + aside;
                let missing = most * deficit(most / held);
                if at_rest > 0.0 { missing } else { -missing }
            };
            let of_front = loads[0] * missing(at_rest[0], aside_n[0], front_held);
            let of_rear = loads[1] * missing(at_rest[1], aside_n[1], rear_held);
            self.of_forces(vehicle, -of_front, -of_rear)
        });
        // The transfer that is known is taken where the vehicle as modelled is, and its size from the speed.
        let unknown = self.load_transfer * magnitude(a_x) + magnitude(asked_m_per_s2 - a_x);
        let along_it = if a_x < 0.0 { -unknown } else { unknown };
        let elsewhere = [at_rest[0] - modelled[0], at_rest[1] - modelled[1]];
        let transferred =
            sum(vehicle.load_transfer(elsewhere, a_x), vehicle.load_transfer(at_rest, along_it));
        [
            [self.mass * asked_m_per_s2, self.mass * (front + rear - drag) / m, 0.0],
            [0.0, 0.0, self.yaw_inertia * (l_f * front - l_r * rear) / i_z],
            self.of_forces(vehicle, self.front_cornering_stiffness * front, 0.0),
            self.of_forces(vehicle, 0.0, self.rear_cornering_stiffness * rear),
            saturated,
            transferred,
        ]
    }

    /// Axle forces in N, front and rear, that hold the vehicle straight against bank and gust at speed `v_x`
    /// in m/s, each at its bound.
    fn aside_n(&self, vehicle: &Vehicle, v_x: f64) -> [f64; 2] {
        if !self.pushes() {
            return [0.0; 2];
        }
        let (l_f, l_r) = (vehicle.front_axle_distance_m, vehicle.rear_axle_distance_m);
        let wheelbase = l_f + l_r;
        let (gust, ahead) = (self.gust.side_force(v_x), self.gust.acting_ahead_m);
        let bank = vehicle.mass_kg * self.bank_m_per_s2;
        [
            (bank * l_r + gust * magnitude(l_r + ahead)) / wheelbase,
            (bank * l_f + gust * magnitude(l_f - ahead)) / wheelbase,
        ]
    }

    /// What each cause that acts wherever the vehicle is adds to x'.
    fn common(&self, vehicle: &Vehicle, place: &Place) -> [StateVector; COMMON] {
        let by_steering = 2.0 * vehicle.front_cornering_stiffness_n_per_rad;
        let turned = |angle_rad: f64| self.of_forces(vehicle, by_steering * angle_rad, 0.0);
        let gust = self.gust.side_force(place.x.v_x_m_per_s);
        let ahead = self.gust.acting_ahead_m;
        let of_gust = [
            0.0,
            (1.0 + self.mass) * gust / vehicle.mass_kg,
            (1.0 + self.yaw_inertia) * ahead * gust / vehicle.yaw_inertia_kg_m2,
        ];
        let [front, rear] = place.loading.aside_n;
        // By as much the stiffness may be another, load and tyre together.
        let other = |tyre: f64, load: f64| tyre * load + magnitude(load - 1.0);
        let loads = place.loading.factors;
        [
            [0.0, self.bank_m_per_s2, 0.0],
            of_gust,
            turned(place.slowest_behind_rad),
            turned(self.steering_ratio * place.u.delta_rad),
            turned(self.steering_offset_rad),
            self.of_forces(vehicle, other(self.front_cornering_stiffness, loads[0]) * front, 0.0),
            self.of_forces(vehicle, 0.0, other(self.rear_cornering_stiffness, loads[1]) * rear),
        ]
    }

    /// What each cause that acts on the measurement adds to it: columns of y, m/s and rad/s.
    fn sensed(&self, v_x: f64) -> [[f64; 2]; SENSED] {
        [[0.0, self.yaw_rate_bias_rad_per_s], [self.v_x_scale * v_x, 0.0]]
    }
}

/// What the detector is told of deviations.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize), serde(deny_unknown_fields))]
pub struct Deviations {
    /// Whether the response to Euler's remainder is taken out of the residual, and slopes act over the
    /// period; else all is as Euler's steps say.
    pub euler_correction: bool,
    /// What raises the threshold.
    pub uncertainty: Uncertainty,
    /// Deviation w that the smallest fault of interest makes, in m/s, m/s, rad/s: its column of F, times
    /// its size.
    pub smallest_fault: StateVector,
}

impl Deviations {
    /// Nothing is corrected, uncertain or looked for.
    pub const NONE: Self =
        Self { euler_correction: false, uncertainty: Uncertainty::NONE, smallest_fault: [0.0; 3] };
}

/// What no sample changes of the responses, found once.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Standing {
    /// The causes that act and raise the threshold: the others cost nothing.
    acting: [bool; CAUSES],
    /// Whether there is one, and whether one acts along the motions.
    any: bool,
    along: bool,
    /// Reference motions that differ.
    motions: usize,
    /// Whether axle load is transferred.
    transfers: bool,
    /// Whether something asks for the model's Jacobian.
    curves: bool,
    /// What the least friction holds of the axles at rest, N; none for tyres without end.
    held_n: Option<[f64; 2]>,
}

impl Standing {
    pub(crate) fn new(
        deviations: &Deviations,
        observer: &Observer,
        evaluation: &Evaluation,
        motions: usize,
    ) -> Self {
        let raises = evaluation.uncertainty_share > 0.0;
        let vehicle = &observer.model.vehicle;
        let acting = Cause::ALL.map(|cause| raises && deviations.uncertainty.acts(cause, vehicle));
        Self {
            acting,
            any: acting.contains(&true),
            along: acting.iter().take(ALONG).any(|&acts| acts),
            motions,
            transfers: vehicle.centre_of_gravity_height_m > 0.0,
            curves: deviations.euler_correction
                || acting.iter().skip(ALONG + COMMON).any(|&acts| acts),
            held_n: deviations.uncertainty.held_n(vehicle),
        }
    }

    /// Of the causes from `first` on.
    fn acting(&self, first: usize) -> impl Iterator<Item = &bool> {
        self.acting.iter().skip(first)
    }
}

/// Responses since the observer's start, e in m/s, m/s, rad/s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Responses {
    /// To what is known.
    pub known: StateVector,
    /// To each cause at its bound that acts along the motions, motion by motion.
    pub along: [[StateVector; ALONG]; MOTIONS],
    /// To each that acts wherever the vehicle is.
    pub common: [StateVector; COMMON],
    /// To each that acts on the measurement: `e - E` times the measurement's error.
    pub sensed: [StateVector; SENSED],
    /// To the smallest fault of interest.
    pub fault: StateVector,
    /// Window of the sum of `||W_r C e||` over the causes.
    pub uncertainty_rms: Rms,
    /// Window of `||W_r C e||` of the fault.
    pub fault_rms: Rms,
}

impl Responses {
    /// At the observer's start.
    pub const NONE: Self = Self {
        known: [0.0; 3],
        along: [[[0.0; 3]; ALONG]; MOTIONS],
        common: [[0.0; 3]; COMMON],
        sensed: [[0.0; 3]; SENSED],
        fault: [0.0; 3],
        uncertainty_rms: Rms::EMPTY,
        fault_rms: Rms::EMPTY,
    };

    /// What each cause at its bound does to the residual at this sample, `||W_r r||`, in the order of
    /// [`Cause::ALL`]; of those along the motions the largest.
    pub(crate) fn levels_by_cause(
        &self,
        deviations: &Deviations,
        observer: &Observer,
        evaluation: &Evaluation,
        v_x: f64,
    ) -> [f64; CAUSES] {
        let mut levels = [0.0; CAUSES];
        // Of the motion with the largest sum, as in the threshold.
        let sum = |motion: &[StateVector; ALONG]| motion.iter().map(|e| size(evaluation, *e)).sum();
        let (mut worst, mut largest) = ([[0.0; 3]; ALONG], 0.0_f64);
        for motion in &self.along {
            let of_motion: f64 = sum(motion);
            if of_motion > largest {
                (worst, largest) = (*motion, of_motion);
            }
        }
        for (level, e) in levels.iter_mut().zip(worst.iter().chain(&self.common)) {
            *level = size(evaluation, *e);
        }
        let errors = deviations.uncertainty.sensed(v_x);
        let sensed = levels.iter_mut().skip(ALONG + COMMON);
        for ((level, e), error) in sensed.zip(&self.sensed).zip(errors) {
            *level = size(evaluation, seen(observer, *e, error));
        }
        levels
    }

    /// What the uncertainties add to J at most, and the J that the smallest fault makes alone, at this
    /// sample, measured at `v_x`.
    ///
    /// `||W_r C e|| <= sum_j ||W_r C e_j||` whatever the uncertainties' signs, and J is a norm.
    pub(crate) fn levels(
        &mut self,
        standing: &Standing,
        deviations: &Deviations,
        observer: &Observer,
        evaluation: &Evaluation,
        v_x: f64,
    ) -> [f64; 2] {
        let fault_size = size(evaluation, self.fault);
        let fault = self.fault_rms.push(fault_size * fault_size, evaluation.window);
        if !standing.any {
            return [0.0, fault];
        }
        let sum_of = |es: &[StateVector], first: usize| {
            let mut sum = 0.0;
            for (e, acts) in es.iter().zip(standing.acting(first)) {
                if *acts {
                    sum += size(evaluation, *e);
                }
            }
            sum
        };
        let mut largest = 0.0_f64;
        if standing.along {
            for motion in self.along.iter().take(standing.motions) {
                largest = largest.max(sum_of(motion, 0));
            }
        }
        let mut bound = largest + sum_of(&self.common, ALONG);
        let sensed = self.sensed.iter().zip(deviations.uncertainty.sensed(v_x));
        for ((e, error), acts) in sensed.zip(standing.acting(ALONG + COMMON)) {
            if *acts {
                bound += size(evaluation, seen(observer, *e, error));
            }
        }
        [self.uncertainty_rms.push(bound * bound, evaluation.window), fault]
    }

    /// Goes on to the next sample; `n` is N(h) and `l` L(h) at this one.
    pub(crate) fn advance(
        &mut self,
        standing: &Standing,
        deviations: &Deviations,
        observer: &Observer,
        n: &[[f64; 3]; 3],
        l: &[[f64; 2]; 3],
        place: &Place,
    ) {
        let Place { x, u, loading: Loading { a_x_m_per_s2, .. }, .. } = *place;
        let vehicle = &observer.model.vehicle;
        let t = observer.model.sampling_period_s;
        let jacobian = if standing.curves { vehicle.jacobian(x) } else { [[0.0; 3]; 3] };
        // M (I + T_s J / 2): what a slope that acts over the period leaves in the error.
        let held =
            if deviations.euler_correction { observer.held(&jacobian) } else { observer.gains.m };
        let respond = |e: StateVector, slope: StateVector| {
            sum(product(n, &e), product(&held, &slope.map(|x| t * x)))
        };
        self.fault = sum(product(n, &self.fault), product(&held, &deviations.smallest_fault));

        let [modelled, ..] = place.motions.map(|motion| motion.at(x.v_x_m_per_s));
        let modelled = vehicle.axle_forces(modelled, u.delta_rad);
        let transfer = if standing.transfers {
            vehicle.load_transfer(modelled, a_x_m_per_s2)
        } else {
            [0.0; 3]
        };
        if deviations.euler_correction {
            // x(t + T_s) = x + T_s x' + T_s^2/2 x'' + ...: Euler's step has all but the last.
            let forces = vehicle.axle_forces(x, u.delta_rad);
            let x_dot = vehicle.derivative_under(x, u.t_eng_n_m, forces);
            let remainder = product(&jacobian, &x_dot).map(|x| 0.5 * t * t * x);
            self.known = observer.respond(n, self.known, remainder);
            self.known = sum(self.known, product(&held, &transfer.map(|x| t * x)));
        } else if standing.transfers {
            self.known = respond(self.known, transfer);
        }
        if !standing.any {
            return;
        }
        let uncertainty = &deviations.uncertainty;
        if standing.along {
            let motions = self.along.iter_mut().zip(place.motions).take(standing.motions);
            for (responses, motion) in motions {
                let x = motion.at(x.v_x_m_per_s);
                let slopes = uncertainty.along(vehicle, place, x, modelled, standing.held_n);
                for ((e, slope), acts) in responses.iter_mut().zip(slopes).zip(standing.acting(0)) {
                    if *acts {
                        *e = respond(*e, slope);
                    }
                }
            }
        }
        let slopes = uncertainty.common(vehicle, place);
        for ((e, slope), acts) in self.common.iter_mut().zip(slopes).zip(standing.acting(ALONG)) {
            if *acts {
                *e = respond(*e, slope);
            }
        }
        let errors = uncertainty.sensed(x.v_x_m_per_s);
        let sensed = self.sensed.iter_mut().zip(errors).zip(standing.acting(ALONG + COMMON));
        for ((e, error), acts) in sensed {
            if *acts {
                // K = T_s d[A x + g]/dy: the premise is measured too. method 5.
                let by_premise: StateVector =
                    jacobian.map(|[by_v_x, _, by_r]| t * (by_v_x * error[0] + by_r * error[1]));
                let w = sum(product(l, &error), product(&observer.gains.m, &by_premise));
                *e = sum(product(n, e), w.map(|x| -x));
            }
        }
    }
}

/// `||W_r C e||`.
pub(crate) fn size(evaluation: &Evaluation, e: StateVector) -> f64 {
    libm::sqrt(evaluation.square(VehicleState::from(e).measured()))
}

/// The error as the residual shows it that a measurement's `error` makes: `e' + (I + E C)` times it.
fn seen(observer: &Observer, e: StateVector, [v_x, r]: [f64; 2]) -> StateVector {
    let [of_v_x, of_v_y, of_r] = product(&observer.gains.e, &[v_x, r]);
    sum(e, [of_v_x + v_x, of_v_y, of_r + r])
}
