//! Names of platforms. Depends on nothing: the build script reads it as well.

macro_rules! platforms {
    ($($(#[$attribute:meta])+ $platform:ident: $folder:literal, $extension:literal;)+) => {
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
        }
    };
}

// The names of FMI 2.0.4, section 2.3, and those of FMI 3.0, which 2.0 leaves free.
platforms! {
    /// Linux on x86-64.
    Linux64: "linux64", "so";
    /// Windows on x86-64.
    Win64: "win64", "dll";
    /// macOS.
    Darwin64: "darwin64", "dylib";
    /// Linux on 64-bit Arm, which FMI 2.0 has no name for.
    Aarch64Linux: "aarch64-linux", "so";
    /// Windows on x86.
    Win32: "win32", "dll";
    /// Linux on x86.
    Linux32: "linux32", "so";
    /// macOS on x86.
    Darwin32: "darwin32", "dylib";
    /// Windows on x86 in FMI 3.0.
    X86Windows: "x86-windows", "dll";
    /// Windows on x86-64 in FMI 3.0.
    X86_64Windows: "x86_64-windows", "dll";
    /// Windows on 64-bit Arm in FMI 3.0.
    Aarch64Windows: "aarch64-windows", "dll";
    /// Linux on x86-64 in FMI 3.0.
    X86_64Linux: "x86_64-linux", "so";
    /// macOS on x86-64 in FMI 3.0.
    X86_64Darwin: "x86_64-darwin", "dylib";
    /// macOS on 64-bit Arm in FMI 3.0.
    Aarch64Darwin: "aarch64-darwin", "dylib";
}

impl Platform {
    /// Those that FMUs are packaged for.
    pub const PACKAGED: [Self; 4] =
        [Self::Linux64, Self::Win64, Self::Darwin64, Self::Aarch64Linux];

    /// The platform this command runs on, if FMUs can be run there.
    pub const HOST: Option<Self> = Self::of(std::env::consts::OS, std::env::consts::ARCH);

    /// The platform of an operating system and a processor, in the words of Rust's targets.
    pub const fn of(os: &str, processor: &str) -> Option<Self> {
        match (os.as_bytes(), processor.as_bytes()) {
            (b"linux", b"x86_64") => Some(Self::Linux64),
            (b"windows", b"x86_64") => Some(Self::Win64),
            (b"macos", _) => Some(Self::Darwin64),
            (b"linux", b"aarch64") => Some(Self::Aarch64Linux),
            _ => None,
        }
    }

    /// The platform whose folder under `binaries/` has this name.
    pub fn of_folder(name: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|platform| platform.folder() == name)
    }

    /// Name of the shared library of a model.
    pub fn library(self, model_identifier: &str) -> String {
        format!("{model_identifier}.{}", self.extension())
    }

    /// Path of the shared library inside an FMU.
    pub fn library_path(self, model_identifier: &str) -> String {
        format!("binaries/{}/{}", self.folder(), self.library(model_identifier))
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
