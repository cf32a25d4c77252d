//! The signals of a drive, and what a caller wants of them.

use std::fmt;

use crate::unit::Quantity;

/// A signal of a drive.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Signal {
    /// Time stamp.
    Time,
    /// Longitudinal speed.
    Speed,
    /// Yaw rate.
    YawRate,
    /// Angle of the steering sensor.
    Steering,
    /// Lateral acceleration.
    LateralAcceleration,
    /// Drive torque at the wheels.
    DriveTorque,
}

impl Signal {
    /// All, in the order of their values in a row.
    pub const ALL: [Self; 6] = [
        Self::Time,
        Self::Speed,
        Self::YawRate,
        Self::Steering,
        Self::LateralAcceleration,
        Self::DriveTorque,
    ];

    /// All but the time, in the same order.
    pub const MEASURED: [Self; 5] =
        [Self::Speed, Self::YawRate, Self::Steering, Self::LateralAcceleration, Self::DriveTorque];

    /// Its place in [`Self::ALL`].
    pub const fn index(self) -> usize {
        self as usize
    }

    /// What it measures.
    pub const fn quantity(self) -> Quantity {
        match self {
            Self::Time => Quantity::Time,
            Self::Speed => Quantity::Speed,
            Self::YawRate => Quantity::AngularRate,
            Self::Steering => Quantity::Angle,
            Self::LateralAcceleration => Quantity::Acceleration,
            Self::DriveTorque => Quantity::Torque,
        }
    }

    /// The flag that names its column, without dashes.
    pub const fn flag(self) -> &'static str {
        match self {
            Self::Time => "time",
            Self::Speed => "speed",
            Self::YawRate => "yaw",
            Self::Steering => "steering",
            Self::LateralAcceleration => "lateral-acceleration",
            Self::DriveTorque => "torque",
        }
    }

    /// Whether no drive can do without it.
    pub const fn is_needed(self) -> bool {
        !matches!(self, Self::LateralAcceleration | Self::DriveTorque)
    }
}

impl fmt::Display for Signal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Time => "time",
            Self::Speed => "speed",
            Self::YawRate => "yaw rate",
            Self::Steering => "steering",
            Self::LateralAcceleration => "lateral acceleration",
            Self::DriveTorque => "drive torque",
        })
    }
}

/// Which signals beside time, speed, yaw rate and steering are taken where a file has them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Wanted {
    /// The lateral acceleration.
    pub lateral_acceleration: bool,
    /// The drive torque.
    pub drive_torque: bool,
}

impl Wanted {
    /// Everything.
    pub const ALL: Self = Self { lateral_acceleration: true, drive_torque: true };

    /// Whether `signal` is taken.
    pub const fn takes(self, signal: Signal) -> bool {
        match signal {
            Signal::LateralAcceleration => self.lateral_acceleration,
            Signal::DriveTorque => self.drive_torque,
            _ => true,
        }
    }
}
