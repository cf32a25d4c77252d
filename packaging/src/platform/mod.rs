//! Platforms an FMU carries shared libraries for.

mod name;

use object::{Architecture, BinaryFormat, Object as _};
use steerguard_fmu_core::baked;

pub use name::Platform;

impl Platform {
    /// Format of shared libraries.
    pub fn format(self) -> BinaryFormat {
        match self.extension() {
            "dll" => BinaryFormat::Pe,
            "dylib" => BinaryFormat::MachO,
            _ => BinaryFormat::Elf,
        }
    }

    /// Processors that shared libraries are for.
    pub const fn architectures(self) -> &'static [Architecture] {
        match self {
            Self::Darwin64 => &[Architecture::X86_64, Architecture::Aarch64],
            Self::Linux64
            | Self::Win64
            | Self::X86_64Windows
            | Self::X86_64Linux
            | Self::X86_64Darwin => &[Architecture::X86_64],
            Self::Aarch64Linux | Self::Aarch64Windows | Self::Aarch64Darwin => {
                &[Architecture::Aarch64]
            }
            Self::Win32 | Self::Linux32 | Self::Darwin32 | Self::X86Windows => {
                &[Architecture::I386]
            }
        }
    }

    /// Whether FMI 3.0 calls a platform so: processor and operating system.
    pub fn is_of_fmi3(self) -> bool {
        self.folder().contains('-')
    }

    /// The platforms of FMI 3.0 that a shared library for this one serves.
    pub const fn of_fmi3(self) -> &'static [Self] {
        match self {
            Self::Linux64 => &[Self::X86_64Linux],
            Self::Win64 => &[Self::X86_64Windows],
            Self::Darwin64 => &[Self::X86_64Darwin, Self::Aarch64Darwin],
            Self::Aarch64Linux => &[Self::Aarch64Linux],
            _ => &[],
        }
    }

    /// Section that a design is baked into.
    pub fn section(self) -> &'static str {
        match self.format() {
            BinaryFormat::Pe => baked::SECTION_PE,
            BinaryFormat::MachO => baked::SECTION_MACH_O,
            _ => baked::SECTION_ELF,
        }
    }

    /// Whether `library` is an object file for this platform.
    pub fn accepts(self, library: &object::File<'_>) -> bool {
        library.format() == self.format() && self.architectures().contains(&library.architecture())
    }
}
