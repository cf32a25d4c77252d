//! A design as bytes: the payload of the block that is baked into the library.

use steerguard_detector::{
    Actuator, Configuration, ConfigurationError, Deviations, Estimator, Evaluation, Gains, Gust,
    Interval, OperatingRange, RULES, Staleness, TsModel, Uncertainty, Vehicle, Zero,
};
use steerguard_fmu_core::Archive;
use steerguard_fmu_core::fields::{read_fields, write_fields};

/// First bytes of a design.
const MAGIC: [u8; 4] = *b"SGDD";
/// Version of the format: the order of [`BakedDesign::fields`].
const VERSION: u32 = 6;
/// Hexadecimal digits of a SHA-256.
const HASH_LENGTH: usize = 64;

/// Everything that the detector's library is told.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BakedDesign {
    /// SHA-256 of the design file, in hexadecimal digits.
    pub hash: [u8; HASH_LENGTH],
    /// Whether those figures are proven.
    pub certified: bool,
    /// Whether the design misses its smallest fault of interest straight ahead.
    pub blind: bool,
    /// Fault sensitivity that the design reports.
    pub beta: f64,
    /// Disturbance gain that the design reports.
    pub gamma: f64,
    /// Fault-to-disturbance gap that the design reports.
    pub gap: f64,
    /// What the detector runs on.
    pub configuration: Configuration,
}

/// Why a design cannot be baked, or why baked bytes are none.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DesignError {
    /// The bytes are not a design of this format and version.
    Format,
    /// The hash does not consist of hexadecimal digits.
    Hash,
    /// A figure that the design reports is not finite: its name.
    Figure(&'static str),
    /// The detector cannot run on these numbers.
    Configuration(ConfigurationError),
}

impl core::fmt::Display for DesignError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Format => f.write_str("these bytes are not a baked design of this version"),
            Self::Hash => f.write_str("the design's hash must be 64 hexadecimal digits"),
            Self::Figure(name) => write!(f, "the design's {name} is not finite"),
            Self::Configuration(error) => error.fmt(f),
        }
    }
}

impl core::error::Error for DesignError {}

impl BakedDesign {
    /// Length of an encoded design, bytes.
    pub const LENGTH: usize = 4 + 4 + HASH_LENGTH + 8 * NUMBERS + 4 + 6;

    /// The design as payload for [`steerguard_fmu_core::seal`].
    ///
    /// # Errors
    /// [`DesignError`] if the library would refuse it.
    pub fn encode(&self) -> Result<[u8; Self::LENGTH], DesignError> {
        self.check()?;
        let mut bytes = [0; Self::LENGTH];
        let mut copy = *self;
        if write_fields(&mut bytes, |archive| copy.fields(archive)) {
            Ok(bytes)
        } else {
            Err(DesignError::Format)
        }
    }

    /// The design in a payload.
    ///
    /// # Errors
    /// [`DesignError`].
    pub fn decode(bytes: &[u8]) -> Result<Self, DesignError> {
        let mut design = Self::EMPTY;
        if !read_fields(bytes, |archive| design.fields(archive)) {
            return Err(DesignError::Format);
        }
        design.check()?;
        Ok(design)
    }

    fn check(&self) -> Result<(), DesignError> {
        if !self.hash.iter().all(u8::is_ascii_hexdigit) {
            return Err(DesignError::Hash);
        }
        for (name, figure) in [("beta", self.beta), ("gamma", self.gamma), ("gap", self.gap)] {
            if !figure.is_finite() {
                return Err(DesignError::Figure(name));
            }
        }
        self.configuration.check().map_err(DesignError::Configuration)
    }

