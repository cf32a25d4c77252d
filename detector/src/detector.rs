//! The detector: observer, evaluation and decision, armed only where its guarantee holds.

use crate::algebra::all_finite;
use crate::configuration::{measurable, not_negative};
use crate::deviation::Standing;
use crate::filter::Kalman;
use crate::onset::OnsetTest;
use crate::reference::References;
use crate::{
    Actuator, ActuatorState, Configuration, ConfigurationError, Deviations, Evaluation,
    FaultEstimate, Filter, Input, Loading, MOTIONS, Measurement, Observer, Onsets, OperatingRange,
    Place, RELEASE, ReferenceMotion, Responses, Rms, Signal, Staleness, StartUp, StateVector,
    VehicleState, Zero,
};

/// An estimate of this magnitude is lost, in SI units: a sample that starts below it cannot overflow.
pub const LARGEST_ESTIMATE: f64 = 1e9;

/// Time constant of the filter that makes the longitudinal acceleration of the measured speed, s.
const ACCELERATION_FILTER_S: f64 = 0.15;

/// Whether `x` is a number and not lost.
fn plausible(x: &VehicleState) -> bool {
    x.vector().iter().all(|x| -LARGEST_ESTIMATE < *x && *x < LARGEST_ESTIMATE)
}

/// Which condition holds at the last sample.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Monitor {
    /// No sample yet.
    #[default]
    Starting,
    /// Residual and J are valid, and new alarms are given by them.
    Monitoring,
    /// The measurement or the estimated lateral speed lies outside S_x: the residual raises no alarm.
    OutOfRange,
    /// A measurement or input is not finite or beyond its [limit](Signal::limit): the other outputs keep
    /// their last values, and the observer starts anew at the next valid sample.
    InvalidInput,
    /// The detector is switched off: no alarm, and a clean start afterwards.
    Disabled,
    /// The measurements have not changed for too long: no new alarm.
    StaleInput,
}

/// What keeps the detector from monitoring.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum StateCause {
    /// Nothing, or that no sample has come yet.
    #[default]
    None,
    /// A signal that is invalid, out of range, or no longer changes.
    Signal(Signal),
    /// The estimated lateral speed is out of range.
    LateralSpeed,
    /// Neither measured signal changes any more.
    Unchanged,
    /// It is switched off.
    NotEnabled,
}

/// Which test raised the alarm that stands.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum AlarmCause {
    /// No alarm stands.
    #[default]
    None,
    /// `J >= J_th`.
    Residual,
    /// The vehicle has left S_x, and no reference motion does.
    Range,
    /// A fault from some sample on makes the measurements likelier than stated uncertainties do.
    SecondTest,
}

/// How the observer starts at the first sample; every later start is from the measurement.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Initialisation {
    /// `z_0 = M [v_x, 0, r]`: covered by the threshold's start-up term.
    #[default]
    FirstMeasurement,
    /// A given z_0, such as the paper's zero, finite: its transient is not covered by the threshold.
    Given(StateVector),
}

/// Results of the last sample.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Output {
    /// Residual `r = y - C x^` (10), less the response to Euler's remainder where that is corrected; zero
    /// where no observer runs.
    pub residual: Measurement,
    /// Estimated lateral speed, m/s.
    pub v_y_hat: f64,
    /// J, the windowed RMS of the weighted residual.
    pub j_rms: f64,
    /// J_th, the threshold that J is held against; positive.
    pub j_th: f64,
    /// The J that the smallest fault of interest would make alone had it acted since the observer's
    /// start, over J_th: below 1 it could not be seen.
    pub detectability: f64,
    /// Whether an alarm stands: it ends once J has stayed below [`RELEASE`] of J_th for a while.
    pub alarm: bool,
    /// Which test raised it.
    pub alarm_cause: AlarmCause,
    /// Which condition holds.
    pub monitor: Monitor,
    /// What keeps it from monitoring.
    pub state_cause: StateCause,
    /// Index of the sample that raised the first alarm.
    pub first_alarm: Option<u64>,
    /// The largest statistic of the second test, over its threshold.
    pub second_ratio: f64,
    /// What the second test knows of the fault, where an alarm stands and it has found one.
    pub estimate: Option<FaultEstimate>,
}

