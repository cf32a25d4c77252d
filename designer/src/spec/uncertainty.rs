//! `[uncertainty]`: what is not known of vehicle, road, air and sensors.
//!
//! # Conventions
//! Parameters lie within [min, max], percent off the value in `[vehicle]`.

use serde::{Deserialize, Serialize};
use steerguard_detector::{Gust, Uncertainty, Vehicle};
use steerguard_world::bank_m_per_s2;

use super::ActuatorTable;
use crate::document::{Allowed, Mistake, Mistakes};

/// Density of air, kg/m^3.
pub(crate) const AIR_KG_PER_M3: f64 = 1.2;

/// Friction from which on tyres are taken to have no end.
const LARGEST_FRICTION: f64 = 10.0;

/// `[uncertainty]`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct UncertaintyTable {
    /// Mass, and I_e with it; default [-10, 10].
    pub mass_percent: [f64; 2],
    /// Yaw inertia; default [-10, 10].
    pub yaw_inertia_percent: [f64; 2],
    /// Cornering stiffness of a front tyre, friction included; default [-10, 10].
    pub front_cornering_stiffness_percent: [f64; 2],
    /// Cornering stiffness of a rear tyre, friction included; default [-10, 10].
    pub rear_cornering_stiffness_percent: [f64; 2],
    /// Largest lag of the steering actuator beyond `actuator.lag_s`; default 0.
    pub actuator_lag_s: f64,
    /// Longest dead time of the steering actuator beyond `actuator.delay_s`; default 0.
    pub actuator_delay_s: f64,
    /// Steering ratio: hand wheel over road wheel, or command over road wheel; default [0, 0].
    pub steering_ratio_percent: [f64; 2],
    /// Largest offset of the road wheel from where it is commanded to be, to either side, beyond
    /// `sensors.steering_offset_deg`; default 0.
    pub steering_offset_deg: f64,
    /// Largest bias of the yaw-rate sensor, of either sign, beyond `sensors.yaw_rate_bias_deg_per_s`;
    /// default 0.
    pub yaw_rate_bias_deg_per_s: f64,
    /// Largest error of the measured speed, of either sign; default 0.
    pub v_x_scale_percent: f64,
    /// Smallest and largest friction between tyre and road, which limits the axle force; default [1, 1].
    pub friction: [f64; 2],
    /// Largest error of the known transfer of axle load, of either sign; default 10.
    pub load_transfer_percent: f64,
    /// Steepest bank of the road, to either side; default 3.
    pub bank_deg: f64,
    /// Fastest gust across the road, from either side; default 10.
    pub gust_m_per_s: f64,
    /// Where gusts act ahead of the centre of gravity; default 0.25.
    pub gust_acting_ahead_m: f64,
    /// Frontal area of the vehicle; default 2.2.
    pub frontal_area_m2: f64,
    /// Side-force derivative of the vehicle on its frontal area, per rad; default 2.
    pub side_force_per_rad: f64,
}

impl Default for UncertaintyTable {
    fn default() -> Self {
        Self::DEFAULT
    }
}

impl UncertaintyTable {
    /// A passenger car between empty and loaded, on any tyres, on public roads.
    pub const DEFAULT: Self = Self {
        mass_percent: [-10.0, 10.0],
        yaw_inertia_percent: [-10.0, 10.0],
        front_cornering_stiffness_percent: [-10.0, 10.0],
        rear_cornering_stiffness_percent: [-10.0, 10.0],
        actuator_lag_s: 0.0,
        actuator_delay_s: 0.0,
        steering_ratio_percent: [0.0, 0.0],
        steering_offset_deg: 0.0,
        yaw_rate_bias_deg_per_s: 0.0,
        v_x_scale_percent: 0.0,
        friction: [1.0, 1.0],
        load_transfer_percent: 10.0,
        bank_deg: 3.0,
        gust_m_per_s: 10.0,
        gust_acting_ahead_m: 0.25,
        frontal_area_m2: 2.2,
        side_force_per_rad: 2.0,
    };

