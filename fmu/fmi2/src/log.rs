//! Log messages in the standard's categories.

use core::ffi::CStr;

use steerguard_model_description::LogCategory;

use crate::Text;
use crate::types::{fmi2CallbackFunctions, fmi2Status, fmi2String};

/// Longest instance name, bytes; longer ones are shortened in messages.
const NAME_CAPACITY: usize = 255;

/// What an instance knows of the importer: callbacks and name, both copied, and the categories that
/// are enabled.
pub(crate) struct Environment {
    pub(crate) callbacks: fmi2CallbackFunctions,
    name: [u8; NAME_CAPACITY + 1],
    categories: u8,
}

impl Environment {
    pub(crate) fn new(callbacks: fmi2CallbackFunctions, name: &CStr) -> Self {
        let mut copy = [0; NAME_CAPACITY + 1];
        for (place, &byte) in copy.iter_mut().take(NAME_CAPACITY).zip(name.to_bytes()) {
            *place = byte;
        }
        Self { callbacks, name: copy, categories: 0 }
    }

    /// Disables every category.
    pub(crate) fn disable_all(&mut self) {
        self.categories = 0;
    }

    /// Enables a category.
    pub(crate) fn enable(&mut self, category: LogCategory) {
        self.categories |= match category {
            LogCategory::All => u8::MAX,
            one => 1 << one as u8,
        };
    }

    /// Sends a message if its category is enabled; the text is made only then.
    pub(crate) fn log(
        &self,
        category: LogCategory,
        status: fmi2Status,
        write: impl FnOnce(&mut Text),
    ) {
        if self.categories & (1 << category as u8) != 0 {
            self.send(category, status, write);
        }
    }

    /// Sends a message whatever is enabled.
    #[cold]
    pub(crate) fn send(
        &self,
        category: LogCategory,
        status: fmi2Status,
        write: impl FnOnce(&mut Text),
    ) {
        let Some(logger) = self.callbacks.logger else { return };
        let mut text = Text::new();
        write(&mut text);
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

/// Where a model reports what happens in a sample.
pub struct Log<'a> {
    environment: &'a Environment,
}

impl<'a> Log<'a> {
    pub(crate) fn new(environment: &'a Environment) -> Self {
        Self { environment }
    }

    /// Reports a change of state, in `logEvents`.
    pub fn event(&self, write: impl FnOnce(&mut Text)) {
        self.environment.log(LogCategory::Events, fmi2Status::fmi2OK, write);
    }

    /// Reports a warning; the model returns fmi2Warning from the same sample.
    pub fn warning(&self, write: impl FnOnce(&mut Text)) {
        self.environment.log(LogCategory::StatusWarning, fmi2Status::fmi2Warning, write);
    }

    /// Reports why a sample failed; the model returns fmi2Error from the same sample.
    pub fn error(&self, write: impl FnOnce(&mut Text)) {
        self.environment.log(LogCategory::StatusError, fmi2Status::fmi2Error, write);
    }
}
