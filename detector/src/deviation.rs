//! Where the vehicle departs from the model (7), and what that does to the residual.
//!
//! # Conventions
//! - A deviation `w` is what one sampling period adds to the state beside (7). The error answers with
//!   `e+ = N(h) e + M w` (13), to first order in e: a response is that e, 3 x 1.
//! - Three kinds: Euler's remainder, known and taken out of the residual; uncertainties, known by
//!   their bounds, which raise the threshold; the smallest fault of interest, which says what the
//!   threshold still lets through. method 6.

#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

use crate::algebra::{product, sum};
use crate::{Actuator, Evaluation, Input, Observer, Rms, StateVector, Vehicle, VehicleState};

/// Number of uncertainties.
pub const UNCERTAINTIES: usize = 7;

/// What is not known of vehicle, road and air: bounds, not negative, 0 for what is known.
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
    /// Lateral component of gravity on the steepest bank, m/s^2.
    pub bank_m_per_s2: f64,
    /// Fastest gust across the road.
    pub gust: Gust,
    /// Largest lag of the actuator beyond the one modelled, s.
    pub actuator_lag_s: f64,
    /// Longest dead time of the actuator beyond the one modelled, s.
    pub actuator_delay_s: f64,
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
    /// Side force in N at speed `v_x` in m/s.
    pub fn side_force(&self, v_x: f64) -> f64 {
        let w = self.speed_m_per_s;
        self.coefficient_n_s2_per_m2 * w * libm::sqrt(v_x * v_x + w * w)
    }
}

/// Where the vehicle is at a sample, as far as measured, estimated and commanded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// State.
    pub x: VehicleState,
    /// Input, the angle that of the actuator.
    pub u: Input,
    /// The angle of the slowest actuator less that angle, rad.
    pub slowest_behind_rad: f64,
}

impl Uncertainty {
    /// Everything is known.
    pub const NONE: Self = Self {
        mass: 0.0,
        yaw_inertia: 0.0,
        front_cornering_stiffness: 0.0,
        rear_cornering_stiffness: 0.0,
        bank_m_per_s2: 0.0,
        gust: Gust { speed_m_per_s: 0.0, coefficient_n_s2_per_m2: 0.0, acting_ahead_m: 0.0 },
        actuator_lag_s: 0.0,
        actuator_delay_s: 0.0,
    };

    /// The slowest that an `actuator` may be.
    pub fn slowest(&self, actuator: &Actuator) -> Actuator {
        Actuator {
            lag_s: actuator.lag_s + self.actuator_lag_s,
            delay_s: actuator.delay_s + self.actuator_delay_s,
            ..*actuator
        }
    }

    /// What each uncertainty at its bound adds to `x'` (1) of `vehicle`, in m/s^2, m/s^2, rad/s^2 and in
    /// the order of the fields.
    pub fn slopes(&self, vehicle: &Vehicle, place: &Place) -> [StateVector; UNCERTAINTIES] {
        let forces = vehicle.axle_forces(place.x, place.u.delta_rad);
        Kind::ALL.map(|kind| self.slope(kind, vehicle, place, forces))
    }

    /// That of one, under the axle forces `[F_yf, F_yr]` in N.
    fn slope(
        &self,
        kind: Kind,
        vehicle: &Vehicle,
        place: &Place,
        [front, rear]: [f64; 2],
    ) -> StateVector {
        let Place { x, u, slowest_behind_rad } = *place;
        let [v_x, v_y, _] = x.vector();
        let (m, i_z) = (vehicle.mass_kg, vehicle.yaw_inertia_kg_m2);
        let (l_f, l_r) = (vehicle.front_axle_distance_m, vehicle.rear_axle_distance_m);
        let (c_f, c_r) = (self.front_cornering_stiffness, self.rear_cornering_stiffness);
        match kind {
            Kind::Mass => {
                let drag = vehicle.lateral_drag_n_s2_per_m2 * v_y * v_y;
                let longitudinal = (u.t_eng_n_m - vehicle.cruise_torque(v_x))
                    / vehicle.effective_longitudinal_inertia_kg_m;
                [self.mass * longitudinal, self.mass * (front + rear - drag) / m, 0.0]
            }
            Kind::YawInertia => [0.0, 0.0, self.yaw_inertia * (l_f * front - l_r * rear) / i_z],
            Kind::FrontStiffness => [0.0, c_f * front / m, c_f * l_f * front / i_z],
            Kind::RearStiffness => [0.0, c_r * rear / m, -c_r * l_r * rear / i_z],
            Kind::Bank => [0.0, self.bank_m_per_s2, 0.0],
            Kind::Gust => {
                let gust = self.gust.side_force(v_x);
                [0.0, gust / m, self.gust.acting_ahead_m * gust / i_z]
            }
            Kind::Actuator => {
                let behind = 2.0 * vehicle.front_cornering_stiffness_n_per_rad * slowest_behind_rad;
                [0.0, behind / m, l_f * behind / i_z]
            }
        }
    }