impl Output {
    /// Whether everything that is told, J over J_th too, is a finite number, and J_th positive.
    fn is_finite(&self) -> bool {
        let Measurement { v_x_m_per_s, r_rad_per_s } = self.residual;
        let (fault_rad, bound_rad) =
            self.estimate.map_or((0.0, 0.0), |x| (x.fault_rad, x.bound_rad));
        self.j_th > 0.0
            && all_finite(&[
                v_x_m_per_s,
                r_rad_per_s,
                self.v_y_hat,
                self.j_rms,
                self.j_th,
                self.j_rms / self.j_th,
                self.detectability,
                self.second_ratio,
                fault_rad,
                bound_rad,
            ])
    }
}

/// All that changes from sample to sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct State {
    /// Index of the sample to come.
    pub sample: u64,
    /// Observer state z before the sample to come; meaningful while `tracking`.
    pub z: StateVector,
    /// Whether z has followed every sample since the observer's last start.
    pub tracking: bool,
    /// Whether alarms are given.
    pub armed: bool,
    /// Residual window.
    pub rms: Rms,
    /// Threshold's start-up term.
    pub start_up: StartUp,
    /// Responses to deviations from the model.
    pub responses: Responses,
    /// The actuator, which moves at every sample, seen or not.
    pub actuator: ActuatorState,
    /// The slowest that the actuator may be, likewise.
    pub slowest_actuator: ActuatorState,
    /// Reference motions at the sample to come, meaningful while `followed` is not 0.
    pub motions: [ReferenceMotion; MOTIONS],
    /// Samples that they have followed the speed without a break.
    pub followed: u32,
    /// What the second test's filter knows; meaningful while `tracking`, as are its onsets.
    pub filter: Filter,
    /// Onsets of a fault that it looks at, and the fault that the filter knows.
    pub onsets: Onsets,
    /// Filtered speed behind the longitudinal acceleration, m/s, likewise.
    pub filtered_v_x_m_per_s: f64,
    /// The last valid measurement.
    pub last: Measurement,
    /// Samples since it changed.
    pub unchanged: u32,
    /// Those of them since the commanded angle changed.
    pub unanswered: u32,
    /// Consecutive samples that raise an alarm.
    pub exceedances: u32,
    /// Consecutive samples that would end one.
    pub clear: u32,
    /// Results of the last sample.
    pub output: Output,
}

impl State {
    /// The observer no longer runs, and so raises no alarms.
    const fn stop_observer(&mut self) {
        self.tracking = false;
        self.armed = false;
    }

    /// The observer no longer runs, and what it has come to is lost: it may be no number, which no state may hold.
    #[cold]
    fn lose_observer(&mut self) {
        self.stop_observer();
        self.z = [0.0; 3];
        self.rms = Rms::EMPTY;
        self.responses = Responses::NONE;
    }
}

/// Why a state is refused: no detector of the configuration can have had it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StateError;

impl core::fmt::Display for StateError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str("no detector of this configuration can have had this state")
    }
}

impl core::error::Error for StateError {}

/// The test beside the residual: what no sample changes.
#[derive(Clone, Copy, Debug, PartialEq)]
struct SecondTest {
    kalman: Kalman,
    test: OnsetTest,
}

impl SecondTest {
    /// Forgets everything: the next sample starts anew.
    fn forget(&self, filter: &mut Filter, onsets: &mut Onsets) {
        *filter = self.kalman.forget();
        *onsets = Onsets::NONE;
    }

