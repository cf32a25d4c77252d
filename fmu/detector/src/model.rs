//! The detector behind the variables of its description.

use core::ffi::CStr;

use steerguard_detector::{
    ActuatorState, AlarmCause, ConfigurationError, Detector, FaultEstimate, FaultHypothesis,
    Filter, Hypothesis, Initialisation, Input, Jump, Measurement, Monitor, Onsets, Output,
    ReferenceMotion, Responses, Rms, Signal, Signature, State, StateCause, StateVector, Zero,
};
use steerguard_fmu_core::{Archive, Log, Model, Status, Text};
use steerguard_model_description::detector::{
    DetectorVariable as V, INFO, Initialisation as Item, NO_ALARM_TIME,
};
use steerguard_model_description::{ModelInfo, Value};

use crate::{BakedDesign, alarm_cause, fault_hypothesis, state, state_cause};

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
    /// Whether a measurement that jumped has been reported.
    jump_reported: bool,
}

/// What of a sample's results the log tells when it changes.
#[derive(Clone, Copy, PartialEq)]
struct Shown {
    monitor: Monitor,
    state_cause: StateCause,
    alarm: bool,
}

impl Shown {
    const fn of(output: &Output) -> Self {
        let Output { monitor, state_cause, alarm, .. } = *output;
        Self { monitor, state_cause, alarm }
    }
}