    /// Whether one is more than nothing.
    fn acts(&self, kind: Kind) -> bool {
        match kind {
            Kind::Mass => self.mass > 0.0,
            Kind::YawInertia => self.yaw_inertia > 0.0,
            Kind::FrontStiffness => self.front_cornering_stiffness > 0.0,
            Kind::RearStiffness => self.rear_cornering_stiffness > 0.0,
            Kind::Bank => self.bank_m_per_s2 > 0.0,
            Kind::Gust => self.gust.speed_m_per_s > 0.0 && self.gust.coefficient_n_s2_per_m2 > 0.0,
            Kind::Actuator => self.actuator_lag_s > 0.0 || self.actuator_delay_s > 0.0,
        }
    }
}

/// The uncertainties by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Mass,
    YawInertia,
    FrontStiffness,
    RearStiffness,
    Bank,
    Gust,
    Actuator,
}

impl Kind {
    /// In the order in which they are told.
    const ALL: [Self; UNCERTAINTIES] = [
        Self::Mass,
        Self::YawInertia,
        Self::FrontStiffness,
        Self::RearStiffness,
        Self::Bank,
        Self::Gust,
        Self::Actuator,
    ];
}

/// What the detector is told of deviations.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize), serde(deny_unknown_fields))]
pub struct Deviations {
    /// Whether the response to Euler's remainder is taken out of the residual.
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
    /// The uncertainties that act and raise the threshold: the others cost nothing.
    acting: [bool; UNCERTAINTIES],
    /// Whether there is one.
    any: bool,
    /// `M w` of the smallest fault.
    m_fault: StateVector,
}

impl Standing {
    pub(crate) fn new(
        deviations: &Deviations,
        observer: &Observer,
        evaluation: &Evaluation,
    ) -> Self {
        let raises = evaluation.uncertainty_share > 0.0;
        let acting = Kind::ALL.map(|kind| raises && deviations.uncertainty.acts(kind));
        Self {
            acting,
            any: acting.contains(&true),
            m_fault: product(&observer.gains.m, &deviations.smallest_fault),
        }
    }
}

/// Responses since the observer's start, e in m/s, m/s, rad/s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Responses {
    /// To Euler's remainder.
    pub remainder: StateVector,
    /// To each uncertainty at its bound.
    pub uncertainties: [StateVector; UNCERTAINTIES],
    /// To the smallest fault of interest.
    pub fault: StateVector,
    /// Window of the sum of `||W_r C e||` over the uncertainties.
    pub uncertainty_rms: Rms,
    /// Window of `||W_r C e||` of the fault.
    pub fault_rms: Rms,
}

impl Responses {
    /// At the observer's start.
    pub const NONE: Self = Self {
        remainder: [0.0; 3],
        uncertainties: [[0.0; 3]; UNCERTAINTIES],
        fault: [0.0; 3],
        uncertainty_rms: Rms::EMPTY,
        fault_rms: Rms::EMPTY,
    };

    /// What the uncertainties add to J at most, and the J that the smallest fault makes alone, at this
    /// sample.
    ///
    /// `||W_r C e|| <= sum_j ||W_r C e_j||` whatever the uncertainties' signs, and J is a norm.
    pub(crate) fn levels(&mut self, standing: &Standing, evaluation: &Evaluation) -> [f64; 2] {
        let seen = |e: &StateVector| evaluation.square(VehicleState::from(*e).measured());
        let fault = self.fault_rms.push(seen(&self.fault), evaluation.window);
        if !standing.any {
            return [0.0, fault];
        }
        let mut bound = 0.0;
        for (e, acts) in self.uncertainties.iter().zip(standing.acting) {
            if acts {
                bound += libm::sqrt(seen(e));
            }
        }
        [self.uncertainty_rms.push(bound * bound, evaluation.window), fault]
    }

    /// Goes on to the next sample; `n` is N(h) at this one.
    pub(crate) fn advance(
        &mut self,
        standing: &Standing,
        deviations: &Deviations,
        observer: &Observer,
        n: &[[f64; 3]; 3],
        place: &Place,
    ) {
        self.fault = sum(product(n, &self.fault), standing.m_fault);
        if !deviations.euler_correction && !standing.any {
            return;
        }
        let Place { x, u, .. } = *place;
        let vehicle = &observer.model.vehicle;
        let sampling_period_s = observer.model.sampling_period_s;
        let scaled = |by: f64, w: StateVector| w.map(|w| by * w);
        let forces = vehicle.axle_forces(x, u.delta_rad);
        if deviations.euler_correction {
            // x(t + T_s) = x + T_s x' + T_s^2/2 x'' + ...: Euler's step has all but the last.
            let half_square = 0.5 * sampling_period_s * sampling_period_s;
            let x_dot = vehicle.derivative_under(x, u.t_eng_n_m, forces);
            let w = scaled(half_square, vehicle.second_derivative_along(x, x_dot));
            self.remainder = observer.respond(n, self.remainder, w);
        }
        let responses = self.uncertainties.iter_mut().zip(Kind::ALL).zip(standing.acting);
        for ((response, kind), acts) in responses {
            if acts {
                let slope = deviations.uncertainty.slope(kind, vehicle, place, forces);
                *response = observer.respond(n, *response, scaled(sampling_period_s, slope));
            }
        }
    }
}