    /// Everything is known: no bank, no gust. Tyres end all the same.
    pub const NONE: Self = Self {
        load_transfer_percent: 0.0,
        mass_percent: [0.0, 0.0],
        yaw_inertia_percent: [0.0, 0.0],
        front_cornering_stiffness_percent: [0.0, 0.0],
        rear_cornering_stiffness_percent: [0.0, 0.0],
        bank_deg: 0.0,
        gust_m_per_s: 0.0,
        ..Self::DEFAULT
    };

    /// The parameters' intervals: mass, yaw inertia, front and rear stiffness.
    pub fn intervals_percent(&self) -> [[f64; 2]; 4] {
        [
            self.mass_percent,
            self.yaw_inertia_percent,
            self.front_cornering_stiffness_percent,
            self.rear_cornering_stiffness_percent,
        ]
    }

    /// The vehicle with its parameters times `factors`: mass (and I_e with it), yaw inertia, front and rear
    /// stiffness.
    pub(crate) fn vehicle(nominal: &Vehicle, factors: [f64; 4]) -> Vehicle {
        let [mass, yaw_inertia, front, rear] = factors;
        Vehicle {
            mass_kg: mass * nominal.mass_kg,
            effective_longitudinal_inertia_kg_m: mass * nominal.effective_longitudinal_inertia_kg_m,
            yaw_inertia_kg_m2: yaw_inertia * nominal.yaw_inertia_kg_m2,
            front_cornering_stiffness_n_per_rad: front
                * nominal.front_cornering_stiffness_n_per_rad,
            rear_cornering_stiffness_n_per_rad: rear * nominal.rear_cornering_stiffness_n_per_rad,
            ..*nominal
        }
    }

    /// The vehicles at the corners of the parameters' intervals.
    pub(crate) fn corners(&self, nominal: &Vehicle) -> impl Iterator<Item = Vehicle> {
        let intervals = self.intervals_percent();
        let parameters = intervals.len();
        (0..1_usize << parameters).map(move |corner| {
            let end = |parameter: usize| intervals[parameter][corner >> parameter & 1];
            Self::vehicle(nominal, std::array::from_fn(|parameter| 1.0 + end(parameter) / 100.0))
        })
    }

    /// Whether vehicles may have tyres that saturate: friction that no vehicle reaches is none.
    pub fn tyres_end(&self) -> bool {
        self.friction[0] < LARGEST_FRICTION
    }

    /// Fastest gust and its force.
    pub fn gust(&self) -> Gust {
        Gust {
            speed_m_per_s: self.gust_m_per_s,
            coefficient_n_s2_per_m2: 0.5
                * AIR_KG_PER_M3
                * self.frontal_area_m2
                * self.side_force_per_rad,
            acting_ahead_m: self.gust_acting_ahead_m,
        }
    }

    /// The bounds that the detector is told.
    pub fn bounds(&self) -> Uncertainty {
        let largest = |ends: [f64; 2], deviation: fn(f64) -> f64| {
            ends.into_iter().fold(0.0_f64, |most, end| most.max(deviation(1.0 + end / 100.0).abs()))
        };
        let of_inertia = |ends| largest(ends, |ratio| 1.0 / ratio - 1.0);
        let of_stiffness = |ends| largest(ends, |ratio| ratio - 1.0);
        Uncertainty {
            mass: of_inertia(self.mass_percent),
            yaw_inertia: of_inertia(self.yaw_inertia_percent),
            front_cornering_stiffness: of_stiffness(self.front_cornering_stiffness_percent),
            rear_cornering_stiffness: of_stiffness(self.rear_cornering_stiffness_percent),
            bank_m_per_s2: bank_m_per_s2(self.bank_deg.to_radians()).abs(),
            gust: self.gust(),
            actuator_lag_s: self.actuator_lag_s,
            actuator_delay_s: self.actuator_delay_s,
            steering_ratio: of_inertia(self.steering_ratio_percent),
            steering_offset_rad: self.steering_offset_deg.to_radians(),
            yaw_rate_bias_rad_per_s: self.yaw_rate_bias_deg_per_s.to_radians(),
            v_x_scale: self.v_x_scale_percent / 100.0,
            friction: self.tyres_end().then_some(self.friction[0]),
            load_transfer: self.load_transfer_percent / 100.0,
        }
    }

