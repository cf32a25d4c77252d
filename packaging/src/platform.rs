//! Platforms an FMU carries shared libraries for.

use object::{Architecture, BinaryFormat, Object as _};
use steerguard_fmu_core::baked;

macro_rules! platforms {
    ($($(#[$attribute:meta])+
        $platform:ident: $folder:literal, $extension:literal, $format:ident, [$($architecture:ident),+];
    )+) => {
        /// Operating system and processor of a shared library.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub enum Platform {
            $($(#[$attribute])+ $platform,)+
        }

        impl Platform {
            /// All platforms that importers look for.
            pub const ALL: &'static [Self] = &[$(Self::$platform),+];

            /// Name of the folder under `binaries/`.
            pub const fn folder(self) -> &'static str {
                match self {
                    $(Self::$platform => $folder,)+
                }
            }

            /// Extension of shared libraries.
            pub const fn extension(self) -> &'static str {
                match self {
                    $(Self::$platform => $extension,)+
                }
            }

            /// Format of shared libraries.
            pub const fn format(self) -> BinaryFormat {
                match self {
                    $(Self::$platform => BinaryFormat::$format,)+
                }
            }

            /// Processors that shared libraries are for.
            pub const fn architectures(self) -> &'static [Architecture] {
                match self {
                    $(Self::$platform => &[$(Architecture::$architecture),+],)+
                }
            }
        }
    };
}

// The names of FMI 2.0.4, section 2.3, and those of FMI 3.0, which 2.0 leaves free.
platforms! {
    /// Linux on x86-64.
    Linux64: "linux64", "so", Elf, [X86_64];
    /// Windows on x86-64.
    Win64: "win64", "dll", Pe, [X86_64];
    /// macOS.
    Darwin64: "darwin64", "dylib", MachO, [X86_64, Aarch64];
    /// Linux on 64-bit Arm, which FMI 2.0 has no name for.
    Aarch64Linux: "aarch64-linux", "so", Elf, [Aarch64];
    /// Windows on x86.
    Win32: "win32", "dll", Pe, [I386];
    /// Linux on x86.
    Linux32: "linux32", "so", Elf, [I386];
    /// macOS on x86.
    Darwin32: "darwin32", "dylib", MachO, [I386];
    /// Windows on x86 in FMI 3.0.
    X86Windows: "x86-windows", "dll", Pe, [I386];
    /// Windows on x86-64 in FMI 3.0.
    X86_64Windows: "x86_64-windows", "dll", Pe, [X86_64];
    /// Windows on 64-bit Arm in FMI 3.0.
    Aarch64Windows: "aarch64-windows", "dll", Pe, [Aarch64];
    /// Linux on x86-64 in FMI 3.0.
    X86_64Linux: "x86_64-linux", "so", Elf, [X86_64];
    /// macOS on x86-64 in FMI 3.0.
    X86_64Darwin: "x86_64-darwin", "dylib", MachO, [X86_64];
    /// macOS on 64-bit Arm in FMI 3.0.
    Aarch64Darwin: "aarch64-darwin", "dylib", MachO, [Aarch64];
}

impl Platform {
    /// Those that FMUs are packaged for.
    pub const PACKAGED: [Self; 4] =
        [Self::Linux64, Self::Win64, Self::Darwin64, Self::Aarch64Linux];

    /// The platform this command runs on, if FMUs can be run there.
    pub const HOST: Option<Self> = if cfg!(all(target_os = "linux", target_arch = "x86_64")) {
        Some(Self::Linux64)
    } else if cfg!(all(target_os = "windows", target_arch = "x86_64")) {
        Some(Self::Win64)
    } else if cfg!(target_os = "macos") {
        Some(Self::Darwin64)
    } else if cfg!(all(target_os = "linux", target_arch = "aarch64")) {
        Some(Self::Aarch64Linux)
    } else {
        None
    };

    /// The platform whose folder under `binaries/` has this name.
    pub fn of_folder(name: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|platform| platform.folder() == name)
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

    /// Path of the shared library inside an FMU.
    pub fn library_path(self, model_identifier: &str) -> String {
        format!("binaries/{}/{model_identifier}.{}", self.folder(), self.extension())
    }

    /// Section that a design is baked into.
    pub const fn section(self) -> &'static str {
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

impl std::str::FromStr for Platform {
    type Err = String;

    fn from_str(name: &str) -> Result<Self, String> {
        Self::PACKAGED.into_iter().find(|platform| platform.folder() == name).ok_or_else(|| {
            let known = Self::PACKAGED.map(Self::folder);
            format!("unknown platform `{name}`; known are {}", known.join(", "))
        })
    }
}