    /// Takes in a sample and goes on to the next; `factor` on the threshold.
    fn sample(
        &self,
        filter: &mut Filter,
        onsets: &mut Onsets,
        y: Measurement,
        place: &Place,
        factor: f64,
    ) {
        let starts = onsets.samples == 0 || {
            let correction = self.kalman.update(filter, y);
            let over = correction.is_none_or(|x| self.test.correct(onsets, filter, &x, factor));
            if over {
                self.forget(filter, onsets);
            }
            over
        };
        if starts {
            self.kalman.start(filter, y);
        }
        let transition = self.kalman.predict(filter, place, onsets.held_rad);
        self.test.advance(onsets, &transition);
    }
}

/// A steering-fault detector.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Detector {
    observer: Observer,
    armed_range: OperatingRange,
    evaluation: Evaluation,
    actuator: Actuator,
    slowest_actuator: Actuator,
    deviations: Deviations,
    standing: Standing,
    references: References,
    second: Option<SecondTest>,
    staleness: Staleness,
    zero: Zero,
    threshold_factor: f64,
    debounce_samples: u32,
    alarm_hold_s: f64,
    enabled: bool,
    initialisation: Initialisation,
    state: State,
}

impl Detector {
    /// A detector before its first sample.
    ///
    /// # Errors
    /// [`ConfigurationError`] where a number is not finite or out of its range.
    pub fn new(configuration: &Configuration) -> Result<Self, ConfigurationError> {
        configuration.check()?;
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
        } = *configuration;
        let second = estimator.map(|estimator| SecondTest {
            kalman: Kalman::new(&model, &deviations.uncertainty, &estimator),
            test: OnsetTest::new(&model, &deviations.uncertainty, &estimator),
        });
        let observer = Observer::new(model, gains);
        let references = deviations.uncertainty.references(&model.vehicle, model.sampling_period_s);
        Ok(Self {
            observer,
            armed_range: model.range.shrunk(hysteresis),
            evaluation,
            actuator,
            slowest_actuator: deviations.uncertainty.slowest(&actuator),
            deviations,
            standing: Standing::new(&deviations, &observer, &evaluation, references.distinct),
            references,
            second,
            staleness,
            zero,
            threshold_factor: 1.0,
            debounce_samples: evaluation.debounce_samples,
            alarm_hold_s: evaluation.alarm_hold_s,
            enabled: true,
            initialisation: Initialisation::FirstMeasurement,
            state: State {
                sample: 0,
                z: [0.0; 3],
                tracking: false,
                armed: false,
                rms: Rms::EMPTY,
                start_up: StartUp::RESTARTED,
                responses: Responses::NONE,
                actuator: ActuatorState::START,
                slowest_actuator: ActuatorState::START,
                motions: [ReferenceMotion::default(); MOTIONS],
                followed: 0,
                filter: second.map_or(Filter::NONE, |second| second.kalman.forget()),
                onsets: Onsets::NONE,
                filtered_v_x_m_per_s: 0.0,
                last: Measurement::default(),
                unchanged: 0,
                unanswered: 0,
                exceedances: 0,
                clear: 0,
                output: Output { j_th: evaluation.threshold, ..Output::default() },
            },
        })
    }

    /// Factor on J_th; 1 is the design's threshold.
    pub const fn threshold_factor(&self) -> f64 {
        self.threshold_factor
    }

    /// Sets the factor on J_th, 1e-100 to 1e100: that of the samples to come, and before the first of the
    /// output too.
    ///
    /// # Errors
    /// [`ConfigurationError`] where it is none of these.
    pub fn set_threshold_factor(&mut self, factor: f64) -> Result<(), ConfigurationError> {
        if !measurable(factor) {
            return Err(ConfigurationError { field: "threshold factor" });
        }
        self.threshold_factor = factor;
        if self.state.output.monitor == Monitor::Starting {
            self.state.output.j_th = factor * self.evaluation.threshold;
        }
        Ok(())
    }

    /// Consecutive samples with `J >= J_th` that raise the alarm.
    pub const fn debounce_samples(&self) -> u32 {
        self.debounce_samples
    }

    /// Sets the number of consecutive samples with `J >= J_th` that raise the alarm, at least 1.
    ///
    /// # Errors
    /// [`ConfigurationError`] for none.
    pub const fn set_debounce_samples(&mut self, samples: u32) -> Result<(), ConfigurationError> {
        if samples == 0 {
            return Err(ConfigurationError { field: "debounce" });
        }
        self.debounce_samples = samples;
        Ok(())
    }

    /// Time of monitoring with J below [`RELEASE`] of J_th that ends an alarm, s.
    pub const fn alarm_hold_s(&self) -> f64 {
        self.alarm_hold_s
    }

    /// Sets the time of monitoring with J below [`RELEASE`] of J_th that ends an alarm, s.
    ///
    /// # Errors
    /// [`ConfigurationError`] where it is negative or not finite.
    pub fn set_alarm_hold_s(&mut self, hold_s: f64) -> Result<(), ConfigurationError> {
        if !not_negative(hold_s) {
            return Err(ConfigurationError { field: "alarm hold" });
        }
        self.alarm_hold_s = hold_s;
        Ok(())
    }

    /// Whether the detector is switched on.
    pub const fn enabled(&self) -> bool {
        self.enabled
    }

    /// Switches the detector on or off, from the sample to come on.
    pub const fn set_enabled(&mut self, enabled: bool) {
        self.enabled = enabled;
    }

    /// What the sensors show where there is nothing.
    pub const fn zero(&self) -> Zero {
        self.zero
    }

    /// Sets what the sensors show where there is nothing.
    ///
    /// # Errors
    /// [`ConfigurationError`] for a number that is not finite.
    pub fn set_zero(&mut self, zero: Zero) -> Result<(), ConfigurationError> {
        if !all_finite(&[zero.steering_offset_rad, zero.yaw_rate_bias_rad_per_s]) {
            return Err(ConfigurationError { field: "zero of a sensor" });
        }
        self.zero = zero;
        Ok(())
    }

    /// Time after which measurements that do not change are stale, s; 0 for never.
    pub const fn stale_after_s(&self) -> f64 {
        self.staleness.after_s
    }

    /// Sets the time after which measurements that do not change are stale, s; 0 for never.
    ///
    /// # Errors
    /// [`ConfigurationError`] where it is negative or not finite.
    pub fn set_stale_after_s(&mut self, after_s: f64) -> Result<(), ConfigurationError> {
        if !not_negative(after_s) {
            return Err(ConfigurationError { field: "time until data are stale" });
        }
        self.staleness.after_s = after_s;
        Ok(())
    }

    /// How the observer starts at the first sample.
    pub const fn initialisation(&self) -> Initialisation {
        self.initialisation
    }

    /// Sets how the observer starts at the first sample.
    ///
    /// # Errors
    /// [`ConfigurationError`] for a z_0 that is not finite.
    pub fn set_initialisation(
        &mut self,
        initialisation: Initialisation,
    ) -> Result<(), ConfigurationError> {
        if matches!(initialisation, Initialisation::Given(z_0) if !all_finite(&z_0)) {
            return Err(ConfigurationError { field: "z_0" });
        }
        self.initialisation = initialisation;
        Ok(())
    }

    /// What the samples so far have left.
    pub const fn state(&self) -> &State {
        &self.state
    }

    /// Goes on from `state`, which a detector of the same configuration had.
    ///
    /// # Errors
    /// [`StateError`] where none can have had it; the detector is then as before.
    pub fn set_state(&mut self, state: &State) -> Result<(), StateError> {
        let period_s = self.observer.model.sampling_period_s;
        let window = self.evaluation.window;
        let actuators =
            [(&state.actuator, &self.actuator), (&state.slowest_actuator, &self.slowest_actuator)];
        let responses = &state.responses;
        let windows = [&state.rms, &responses.uncertainty_rms, &responses.fault_rms];
        let output = &state.output;
        let possible = all_finite(&state.z)
            && windows.iter().all(|rms| rms.is_possible(window))
            && state.start_up.samples <= window
            && all_finite(&[state.start_up.power, state.start_up.sum])
            && all_finite(&responses.known)
            && all_finite(responses.along.as_flattened().as_flattened())
            && all_finite(responses.common.as_flattened())
            && all_finite(responses.sensed.as_flattened())
            && all_finite(&responses.fault)
            && state.motions.iter().all(|x| all_finite(&[x.v_y_m_per_s, x.r_rad_per_s]))
            && state.filtered_v_x_m_per_s.is_finite()
            && state.filter.is_possible()
            && state.onsets.is_possible()
            && all_finite(&state.last.vector())
            && output.alarm == (output.alarm_cause != AlarmCause::None)
            && actuators.iter().all(|(state, of)| state.is_possible(of.delay_samples(period_s)))
            && output.is_finite();
        if !possible {
            return Err(StateError);
        }
        self.state = *state;
        Ok(())
    }

    /// Results of the last sample.
    pub const fn output(&self) -> &Output {
        &self.state.output
    }

    /// Runs sample k: measurement `y_k`, and the input `u_k` that acts until sample k + 1.
    ///
    /// ```
    /// # use steerguard_detector::{Detector, Input, Measurement};
    /// fn alarm(detector: &mut Detector, y: Measurement, u: Input) -> bool {
    ///     detector.sample(y, u).alarm
    /// }
    /// ```
    ///
    /// Both are pairs of numbers, but swapped they do not compile:
    ///
    /// ```compile_fail,E0308
    /// # use steerguard_detector::{Detector, Input, Measurement};
    /// fn alarm(detector: &mut Detector, y: Measurement, u: Input) -> bool {
    ///     detector.sample(u, y).alarm
    /// }
    /// ```
    pub fn sample(&mut self, y: Measurement, u: Input) -> &Output {
        let invalid = Signal::invalid(y, u);
        let before = self.state.actuator.command;
        let [delta_rad, slowest_rad] = self.steer(u.delta_rad);
        if let Some(signal) = invalid {
            // Time passes unseen: z and motions are void, the last results stand.
            let state = &mut self.state;
            state.stop_observer();
            state.followed = 0;
            state.unchanged = 0;
            state.unanswered = 0;
            state.output.monitor = Monitor::InvalidInput;
            state.output.state_cause = StateCause::Signal(signal);
        } else {
            let r_rad_per_s = y.r_rad_per_s - self.zero.yaw_rate_bias_rad_per_s;
            let y = Measurement { r_rad_per_s, ..y };
            let u = Input { delta_rad, ..u };
            let stale = self.compare(y, self.state.actuator.command != before);
            let a_x_m_per_s2 = self.follow(y);
            let vehicle = &self.observer.model.vehicle;
            let uncertainty = &self.deviations.uncertainty;
            let loading = uncertainty.loading(vehicle, y.v_x_m_per_s, u.t_eng_n_m, a_x_m_per_s2);
            if self.enabled {
                self.track(y);
                if self.state.tracking {
                    self.observe(y, u, slowest_rad - delta_rad, loading);
                }
                self.decide(y, stale);
                if !self.state.output.is_finite() {
                    self.lose();
                }
            } else {
                self.rest();
            }
            if self.state.followed > 0 {
                self.references.advance(&mut self.state.motions, y, delta_rad, &loading);
            }
        }
        self.state.sample += 1;
        &self.state.output
    }

    /// The angle at the road wheel, the average over this sample, for what the input says of it, and
    /// the same of the slowest actuator. An invalid command leaves the last one standing: the actuator
    /// goes on in any case.
    fn steer(&mut self, shown: f64) -> [f64; 2] {
        let State { actuator, slowest_actuator, .. } = &mut self.state;
        let command = if Signal::SteeringAngle.admits(shown) {
            Some(shown - self.zero.steering_offset_rad)
        } else {
            actuator.command
        };
        let Some(command) = command else {
            return [0.0; 2];
        };
        let period_s = self.observer.model.sampling_period_s;
        let angle = actuator.sample(&self.actuator, period_s, command);
        if self.slowest_actuator == self.actuator {
            [angle; 2]
        } else {
            [angle, slowest_actuator.sample(&self.slowest_actuator, period_s, command)]
        }
    }

    /// Whether measurements are stale at this one. Where they return with a jump, or had left steering
    /// unanswered for as long as makes them stale, the observer starts anew.
    fn compare(&mut self, y: Measurement, steered: bool) -> bool {
        let state = &mut self.state;
        let period_s = self.observer.model.sampling_period_s;
        let stale = |unchanged: u32| {
            self.staleness.after_s > 0.0
                && f64::from(unchanged) * period_s > self.staleness.after_s
                && self.observer.model.range.v_x.contains(y.v_x_m_per_s)
        };
        let same = state.sample > 0
            && y.vector().map(f64::to_bits) == state.last.vector().map(f64::to_bits);
        if same {
            state.unchanged = state.unchanged.saturating_add(1);
            if steered || state.unanswered > 0 {
                state.unanswered = state.unanswered.saturating_add(1);
            }
        } else {
            let jumps = || self.staleness.jumps(state.last, y).iter().any(Option::is_some);
            if stale(state.unchanged) && (stale(state.unanswered) || jumps()) {
                state.stop_observer();
                state.followed = 0;
            }
            state.unchanged = 0;
            state.unanswered = 0;
        }
        state.last = y;
        stale(state.unchanged)
    }

    /// Lets the reference motions begin or go on; returns the longitudinal acceleration, m/s^2.
    fn follow(&mut self, y: Measurement) -> f64 {
        let state = &mut self.state;
        let v_x = y.v_x_m_per_s;
        if !self.observer.model.range.v_x.contains(v_x) {
            state.followed = 0;
            return 0.0;
        }
        if state.followed == 0 {
            let r_rad_per_s = y.r_rad_per_s;
            state.motions = [ReferenceMotion { v_y_m_per_s: 0.0, r_rad_per_s }; MOTIONS];
            state.filtered_v_x_m_per_s = v_x;
        }
        state.followed = state.followed.saturating_add(1);
        let period_s = self.observer.model.sampling_period_s;
        let a_x = (v_x - state.filtered_v_x_m_per_s) / (ACCELERATION_FILTER_S + period_s);
        state.filtered_v_x_m_per_s += period_s * a_x;
        a_x
    }

    /// Stops the observer outside S_x and starts it, armed, inside the armed range.
    fn track(&mut self, y: Measurement) {
        let inside = |range: &OperatingRange| {
            range.v_x.contains(y.v_x_m_per_s) && range.r.contains(y.r_rad_per_s)
        };
        if !inside(&self.observer.model.range) {
            self.state.stop_observer();
        } else if !self.state.armed && inside(&self.armed_range) {
            let v_y_may_arm = self.armed_range.v_y.contains(self.state.output.v_y_hat);
            if !self.state.tracking || v_y_may_arm {
                self.start(y);
            }
        }
    }

    /// Starts the observer at measurement `y` with an empty window.
    fn start(&mut self, y: Measurement) {
        let state = &mut self.state;
        state.z = match self.initialisation {
            Initialisation::Given(z_0) if state.sample == 0 => z_0,
            _ => self.observer.start(y),
        };
        state.tracking = true;
        state.armed = true;
        state.rms = Rms::EMPTY;
        state.start_up = StartUp::RESTARTED;
        state.responses = Responses::NONE;
        // What the filter has learned of road and vehicle stays.
        state.onsets = Onsets::NONE;
    }

    /// Residual and J of this sample, and z of the next.
    fn observe(&mut self, y: Measurement, u: Input, slowest_behind_rad: f64, loading: Loading) {
        let state = &mut self.state;
        let x_hat = self.observer.estimate(state.z, y);
        if !plausible(&x_hat) {
            // phi grows with the square of the estimate: nothing leads back from here.
            state.lose_observer();
            return;
        }
        let h = self.observer.membership(y);
        let n = self.observer.n(&h);
        let l = self.observer.l(&h);
        state.z = self.observer.advance(&n, &l, state.z, y, u, x_hat.v_y_m_per_s);

        let evaluation = &self.evaluation;
        // (10), less what is known to depart from (7): method 6.
        let [v_x, _, r] = state.responses.known;
        let residual = Measurement {
            v_x_m_per_s: y.v_x_m_per_s - x_hat.v_x_m_per_s - v_x,
            r_rad_per_s: y.r_rad_per_s - x_hat.r_rad_per_s - r,
        };
        let Measurement { v_x_m_per_s, r_rad_per_s } = y;
        let v_y_m_per_s = x_hat.v_y_m_per_s;
        let [uncertainty, fault] = state.responses.levels(
            &self.standing,
            &self.deviations,
            &self.observer,
            evaluation,
            v_x_m_per_s,
        );
        let x = VehicleState { v_x_m_per_s, v_y_m_per_s, r_rad_per_s };
        let place = Place { x, u, slowest_behind_rad, loading, motions: state.motions };
        state.responses.advance(&self.standing, &self.deviations, &self.observer, &n, &l, &place);

        if let Some(second) = &self.second {
            let State { filter, onsets, .. } = state;
            second.sample(filter, onsets, y, &place, self.threshold_factor);
        }

        let output = &mut state.output;
        output.residual = residual;
        output.v_y_hat = v_y_m_per_s;
        output.j_rms = state.rms.push(evaluation.square(residual), evaluation.window);
        output.j_th = self.threshold_factor
            * (evaluation.threshold
                + state.start_up.next(evaluation)
                + evaluation.uncertainty_share * uncertainty);
        output.detectability = fault / output.j_th;
        // The bound on rho (15) holds only while the estimate stays in S_x too.
        state.armed &= self.observer.model.range.v_y.contains(v_y_m_per_s);
    }

    /// The results while switched off.
    fn rest(&mut self) {
        let state = &mut self.state;
        state.stop_observer();
        state.exceedances = 0;
        state.clear = 0;
        state.output = Output {
            j_th: self.threshold_factor * self.evaluation.threshold,
            first_alarm: state.output.first_alarm,
            monitor: Monitor::Disabled,
            state_cause: StateCause::NotEnabled,
            ..Output::default()
        };
    }

    /// What keeps the detector from monitoring where it is not armed: what lies outside S_x, or else what
    /// keeps it from arming.
    fn out_of_range(&self, y: Measurement) -> StateCause {
        let v_y_hat = self.state.output.v_y_hat;
        let outside = |range: &OperatingRange| {
            if !range.v_x.contains(y.v_x_m_per_s) {
                StateCause::Signal(Signal::Speed)
            } else if !range.r.contains(y.r_rad_per_s) {
                StateCause::Signal(Signal::YawRate)
            } else if !range.v_y.contains(v_y_hat) {
                StateCause::LateralSpeed
            } else {
                StateCause::None
            }
        };
        match outside(&self.observer.model.range) {
            StateCause::None => outside(&self.armed_range),
            cause => cause,
        }
    }

    /// Whether yaw rate or estimated lateral speed have left S_x although every reference motion, which
    /// knows no fault, stays well inside.
    fn is_astray(&self, y: Measurement) -> bool {
        let range = &self.observer.model.range;
        let State { followed, motions, output, .. } = &self.state;
        let left = !range.r.contains(y.r_rad_per_s) || !range.v_y.contains(output.v_y_hat);
        // A motion that has begun at the measurement must have come to the command's.
        left && *followed > self.evaluation.window as u32
            && motions.iter().all(|motion| {
                self.armed_range.r.contains(motion.r_rad_per_s)
                    && self.armed_range.v_y.contains(motion.v_y_m_per_s)
            })
    }

    /// Nothing is known of this sample; what was found before stands.
    fn clear_output(&mut self) {
        let Output { alarm, alarm_cause, first_alarm, estimate, .. } = self.state.output;
        self.state.output = Output {
            j_th: self.threshold_factor * self.evaluation.threshold,
            alarm,
            alarm_cause,
            first_alarm,
            estimate,
            ..Output::default()
        };
    }

    /// A result is no finite number, which numbers that no vehicle and no design have can make it: everything
    /// starts anew at the next sample, and what is told until then is finite.
    #[cold]
    fn lose(&mut self) {
        self.state.lose_observer();
        self.state.followed = 0;
        self.state.motions = [ReferenceMotion::default(); MOTIONS];
        if let Some(second) = &self.second {
            second.forget(&mut self.state.filter, &mut self.state.onsets);
        }
        self.state.output.estimate = None;
        self.clear_output();
        self.state.output.monitor = Monitor::OutOfRange;
    }

    /// Alarm and condition of this sample.
    fn decide(&mut self, y: Measurement, stale: bool) {
        if !self.state.tracking {
            self.clear_output();
        }
        let astray = !stale && self.is_astray(y);
        let state_cause = if stale {
            StateCause::Unchanged
        } else if self.state.armed {
            StateCause::None
        } else {
            self.out_of_range(y)
        };
        let state = &mut self.state;
        let output = &mut state.output;
        output.state_cause = state_cause;
        output.monitor = if stale {
            output.detectability = 0.0;
            Monitor::StaleInput
        } else if state.armed {
            Monitor::Monitoring
        } else {
            Monitor::OutOfRange
        };
        let monitors = output.monitor == Monitor::Monitoring;
        let exceeds = monitors && output.j_rms >= output.j_th;
        let factor = self.threshold_factor;
        let onsets = &state.onsets;
        let second = self.second.as_ref().filter(|_| monitors).map(|second| &second.test);
        let second_exceeds = second.is_some_and(|test| test.speaks(onsets, factor));
        let second_is_clear = second.is_none_or(|test| test.is_clear(onsets, factor));
        let estimate = second.and_then(|test| test.estimate(onsets, factor, state.sample));
        output.second_ratio = second.map_or(0.0, |test| test.ratio(onsets) / factor);
        // Where nothing can be told the count stands.
        if exceeds || second_exceeds || astray {
            state.exceedances = state.exceedances.saturating_add(1);
        } else if monitors {
            state.exceedances = 0;
        }
        if output.alarm {
            let clear = monitors && output.j_rms < RELEASE * output.j_th && second_is_clear;
            state.clear = if clear { state.clear.saturating_add(1) } else { 0 };
            let period_s = self.observer.model.sampling_period_s;
            if clear && f64::from(state.clear) * period_s >= self.alarm_hold_s {
                output.alarm = false;
                output.alarm_cause = AlarmCause::None;
                if let Some(second) = &self.second {
                    second.forget(&mut state.filter, &mut state.onsets);
                }
            }
        } else if (exceeds || second_exceeds || astray)
            && state.exceedances >= self.debounce_samples
        {
            output.alarm = true;
            output.alarm_cause = if exceeds {
                AlarmCause::Residual
            } else if astray {
                AlarmCause::Range
            } else {
                AlarmCause::SecondTest
            };
            state.clear = 0;
            if output.first_alarm.is_none() {
                output.first_alarm = Some(state.sample);
            }
        }
        output.estimate = if output.alarm { estimate.or(output.estimate) } else { None };
    }
}
