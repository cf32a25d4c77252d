//! What an instance knows of the importer.

use steerguard_fmu_core::{Categories, Log, Logger, Text};
use steerguard_model_description::LogCategory;

use crate::types::{fmi3InstanceEnvironment, fmi3LogMessageCallback, fmi3Status};

/// Where messages go, and the log categories that are enabled.
pub(crate) struct Environment {
    pub(crate) log_message: Option<fmi3LogMessageCallback>,
    pub(crate) instance_environment: fmi3InstanceEnvironment,
    pub(crate) categories: Categories,
}

impl Environment {
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
        let Some(log_message) = self.log_message else { return };
        let status = match category {
            LogCategory::Events | LogCategory::All => fmi3Status::fmi3OK,
            LogCategory::StatusWarning => fmi3Status::fmi3Warning,
            LogCategory::StatusDiscard => fmi3Status::fmi3Discard,
            LogCategory::StatusError => fmi3Status::fmi3Error,
            LogCategory::StatusFatal => fmi3Status::fmi3Fatal,
        };
        let category = category.name().as_ptr();
        // SAFETY: the importer gave the function for this call; strings are NUL-terminated and live until
        // it returns.
        unsafe { log_message(self.instance_environment, status, category, text.as_ptr()) };
    }
}
