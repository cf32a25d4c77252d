//! What an instance knows of the importer.

use core::ffi::CStr;

use steerguard_fmu_core::{Categories, Log, Logger, Memory, Text};
use steerguard_model_description::LogCategory;

use crate::types::{
    fmi2CallbackFunctions, fmi2ComponentEnvironment, fmi2Status, fmi2StepFinished, fmi2String,
};

/// Longest instance name, bytes; longer ones are shortened in messages.
const NAME_CAPACITY: usize = 255;

/// Callbacks and name, both copied, and the log categories that are enabled.
pub(crate) struct Environment {
    callbacks: fmi2CallbackFunctions,
    name: [u8; NAME_CAPACITY + 1],
    pub(crate) categories: Categories,
}

impl Environment {
    pub(crate) fn new(callbacks: fmi2CallbackFunctions, name: &CStr) -> Self {
        let mut copy = [0; NAME_CAPACITY + 1];
        for (place, &byte) in copy.iter_mut().take(NAME_CAPACITY).zip(name.to_bytes()) {
            *place = byte;
        }
        Self { callbacks, name: copy, categories: Categories::NONE }
    }

    /// The importer's memory.
    pub(crate) fn memory(&self) -> Memory {
        let fmi2CallbackFunctions { allocateMemory, freeMemory, .. } = self.callbacks;
        // SAFETY: the importer gave the functions for this use, and they live as long as the instance.
        unsafe { Memory::of_importer(allocateMemory, freeMemory) }
    }

    /// What the importer wants to have called after a completed step, and with what.
    pub(crate) fn step_finished(&self) -> Option<(fmi2StepFinished, fmi2ComponentEnvironment)> {
        let fmi2CallbackFunctions { stepFinished, componentEnvironment, .. } = self.callbacks;
        stepFinished.map(|tell| (tell, componentEnvironment))
    }

    /// The importer's log.
    pub(crate) fn log(&self) -> Log<'_> {
        Log::new(self)
    }
}

impl Logger for Environment {
    fn categories(&self) -> Categories {
        self.categories
    }

    fn send(&self, category: LogCategory, text: &Text) {
        let Some(logger) = self.callbacks.logger else { return };
        let status = match category {
            LogCategory::Events | LogCategory::All => fmi2Status::fmi2OK,
            LogCategory::StatusWarning => fmi2Status::fmi2Warning,
            LogCategory::StatusDiscard => fmi2Status::fmi2Discard,
            LogCategory::StatusError => fmi2Status::fmi2Error,
            LogCategory::StatusFatal => fmi2Status::fmi2Fatal,
        };
        let name: fmi2String = self.name.as_ptr().cast();
        // SAFETY: the importer gave the logger for this call; all strings are NUL-terminated and
        // live until it returns, and the message holds no conversion that would ask for arguments.
        unsafe {
            logger(
                self.callbacks.componentEnvironment,
                name,
                status,
                category.name().as_ptr(),
                text.as_ptr(),
            );
        }
    }
}
