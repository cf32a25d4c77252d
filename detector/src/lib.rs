#![no_std]
//! Steerguard.
