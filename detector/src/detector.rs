//! The detector: observer, evaluation and decision, armed only where its guarantee holds.

use crate::algebra::all_finite;
use crate::deviation::Standing;
use crate::{
    Actuator, ActuatorState, Configuration, ConfigurationError, Deviations, Evaluation, Input,
    Measurement, Observer, OperatingRange, Place, Responses, Rms, StartUp, StateVector,
    VehicleState,
};

/// Inputs and measurements of this magnitude and more count as invalid, in SI units, and an estimate
/// of this magnitude as lost: a sample that starts below it cannot overflow.
pub const LARGEST_MAGNITUDE: f64 = 1e9;

/// Whether all `values` are finite and below [`LARGEST_MAGNITUDE`].
fn plausible(values: &[f64]) -> bool {
    values.iter().all(|x| -LARGEST_MAGNITUDE < *x && *x < LARGEST_MAGNITUDE)
}

/// Which condition holds at the last sample.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Monitor {
    /// No sample yet.
    #[default]
    Starting,
    /// Residual, J and alarm are valid.
    Monitoring,
    /// The measurement or the estimated lateral speed lies outside S_x: the alarm is withheld.
    OutOfRange,
    /// A measurement or input is not finite or larger than [`LARGEST_MAGNITUDE`]: the other outputs
    /// keep their last values, and the observer starts anew at the next valid sample.
    InvalidInput,
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
    /// Whether a fault is detected at this sample.
    pub alarm: bool,
    /// Which condition holds.
    pub monitor: Monitor,
    /// Index of the sample that raised the first alarm.
    pub first_alarm: Option<u64>,
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
    /// Consecutive samples with `J >= J_th`.
    pub exceedances: u32,
    /// Results of the last sample.
    pub output: Output,
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
    threshold_factor: f64,
    debounce_samples: u32,
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
        let Configuration { model, hysteresis, gains, evaluation, actuator, deviations } =
            *configuration;
        let observer = Observer::new(model, gains);
        Ok(Self {
            observer,
            armed_range: model.range.shrunk(hysteresis),
            evaluation,
            actuator,
            slowest_actuator: deviations.uncertainty.slowest(&actuator),
            deviations,
            standing: Standing::new(&deviations, &observer, &evaluation),
            threshold_factor: 1.0,
            debounce_samples: evaluation.debounce_samples,
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
                exceedances: 0,
                output: Output { j_th: evaluation.threshold, ..Output::default() },
            },
        })
    }

    /// Factor on J_th; 1 is the design's threshold.
    pub const fn threshold_factor(&self) -> f64 {
        self.threshold_factor
    }

    /// Sets the factor on J_th, positive: that of the samples to come, and before the first of the
    /// output too.
    ///
    /// # Errors
    /// [`ConfigurationError`] where it is not finite or not positive.
    pub fn set_threshold_factor(&mut self, factor: f64) -> Result<(), ConfigurationError> {
        if !(factor > 0.0 && factor.is_finite()) {
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
        let Measurement { v_x_m_per_s, r_rad_per_s } = output.residual;
        let possible = all_finite(&state.z)
            && windows.iter().all(|rms| rms.is_possible(window))
            && state.start_up.samples <= window
            && all_finite(&[state.start_up.power, state.start_up.sum])
            && all_finite(&responses.remainder)
            && all_finite(responses.uncertainties.as_flattened())
            && all_finite(&responses.fault)
            && actuators.iter().all(|(state, of)| state.is_possible(of.delay_samples(period_s)))
            && all_finite(&[
                v_x_m_per_s,
                r_rad_per_s,
                output.v_y_hat,
                output.j_rms,
                output.detectability,
            ])
            && all_finite(&[output.j_th])
            && output.j_th > 0.0;
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
        let [delta_rad, slowest_rad] = self.steer(u.delta_rad);
        if plausible(&y.vector()) && plausible(&u.vector()) {
            self.track(y);
            if self.state.tracking {
                self.observe(y, Input { delta_rad, ..u }, slowest_rad - delta_rad);
            }
            self.decide();
        } else {
            // Time passes unseen: z is void, the last results stand.
            self.state.tracking = false;
            self.state.armed = false;
            self.state.output.monitor = Monitor::InvalidInput;
        }
        self.state.sample += 1;
        &self.state.output
    }

    /// The angle at the road wheel, the average over this sample, for what the input says of it, and
    /// the same of the slowest actuator. An invalid command leaves the last one standing: the actuator
    /// goes on in any case.
    fn steer(&mut self, command: f64) -> [f64; 2] {
        let State { actuator, slowest_actuator, .. } = &mut self.state;
        let valid = if plausible(&[command]) { Some(command) } else { actuator.command };
        let Some(command) = valid else {
            return [command; 2];
        };
        let period_s = self.observer.model.sampling_period_s;
        let angle = actuator.sample(&self.actuator, period_s, command);
        if self.slowest_actuator == self.actuator {
            [angle; 2]
        } else {
            [angle, slowest_actuator.sample(&self.slowest_actuator, period_s, command)]
        }
    }

    /// Stops the observer outside S_x and starts it, armed, inside the armed range.
    fn track(&mut self, y: Measurement) {
        let inside = |range: &OperatingRange| {
            range.v_x.contains(y.v_x_m_per_s) && range.r.contains(y.r_rad_per_s)
        };
        if !inside(&self.observer.model.range) {
            self.state.tracking = false;
            self.state.armed = false;
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
        state.exceedances = 0;
    }

    /// Residual and J of this sample, and z of the next.
    fn observe(&mut self, y: Measurement, u: Input, slowest_behind_rad: f64) {
        let state = &mut self.state;
        let x_hat = self.observer.estimate(state.z, y);
        if !plausible(&x_hat.vector()) {
            // phi grows with the square of the estimate: nothing leads back from here.
            state.tracking = false;
            state.armed = false;
            return;
        }
        let h = self.observer.membership(y);
        let n = self.observer.n(&h);
        state.z = self.observer.advance(&h, &n, state.z, y, u, x_hat.v_y_m_per_s);

        let evaluation = &self.evaluation;
        // (10), less what Euler's remainder makes of it: method 6.
        let [v_x, _, r] = state.responses.remainder;
        let residual = Measurement {
            v_x_m_per_s: y.v_x_m_per_s - x_hat.v_x_m_per_s - v_x,
            r_rad_per_s: y.r_rad_per_s - x_hat.r_rad_per_s - r,
        };
        let [uncertainty, fault] = state.responses.levels(&self.standing, evaluation);
        let Measurement { v_x_m_per_s, r_rad_per_s } = y;
        let v_y_m_per_s = x_hat.v_y_m_per_s;
        let x = VehicleState { v_x_m_per_s, v_y_m_per_s, r_rad_per_s };
        let place = Place { x, u, slowest_behind_rad };
        state.responses.advance(&self.standing, &self.deviations, &self.observer, &n, &place);

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

    /// Alarm and condition of this sample.
    fn decide(&mut self) {
        let state = &mut self.state;
        let output = &mut state.output;
        if !state.tracking {
            *output = Output {
                j_th: self.threshold_factor * self.evaluation.threshold,
                first_alarm: output.first_alarm,
                ..Output::default()
            };
        }
        let exceeds = state.armed && output.j_rms >= output.j_th;
        state.exceedances = if exceeds { state.exceedances.saturating_add(1) } else { 0 };
        output.alarm = exceeds && state.exceedances >= self.debounce_samples;
        output.monitor = if state.armed { Monitor::Monitoring } else { Monitor::OutOfRange };
        if output.alarm && output.first_alarm.is_none() {
            output.first_alarm = Some(state.sample);
        }
    }
}