    /// Finds what is not possible, for a further dead time of at most `largest_delay_s` where that is
    /// known.
    pub(super) fn check(&self, largest_delay_s: Option<f64>, mistakes: &mut Mistakes) {
        let lag_s = Allowed::between(0.0, ActuatorTable::LARGEST_LAG_S);
        mistakes.number("uncertainty.actuator_lag_s", self.actuator_lag_s, lag_s);
        let delay_s = largest_delay_s
            .map_or(Allowed::NOT_NEGATIVE, |largest_s| Allowed::between(0.0, largest_s));
        mistakes.unless(delay_s.holds(self.actuator_delay_s), || {
            Mistake::value("uncertainty.actuator_delay_s", self.actuator_delay_s, delay_s)
                .because_of("actuator.delay_s")
        });
        let parameters =
            ["mass", "yaw_inertia", "front_cornering_stiffness", "rear_cornering_stiffness"];
        for (parameter, interval) in parameters.into_iter().zip(self.intervals_percent()) {
            let [min, max] = interval;
            let around_zero = (-90.0..=0.0).contains(&min) && (0.0..=900.0).contains(&max);
            mistakes.unless(around_zero, || {
                let key = format!("uncertainty.{parameter}_percent");
                Mistake::value(key, interval, "-90 <= min <= 0 <= max <= 900")
                    .help("[min, max] is in percent off the specified value")
            });
        }
        let [low, high] = self.steering_ratio_percent;
        let around_zero = (-50.0..=0.0).contains(&low) && (0.0..=100.0).contains(&high);
        mistakes.unless(around_zero, || {
            let allowed = "-50 <= min <= 0 <= max <= 100";
            Mistake::value("uncertainty.steering_ratio_percent", [low, high], allowed)
                .help("[min, max] is in percent off the specified ratio")
        });
        let [low, high] = self.friction;
        mistakes.unless(0.05 <= low && low <= high && high <= LARGEST_FRICTION, || {
            let allowed = format!("0.05 <= min <= max <= {LARGEST_FRICTION}");
            Mistake::value("uncertainty.friction", [low, high], allowed).help(
                "the smallest and the largest friction between tyre and road: dry asphalt 1, wet 0.7, \
                 snow 0.3",
            )
        });
        for (key, value, largest) in [
            ("steering_offset_deg", self.steering_offset_deg, 10.0),
            ("yaw_rate_bias_deg_per_s", self.yaw_rate_bias_deg_per_s, 10.0),
            ("v_x_scale_percent", self.v_x_scale_percent, 50.0),
            ("load_transfer_percent", self.load_transfer_percent, 100.0),
        ] {
            let allowed = Allowed::between(0.0, largest);
            mistakes.number(&format!("uncertainty.{key}"), value, allowed);
        }
        mistakes.number("uncertainty.bank_deg", self.bank_deg, Allowed::between(0.0, 45.0));
        for (key, value) in [
            ("gust_m_per_s", self.gust_m_per_s),
            ("frontal_area_m2", self.frontal_area_m2),
            ("side_force_per_rad", self.side_force_per_rad),
        ] {
            mistakes.number(&format!("uncertainty.{key}"), value, Allowed::NOT_NEGATIVE);
        }
        let acting_ahead_m = self.gust_acting_ahead_m;
        mistakes.number("uncertainty.gust_acting_ahead_m", acting_ahead_m, Allowed::FINITE);
    }
}
