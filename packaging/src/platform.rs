//! Platforms an FMU carries shared libraries for, under the names of FMI 2.0.4, section 2.3.

use object::{Architecture, BinaryFormat, Object as _};

/// Operating system and processor of a shared library.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Platform {
    /// Linux on x86-64.
    Linux64,
    /// Windows on x86-64.
    Win64,
    /// macOS.
    Darwin64,
    /// Linux on 64-bit Arm, which FMI 2.0 has no name for; FMI 3.0 calls it so.
    LinuxAarch64,
}

impl Platform {
    /// All platforms.
    pub const ALL: [Self; 4] = [Self::Linux64, Self::Win64, Self::Darwin64, Self::LinuxAarch64];

    /// The platform this command runs on, if FMUs can be run there.
    pub const HOST: Option<Self> = if cfg!(all(target_os = "linux", target_arch = "x86_64")) {
        Some(Self::Linux64)
    } else if cfg!(all(target_os = "windows", target_arch = "x86_64")) {
        Some(Self::Win64)
    } else if cfg!(target_os = "macos") {
        Some(Self::Darwin64)
    } else if cfg!(all(target_os = "linux", target_arch = "aarch64")) {
        Some(Self::LinuxAarch64)
    } else {
        None
    };

    /// Name of the folder under `binaries/`.
    pub const fn folder(self) -> &'static str {
        match self {
            Self::Linux64 => "linux64",
            Self::Win64 => "win64",
            Self::Darwin64 => "darwin64",
            Self::LinuxAarch64 => "aarch64-linux",
        }
    }

    /// Path of the shared library inside an FMU.
    pub fn library_path(self, model_identifier: &str) -> String {
        let extension = match self {
            Self::Linux64 | Self::LinuxAarch64 => "so",
            Self::Win64 => "dll",
            Self::Darwin64 => "dylib",
        };
        format!("binaries/{}/{model_identifier}.{extension}", self.folder())
    }

    /// Whether `library` is an object file for this platform.
    pub fn accepts(self, library: &object::File<'_>) -> bool {
        let (format, architectures): (_, &[_]) = match self {
            Self::Linux64 => (BinaryFormat::Elf, &[Architecture::X86_64]),
            Self::Win64 => (BinaryFormat::Pe, &[Architecture::X86_64]),
            Self::Darwin64 => (BinaryFormat::MachO, &[Architecture::X86_64, Architecture::Aarch64]),
            Self::LinuxAarch64 => (BinaryFormat::Elf, &[Architecture::Aarch64]),
        };
        library.format() == format && architectures.contains(&library.architecture())
    }
}

impl std::str::FromStr for Platform {
    type Err = String;

    fn from_str(name: &str) -> Result<Self, String> {
        Self::ALL.into_iter().find(|platform| platform.folder() == name).ok_or_else(|| {
            let known: Vec<_> = Self::ALL.iter().map(|platform| platform.folder()).collect();
            format!("unknown platform `{name}`; known are {}", known.join(", "))
        })
    }
}
