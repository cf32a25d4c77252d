//! Inquiry, creation, logging, initialisation, termination, reset.

use core::ptr;

use steerguard_fmu_core::foreign::{array, string};
use steerguard_fmu_core::{BakedError, Fmu, Guid, baked};
use steerguard_model_description::LogCategory;

use super::call::{OK, call, enter};
use crate::environment::Environment;
use crate::instance::{Instance, Machine};
use crate::types::*;
use crate::{CallState, Function};

pub unsafe fn fmi2GetTypesPlatform<F: Fmu>() -> fmi2String {
    c"default".as_ptr()
}

pub unsafe fn fmi2GetVersion<F: Fmu>() -> fmi2String {
    c"2.0".as_ptr()
}

const NO_CALLBACKS: fmi2CallbackFunctions = fmi2CallbackFunctions {
    logger: None,
    allocateMemory: None,
    freeMemory: None,
    stepFinished: None,
    componentEnvironment: ptr::null_mut(),
};

pub unsafe fn fmi2Instantiate<F: Fmu>(
    instance_name: fmi2String,
    fmu_type: fmi2Type,
    guid: fmi2String,
    _resource_location: fmi2String,
    functions: *const fmi2CallbackFunctions,
    _visible: fmi2Boolean,
    logging_on: fmi2Boolean,
) -> fmi2Component {
    // SAFETY: the contract of this module.
    let (callbacks, name, guid) = unsafe {
        let callbacks = functions.as_ref().copied().unwrap_or(NO_CALLBACKS);
        (callbacks, string(instance_name).unwrap_or(c""), string(guid).unwrap_or(c""))
    };
    let environment = Environment::new(callbacks, name);
    let prepare = || {
        if name.is_empty() {
            return Err("the instance name is NULL or empty");
        }
        if fmu_type != fmi2CoSimulation {
            return Err("this FMU is for Co-Simulation, not for Model Exchange");
        }
        let block = F::block().load();
        let baked = baked::open(&block).map_err(BakedError::description)?;
        if guid.to_bytes() != baked.guid.as_bytes() {
            return Err("the GUID is not the one baked into this library: binary and description \
                        come from different FMUs");
        }
        let machine = Machine::<F::Model>::fresh(baked.payload)?;
        let memory = environment.memory().allocate::<Instance<F::Model>>();
        let memory = memory.ok_or("out of memory")?;
        Ok((memory, machine, Guid::new(baked.guid)))
    };
    match prepare() {
        Ok((memory, machine, guid)) => {
            let logging_on = logging_on != fmi2False;
            let mut instance = Instance { environment, logging_on, guid, machine };
            instance.set_logging(logging_on, core::iter::empty());
            // SAFETY: the memory is of this size and alignment and ours alone.
            unsafe { memory.write(instance) };
            memory.as_ptr().cast()
        }
        Err(reason) => {
            // There is no instance to ask for the reason: it is logged whatever is enabled.
            environment.log().message_anyway(LogCategory::StatusError, |text| {
                text.str("fmi2Instantiate: ").str(reason);
            });
            ptr::null_mut()
        }
    }
}

pub unsafe fn fmi2FreeInstance<F: Fmu>(c: fmi2Component) {
    // SAFETY: the contract of this module.
    let Ok(instance) = (unsafe { enter::<F>(c, Function::fmi2FreeInstance) }) else { return };
    let memory = instance.environment.memory();
    // SAFETY: the instance was allocated from this memory and, by the contract of this module,
    // is not used any more. It owns nothing that would have to be dropped.
    unsafe { memory.release(c) };
}

pub unsafe fn fmi2SetDebugLogging<F: Fmu>(
    c: fmi2Component,
    logging_on: fmi2Boolean,
    n_categories: usize,
    categories: *const fmi2String,
) -> fmi2Status {
    // SAFETY: the contract of this module.
    unsafe {
        call::<F>(c, Function::fmi2SetDebugLogging, |instance, function| {
            let names = array(categories, n_categories)
                .filter(|names| names.iter().all(|name| !name.is_null()))
                .ok_or_else(|| instance.null(function, "categories"))?;
            let names = names.iter().filter_map(|&name| string(name));
            Ok(instance.set_logging(logging_on != fmi2False, names))
        })
    }
}

pub unsafe fn fmi2SetupExperiment<F: Fmu>(
    c: fmi2Component,
    _tolerance_defined: fmi2Boolean,
    _tolerance: fmi2Real,
    start_time: fmi2Real,
    stop_time_defined: fmi2Boolean,
    stop_time: fmi2Real,
) -> fmi2Status {
    let stop_time = (stop_time_defined != fmi2False).then_some(stop_time);
    // SAFETY: the contract of this module.
    unsafe {
        call::<F>(c, Function::fmi2SetupExperiment, |instance, _| {
            Ok(instance.set_up(start_time, stop_time))
        })
    }
}

pub unsafe fn fmi2EnterInitializationMode<F: Fmu>(c: fmi2Component) -> fmi2Status {
    // SAFETY: the contract of this module.
    unsafe {
        call::<F>(c, Function::fmi2EnterInitializationMode, |instance, _| {
            instance.machine.state = CallState::InitializationMode;
            Ok(OK)
        })
    }
}

pub unsafe fn fmi2ExitInitializationMode<F: Fmu>(c: fmi2Component) -> fmi2Status {
    // SAFETY: the contract of this module.
    unsafe {
        call::<F>(c, Function::fmi2ExitInitializationMode, |instance, _| Ok(instance.initialise()))
    }
}

pub unsafe fn fmi2Terminate<F: Fmu>(c: fmi2Component) -> fmi2Status {
    // SAFETY: the contract of this module.
    unsafe {
        call::<F>(c, Function::fmi2Terminate, |instance, _| {
            instance.machine.state = CallState::Terminated;
            Ok(OK)
        })
    }
}

pub unsafe fn fmi2Reset<F: Fmu>(c: fmi2Component) -> fmi2Status {
    // SAFETY: the contract of this module.
    unsafe {
        call::<F>(c, Function::fmi2Reset, |instance, function| {
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
