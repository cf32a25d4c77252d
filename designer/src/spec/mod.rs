//! The specification: vehicle, ranges, faults of interest, disturbances, method and evaluation.
//!
//! Read from TOML. Every key has a default; unknown keys and impossible values are refused by name.
//! `examples/paper.toml` spells out every key, with the paper's values.
//!
//! # Conventions
//! Units stand in the keys. Bands are in Hz, from 0 (low), up to the Nyquist frequency (high), or
//! both (all frequencies).

use serde::{Deserialize, Serialize};
use steerguard_detector::{MAX_DELAY_SAMPLES, Vehicle, critical_speed};
use steerguard_world::steady_angle;

use crate::document::{self, Mistake, Mistakes};

mod actuator;
mod band;
mod calibration;
mod design;
mod disturbance;
mod estimator;
mod evaluation;
mod fault;
mod noise;
mod operating_range;
mod sampling;
mod sensors;
mod uncertainty;
mod vehicle;

pub use actuator::ActuatorTable;
pub(crate) use band::check_band;
pub use calibration::{Calibration, Manoeuvre};
pub use design::{Method, MethodName, MultiplierV, VName};
pub use disturbance::Disturbance;
pub use estimator::EstimatorTable;
pub use evaluation::{Covers, Evaluation, ThresholdKind};
pub use fault::Fault;
pub use noise::{Noise, SpeedNoise, YawRateNoise};
pub use operating_range::OperatingRangeTable;
pub use sampling::Sampling;
pub use sensors::SensorsTable;
pub(crate) use uncertainty::AIR_KG_PER_M3;
pub use uncertainty::UncertaintyTable;

/// A specification.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Spec {
    /// Vehicle data, Table 1 of the paper.
    #[serde(with = "vehicle::VehicleTable")]
    pub vehicle: Vehicle,
    /// Design range S_x and arming.
    pub operating_range: OperatingRangeTable,
    /// Sampling.
    pub sampling: Sampling,
    /// What the sensors show of what there is.
    pub sensors: SensorsTable,
    /// The steering actuator, where `u.delta` is its command.
    pub actuator: ActuatorTable,
    /// Faults of interest: the gains are made for the first, the others are reported.
    pub fault: Vec<Fault>,
    /// Disturbances.
    pub disturbance: Vec<Disturbance>,
    /// Sensor noise; the default is that of a wheel-speed and a yaw-rate sensor of a production car.
    pub noise: Noise,
    /// What is not known of vehicle, road and air.
    pub uncertainty: UncertaintyTable,
    /// How the gains are found.
    pub design: Method,
    /// How the residual is evaluated.
    pub evaluation: Evaluation,
    /// The second test.
    pub estimator: EstimatorTable,
}

impl Default for Spec {
    /// The paper's vehicle and disturbance, sensors with noise, and method "gap".
    fn default() -> Self {
        Self {
            vehicle: vehicle::default_vehicle(),
            operating_range: OperatingRangeTable::default(),
            sampling: Sampling::default(),
            sensors: SensorsTable::default(),
            actuator: ActuatorTable::default(),
            fault: vec![Fault::default()],
            disturbance: vec![Disturbance::default()],
            noise: Noise::default(),
            uncertainty: UncertaintyTable::default(),
            design: Method::default(),
            evaluation: Evaluation::default(),
            estimator: EstimatorTable::default(),
        }
    }
}

impl Spec {
    /// The paper's own case: its range, Theorem 4 with its multipliers, no sensor noise, W_r = I, Euler's
    /// steps as they are, everything known.
    pub fn paper() -> Self {
        Self {
            vehicle: Vehicle::PAPER,
            operating_range: OperatingRangeTable::PAPER,
            noise: Noise {
                v_x: SpeedNoise { white_std_m_per_s: 0.0, ..SpeedNoise::default() },
                r: YawRateNoise { white_std_rad_per_s: 0.0, ..YawRateNoise::default() },
            },
            sampling: Sampling { euler_correction: false, ..Sampling::default() },
            uncertainty: UncertaintyTable::NONE,
            design: Method { method: MethodName::Paper, decay: Some(0.97), ..Method::default() },
            evaluation: Evaluation {
                window_s: Some(0.4),
                weights: [1.0, 1.0],
                threshold: ThresholdKind::Calibrated,
                margin: 1.25,
                calibration: Calibration {
                    initial_v_y_m_per_s: Some(vec![-1.0, 0.0, 1.0]),
                    ..Calibration::default()
                },
                ..Evaluation::default()
            },
            ..Self::default()
        }
    }

