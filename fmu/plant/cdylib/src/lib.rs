//! `VehiclePlant`: the shared library inside the FMU. All logic is in `steerguard-plant`.
#![no_std]
#![allow(non_snake_case, reason = "the library is named after the FMU")]

steerguard_fmu_core::reserve_block!(BLOCK);
steerguard_fmi2::export_fmi2!(steerguard_plant::PlantModel, block = &BLOCK);
steerguard_fmu_core::freestanding!();
