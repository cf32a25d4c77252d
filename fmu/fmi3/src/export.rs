//! The C symbols.

/// Makes the current `cdylib` an FMU of the given [`Model`](steerguard_fmu_core::Model): defines the
/// 75 functions of FMI 3.0. The numbers of the model are in `block`, an expression of type
/// `&'static Block`.
#[macro_export]
macro_rules! export_fmi3 {
    ($model:ty, block = $block:expr) => {
        struct ExportedFmu;

        impl $crate::fmu_core::Fmu for ExportedFmu {
            type Model = $model;

            fn block() -> &'static $crate::fmu_core::Block {
                $block
            }
        }

        $crate::fmi3_functions!([$crate::define_fmi3_functions] {});
    };
}

#[doc(hidden)]
#[macro_export]
macro_rules! define_fmi3_functions {
    ({}
        provided: $(fn $p:ident($($pa:ident: $pt:ty),*) -> $pr:ty;)+
        $(absent $reason:literal:
            $(fn $a:ident($instance:ident: $instance_type:ty $(, $aa:ident: $at:ty)*) -> $ar:ty;)+
        )+
    ) => {
        /// The functions of FMI 3.0, sections 2 to 5.
        #[allow(non_snake_case, clippy::missing_safety_doc, clippy::too_many_arguments)]
        mod fmi3 {
            use $crate::types::*;
            use super::ExportedFmu;

            $(
                #[unsafe(no_mangle)]
                pub unsafe extern "C" fn $p($($pa: $pt),*) -> $pr {
                    // SAFETY: the importer's obligations are the contract of the boundary.
                    unsafe { $crate::boundary::$p::<ExportedFmu>($($pa),*) }
                }
            )+
            $($(
                #[unsafe(no_mangle)]
                pub unsafe extern "C" fn $a($instance: $instance_type $(, _: $at)*) -> $ar {
                    // SAFETY: the importer's obligations are the contract of the boundary.
                    unsafe {
                        $crate::boundary::absent::<ExportedFmu>(
                            $instance, $crate::Function::$a, $reason,
                        )
                    }
                }
            )+)+
        }
    };
}
