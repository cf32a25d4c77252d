//! One instance of an FMU.

use std::cell::Cell;
use std::ffi::CString;
use std::ptr;
use std::sync::Arc;

use steerguard_fmi2::types::{
    fmi2CallbackFunctions, fmi2CoSimulation, fmi2Component, fmi2False, fmi2Status, fmi2True,
};

use super::library::Library;
use super::log::{Log, LogMessage, text};

/// A call that the FMU refused or could not carry out.
#[derive(Debug, thiserror::Error)]
#[error("{instance}: {function} answered {}{}", status_name(*status), listed(messages))]
pub struct CallError {
    /// Name of the instance.
    pub instance: String,
    /// The function of the standard.
    pub function: &'static str,
    /// What it answered; `None` if it returned no instance.
    pub status: Option<fmi2Status>,
    /// What the FMU logged since the last call that was looked at.
    pub messages: Vec<LogMessage>,
}

fn status_name(status: Option<fmi2Status>) -> String {
    match status {
        None => "NULL".into(),
        Some(fmi2Status::fmi2Discard) => "fmi2Discard".into(),
        Some(fmi2Status::fmi2Error) => "fmi2Error".into(),
        Some(fmi2Status::fmi2Fatal) => "fmi2Fatal".into(),
        Some(fmi2Status::fmi2Pending) => "fmi2Pending".into(),
        Some(fmi2Status(other)) => format!("status {other}"),
    }
}

fn listed(messages: &[LogMessage]) -> String {
    messages.iter().map(|message| format!("\n  {message}")).collect()
}

/// An instance of a Co-Simulation FMU. Dropping it frees the FMU's instance.
pub struct Instance {
    name: String,
    component: fmi2Component,
    /// The standard forbids any further call after fmi2Fatal.
    broken: Cell<bool>,
    log: Box<Log>,
    /// The standard lets the FMU keep the pointer to these.
    _callbacks: Box<fmi2CallbackFunctions>,
    library: Arc<Library>,
}

impl Instance {
    /// Calls `fmi2Instantiate`, with logging on.
    pub(super) fn new(
        library: Arc<Library>,
        name: &str,
        guid: &str,
        resource_location: &str,
    ) -> Result<Self, CallError> {
        let log = Box::new(Log::default());
        let callbacks = Box::new(log.callbacks());
        let c_string = |text: &str| CString::new(text.replace('\0', "")).unwrap_or_default();
        let [c_name, c_guid, c_resources] = [name, guid, resource_location].map(c_string);
        // SAFETY: strings and callbacks are valid during the call, and callbacks and log live as
        // long as the instance.
        let component = unsafe {
            (library.instantiate)(
                c_name.as_ptr(),
                fmi2CoSimulation,
                c_guid.as_ptr(),
                c_resources.as_ptr(),
                &raw const *callbacks,
                fmi2False,
                fmi2True,
            )
        };
        if component.is_null() {
            return Err(CallError {
                instance: name.to_owned(),
                function: "fmi2Instantiate",
                status: None,
                messages: log.take(),
            });
        }
        Ok(Self {
            name: name.to_owned(),
            component,
            broken: Cell::new(false),
            log,
            _callbacks: callbacks,
            library,
        })
    }

    /// Messages that the FMU logged since they were last taken.
    pub fn take_log(&self) -> Vec<LogMessage> {
        self.log.take()
    }

    /// `fmi2SetupExperiment` without a tolerance, from time 0 to `stop_time_s`.
    ///
    /// # Errors
    /// [`CallError`] if the FMU refuses.
    pub fn setup_experiment(&mut self, stop_time_s: f64) -> Result<(), CallError> {
        // SAFETY: `component` is a live instance of this library.
        let status = unsafe {
            let setup = self.library.setup_experiment;
            setup(self.component, fmi2False, 0.0, 0.0, fmi2True, stop_time_s)
        };
        self.check("fmi2SetupExperiment", status)
    }

    /// `fmi2EnterInitializationMode`.
    ///
    /// # Errors
    /// [`CallError`] if the FMU refuses.
    pub fn enter_initialization_mode(&mut self) -> Result<(), CallError> {
        // SAFETY: `component` is a live instance of this library.
        let status = unsafe { (self.library.enter_initialization_mode)(self.component) };
        self.check("fmi2EnterInitializationMode", status)
    }

