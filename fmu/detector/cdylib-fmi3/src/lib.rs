//! `SteeringFaultDetector`: the shared library inside the FMU of FMI 3.0. All logic is in `steerguard-fmu`.
#![no_std]
#![allow(non_snake_case, reason = "the library is named after the FMU")]

steerguard_fmu_core::reserve_block!(BLOCK);
steerguard_fmi3::export_fmi3!(steerguard_fmu::DetectorModel, block = &BLOCK);
steerguard_fmu_core::freestanding!();
