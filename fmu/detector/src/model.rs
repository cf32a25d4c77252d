//! The detector behind the variables of its description.

use core::ffi::CStr;

use steerguard_detector::{
    ActuatorState, ConfigurationError, Detector, Initialisation, Input, Measurement, Monitor,
    Output, Responses, Rms, State, StateVector,
};
use steerguard_fmu_core::{Archive, Log, Model, Status};
use steerguard_model_description::detector::{
    DetectorVariable as V, INFO, Initialisation as Item, NO_ALARM_TIME,
};
use steerguard_model_description::{ModelInfo, Value};

use crate::{BakedDesign, state};

/// Value of `initialisation` for a start from the first measurement.
const FIRST_MEASUREMENT: i32 = Item::FirstMeasurement.value();
/// Value of `initialisation` for a start from `z_0`.
const GIVEN: i32 = Item::Given.value();

/// The detector as an FMU model.
#[derive(Clone)]
pub struct DetectorModel {
    design: BakedDesign,
    /// The design's hash, NUL-terminated.
    hash: [u8; 65],
    detector: Detector,
    measurement: Measurement,
    input: Input,
    initialisation: i32,
    z_0: StateVector,
    start_time_s: f64,
}

impl DetectorModel {
    fn output(&self) -> &Output {
        self.detector.output()
    }

    fn time_s(&self, sample: u64) -> f64 {
        self.start_time_s + sample as f64 * self.sample_period_s()
    }

    /// Hands the fixed parameters to the detector.
    fn apply_initialisation(&mut self) -> Result<(), ConfigurationError> {
        self.detector.set_initialisation(match self.initialisation {
            GIVEN => Initialisation::Given(self.z_0),
            _ => Initialisation::FirstMeasurement,
        })
    }

    /// Reports what the sample just run has changed.
    #[cold]
    fn report(&self, before: Monitor, alarm_before: bool, log: &Log<'_>) -> Status {
        let output = self.output();
        let time_s = self.time_s(self.detector.state().sample.saturating_sub(1));
        if output.alarm != alarm_before {
            log.event(|text| {
                text.str(if output.alarm { "alarm" } else { "alarm over" });
                text.str(" at ").real(time_s).str(" s: J_rms = ").rounded(output.j_rms);
                text.str(", J_th = ").rounded(output.j_th);
            });
        }
        if output.monitor == before {
            return Status::Ok;
        }
        if output.monitor == Monitor::InvalidInput {
            log.warning(|text| {
                text.str("an input is not finite or implausibly large at ").real(time_s);
                text.str(" s: the last results are held until inputs are valid again");
            });
            return Status::Warning;
        }
        log.event(|text| {
            text.str(if output.monitor == Monitor::Monitoring {
                "monitoring from "
            } else {
                "outside the range of the design, alarms withheld from "
            });
            text.real(time_s).str(" s");
        });
        Status::Ok
    }
}

impl Model for DetectorModel {
    type Variable = V;
    const INFO: ModelInfo = INFO;