/// The Real that `value` sets in place of `current`.
fn set_to(value: Value<'_>, mut current: f64) -> f64 {
    value.store_real(&mut current);
    current
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
    fn report(&self, before: Shown, log: &Log<'_>) -> Status {
        let output = self.output();
        let time_s = self.time_s(self.detector.state().sample.saturating_sub(1));
        if output.alarm != before.alarm {
            log.event(|text| {
                text.str(if output.alarm { "alarm" } else { "alarm over" });
                text.str(" at ").real(time_s).str(" s: ");
                if output.alarm_cause == AlarmCause::Range {
                    self.place(output, text);
                    text.str(", although the command does not lead there");
                } else if output.alarm_cause == AlarmCause::SecondTest {
                    text.str("second_ratio = ").rounded(output.second_ratio);
                } else {
                    text.str("J_rms = ").rounded(output.j_rms);
                    text.str(", J_th = ").rounded(output.j_th);
                }
            });
        }
        if (output.monitor, output.state_cause) == (before.monitor, before.state_cause) {
            return Status::Ok;
        }
        match output.monitor {
            Monitor::InvalidInput => {
                log.warning(|text| self.invalid(output, time_s, text));
                return Status::Warning;
            }
            Monitor::Starting => {}
            Monitor::Monitoring => log.event(|text| {
                text.str("monitoring from ").real(time_s).str(" s");
            }),
            Monitor::OutOfRange => log.event(|text| {
                text.str("outside the range of the design from ").real(time_s).str(" s: ");
                self.place(output, text);
            }),
            Monitor::Disabled => log.event(|text| {
                text.str("switched off by the input enabled from ").real(time_s).str(" s");
            }),
            Monitor::StaleInput => log.event(|text| {
                text.str("v_x and r have not changed for ").rounded(self.detector.stale_after_s());
                text.str(" s at ").real(time_s).str(
                    " s: no alarm until they do; for simulations \
                     without noise set the parameter stale_after_s = 0",
                );
            }),
        }
        Status::Ok
    }

    /// Reports measurements that no vehicle reaches from the last within a sample: a wrong unit or a broken
    /// signal.
    #[cold]
    fn report_jumps(&mut self, jumps: [Option<Jump>; 2], log: &Log<'_>) {
        let signals = [("v_x", " m/s", "km/h"), ("r", " rad/s", "deg/s")];
        for (jump, (name, unit, other_unit)) in jumps.into_iter().zip(signals) {
            // A most of 0 is that of a detector whose data are never stale.
            if let Some(Jump { change, most }) = jump.filter(|jump| jump.most > 0.0) {
                self.jump_reported = true;
                let time_s = self.time_s(self.detector.state().sample.saturating_sub(1));
                log.event(|text| {
                    text.str(name).str(" changes by ").rounded(change).str(unit);
                    text.str(" within a sample at ").real(time_s).str(" s, ");
                    text.rounded(change / most).str(" times the most that a vehicle and the ");
                    text.str("sensor's noise allow: is it in ").str(other_unit).str("?");
                });
            }
        }
    }

    /// What lies outside the range of the design, its value and the range; or what keeps the detector
    /// from arming.
    fn place(&self, output: &Output, text: &mut Text) {
        let range = &self.design.configuration.model.range;
        let (name, value, range) = match output.state_cause {
            StateCause::Signal(Signal::Speed) => ("v_x", self.measurement.v_x_m_per_s, range.v_x),
            StateCause::LateralSpeed => ("v_y_hat", output.v_y_hat, range.v_y),
            _ => ("r", self.measurement.r_rad_per_s, range.r),
        };
        text.str(name).str(" = ").rounded(value);
        text.str(if range.contains(value) { " is near an end of [" } else { " is not in [" });
        text.rounded(range.min).str(", ").rounded(range.max).str("]");
    }

    /// Which input is invalid, why, and what it might be.
    fn invalid(&self, output: &Output, time_s: f64, text: &mut Text) {
        let StateCause::Signal(signal) = output.state_cause else { return };
        let (name, value, guess) = match signal {
            Signal::Speed => (
                "v_x",
                self.measurement.v_x_m_per_s,
                " m/s, which no road vehicle reaches: is it in km/h?",
            ),
            Signal::YawRate => (
                "r",
                self.measurement.r_rad_per_s,
                " rad/s, which no road vehicle reaches: is it in deg/s?",
            ),
            Signal::DriveTorque => ("u.T_eng", self.input.t_eng_n_m, " N m at the wheels"),
            Signal::SteeringAngle => (
                "u.delta",
                self.input.delta_rad,
                " rad at the road wheel: is it in degrees, or the angle of the hand wheel?",
            ),
        };
        text.str(name).str(" = ").rounded(value).str(" at ").real(time_s).str(" s ");
        if value.is_finite() {
            text.str("is beyond its limit, +-").rounded(signal.limit()).str(guess);
        } else {
            text.str("is not finite");
        }
        text.str("; the last results are held until inputs are valid again");
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
            jump_reported: false,
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
            V::Enabled => return Value::Boolean(self.detector.enabled()),

            V::ResidualSpeedX => output.residual.v_x_m_per_s,
            V::ResidualYawRate => output.residual.r_rad_per_s,
            V::Rms => output.j_rms,
            V::Threshold => output.j_th,
            V::Alarm => return Value::Boolean(output.alarm),
            V::State | V::StateIndex => return Value::Integer(state(output.monitor).value()),

            V::AlarmCause | V::AlarmCauseIndex => {
                return Value::Integer(alarm_cause(output.alarm_cause).value());
            }
            V::FaultHypothesis | V::FaultHypothesisIndex => {
                return Value::Integer(fault_hypothesis(output.estimate.as_ref()).value());
            }
            V::StateCause | V::StateCauseIndex => {
                return Value::Integer(state_cause(output.state_cause).value());
            }

            V::LateralSpeed => output.v_y_hat,
            V::Ratio => output.j_rms / output.j_th,
            V::Detectability => output.detectability,
            V::Excited => return Value::Boolean(output.detectability >= 1.0),
            V::AlarmLatched => return Value::Boolean(output.first_alarm.is_some()),
            V::FirstAlarmTime => output.first_alarm.map_or(NO_ALARM_TIME, |k| self.time_s(k)),
            V::FaultEstimate => output.estimate.map_or(0.0, |x| x.fault_rad),
            V::FaultEstimateBound => output.estimate.map_or(0.0, |x| x.bound_rad),
            V::FaultOnsetTime => output.estimate.map_or(NO_ALARM_TIME, |x| self.time_s(x.onset)),
            V::SecondRatio => output.second_ratio,

            V::ThresholdFactor => self.detector.threshold_factor(),
            V::DebounceSamples => return Value::Integer(self.detector.debounce_samples() as i32),
            V::AlarmHold => self.detector.alarm_hold_s(),
            V::SteeringOffset => self.detector.zero().steering_offset_rad,
            V::YawRateBias => self.detector.zero().yaw_rate_bias_rad_per_s,
            V::StaleAfter => self.detector.stale_after_s(),
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
            V::DesignBlind => return Value::Boolean(self.design.blind),
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
            V::ActuatorAngleLimit => configuration.actuator.angle_limit_rad.unwrap_or(0.0),

            V::VehicleMass => vehicle.mass_kg,
            V::VehicleYawInertia => vehicle.yaw_inertia_kg_m2,
            V::VehicleLongitudinalInertia => vehicle.effective_longitudinal_inertia_kg_m,
            V::VehicleFrontAxleDistance => vehicle.front_axle_distance_m,
            V::VehicleRearAxleDistance => vehicle.rear_axle_distance_m,
            V::VehicleFrontStiffness => vehicle.front_cornering_stiffness_n_per_rad,
            V::VehicleRearStiffness => vehicle.rear_cornering_stiffness_n_per_rad,
            V::VehicleLongitudinalDrag => vehicle.longitudinal_drag_n_m_s2_per_m2,
            V::VehicleLateralDrag => vehicle.lateral_drag_n_s2_per_m2,
            V::VehicleHeight => vehicle.centre_of_gravity_height_m,
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
            V::Enabled => {
                let mut enabled = self.detector.enabled();
                value.store_boolean(&mut enabled);
                self.detector.set_enabled(enabled);
            }

            // The limits of these are the detector's: it refuses nothing that the layer lets through.
            V::ThresholdFactor => {
                let factor = set_to(value, self.detector.threshold_factor());
                let _ = self.detector.set_threshold_factor(factor);
            }
            V::DebounceSamples => {
                let mut samples = self.detector.debounce_samples() as i32;
                value.store_integer(&mut samples);
                let _ = self.detector.set_debounce_samples(samples.unsigned_abs());
            }
            V::AlarmHold => {
                let hold_s = set_to(value, self.detector.alarm_hold_s());
                let _ = self.detector.set_alarm_hold_s(hold_s);
            }
            V::SteeringOffset => {
                let mut zero = self.detector.zero();
                value.store_real(&mut zero.steering_offset_rad);
                let _ = self.detector.set_zero(zero);
            }
            V::YawRateBias => {
                let mut zero = self.detector.zero();
                value.store_real(&mut zero.yaw_rate_bias_rad_per_s);
                let _ = self.detector.set_zero(zero);
            }
            V::StaleAfter => {
                let after_s = set_to(value, self.detector.stale_after_s());
                let _ = self.detector.set_stale_after_s(after_s);
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
            | V::FaultEstimate
            | V::FaultEstimateBound
            | V::FaultOnsetTime
            | V::SecondRatio
            | V::StateIndex
            | V::AlarmCause
            | V::AlarmCauseIndex
            | V::FaultHypothesis
            | V::FaultHypothesisIndex
            | V::StateCause
            | V::StateCauseIndex
            | V::InitialisationIndex
            | V::DesignHash
            | V::DesignSamplePeriod
            | V::DesignCertified
            | V::DesignBlind
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
            | V::ActuatorAngleLimit
            | V::VehicleMass
            | V::VehicleYawInertia
            | V::VehicleLongitudinalInertia
            | V::VehicleFrontAxleDistance
            | V::VehicleRearAxleDistance
            | V::VehicleFrontStiffness
            | V::VehicleRearStiffness
            | V::VehicleLongitudinalDrag
            | V::VehicleLateralDrag
            | V::VehicleHeight => {}
        }
    }

    fn initialise(&mut self, start_time_s: f64) -> Result<(), &'static str> {
        self.start_time_s = start_time_s;
        self.apply_initialisation().map_err(|_| "z_0 is not finite")
    }

    fn sample(&mut self, log: &Log<'_>) -> Status {
        let before = Shown::of(self.output());
        let last = self.detector.state().last;
        let after = Shown::of(self.detector.sample(self.measurement, self.input));
        let both_valid = !matches!(before.monitor, Monitor::Starting | Monitor::InvalidInput)
            && after.monitor != Monitor::InvalidInput;
        if both_valid && !self.jump_reported {
            let staleness = &self.design.configuration.staleness;
            let jumps = staleness.jumps(last, self.detector.state().last);
            if jumps != [None; 2] {
                self.report_jumps(jumps, log);
            }
        }
        if after == before { Status::Ok } else { self.report(before, log) }
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
        let mut alarm_hold_s = self.detector.alarm_hold_s();
        archive.real(&mut alarm_hold_s);
        archive.require(self.detector.set_alarm_hold_s(alarm_hold_s).is_ok());
        let mut zero = self.detector.zero();
        let Zero { steering_offset_rad, yaw_rate_bias_rad_per_s } = &mut zero;
        archive.real(steering_offset_rad);
        archive.real(yaw_rate_bias_rad_per_s);
        archive.require(self.detector.set_zero(zero).is_ok());
        let mut stale_after_s = self.detector.stale_after_s();
        archive.real(&mut stale_after_s);
        archive.require(self.detector.set_stale_after_s(stale_after_s).is_ok());
        let mut enabled = self.detector.enabled();
        archive.flag(&mut enabled);
        self.detector.set_enabled(enabled);
        archive.choice(&mut self.initialisation, &[FIRST_MEASUREMENT, GIVEN]);
        for number in self.z_0.iter_mut().chain([&mut self.start_time_s]) {
            archive.finite(number);
        }
        archive.flag(&mut self.jump_reported);
        let configuration = &self.design.configuration;
        let window = configuration.evaluation.window;
        let actuator = configuration.actuator;
        let slowest = configuration.deviations.uncertainty.slowest(&actuator);
        let delays = [actuator, slowest]
            .map(|actuator| actuator.delay_samples(configuration.model.sampling_period_s));
        let mut state = *self.detector.state();
        archive_state(&mut state, window, delays, configuration.estimator.is_some(), archive);
        archive.require(self.detector.set_state(&state).is_ok());
        archive.require(self.apply_initialisation().is_ok());
    }
}