    /// Passes all fields through `archive`.
    fn fields(&mut self, archive: &mut Archive<'_>) {
        let mut magic = MAGIC;
        let mut version = VERSION;
        archive.bytes(&mut magic);
        archive.u32(&mut version);
        archive.require(magic == MAGIC && version == VERSION);
        archive.bytes(&mut self.hash);
        archive.flag(&mut self.certified);
        archive.flag(&mut self.blind);

        let Configuration {
            model,
            hysteresis,
            gains,
            evaluation,
            actuator,
            deviations,
            zero,
            staleness,
            estimator,
        } = &mut self.configuration;
        let TsModel { vehicle, sampling_period_s, range } = model;
        for number in [&mut self.beta, &mut self.gamma, &mut self.gap] {
            archive.real(number);
        }
        vehicle_fields(vehicle, archive);
        archive.real(sampling_period_s);
        for Interval { min, max } in [&mut range.v_x, &mut range.v_y, &mut range.r] {
            archive.real(min);
            archive.real(max);
        }
        let Gains { n, l, m, e } = gains;
        let numbers = hysteresis
            .iter_mut()
            .chain(n.as_flattened_mut().as_flattened_mut())
            .chain(l.as_flattened_mut().as_flattened_mut())
            .chain(m.as_flattened_mut())
            .chain(e.as_flattened_mut());
        for number in numbers {
            archive.real(number);
        }
        evaluation_fields(evaluation, archive);
        actuator_fields(actuator, archive);
        deviation_fields(deviations, archive);
        let Zero { steering_offset_rad, yaw_rate_bias_rad_per_s } = zero;
        let Staleness { after_s, v_x_jump_m_per_s, r_jump_rad_per_s } = staleness;
        for number in [
            steering_offset_rad,
            yaw_rate_bias_rad_per_s,
            after_s,
            v_x_jump_m_per_s,
            r_jump_rad_per_s,
        ] {
            archive.real(number);
        }
        // One of no threshold is none.
        let mut told = estimator.unwrap_or(NO_ESTIMATOR);
        let Estimator { threshold, estimate_factor, noise } = &mut told;
        for number in noise.iter_mut().chain([threshold, estimate_factor]) {
            archive.real(number);
        }
        *estimator = (told != NO_ESTIMATOR).then_some(told);
    }

    /// What decoding fills in; no detector runs on it.
    const EMPTY: Self = Self {
        hash: [0; HASH_LENGTH],
        certified: false,
        blind: false,
        beta: 0.0,
        gamma: 0.0,
        gap: 0.0,
        configuration: Configuration {
            model: TsModel {
                vehicle: Vehicle {
                    mass_kg: 0.0,
                    yaw_inertia_kg_m2: 0.0,
                    effective_longitudinal_inertia_kg_m: 0.0,
                    front_axle_distance_m: 0.0,
                    rear_axle_distance_m: 0.0,
                    front_cornering_stiffness_n_per_rad: 0.0,
                    rear_cornering_stiffness_n_per_rad: 0.0,
                    longitudinal_drag_n_m_s2_per_m2: 0.0,
                    lateral_drag_n_s2_per_m2: 0.0,
                    centre_of_gravity_height_m: 0.0,
                },
                sampling_period_s: 0.0,
                range: OperatingRange {
                    v_x: Interval::new(0.0, 0.0),
                    v_y: Interval::new(0.0, 0.0),
                    r: Interval::new(0.0, 0.0),
                },
            },
            hysteresis: [0.0; 3],
            gains: Gains {
                n: [[[0.0; 3]; 3]; RULES],
                l: [[[0.0; 2]; 3]; RULES],
                m: [[0.0; 3]; 3],
                e: [[0.0; 2]; 3],
            },
            evaluation: Evaluation {
                window: 0,
                weights: [0.0; 2],
                threshold: 0.0,
                uncertainty_share: 0.0,
                start_up_amplitude: 0.0,
                start_up_decay: 0.0,
                debounce_samples: 0,
                alarm_hold_s: 0.0,
            },
            deviations: Deviations::NONE,
            actuator: Actuator::NONE,
            zero: Zero { steering_offset_rad: 0.0, yaw_rate_bias_rad_per_s: 0.0 },
            staleness: Staleness::NEVER,
            estimator: None,
        },
    };
}