    fn new(payload: &[u8]) -> Result<Self, &'static str> {
        let design = BakedDesign::decode(payload)
            .map_err(|_| "what is baked into this library is not a design of its version")?;
        let detector = Detector::new(&design.configuration)
            .map_err(|_| "the detector cannot run on the numbers baked into this library")?;
        let mut hash = [0; 65];
        for (place, &digit) in hash.iter_mut().zip(&design.hash) {
            *place = digit;
        }
        Ok(Self {
            design,
            hash,
            detector,
            measurement: Measurement::default(),
            input: Input::default(),
            initialisation: FIRST_MEASUREMENT,
            z_0: [0.0; 3],
            start_time_s: 0.0,
        })
    }

    fn sample_period_s(&self) -> f64 {
        self.design.configuration.model.sampling_period_s
    }

    #[inline(always)] // each C getter keeps the arm of its own type
    fn get(&self, variable: V) -> Value<'_> {
        let configuration = &self.design.configuration;
        let vehicle = &configuration.model.vehicle;
        let range = &configuration.model.range;
        let evaluation = &configuration.evaluation;
        let output = self.output();
        let real = match variable {
            V::SpeedX => self.measurement.v_x_m_per_s,
            V::YawRate => self.measurement.r_rad_per_s,
            V::DriveTorque => self.input.t_eng_n_m,
            V::SteeringAngle => self.input.delta_rad,

            V::ResidualSpeedX => output.residual.v_x_m_per_s,
            V::ResidualYawRate => output.residual.r_rad_per_s,
            V::Rms => output.j_rms,
            V::Threshold => output.j_th,
            V::Alarm => return Value::Boolean(output.alarm),
            V::State | V::StateIndex => return Value::Integer(state(output.monitor).value()),

            V::LateralSpeed => output.v_y_hat,
            V::Ratio => output.j_rms / output.j_th,
            V::Detectability => output.detectability,
            V::Excited => return Value::Boolean(output.detectability >= 1.0),
            V::AlarmLatched => return Value::Boolean(output.first_alarm.is_some()),
            V::FirstAlarmTime => output.first_alarm.map_or(NO_ALARM_TIME, |k| self.time_s(k)),

            V::ThresholdFactor => self.detector.threshold_factor(),
            V::DebounceSamples => return Value::Integer(self.detector.debounce_samples() as i32),
            V::Initialisation | V::InitialisationIndex => {
                return Value::Integer(self.initialisation);
            }
            V::InitialZ1 => self.z_0[0],
            V::InitialZ2 => self.z_0[1],
            V::InitialZ3 => self.z_0[2],

            V::DesignHash => {
                return Value::String(CStr::from_bytes_until_nul(&self.hash).unwrap_or(c""));
            }
            V::DesignSamplePeriod => configuration.model.sampling_period_s,
            V::DesignCertified => return Value::Boolean(self.design.certified),
            V::DesignBeta => self.design.beta,
            V::DesignGamma => self.design.gamma,
            V::DesignGap => self.design.gap,
            V::DesignThreshold => evaluation.threshold,
            V::DesignUncertaintyShare => evaluation.uncertainty_share,
            V::DesignWindow => return Value::Integer(evaluation.window as i32),
            V::DesignWeightSpeedX => evaluation.weights[0],
            V::DesignWeightYawRate => evaluation.weights[1],
            V::RangeSpeedXMin => range.v_x.min,
            V::RangeSpeedXMax => range.v_x.max,
            V::RangeSpeedYMin => range.v_y.min,
            V::RangeSpeedYMax => range.v_y.max,
            V::RangeYawRateMin => range.r.min,
            V::RangeYawRateMax => range.r.max,

            V::ActuatorLag => configuration.actuator.lag_s,
            V::ActuatorDelay => configuration.actuator.delay_s,
            V::ActuatorRateLimit => configuration.actuator.rate_limit_rad_per_s.unwrap_or(0.0),

            V::VehicleMass => vehicle.mass_kg,
            V::VehicleYawInertia => vehicle.yaw_inertia_kg_m2,
            V::VehicleLongitudinalInertia => vehicle.effective_longitudinal_inertia_kg_m,
            V::VehicleFrontAxleDistance => vehicle.front_axle_distance_m,
            V::VehicleRearAxleDistance => vehicle.rear_axle_distance_m,
            V::VehicleFrontStiffness => vehicle.front_cornering_stiffness_n_per_rad,
            V::VehicleRearStiffness => vehicle.rear_cornering_stiffness_n_per_rad,
            V::VehicleLongitudinalDrag => vehicle.longitudinal_drag_n_m_s2_per_m2,
            V::VehicleLateralDrag => vehicle.lateral_drag_n_s2_per_m2,
        };
        Value::Real(real)
    }

    #[inline(always)]
    fn set(&mut self, variable: V, value: Value<'_>) {
        match variable {
            V::SpeedX => value.store_real(&mut self.measurement.v_x_m_per_s),
            V::YawRate => value.store_real(&mut self.measurement.r_rad_per_s),
            V::DriveTorque => value.store_real(&mut self.input.t_eng_n_m),
            V::SteeringAngle => value.store_real(&mut self.input.delta_rad),

            // The limits of both are the detector's: it refuses nothing that the layer lets through.
            V::ThresholdFactor => {
                let mut factor = self.detector.threshold_factor();
                value.store_real(&mut factor);
                let _ = self.detector.set_threshold_factor(factor);
            }
            V::DebounceSamples => {
                let mut samples = self.detector.debounce_samples() as i32;
                value.store_integer(&mut samples);
                let _ = self.detector.set_debounce_samples(samples.unsigned_abs());
            }
            V::Initialisation => value.store_integer(&mut self.initialisation),
            V::InitialZ1 => value.store_real(&mut self.z_0[0]),
            V::InitialZ2 => value.store_real(&mut self.z_0[1]),
            V::InitialZ3 => value.store_real(&mut self.z_0[2]),

            // Outputs, locals and constants: never set.
            V::ResidualSpeedX
            | V::ResidualYawRate
            | V::Rms
            | V::Threshold
            | V::Alarm
            | V::State
            | V::LateralSpeed
            | V::Ratio
            | V::Detectability
            | V::Excited
            | V::AlarmLatched
            | V::FirstAlarmTime
            | V::StateIndex
            | V::InitialisationIndex
            | V::DesignHash
            | V::DesignSamplePeriod
            | V::DesignCertified
            | V::DesignBeta
            | V::DesignGamma
            | V::DesignGap
            | V::DesignThreshold
            | V::DesignUncertaintyShare
            | V::DesignWindow
            | V::DesignWeightSpeedX
            | V::DesignWeightYawRate
            | V::RangeSpeedXMin
            | V::RangeSpeedXMax
            | V::RangeSpeedYMin
            | V::RangeSpeedYMax
            | V::RangeYawRateMin
            | V::RangeYawRateMax
            | V::ActuatorLag
            | V::ActuatorDelay
            | V::ActuatorRateLimit
            | V::VehicleMass
            | V::VehicleYawInertia
            | V::VehicleLongitudinalInertia
            | V::VehicleFrontAxleDistance
            | V::VehicleRearAxleDistance
            | V::VehicleFrontStiffness
            | V::VehicleRearStiffness
            | V::VehicleLongitudinalDrag
            | V::VehicleLateralDrag => {}
        }
    }

    fn initialise(&mut self, start_time_s: f64) -> Result<(), &'static str> {
        self.start_time_s = start_time_s;
        self.apply_initialisation().map_err(|_| "z_0 is not finite")
    }

    fn sample(&mut self, log: &Log<'_>) -> Status {
        let Output { monitor, alarm, .. } = *self.output();
        let after = self.detector.sample(self.measurement, self.input);
        if after.monitor == monitor && after.alarm == alarm {
            Status::Ok
        } else {
            self.report(monitor, alarm, log)
        }
    }

    fn archive(&mut self, archive: &mut Archive<'_>) {
        let Measurement { v_x_m_per_s, r_rad_per_s } = &mut self.measurement;
        let Input { t_eng_n_m, delta_rad } = &mut self.input;
        for number in [v_x_m_per_s, r_rad_per_s, t_eng_n_m, delta_rad] {
            archive.real(number);
        }
        let mut threshold_factor = self.detector.threshold_factor();
        archive.real(&mut threshold_factor);
        archive.require(self.detector.set_threshold_factor(threshold_factor).is_ok());
        let mut debounce_samples = self.detector.debounce_samples();
        archive.u32(&mut debounce_samples);
        archive.require(self.detector.set_debounce_samples(debounce_samples).is_ok());
        archive.choice(&mut self.initialisation, &[FIRST_MEASUREMENT, GIVEN]);
        for number in self.z_0.iter_mut().chain([&mut self.start_time_s]) {
            archive.finite(number);
        }
        let configuration = &self.design.configuration;
        let window = configuration.evaluation.window;
        let actuator = configuration.actuator;
        let slowest = configuration.deviations.uncertainty.slowest(&actuator);
        let delays = [actuator, slowest]
            .map(|actuator| actuator.delay_samples(configuration.model.sampling_period_s));
        let mut state = *self.detector.state();
        archive_state(&mut state, window, delays, archive);
        archive.require(self.detector.set_state(&state).is_ok());
        archive.require(self.apply_initialisation().is_ok());
    }
}

