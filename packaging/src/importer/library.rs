//! The shared library of an FMU: the functions an importer calls, looked up once.

use std::path::Path;

use steerguard_fmi2::pointers;

use crate::output::temporary::TemporaryFolder;

macro_rules! library {
    ($($field:ident: $function:ident,)+) => {
        /// A loaded FMU library.
        pub(super) struct Library {
            $(pub(super) $field: pointers::$function,)+
            /// Keeps the code mapped for as long as the pointers above live.
            _code: libloading::Library,
            /// The unpacked FMU, removed after the code is unmapped.
            _folder: TemporaryFolder,
        }

        impl Library {
            /// Loads the library at `path`, inside `folder`, and looks up its functions.
            pub(super) fn load(path: &Path, folder: TemporaryFolder) -> Result<Self, libloading::Error> {
                // SAFETY: loading runs the library's initialisers. An FMU is code that the user
                // chose to run; nothing in this process relies on what initialisers may change.
                let code = unsafe { libloading::Library::new(path)? };
                $(
                    // SAFETY: the FMI 2.0 headers declare the function with this type.
                    let $field = unsafe {
                        *code.get::<pointers::$function>(stringify!($function))?
                    };
                )+
                Ok(Self { $($field,)+ _code: code, _folder: folder })
            }
        }
    };
}

library! {
    instantiate: fmi2Instantiate,
    free_instance: fmi2FreeInstance,
    setup_experiment: fmi2SetupExperiment,
    enter_initialization_mode: fmi2EnterInitializationMode,
    exit_initialization_mode: fmi2ExitInitializationMode,
    terminate: fmi2Terminate,
    reset: fmi2Reset,
    get_real: fmi2GetReal,
    get_integer: fmi2GetInteger,
    get_boolean: fmi2GetBoolean,
    get_string: fmi2GetString,
    set_real: fmi2SetReal,
    set_integer: fmi2SetInteger,
    set_boolean: fmi2SetBoolean,
    do_step: fmi2DoStep,
}
