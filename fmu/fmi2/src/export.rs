//! The C symbols.

/// Makes the current `cdylib` an FMU of the given [`Model`](steerguard_fmu_core::Model): defines the
/// 44 functions of FMI 2.0. The numbers of the model are in `block`, an expression of type
/// `&'static Block`.
#[macro_export]
macro_rules! export_fmi2 {
    ($model:ty, block = $block:expr) => {
        struct ExportedFmu;

        impl $crate::fmu_core::Fmu for ExportedFmu {
            type Model = $model;

            fn block() -> &'static $crate::fmu_core::Block {
                $block
            }
        }

        $crate::fmi2_functions!([$crate::define_fmi2_functions] {});
    };
}

#[doc(hidden)]
#[macro_export]
macro_rules! define_fmi2_functions {
    ({}
        co_simulation: $(fn $cs:ident($($ca:ident: $ct:ty),*) -> $cr:ty;)+
        model_exchange: $(fn $me:ident($c:ident: $c_type:ty $(, $ma:ident: $mt:ty)*) -> $mr:ty;)+
    ) => {
        /// The functions of FMI 2.0, section 2.1 to 4.2.
        #[allow(non_snake_case, clippy::missing_safety_doc, clippy::too_many_arguments)]
        mod fmi2 {
            use $crate::types::*;
            use super::ExportedFmu;

            $(
                #[unsafe(no_mangle)]
                pub unsafe extern "C" fn $cs($($ca: $ct),*) -> $cr {
                    // SAFETY: the importer's obligations are the contract of the boundary.
                    unsafe { $crate::boundary::$cs::<ExportedFmu>($($ca),*) }
                }
            )+
            $(
                #[unsafe(no_mangle)]
                pub unsafe extern "C" fn $me($c: $c_type $(, _: $mt)*) -> $mr {
                    // SAFETY: the importer's obligations are the contract of the boundary.
                    unsafe {
                        $crate::boundary::model_exchange::<ExportedFmu>($c, $crate::Function::$me)
                    }
                }
            )+
        }
    };
}
