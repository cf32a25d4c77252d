//! Steerguard.
pub mod gains;
pub mod lmi;
pub mod synthesis;
pub mod theorem4;