/// What stands for no second test.
const NO_ESTIMATOR: Estimator = Estimator { threshold: 0.0, estimate_factor: 0.0, noise: [0.0; 2] };

/// Fields of 8 bytes: figures, vehicle, sampling period, range, hysteresis, gains, evaluation,
/// actuator, deviations, zeros of the sensors, staleness, second test.
const NUMBERS: usize = 3 + 10 + 1 + 6 + 3 + RULES * (9 + 6) + 9 + 6 + 8 + 4 + 19 + 2 + 3 + 4;

fn vehicle_fields(vehicle: &mut Vehicle, archive: &mut Archive<'_>) {
    let Vehicle {
        mass_kg,
        yaw_inertia_kg_m2,
        effective_longitudinal_inertia_kg_m,
        front_axle_distance_m,
        rear_axle_distance_m,
        front_cornering_stiffness_n_per_rad,
        rear_cornering_stiffness_n_per_rad,
        longitudinal_drag_n_m_s2_per_m2,
        lateral_drag_n_s2_per_m2,
        centre_of_gravity_height_m,
    } = vehicle;
    for number in [
        mass_kg,
        yaw_inertia_kg_m2,
        effective_longitudinal_inertia_kg_m,
        front_axle_distance_m,
        rear_axle_distance_m,
        front_cornering_stiffness_n_per_rad,
        rear_cornering_stiffness_n_per_rad,
        longitudinal_drag_n_m_s2_per_m2,
        lateral_drag_n_s2_per_m2,
        centre_of_gravity_height_m,
    ] {
        archive.real(number);
    }
}

fn evaluation_fields(evaluation: &mut Evaluation, archive: &mut Archive<'_>) {
    let Evaluation {
        window,
        weights: [w_v_x, w_r],
        threshold,
        uncertainty_share,
        start_up_amplitude,
        start_up_decay,
        debounce_samples,
        alarm_hold_s,
    } = evaluation;
    archive.size(window);
    for number in
        [w_v_x, w_r, threshold, uncertainty_share, start_up_amplitude, start_up_decay, alarm_hold_s]
    {
        archive.real(number);
    }
    archive.u32(debounce_samples);
}

fn actuator_fields(actuator: &mut Actuator, archive: &mut Archive<'_>) {
    let Actuator { lag_s, delay_s, rate_limit_rad_per_s, angle_limit_rad } = actuator;
    archive.real(lag_s);
    archive.real(delay_s);
    archive.optional(rate_limit_rad_per_s, Archive::real);
    archive.optional(angle_limit_rad, Archive::real);
}

fn deviation_fields(deviations: &mut Deviations, archive: &mut Archive<'_>) {
    let Deviations { euler_correction, uncertainty, smallest_fault } = deviations;
    archive.flag(euler_correction);
    let Uncertainty {
        mass,
        yaw_inertia,
        front_cornering_stiffness,
        rear_cornering_stiffness,
        bank_m_per_s2,
        gust: Gust { speed_m_per_s, coefficient_n_s2_per_m2, acting_ahead_m },
        actuator_lag_s,
        actuator_delay_s,
        friction,
        load_transfer,
        steering_ratio,
        steering_offset_rad,
        yaw_rate_bias_rad_per_s,
        v_x_scale,
    } = uncertainty;
    archive.optional(friction, Archive::real);
    for number in [
        mass,
        yaw_inertia,
        front_cornering_stiffness,
        rear_cornering_stiffness,
        bank_m_per_s2,
        speed_m_per_s,
        coefficient_n_s2_per_m2,
        acting_ahead_m,
        actuator_lag_s,
        actuator_delay_s,
        load_transfer,
        steering_ratio,
        steering_offset_rad,
        yaw_rate_bias_rad_per_s,
        v_x_scale,
    ]
    .into_iter()
    .chain(smallest_fault)
    {
        archive.real(number);
    }
}
