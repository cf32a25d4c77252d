//! What a shared library of an FMU needs beside the functions of its FMI version.

/// Reserves the block that a design is baked into, as a static of the given name.
#[macro_export]
macro_rules! reserve_block {
    ($name:ident) => {
        // The packaging tool finds the block by these names: see the module `baked`.
        #[used]
        #[cfg_attr(windows, unsafe(link_section = ".sguard"))]
        #[cfg_attr(target_vendor = "apple", unsafe(link_section = "__DATA,__steerguard"))]
        #[cfg_attr(
            not(any(windows, target_vendor = "apple")),
            unsafe(link_section = ".steerguard")
        )]
        static $name: $crate::Block = $crate::Block::UNBAKED;
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
