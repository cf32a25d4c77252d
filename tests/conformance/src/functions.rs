//! The table of C functions.

use std::path::Path;

use libloading::Library;
use steerguard_fmi2::pointers;

macro_rules! table {
    ({}
        co_simulation: $(fn $cs:ident($($ca:ident: $ct:ty),*) -> $cr:ty;)+
        model_exchange: $(fn $me:ident($($ma:ident: $mt:ty),*) -> $mr:ty;)+
    ) => {
        /// The functions of an FMU by their names in the standard.
        #[allow(non_snake_case, missing_docs, reason = "the standard documents these functions")]
        #[derive(Clone, Copy)]
        pub struct Functions {
            $(pub $cs: pointers::$cs,)+
            $(pub $me: pointers::$me,)+
        }

        impl Functions {
            /// Loads the library of an FMU. The pointers are valid as long as the library.
            ///
            /// # Errors
            /// If it cannot be loaded or lacks a function.
            pub fn load(path: &Path) -> Result<(Self, Library), libloading::Error> {
                // SAFETY: the libraries under test are ours; they have no initialisers.
                let code = unsafe { Library::new(path)? };
                let functions = Self {
                    // SAFETY: the FMI 2.0 headers declare the function with this type.
                    $($cs: unsafe { *code.get::<pointers::$cs>(stringify!($cs))? },)+
                    // SAFETY: the same.
                    $($me: unsafe { *code.get::<pointers::$me>(stringify!($me))? },)+
                };
                Ok((functions, code))
            }
        }
    };
}

steerguard_fmi2::fmi2_functions!([table] {});

/// The [`Functions`] that `steerguard_fmi2::export_fmi2!` has defined in the current module.
#[macro_export]
macro_rules! linked_functions {
    () => {
        ::steerguard_fmi2::fmi2_functions!([$crate::linked_functions] {})
    };
    ({}
        co_simulation: $(fn $cs:ident($($ca:ident: $ct:ty),*) -> $cr:ty;)+
        model_exchange: $(fn $me:ident($($ma:ident: $mt:ty),*) -> $mr:ty;)+
    ) => {
        $crate::Functions { $($cs: fmi2::$cs,)+ $($me: fmi2::$me,)+ }
    };
}
