//! Inquiry, creation, logging, initialisation, modes, termination, reset.

use core::ptr;

use steerguard_fmu_core::foreign::{array, string};
use steerguard_fmu_core::{BakedError, Categories, Guid, Memory, baked};
use steerguard_model_description::LogCategory;

use super::call::{Fmi3, OK, call, enter};
use crate::environment::Environment;
use crate::instance::{Instance, Machine};
use crate::types::*;
use crate::{CallState, Function};

pub unsafe fn fmi3GetVersion<F: Fmi3>() -> fmi3String {
    c"3.0".as_ptr()
}

/// Logs why there is no instance, whatever is enabled: there is none to ask for the reason.
#[cold]
fn refuse_to_instantiate(
    environment: &Environment,
    function: Function,
    reason: &str,
) -> fmi3Instance {
    environment.log().message_anyway(LogCategory::StatusError, |text| {
        text.str(function.name()).str(": ").str(reason);
    });
    ptr::null_mut()
}

pub unsafe fn fmi3InstantiateModelExchange<F: Fmi3>(
    _instance_name: fmi3String,
    _instantiation_token: fmi3String,
    _resource_path: fmi3String,
    _visible: fmi3Boolean,
    _logging_on: fmi3Boolean,
    instance_environment: fmi3InstanceEnvironment,
    log_message: Option<fmi3LogMessageCallback>,
) -> fmi3Instance {
    let environment =
        Environment { log_message, instance_environment, categories: Categories::NONE };
    let reason = "this FMU is for Co-Simulation, not for Model Exchange";
    refuse_to_instantiate(&environment, Function::fmi3InstantiateModelExchange, reason)
}

pub unsafe fn fmi3InstantiateScheduledExecution<F: Fmi3>(
    _instance_name: fmi3String,
    _instantiation_token: fmi3String,
    _resource_path: fmi3String,
    _visible: fmi3Boolean,
    _logging_on: fmi3Boolean,
    instance_environment: fmi3InstanceEnvironment,
    log_message: Option<fmi3LogMessageCallback>,
    _clock_update: Option<fmi3ClockUpdateCallback>,
    _lock_preemption: Option<fmi3LockPreemptionCallback>,
    _unlock_preemption: Option<fmi3UnlockPreemptionCallback>,
) -> fmi3Instance {
    let environment =
        Environment { log_message, instance_environment, categories: Categories::NONE };
    let reason = "this FMU is for Co-Simulation, not for Scheduled Execution";
    refuse_to_instantiate(&environment, Function::fmi3InstantiateScheduledExecution, reason)
}

pub unsafe fn fmi3InstantiateCoSimulation<F: Fmi3>(
    instance_name: fmi3String,
    instantiation_token: fmi3String,
    _resource_path: fmi3String,
    _visible: fmi3Boolean,
    logging_on: fmi3Boolean,
    event_mode_used: fmi3Boolean,
    early_return_allowed: fmi3Boolean,
    _required_intermediate_variables: *const fmi3ValueReference,
    n_required_intermediate_variables: usize,
    instance_environment: fmi3InstanceEnvironment,
    log_message: Option<fmi3LogMessageCallback>,
    _intermediate_update: Option<fmi3IntermediateUpdateCallback>,
) -> fmi3Instance {
    // SAFETY: the contract of this module.
    let (name, token) = unsafe {
        (string(instance_name).unwrap_or(c""), string(instantiation_token).unwrap_or(c""))
    };
    let environment =
        Environment { log_message, instance_environment, categories: Categories::NONE };
    let prepare = || {
        if name.is_empty() {
            return Err("the instance name is NULL or empty");
        }
        if n_required_intermediate_variables > 0 {
            return Err("no variable can be accessed within a step: see the capability flags");
        }
        let block = F::block().load();
        let baked = baked::open(&block).map_err(BakedError::description)?;
        if token.to_bytes() != baked.guid.as_bytes() {
            return Err(
                "the instantiation token is not the one baked into this library: binary and \
                        description come from different FMUs",
            );
        }
        let machine = Machine::<F::Model>::fresh(baked.payload)?;
        let memory = Memory::C.allocate::<Instance<F::Model>>();
        let memory = memory.ok_or("out of memory")?;
        Ok((memory, machine, Guid::new(baked.guid)))
    };
    match prepare() {
        Ok((memory, machine, token)) => {
            let logging_on = logging_on != fmi3False;
            let mut instance = Instance {
                environment,
                logging_on,
                event_mode_used: event_mode_used != fmi3False,
                early_return_allowed: early_return_allowed != fmi3False,
                token,
                machine,
            };
            instance.set_logging(logging_on, core::iter::empty());
            // SAFETY: the memory is of this size and alignment and ours alone.
            unsafe { memory.write(instance) };
            memory.as_ptr().cast()
        }
        Err(reason) => {
            refuse_to_instantiate(&environment, Function::fmi3InstantiateCoSimulation, reason)
        }
    }
}