/// Passes the detector's state, which checks it, through `archive`; `window`, and the `delays` of the actuator and of the
/// slowest one, in samples; `second`, whether the second test runs.
fn archive_state(
    state: &mut State,
    window: usize,
    delays: [usize; 2],
    second: bool,
    archive: &mut Archive<'_>,
) {
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
        motions,
        filter,
        onsets,
        followed,
        filtered_v_x_m_per_s,
        last,
        unchanged,
        unanswered,
        exceedances,
        clear,
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
    let Responses { known, along, common, sensed, fault, uncertainty_rms, fault_rms } = responses;
    let numbers = known
        .iter_mut()
        .chain(along.as_flattened_mut().as_flattened_mut())
        .chain(common.as_flattened_mut())
        .chain(sensed.as_flattened_mut())
        .chain(fault);
    for number in numbers {
        archive.real(number);
    }
    archive_rms(uncertainty_rms, window, archive);
    archive_rms(fault_rms, window, archive);
    for (actuator, delay) in [actuator, slowest_actuator].into_iter().zip(delays) {
        archive_actuator(actuator, delay, archive);
    }
    for ReferenceMotion { v_y_m_per_s, r_rad_per_s } in motions {
        archive.real(v_y_m_per_s);
        archive.real(r_rad_per_s);
    }
    archive.real(filtered_v_x_m_per_s);
    archive.real(&mut last.v_x_m_per_s);
    archive.real(&mut last.r_rad_per_s);
    for count in [followed, unchanged, unanswered, exceedances, clear] {
        archive.u32(count);
    }
    if second {
        let Filter { x, p } = filter;
        for number in x.iter_mut().chain(p.as_flattened_mut()) {
            archive.real(number);
        }
        archive_onsets(onsets, archive);
    }

    let Output {
        residual,
        v_y_hat,
        j_rms,
        j_th,
        detectability,
        alarm,
        alarm_cause,
        monitor,
        state_cause,
        first_alarm,
        second_ratio,
        estimate,
    } = output;
    let Measurement { v_x_m_per_s, r_rad_per_s } = residual;
    for number in [v_x_m_per_s, r_rad_per_s, v_y_hat, j_rms, j_th, detectability, second_ratio] {
        archive.real(number);
    }
    archive.flag(alarm);
    archive.choice(
        monitor,
        &[
            Monitor::Starting,
            Monitor::Monitoring,
            Monitor::OutOfRange,
            Monitor::InvalidInput,
            Monitor::Disabled,
            Monitor::StaleInput,
        ],
    );
    archive.choice(
        alarm_cause,
        &[AlarmCause::None, AlarmCause::Residual, AlarmCause::Range, AlarmCause::SecondTest],
    );
    let [speed, yaw_rate, torque, angle] = Signal::ALL.map(StateCause::Signal);
    archive.choice(
        state_cause,
        &[
            StateCause::None,
            speed,
            yaw_rate,
            torque,
            angle,
            StateCause::LateralSpeed,
            StateCause::Unchanged,
            StateCause::NotEnabled,
        ],
    );
    archive.optional(first_alarm, |archive, sample| archive.u64(sample));
    archive.optional(
        estimate,
        |archive, FaultEstimate { fault_rad, bound_rad, onset, hypothesis }| {
            archive.real(fault_rad);
            archive.real(bound_rad);
            archive.u64(onset);
            archive_fault_hypothesis(hypothesis, archive);
        },
    );
}

fn archive_fault_hypothesis(hypothesis: &mut FaultHypothesis, archive: &mut Archive<'_>) {
    archive.choice(
        hypothesis,
        &[
            FaultHypothesis::Undecided,
            FaultHypothesis::Steering,
            FaultHypothesis::YawRateSensor,
            FaultHypothesis::SpeedSensor,
        ],
    );
}

fn archive_onsets(onsets: &mut Onsets, archive: &mut Archive<'_>) {
    let Onsets {
        samples,
        hypotheses,
        held_rad,
        held_variance,
        largest_rad,
        held_onset,
        held_since,
        clear,
        hypothesis,
        statistic,
        looks_rad,
    } = onsets;
    for count in [samples, held_onset, held_since, clear] {
        archive.u64(count);
    }
    archive_fault_hypothesis(hypothesis, archive);
    for number in [held_rad, held_variance, largest_rad, statistic, looks_rad] {
        archive.real(number);
    }
    for Hypothesis { onset, signatures } in hypotheses {
        archive.optional(onset, |archive, sample| archive.u64(sample));
        for Signature { error, correlation, information } in signatures {
            for number in error.iter_mut().chain([correlation, information]) {
                archive.real(number);
            }
        }
    }
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