/// Passes the detector's state, which checks it, through `archive`; `window`, and the `delays` of the actuator and of the
/// slowest one, in samples.
fn archive_state(state: &mut State, window: usize, delays: [usize; 2], archive: &mut Archive<'_>) {
    let State {
        sample,
        z,
        tracking,
        armed,
        rms,
        start_up,
        responses,
        actuator,
        slowest_actuator,
        exceedances,
        output,
    } = state;
    archive.u64(sample);
    for number in z {
        archive.real(number);
    }
    archive.flag(tracking);
    archive.flag(armed);
    archive_rms(rms, window, archive);
    archive.real(&mut start_up.power);
    archive.real(&mut start_up.sum);
    archive.size(&mut start_up.samples);
    let Responses { remainder, uncertainties, fault, uncertainty_rms, fault_rms } = responses;
    for number in remainder.iter_mut().chain(uncertainties.as_flattened_mut()).chain(fault) {
        archive.real(number);
    }
    archive_rms(uncertainty_rms, window, archive);
    archive_rms(fault_rms, window, archive);
    for (actuator, delay) in [actuator, slowest_actuator].into_iter().zip(delays) {
        archive_actuator(actuator, delay, archive);
    }
    archive.u32(exceedances);

    let Output { residual, v_y_hat, j_rms, j_th, detectability, alarm, monitor, first_alarm } =
        output;
    let Measurement { v_x_m_per_s, r_rad_per_s } = residual;
    for number in [v_x_m_per_s, r_rad_per_s, v_y_hat, j_rms, j_th, detectability] {
        archive.real(number);
    }
    archive.flag(alarm);
    archive.choice(
        monitor,
        &[Monitor::Starting, Monitor::Monitoring, Monitor::OutOfRange, Monitor::InvalidInput],
    );
    archive.optional(first_alarm, |archive, sample| archive.u64(sample));
}

fn archive_actuator(state: &mut ActuatorState, delay: usize, archive: &mut Archive<'_>) {
    let ActuatorState { commands, oldest, command, angle } = state;
    for command in commands.iter_mut().take(delay + 1) {
        archive.real(command);
    }
    archive.size(oldest);
    archive.optional(command, Archive::real);
    archive.real(angle);
}

fn archive_rms(rms: &mut Rms, window: usize, archive: &mut Archive<'_>) {
    let Rms { ring, next, newer } = rms;
    for number in ring.iter_mut().take(window).chain([newer]) {
        archive.real(number);
    }
    archive.size(next);
}