    /// Reads and checks a specification in TOML.
    ///
    /// # Errors
    /// [`Mistakes`], each of which names the key, its value and what is allowed.
    pub fn from_toml(text: &str) -> Result<Self, Mistakes> {
        document::read(text, Self::find_mistakes)
    }

    /// Checks every value.
    ///
    /// # Errors
    /// [`Mistakes`]: every value that is not possible.
    pub fn check(&self) -> Result<(), Mistakes> {
        let mut mistakes = Mistakes::default();
        self.find_mistakes(&mut mistakes);
        mistakes.into_result()
    }

    /// Finds what is not possible by itself, then what is not in view of another table, unless that
    /// has a mistake of its own.
    fn find_mistakes(&self, mistakes: &mut Mistakes) {
        vehicle::check(&self.vehicle, mistakes);
        self.operating_range.check(mistakes);
        self.sampling.check(mistakes);
        self.check_euler_step(mistakes);
        self.sensors.check(mistakes);
        let period_known = mistakes.sound("sampling.period_s");

        let largest_delay_s = period_known.then(|| self.largest_delay_s());
        let of_actuator = largest_delay_s.unwrap_or(ActuatorTable::LARGEST_DELAY_S);
        self.actuator.check(of_actuator, mistakes);
        let actuator_known = mistakes.sound("actuator.delay_s");
        let further_s = largest_delay_s.map(|largest_s| largest_s - self.actuator.delay_s);
        self.uncertainty.check(further_s.filter(|_| actuator_known), mistakes);
        self.check_critical_speed(mistakes);

        let nyquist_hz = period_known.then(|| self.sampling.nyquist_hz());
        count("fault", self.fault.len(), mistakes);
        for (index, fault) in self.fault.iter().enumerate() {
            fault.check(&format!("fault[{index}]"), nyquist_hz, mistakes);
        }
        count("disturbance", self.disturbance.len(), mistakes);
        for (index, disturbance) in self.disturbance.iter().enumerate() {
            disturbance.check(&format!("disturbance[{index}]"), nyquist_hz, mistakes);
        }
        self.noise.check(nyquist_hz, mistakes);

        self.design.check(mistakes);
        self.evaluation.check(mistakes);
        if period_known {
            self.evaluation.check_window_of(self.sampling.period_s, mistakes);
        }
        if self.evaluation.threshold == ThresholdKind::Guaranteed {
            self.noise.check_bounded(mistakes);
        }
        let (disturbances, v_y) = (self.disturbance.len(), self.operating_range.v_y_m_per_s);
        self.evaluation.calibration.check_drives(disturbances, v_y, mistakes);
        self.check_end_stops(mistakes);
    }

    /// The end stops must let the calibration's manoeuvres be driven, widest at the lowest armed speed.
    fn check_end_stops(&self, mistakes: &mut Mistakes) {
        let Some(limit_deg) = self.actuator.angle_limit_deg else { return };
        let (limit, accelerations) =
            ("actuator.angle_limit_deg", "evaluation.calibration.lateral_acceleration_m_per_s2");
        let range = "operating_range";
        if !["vehicle", limit, accelerations, range].into_iter().all(|key| mistakes.sound(key)) {
            return;
        }
        let table = &self.operating_range;
        let lowest_speed = table.v_x_m_per_s[0] + table.v_x_hysteresis_m_per_s;
        let largest = self.evaluation.calibration.courses().fold(0.0_f64, |a, (_, b)| a.max(b));
        let needed_deg = steady_angle(&self.vehicle, lowest_speed, largest).to_degrees();
        mistakes.unless(limit_deg >= needed_deg, || {
            // Rounded up.
            let allowed = format!("{:.1} or more", (needed_deg * 10.0).ceil() / 10.0);
            Mistake::value(limit, limit_deg, allowed)
                .help(format!(
                    "a steady turn of {largest} m/s^2 at {lowest_speed} m/s needs that angle: lower the \
                     calibration's lateral accelerations, or raise the lowest speed"
                ))
                .because_of(accelerations)
        });
    }

