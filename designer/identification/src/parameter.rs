//! The parameters that a drive may show, and what it takes to show them: one table.
//!
//! # Conventions
//! [`Values`] are what the model computes with: logarithms of stiffnesses and yaw inertia, so that they
//! stay positive and a standard error is relative; the ratio's inverse, which a turned axis makes
//! negative; the rest in SI.

use std::ops::{Index, IndexMut};

/// A parameter of the single-track model or of its sensors.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Parameter {
    /// i: angle of the steering sensor over that of the road wheel.
    SteeringRatio,
    /// Road-wheel angle shown while the vehicle drives straight ahead, rad.
    SteeringOffset,
    /// Yaw rate shown at standstill, rad/s.
    YawRateBias,
    /// By how much the road wheel follows the recorded steering, s; negative where the steering is
    /// recorded late.
    Delay,
    /// Time constant of the steering actuator, s.
    Lag,
    /// C_f of one tyre, N/rad.
    FrontStiffness,
    /// C_r of one tyre, N/rad.
    RearStiffness,
    /// I_z, kg m^2.
    YawInertia,
    /// Height of the centre of gravity, m.
    Height,
    /// Lateral acceleration shown at standstill, m/s^2.
    LateralBias,
    /// Lateral acceleration shown over what there is, less 1: a body that rolls shows more.
    LateralScale,
    /// By how much the shown lateral acceleration follows, s: filters of the sensor, and the body's roll.
    LateralDelay,
}

use Parameter::*;

/// How a standard error is read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    /// As a share of the value.
    Relative,
    /// As it is, a share itself.
    Share,
    /// As it is, in degrees.
    Degrees,
    /// As it is, in degrees per second.
    DegreesPerSecond,
    /// As it is, in seconds.
    Seconds,
    /// As it is, in metres.
    Metres,
    /// As it is, in m/s^2.
    MetresPerSecondSquared,
}

impl Parameter {
    /// All of them, in the order of [`Values`].
    pub const ALL: [Self; 12] = [
        SteeringRatio,
        SteeringOffset,
        YawRateBias,
        Delay,
        Lag,
        FrontStiffness,
        RearStiffness,
        YawInertia,
        Height,
        LateralBias,
        LateralScale,
        LateralDelay,
    ];

