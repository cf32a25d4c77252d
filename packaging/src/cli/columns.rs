//! What is told of the columns of drive files, and what is said of drives that cannot be read.

use std::path::Path;

use steerguard_drives::{ColumnError, Columns, DriveError, Signal};

use super::column_arguments::ColumnArguments;
use super::failure::Failure;
use super::text::read_text;

/// What `arguments` tell: flags before the file.
pub(super) fn told(arguments: &ColumnArguments) -> Result<Columns, Failure> {
    let mut columns = match &arguments.columns {
        Some(path) => of_file(path)?,
        None => Columns::default(),
    };
    let mut tell = || -> Result<(), ColumnError> {
        for (signal, told) in [
            (Signal::Time, &arguments.time),
            (Signal::Speed, &arguments.speed),
            (Signal::YawRate, &arguments.yaw),
            (Signal::Steering, &arguments.steering),
            (Signal::LateralAcceleration, &arguments.lateral_acceleration),
            (Signal::DriveTorque, &arguments.torque),
        ] {
            told.as_ref().map_or(Ok(()), |text| columns.tell(signal, text))?;
        }
        arguments.delay.iter().try_for_each(|text| columns.tell_delay(text))?;
        arguments.delimiter.as_ref().map_or(Ok(()), |text| columns.tell_delimiter(text))?;
        arguments.decimal_mark.as_ref().map_or(Ok(()), |text| columns.tell_decimal_mark(text))
    };
    tell().map_err(Failure::bad)?;
    Ok(columns)
}

/// What the file at `path` tells.
pub(super) fn of_file(path: &Path) -> Result<Columns, Failure> {
    Columns::from_toml(&read_text(path)?).map_err(|error| {
        Failure::bad(error)
            .at(path.display())
            .help("docs/drive-files.md shows a file of columns with every key")
    })
}

/// A drive that cannot be read, with its place and what to do.
pub(super) fn unreadable(error: &DriveError) -> Failure {
    let DriveError { file, line, cause } = error;
    let line = line.map_or(String::new(), |line| format!(":{line}"));
    let failure = Failure::bad(cause).at(format!("{}{line}", file.display()));
    match cause.help() {
        Some(help) => failure.help(help),
        None => failure,
    }
}