    /// The Euler step must follow the lateral and yaw dynamics, fastest at the lowest speed.
    fn check_euler_step(&self, mistakes: &mut Mistakes) {
        let (speed, period) = ("operating_range.v_x_m_per_s", "sampling.period_s");
        if !["vehicle", speed, period].into_iter().all(|key| mistakes.sound(key)) {
            return;
        }
        let v = &self.vehicle;
        let (c_f, c_r) =
            (v.front_cornering_stiffness_n_per_rad, v.rear_cornering_stiffness_n_per_rad);
        let (l_f, l_r) = (v.front_axle_distance_m, v.rear_axle_distance_m);
        let lateral = 2.0 * (c_f + c_r) / v.mass_kg;
        let yaw = 2.0 * (c_f * l_f * l_f + c_r * l_r * l_r) / v.yaw_inertia_kg_m2;
        let rate = lateral.max(yaw);
        let lowest_speed = self.sampling.period_s * rate;
        let [min, _] = self.operating_range.v_x_m_per_s;
        mistakes.unless(min > lowest_speed, || {
            let allowed = format!("min above {lowest_speed:.3} m/s");
            Mistake::value(speed, self.operating_range.v_x_m_per_s, allowed)
                .help(format!(
                    "below it the lateral dynamics outrun sampling.period_s = {}: raise min, or set \
                     the period below {:.4} s",
                    self.sampling.period_s,
                    // Rounded down.
                    (min / rate * 1e4).floor() * 1e-4
                ))
                .because_of(period)
        });
    }

    /// The lowest critical speed of a vehicle within the uncertainties, m/s; none where none of them
    /// oversteers. Mass and front stiffness lower it, rear stiffness raises it, yaw inertia does neither.
    pub fn lowest_critical_speed(&self) -> Option<f64> {
        let [mass, front, rear] = self.most_oversteering_percent().map(|x| 1.0 + x / 100.0);
        critical_speed(&self.vehicle, [front, rear], 1.0 / mass)
    }

    /// Mass, front and rear stiffness of the vehicle that has it, percent off those specified.
    fn most_oversteering_percent(&self) -> [f64; 3] {
        let u = &self.uncertainty;
        let [_, mass] = u.mass_percent;
        let ([_, front], [rear, _]) =
            (u.front_cornering_stiffness_percent, u.rear_cornering_stiffness_percent);
        [mass, front, rear]
    }

    /// No vehicle within the uncertainties may be driven beyond its critical speed, where it is unstable:
    /// the model's motion then says nothing of where it is.
    fn check_critical_speed(&self, mistakes: &mut Mistakes) {
        let (speed, uncertainty) = ("operating_range.v_x_m_per_s", "uncertainty");
        if !["vehicle", speed, uncertainty].into_iter().all(|key| mistakes.sound(key)) {
            return;
        }
        let Some(critical) = self.lowest_critical_speed() else { return };
        // Rounded down.
        let named = (critical * 10.0).floor() / 10.0;
        let range = self.operating_range.v_x_m_per_s;
        mistakes.unless(range[1] < critical, || {
            let [mass, front, rear] = self.most_oversteering_percent();
            let vehicle = if [mass, front, rear] == [0.0; 3] {
                "the vehicle".to_owned()
            } else {
                format!(
                    "with mass {mass:+} %, front_cornering_stiffness {front:+} % and \
                     rear_cornering_stiffness {rear:+} %, which `uncertainty` allows, the vehicle"
                )
            };
            Mistake::value(speed, range, format!("max up to {named:.1} m/s, a critical speed"))
                .help(format!(
                    "{vehicle} oversteers, and from its critical speed of {named:.1} m/s on it is \
                     unstable: lower max, or state the vehicle with less uncertainty"
                ))
                .because_of("vehicle")
                .because_of(uncertainty)
        });
    }

    /// Longest dead time of the actuator, s.
    fn largest_delay_s(&self) -> f64 {
        let memory_s = MAX_DELAY_SAMPLES as f64 * self.sampling.period_s;
        memory_s.min(ActuatorTable::LARGEST_DELAY_S)
    }
}

/// Finds too few and too many tables of an array.
fn count(key: &str, count: usize, mistakes: &mut Mistakes) {
    let possible = (1..=8).contains(&count);
    mistakes.unless(possible, || Mistake::value(key, count, "from 1 to 8 of them"));
}
