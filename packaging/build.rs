//! Builds the shared libraries of all FMUs for this machine, so that the command embeds them and
//! packages without a compiler.
//!
//! # Conventions
//! - Their bytes depend on the sources, the toolchain and the target only: the environment is
//!   cleaned, and paths are mapped to fixed names.
//! - They are built in a target folder of their own: a nested build in the outer one would wait for
//!   the outer build's lock for ever.

use std::env;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

#[path = "../modelDescription/src/names.rs"]
#[allow(dead_code, reason = "the files of the FMUs are named elsewhere")]
mod names;

/// Package of the shared library, its name, and the variable that carries its path to the crate.
const RUNTIMES: [(&str, &str, &str); 3] = [
    ("steerguard-fmu-cdylib", names::DETECTOR, "STEERGUARD_DETECTOR_RUNTIME"),
    ("steerguard-fmi3-cdylib", names::DETECTOR_FMI3, "STEERGUARD_DETECTOR_FMI3_RUNTIME"),
    ("steerguard-plant-cdylib", names::PLANT, "STEERGUARD_PLANT_RUNTIME"),
];

/// What the runtimes are built from, relative to the workspace.
const SOURCES: [&str; 6] =
    ["Cargo.toml", "Cargo.lock", "detector", "designer/world", "modelDescription", "fmu"];

/// Variables that cargo and rustc need to find themselves and the registry; all others stay behind.
const KEPT: [&str; 12] = [
    "PATH",
    "HOME",
    "CARGO_HOME",
    "RUSTUP_HOME",
    "RUSTUP_TOOLCHAIN",
    "RUSTC_BOOTSTRAP",
    "TMPDIR",
    "TEMP",
    "TMP",
    "SYSTEMROOT",
    "USERPROFILE",
    "SSL_CERT_FILE",
];

/// Beginnings of further variables to keep: network and registry settings of cargo.
const KEPT_PREFIXES: [&str; 4] = ["CARGO_NET_", "CARGO_HTTP_", "CARGO_REGISTR", "CARGO_SOURCE_"];

fn main() -> ExitCode {
    match build() {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("error: the shared libraries inside the FMUs were not built\n{message}");
            ExitCode::FAILURE
        }
    }
}

fn build() -> Result<(), String> {
    let variable = |name: &str| env::var(name).map_err(|error| format!("{name}: {error}"));
    let workspace = Path::new(&variable("CARGO_MANIFEST_DIR")?)
        .parent()
        .ok_or("this package has no parent folder")?
        .to_owned();
    for source in SOURCES {
        // Relative to this package, so that a copied target folder watches its own sources.
        println!("cargo::rerun-if-changed=../{source}");
    }
    let target = variable("TARGET")?;
    let target_folder = Path::new(&variable("OUT_DIR")?).join("runtimes");

    let mut cargo = Command::new(variable("CARGO")?);
    cargo.env_clear();
    cargo.envs(env::vars_os().filter(|(name, _)| {
        let name = name.to_string_lossy().to_uppercase();
        KEPT.contains(&name.as_str())
            || KEPT_PREFIXES.iter().any(|prefix| name.starts_with(prefix))
            || name.ends_with("_PROXY")
    }));
    // Set, not only cleaned: these win over configuration files of the user.
    cargo.env("CARGO_ENCODED_RUSTFLAGS", flags(&workspace));
    cargo.env("RUSTC_WRAPPER", "").env("RUSTC_WORKSPACE_WRAPPER", "");
    cargo.current_dir(&workspace);
    cargo.args(["build", "--locked", "--profile", "fmu", "--target", &target, "--target-dir"]);
    cargo.arg(&target_folder);
    for (package, ..) in RUNTIMES {
        cargo.args(["-p", package]);
    }
    let output = cargo.output().map_err(|error| format!("{cargo:?}: {error}"))?;
    if !output.status.success() {
        return Err(format!("{cargo:?}\n{}", String::from_utf8_lossy(&output.stderr)));
    }

    for (_, library, variable) in RUNTIMES {
        let path = target_folder.join(&target).join("fmu").join(library_file(&target, library));
        if !path.is_file() {
            return Err(format!("`{}` is missing after the build", path.display()));
        }
        println!("cargo::rustc-env={variable}={}", path.display());
    }
    Ok(())
}

/// Compiler flags, separated as `CARGO_ENCODED_RUSTFLAGS` asks.
fn flags(workspace: &Path) -> String {
    let home = if cfg!(windows) { "USERPROFILE" } else { "HOME" };
    let cargo_home = env::var_os("CARGO_HOME")
        .map(PathBuf::from)
        .or_else(|| Some(Path::new(&env::var_os(home)?).join(".cargo")));
    let mut flags = vec![format!("--remap-path-prefix={}=/steerguard", workspace.display())];
    if let Some(cargo_home) = cargo_home {
        flags.push(format!("--remap-path-prefix={}=/cargo", cargo_home.display()));
    }
    flags.join("\x1f")
}

fn library_file(target: &str, name: &str) -> String {
    if target.contains("windows") {
        format!("{name}.dll")
    } else if target.contains("apple") {
        format!("lib{name}.dylib")
    } else {
        format!("lib{name}.so")
    }
}
