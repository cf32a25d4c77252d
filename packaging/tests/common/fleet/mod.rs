//! The fleet of `tests/fleet/cars.toml`: cars that designs with default keys must serve, and a trial of
//! each by the command `steerguard`, as users run it.

#![allow(dead_code, reason = "not everyone needs all")]

pub mod cars;
pub mod trial;
