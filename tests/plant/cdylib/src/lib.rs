//! Steerguard.
