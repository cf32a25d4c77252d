//! What is told, and what drives show.

use std::collections::BTreeMap;

use crate::model::Chassis;
use crate::parameter::Parameter;

/// What is known before.
#[derive(Clone, Debug, PartialEq)]
pub struct Told {
    /// Mass and axle distances.
    pub chassis: Chassis,
    /// Any other parameter, in SI.
    pub values: BTreeMap<Parameter, f64>,
}

/// Where a value comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Origin {
    /// Fitted to the drives.
    Identified,
    /// It was told.
    Told,
    /// The drives cannot show it, or do not; a specification can do without.
    Assumed,
    /// Fitted together with another that the drives do not part from it.
    Pair,
}

/// A parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// Which.
    pub parameter: Parameter,
    /// Its value in SI.
    pub value: f64,
    /// Where it comes from.
    pub origin: Origin,
    /// Standard error, relative or SI as [`Parameter::scale`] says; 0 unless fitted.
    pub standard_error: f64,
    /// By how much it changes beyond its standard error where only parts of the drives are asked, in
    /// the same unit.
    pub misfit: f64,
}

impl Estimate {
    /// Half the interval that the truth is taken to be in: two standard errors and the misfit.
    pub fn interval(&self) -> f64 {
        2.0 * self.standard_error + self.misfit
    }
}

/// A piece of a drive beside its fit.
#[derive(Clone, Debug, PartialEq)]
pub struct Trace {
    /// Time of the first sample, s.
    pub start_s: f64,
    /// Period, s.
    pub period_s: f64,
    /// Measured yaw rate, rad/s.
    pub yaw_rate: Vec<f64>,
    /// Yaw rate of the model, with the sensor's bias, rad/s.
    pub fitted: Vec<f64>,
    /// Whether the sample was compared.
    pub compared: Vec<bool>,
}

/// What is made of the lateral acceleration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Lateral {
    /// It is not logged.
    NotLogged,
    /// The model explains it down to the sensor's noise: it shows the yaw inertia.
    Used {
        /// Standard deviation of what is left over of it, smoothed, m/s^2.
        left_over: f64,
    },
    /// More is left over than the sensor's noise: the body rolls, or the road is banked. It is not used, and
    /// the yaw inertia is a guess.
    Unexplained {
        /// Standard deviation of what is left over of it, smoothed, m/s^2.
        left_over: f64,
        /// What noise would leave over, m/s^2.
        noise: f64,
    },
}

/// What the drives show.
#[derive(Clone, Debug)]
pub struct Identified {
    /// All parameters that matter: without lateral acceleration, its bias does not.
    pub estimates: Vec<Estimate>,
    /// Correlations of the fitted parameters.
    pub correlations: Vec<(Parameter, Parameter, f64)>,
    /// Standard deviation of what the fit leaves of the yaw rate, rad/s.
    pub yaw_rate_left_over: f64,
    /// What is made of the lateral acceleration.
    pub lateral_acceleration: Lateral,
    /// Autocorrelation of what is left of the yaw rate after 0.1 s: 0 of white noise.
    pub autocorrelation: f64,
    /// Time compared, s.
    pub compared_s: f64,
    /// Time driven, s.
    pub driven_s: f64,
    /// Speeds compared, m/s.
    pub speeds_m_per_s: [f64; 2],
    /// Measured and fitted.
    pub traces: Vec<Trace>,
}

impl Identified {
    /// The estimate of `parameter`.
    pub fn estimate(&self, parameter: Parameter) -> Option<&Estimate> {
        self.estimates.iter().find(|estimate| estimate.parameter == parameter)
    }
}

/// A parameter that the drives do not show.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Refused {
    /// Which.
    pub parameter: Parameter,
    /// Its standard error, relative or SI; infinite where the drives say nothing of it.
    pub standard_error: f64,
}
