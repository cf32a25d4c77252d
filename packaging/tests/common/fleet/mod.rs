//! The fleet of `tests/fleet/cars.toml`: cars that designs with default keys must serve, and a trial of
//! each by the command `steerguard`, as users run it.

pub mod cars;
pub mod trial;