    /// What people call it.
    pub const fn name(self) -> &'static str {
        match self {
            SteeringRatio => "steering ratio",
            SteeringOffset => "steering offset",
            YawRateBias => "yaw-rate bias",
            Delay => "delay",
            Lag => "actuator lag",
            FrontStiffness => "front cornering stiffness",
            RearStiffness => "rear cornering stiffness",
            YawInertia => "yaw inertia",
            Height => "height of the centre of gravity",
            LateralBias => "lateral-acceleration bias",
            LateralScale => "lateral-acceleration scale",
            LateralDelay => "lateral-acceleration delay",
        }
    }

    /// How its value and standard error are stated.
    pub const fn scale(self) -> Scale {
        match self {
            SteeringRatio | FrontStiffness | RearStiffness | YawInertia => Scale::Relative,
            SteeringOffset => Scale::Degrees,
            YawRateBias => Scale::DegreesPerSecond,
            Delay | Lag => Scale::Seconds,
            Height => Scale::Metres,
            LateralBias => Scale::MetresPerSecondSquared,
            LateralScale => Scale::Share,
            LateralDelay => Scale::Seconds,
        }
    }

    /// Largest standard error, relative or SI as [`Parameter::scale`] says, with which it counts as
    /// shown; none for what a specification can do without.
    pub fn largest_error(self) -> Option<f64> {
        match self {
            SteeringRatio | FrontStiffness | RearStiffness | YawInertia => Some(0.3),
            SteeringOffset | YawRateBias => Some(0.05_f64.to_radians()),
            Delay => Some(0.01),
            Lag | Height | LateralBias | LateralScale | LateralDelay => None,
        }
    }

    /// Largest standard error of a part of the drives with which it has a say of its own.
    pub(crate) fn part_error(self) -> f64 {
        match self {
            SteeringRatio => 0.003,
            Lag | LateralDelay => 0.001,
            Height | LateralBias | LateralScale => 0.01,
            _ => self.largest_error().unwrap_or_default() / 10.0,
        }
    }

    /// How far the single-track model itself may be off with exact data, as a standard error: small
    /// angles, a sample's steps, tyres that are not quite linear.
    pub(crate) fn model_error(self) -> f64 {
        match self {
            // tan of 7 degrees is half a percent more.
            SteeringRatio => 0.005,
            SteeringOffset | YawRateBias => 0.002_f64.to_radians(),
            Delay | Lag | LateralDelay => 0.001,
            FrontStiffness | RearStiffness | YawInertia => 0.005,
            Height => 0.03,
            LateralBias | LateralScale => 0.01,
        }
    }

    /// What would show it.
    pub const fn manoeuvre(self) -> &'static str {
        match self {
            SteeringRatio => "a slow circle: turns at 3 to 8 m/s, half a minute",
            SteeringOffset => {
                "half a minute straight ahead, and a standstill or several speeds beside it"
            }
            YawRateBias => "a standstill of 10 s with the sensors on",
            Delay | Lag => "quick steering: a sweep to 2 Hz or lane changes at 10 to 20 m/s",
            FrontStiffness | RearStiffness => {
                "a sweep or slalom from 0.2 to 2 Hz, to 3 m/s^2, at 15 to 25 m/s"
            }
            YawInertia => "a sweep to 2 Hz at 10 to 20 m/s with the lateral acceleration logged",
            Height => "braking and accelerating in turns",
            LateralBias | LateralScale | LateralDelay => "a standstill on level ground",
        }
    }

    /// The value, in SI, of what the model computes with.
    pub(crate) fn value(self, internal: f64) -> f64 {
        match self {
            SteeringRatio => 1.0 / internal,
            FrontStiffness | RearStiffness | YawInertia => internal.exp(),
            _ => internal,
        }
    }

    /// What the model computes with, of a value in SI.
    pub(crate) fn internal(self, value: f64) -> f64 {
        match self {
            SteeringRatio => 1.0 / value,
            FrontStiffness | RearStiffness | YawInertia => value.ln(),
            _ => value,
        }
    }

    /// The standard error as [`Parameter::scale`] states it, of one of what the model computes with.
    pub(crate) fn error(self, internal: f64, error: f64) -> f64 {
        match self {
            SteeringRatio => error / internal.abs(),
            _ => error,
        }
    }

    /// A change of what the model computes with that is small against its effect.
    pub(crate) const fn step(self) -> f64 {
        match self {
            SteeringRatio => 1e-5,
            SteeringOffset | YawRateBias => 1e-5,
            Delay | Lag | LateralDelay => 1e-3,
            FrontStiffness | RearStiffness | YawInertia | Height | LateralBias | LateralScale => {
                1e-3
            }
        }
    }
}

/// What the model computes with, by parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Values([f64; Parameter::ALL.len()]);

impl Values {
    /// All of them from SI.
    pub(crate) fn of(value: impl Fn(Parameter) -> f64) -> Self {
        Self(Parameter::ALL.map(|parameter| parameter.internal(value(parameter))))
    }

    /// The value of `parameter` in SI.
    pub(crate) fn value(&self, parameter: Parameter) -> f64 {
        parameter.value(self[parameter])
    }
}

impl Index<Parameter> for Values {
    type Output = f64;

    fn index(&self, parameter: Parameter) -> &f64 {
        &self.0[parameter as usize]
    }
}

impl IndexMut<Parameter> for Values {
    fn index_mut(&mut self, parameter: Parameter) -> &mut f64 {
        &mut self.0[parameter as usize]
    }
}