    /// `fmi2ExitInitializationMode`.
    ///
    /// # Errors
    /// [`CallError`] if the FMU refuses.
    pub fn exit_initialization_mode(&mut self) -> Result<(), CallError> {
        // SAFETY: `component` is a live instance of this library.
        let status = unsafe { (self.library.exit_initialization_mode)(self.component) };
        self.check("fmi2ExitInitializationMode", status)
    }

    /// `fmi2DoStep` from `time_s` over `step_s`.
    ///
    /// # Errors
    /// [`CallError`] if the FMU refuses or fails.
    pub fn do_step(&mut self, time_s: f64, step_s: f64) -> Result<(), CallError> {
        // SAFETY: `component` is a live instance of this library.
        let status = unsafe { (self.library.do_step)(self.component, time_s, step_s, fmi2True) };
        self.check("fmi2DoStep", status)
    }

    /// `fmi2Terminate`.
    ///
    /// # Errors
    /// [`CallError`] if the FMU refuses.
    pub fn terminate(&mut self) -> Result<(), CallError> {
        // SAFETY: `component` is a live instance of this library.
        let status = unsafe { (self.library.terminate)(self.component) };
        self.check("fmi2Terminate", status)
    }

    /// `fmi2Reset`.
    ///
    /// # Errors
    /// [`CallError`] if the FMU refuses.
    pub fn reset(&mut self) -> Result<(), CallError> {
        // SAFETY: `component` is a live instance of this library.
        let status = unsafe { (self.library.reset)(self.component) };
        self.check("fmi2Reset", status)
    }

    /// `fmi2GetString` of one variable.
    ///
    /// # Errors
    /// [`CallError`] if the FMU refuses.
    pub fn get_string(&self, reference: u32) -> Result<String, CallError> {
        let mut value = ptr::null();
        // SAFETY: one reference and room for one value. The pointer received is read below, before
        // any other call to the FMU.
        let status = unsafe {
            (self.library.get_string)(self.component, &raw const reference, 1, &raw mut value)
        };
        self.check("fmi2GetString", status)?;
        // SAFETY: the FMU answered with a NUL-terminated string.
        Ok(unsafe { text(value) })
    }

    fn check(&self, function: &'static str, status: fmi2Status) -> Result<(), CallError> {
        if status <= fmi2Status::fmi2Warning {
            return Ok(());
        }
        if status == fmi2Status::fmi2Fatal {
            self.broken.set(true);
        }
        Err(CallError {
            instance: self.name.clone(),
            function,
            status: Some(status),
            messages: self.log.take(),
        })
    }
}

/// Getters and setters of the types that are passed by value.
macro_rules! values {
    ($($type:ty: $get:ident $c_get:ident, $set:ident $c_set:ident;)+) => { impl Instance { $(
        #[doc = concat!("`", stringify!($c_get), "` of the given value references.")]
        ///
        /// # Errors
        /// [`CallError`] if the FMU refuses.
        pub fn $get<const N: usize>(&self, references: [u32; N]) -> Result<[$type; N], CallError> {
            let mut values = [<$type>::default(); N];
            // SAFETY: `component` is a live instance, and both arrays have N elements.
            let status = unsafe {
                (self.library.$get)(self.component, references.as_ptr(), N, values.as_mut_ptr())
            };
            self.check(stringify!($c_get), status)?;
            Ok(values)
        }

        #[doc = concat!("`", stringify!($c_set), "` of the given value references.")]
        ///
        /// # Errors
        /// [`CallError`] if the FMU refuses.
        pub fn $set<const N: usize>(
            &mut self,
            references: [u32; N],
            values: [$type; N],
        ) -> Result<(), CallError> {
            // SAFETY: `component` is a live instance, and both arrays have N elements.
            let status = unsafe {
                (self.library.$set)(self.component, references.as_ptr(), N, values.as_ptr())
            };
            self.check(stringify!($c_set), status)
        }
    )+ } };
}

values! {
    f64: get_real fmi2GetReal, set_real fmi2SetReal;
    i32: get_integer fmi2GetInteger, set_integer fmi2SetInteger;
    i32: get_boolean fmi2GetBoolean, set_boolean fmi2SetBoolean;
}

impl Drop for Instance {
    fn drop(&mut self) {
        if !self.broken.get() {
            // SAFETY: `component` is a live instance that nobody uses after this.
            unsafe { (self.library.free_instance)(self.component) };
        }
    }
}
