//! Steps and events.

use steerguard_fmu_core::foreign::{array, array_mut, place};
use steerguard_model_description::structure::Entry;

use super::call::{Fmi3, OK, call};
use crate::Function;
use crate::types::*;

pub unsafe fn fmi3DoStep<F: Fmi3>(
    instance: fmi3Instance,
    current_communication_point: fmi3Float64,
    communication_step_size: fmi3Float64,
    _no_set_fmu_state_prior_to_current_point: fmi3Boolean,
    event_handling_needed: *mut fmi3Boolean,
    terminate_simulation: *mut fmi3Boolean,
    early_return: *mut fmi3Boolean,
    last_successful_time: *mut fmi3Float64,
) -> fmi3Status {
    // SAFETY: the contract of this module.
    unsafe {
        call::<F>(instance, Function::fmi3DoStep, |instance, function| {
            let event_handling_needed = place(event_handling_needed)
                .ok_or_else(|| instance.null(function, "eventHandlingNeeded"))?;
            let terminate_simulation = place(terminate_simulation)
                .ok_or_else(|| instance.null(function, "terminateSimulation"))?;
            let early_return =
                place(early_return).ok_or_else(|| instance.null(function, "earlyReturn"))?;
            let last_successful_time = place(last_successful_time)
                .ok_or_else(|| instance.null(function, "lastSuccessfulTime"))?;
            let stepped = instance.do_step(current_communication_point, communication_step_size)?;
            event_handling_needed.write(stepped.event_handling_needed.into());
            // A model never asks for the end of the run.
            terminate_simulation.write(fmi3False);
            early_return.write(stepped.early_return.into());
            last_successful_time.write(stepped.last_successful_time_s);
            Ok(stepped.status)
        })
    }
}

pub unsafe fn fmi3UpdateDiscreteStates<F: Fmi3>(
    instance: fmi3Instance,
    discrete_states_need_update: *mut fmi3Boolean,
    terminate_simulation: *mut fmi3Boolean,
    nominals_of_continuous_states_changed: *mut fmi3Boolean,
    values_of_continuous_states_changed: *mut fmi3Boolean,
    next_event_time_defined: *mut fmi3Boolean,
    next_event_time: *mut fmi3Float64,
) -> fmi3Status {
    // SAFETY: the contract of this module.
    unsafe {
        call::<F>(instance, Function::fmi3UpdateDiscreteStates, |instance, function| {
            let flags = [
                (discrete_states_need_update, "discreteStatesNeedUpdate"),
                (terminate_simulation, "terminateSimulation"),
                (nominals_of_continuous_states_changed, "nominalsOfContinuousStatesChanged"),
                (values_of_continuous_states_changed, "valuesOfContinuousStatesChanged"),
                (next_event_time_defined, "nextEventTimeDefined"),
            ];
            for (flag, name) in flags {
                place(flag).ok_or_else(|| instance.null(function, name))?;
            }
            let next_event_time =
                place(next_event_time).ok_or_else(|| instance.null(function, "nextEventTime"))?;
            for (flag, _) in flags {
                if let Some(flag) = place(flag) {
                    flag.write(fmi3False);
                }
            }
            next_event_time.write(0.0);
            // The event is over; what the model says was settled in the sample.
            instance.machine.tick.active = false;
            Ok(OK)
        })
    }
}

pub unsafe fn fmi3GetClock<F: Fmi3>(
    instance: fmi3Instance,
    value_references: *const fmi3ValueReference,
    n_value_references: usize,
    values: *mut fmi3Clock,
) -> fmi3Status {
    // SAFETY: the contract of this module.
    unsafe {
        call::<F>(instance, Function::fmi3GetClock, |instance, function| {
            let vr = array(value_references, n_value_references)
                .ok_or_else(|| instance.null(function, "valueReferences"))?;
            let values = array_mut(values, n_value_references)
                .ok_or_else(|| instance.null(function, "values"))?;
            for (&vr, value) in vr.iter().zip(values) {
                if instance.find(function, vr)? != Entry::Clock {
                    return Err(instance.refuse(function, |text| {
                        text.str("value reference ").integer(vr.into()).str(" is of no clock");
                    }));
                }
                value.write(instance.machine.tick.active.into());
            }
            Ok(OK)
        })
    }
}