pub unsafe fn fmi3FreeInstance<F: Fmi3>(instance: fmi3Instance) {
    // SAFETY: the contract of this module.
    if unsafe { enter::<F>(instance, Function::fmi3FreeInstance) }.is_ok() {
        // SAFETY: the instance was allocated from this memory and, by the contract of this module,
        // is not used any more. It owns nothing that would have to be dropped.
        unsafe { Memory::C.release(instance) };
    }
}

pub unsafe fn fmi3SetDebugLogging<F: Fmi3>(
    instance: fmi3Instance,
    logging_on: fmi3Boolean,
    n_categories: usize,
    categories: *const fmi3String,
) -> fmi3Status {
    // SAFETY: the contract of this module.
    unsafe {
        call::<F>(instance, Function::fmi3SetDebugLogging, |instance, function| {
            let names = array(categories, n_categories)
                .filter(|names| names.iter().all(|name| !name.is_null()))
                .ok_or_else(|| instance.null(function, "categories"))?;
            let names = names.iter().filter_map(|&name| string(name));
            Ok(instance.set_logging(logging_on != fmi3False, names))
        })
    }
}

pub unsafe fn fmi3EnterInitializationMode<F: Fmi3>(
    instance: fmi3Instance,
    _tolerance_defined: fmi3Boolean,
    _tolerance: fmi3Float64,
    start_time: fmi3Float64,
    stop_time_defined: fmi3Boolean,
    stop_time: fmi3Float64,
) -> fmi3Status {
    let stop_time = (stop_time_defined != fmi3False).then_some(stop_time);
    // SAFETY: the contract of this module.
    unsafe {
        call::<F>(instance, Function::fmi3EnterInitializationMode, |instance, _| {
            Ok(instance.set_up(start_time, stop_time))
        })
    }
}

pub unsafe fn fmi3ExitInitializationMode<F: Fmi3>(instance: fmi3Instance) -> fmi3Status {
    // SAFETY: the contract of this module.
    unsafe {
        call::<F>(instance, Function::fmi3ExitInitializationMode, |instance, _| {
            Ok(instance.initialise())
        })
    }
}

pub unsafe fn fmi3EnterEventMode<F: Fmi3>(instance: fmi3Instance) -> fmi3Status {
    // SAFETY: the contract of this module.
    unsafe {
        call::<F>(instance, Function::fmi3EnterEventMode, |instance, _| {
            Ok(instance.enter_event_mode())
        })
    }
}

pub unsafe fn fmi3EnterStepMode<F: Fmi3>(instance: fmi3Instance) -> fmi3Status {
    // SAFETY: the contract of this module.
    unsafe {
        call::<F>(instance, Function::fmi3EnterStepMode, |instance, _| {
            instance.machine.state = CallState::StepMode;
            instance.machine.tick.active = false;
            Ok(OK)
        })
    }
}

pub unsafe fn fmi3Terminate<F: Fmi3>(instance: fmi3Instance) -> fmi3Status {
    // SAFETY: the contract of this module.
    unsafe {
        call::<F>(instance, Function::fmi3Terminate, |instance, _| {
            instance.machine.state = CallState::Terminated;
            instance.machine.tick.active = false;
            Ok(OK)
        })
    }
}

pub unsafe fn fmi3Reset<F: Fmi3>(instance: fmi3Instance) -> fmi3Status {
    // SAFETY: the contract of this module.
    unsafe {
        call::<F>(instance, Function::fmi3Reset, |instance, function| {
            let block = F::block().load();
            instance.machine = baked::open(&block)
                .map_err(BakedError::description)
                .and_then(|baked| Machine::fresh(baked.payload))
                .map_err(|reason| instance.refuse_because(function, reason))?;
            instance.set_logging(instance.logging_on, core::iter::empty());
            Ok(OK)
        })
    }
}
