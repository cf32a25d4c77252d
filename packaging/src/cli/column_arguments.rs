//! Flags that say what is in the columns of drive files.

use std::path::PathBuf;

use clap::Args;

/// What is told of the columns of drive files.
#[derive(Clone, Debug, Default, Args)]
#[command(
    next_help_heading = "Columns of the drives (NAME:UNIT; a minus before the unit turns the axis)"
)]
pub struct ColumnArguments {
    /// File (TOML) that says what is below for each signal; flags come before it
    #[arg(long, value_name = "FILE")]
    pub columns: Option<PathBuf>,
    /// Time stamp: s, ms, us, ns, or date and clock without a unit
    #[arg(long, value_name = "NAME[:UNIT]")]
    pub time: Option<String>,
    /// Longitudinal speed: m/s, km/h, mph, kn
    #[arg(long, value_name = "NAME[:UNIT]")]
    pub speed: Option<String>,
    /// Yaw rate, left positive: rad/s, deg/s
    #[arg(long, value_name = "NAME[:[-]UNIT]")]
    pub yaw: Option<String>,
    /// Angle of the steering sensor, left positive, at hand wheel or road wheel: rad, deg
    #[arg(long, value_name = "NAME[:[-]UNIT]")]
    pub steering: Option<String>,
    /// Lateral acceleration, left positive: m/s^2, g
    #[arg(long, value_name = "NAME[:[-]UNIT]")]
    pub lateral_acceleration: Option<String>,
    /// Drive torque at the wheels: N m
    #[arg(long, value_name = "NAME[:[-]UNIT]")]
    pub torque: Option<String>,
    /// How late a signal is in the file, s: of speed, yaw, steering, lateral-acceleration, torque
    #[arg(long, value_name = "SIGNAL=S")]
    pub delay: Vec<String>,
    /// Between cells of text: one character, or tab; default: found
    #[arg(long, value_name = "CHARACTER")]
    pub delimiter: Option<String>,
    /// Before decimals of text: . or ,; default: found
    #[arg(long, value_name = "MARK")]
    pub decimal_mark: Option<String>,
}
