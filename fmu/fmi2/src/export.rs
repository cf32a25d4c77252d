//! The C symbols.

/// Makes the current `cdylib` an FMU of the given [`Model`](crate::Model): reserves the block that
/// a design is baked into, and defines the 44 functions of FMI 2.0.
///
/// `export_fmi2!(Model, block = EXPRESSION)` takes a `&'static Block` from elsewhere: for tests,
/// which have no library to bake into.
#[macro_export]
macro_rules! export_fmi2 {
    ($model:ty) => {
        // The packaging tool finds the block by these names: see the module `baked`.
        #[used]
        #[cfg_attr(windows, unsafe(link_section = ".sguard"))]
        #[cfg_attr(target_vendor = "apple", unsafe(link_section = "__DATA,__steerguard"))]
        #[cfg_attr(
            not(any(windows, target_vendor = "apple")),
            unsafe(link_section = ".steerguard")
        )]
        static BLOCK: $crate::Block = $crate::Block::UNBAKED;

        $crate::export_fmi2!($model, block = &BLOCK);
    };
    ($model:ty, block = $block:expr) => {
        struct ExportedFmu;

        impl $crate::Fmu for ExportedFmu {
            type Model = $model;

            fn block() -> &'static $crate::Block {
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

/// For a `no_std` `cdylib`: links the C library, and defines the panic handler.
///
/// The handler calls a function that does not exist. Where no panic can be reached the linker drops
/// it; where one can, the library does not link, and the build fails.
#[macro_export]
macro_rules! freestanding {
    () => {
        #[cfg_attr(not(windows), link(name = "c"))]
        #[cfg_attr(windows, link(name = "msvcrt"))]
        unsafe extern "C" {}

        #[panic_handler]
        fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
            unsafe extern "C" {
                fn steerguard_a_panic_can_be_reached() -> !;
            }
            // SAFETY: never called: a library that refers to it does not link.
            unsafe { steerguard_a_panic_can_be_reached() }
        }
    };
}
