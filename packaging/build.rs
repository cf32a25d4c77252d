//! Builds the shared libraries of all FMUs for this machine, so that the command embeds them and
//! packages without a compiler. The variable `STEERGUARD_RUNTIMES` names a folder of prebuilt ones
//! instead, `<platform>/<library>.<extension>`: all that are there are embedded, if they are of these
//! sources. `packaging/runtimes/build` makes such a folder.
//!
//! # Conventions
//! - Their bytes depend on the sources, the toolchain and the target only: the environment is
//!   cleaned, and paths are mapped to fixed names.
//! - They are built in a target folder of their own: a nested build in the outer one would wait for
//!   the outer build's lock for ever.

use std::collections::BTreeSet;
use std::env;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

#[path = "src/platform/name.rs"]
#[allow(dead_code, reason = "what FMUs of others have is no matter of the build")]
mod name;

use sha2::{Digest as _, Sha256};

#[path = "../modelDescription/src/names.rs"]
#[allow(dead_code, reason = "the files of the FMUs are named elsewhere")]
mod names;

use name::Platform;

/// Package of the shared library, and its name.
const RUNTIMES: [(&str, &str); 3] = [
    ("steerguard-fmu-cdylib", names::DETECTOR),
    ("steerguard-fmi3-cdylib", names::DETECTOR_FMI3),
    ("steerguard-plant-cdylib", names::PLANT),
];

/// A platform and its libraries, in the order of [`RUNTIMES`].
type Embedded = (Platform, Vec<PathBuf>);

/// What the runtimes are built from, relative to the workspace.
const SOURCES: &str = include_str!("runtimes/sources");

/// Digests of these sources in a folder of prebuilt runtimes, as `sha256sum` writes them.
const DIGESTS: &str = "sources.sha256";

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
    let workspace = Path::new(&variable("CARGO_MANIFEST_DIR")?)
        .parent()
        .ok_or("this package has no parent folder")?
        .to_owned();
    let host = Platform::of(&variable("CARGO_CFG_TARGET_OS")?, &variable("CARGO_CFG_TARGET_ARCH")?);
    println!("cargo::rerun-if-env-changed=STEERGUARD_RUNTIMES");
    let embedded = match env::var_os("STEERGUARD_RUNTIMES").filter(|folder| !folder.is_empty()) {
        Some(folder) => prebuilt(&workspace, &workspace.join(folder), host).map_err(|error| {
            format!(
                "{error}\nhelp: STEERGUARD_RUNTIMES names a folder made by packaging/runtimes/build"
            )
        })?,
        None => match host {
            Some(host) => vec![(host, built(&workspace)?)],
            None => Vec::new(),
        },
    };
    let path = Path::new(&variable("OUT_DIR")?).join("embedded.rs");
    fs::write(&path, table(&embedded)).map_err(|error| format!("{}: {error}", path.display()))?;
    println!("cargo::rustc-env=STEERGUARD_EMBEDDED={}", path.display());
    let platforms: Vec<&str> = embedded.iter().map(|(platform, _)| platform.folder()).collect();
    println!("cargo::rustc-env=STEERGUARD_PLATFORMS={}", platforms.join(", "));
    Ok(())
}

fn variable(name: &str) -> Result<String, String> {
    env::var(name).map_err(|error| format!("{name}: {error}"))
}

/// The libraries in `folder`, which are of the sources in `workspace`.
fn prebuilt(
    workspace: &Path,
    folder: &Path,
    host: Option<Platform>,
) -> Result<Vec<Embedded>, String> {
    watch_sources();
    let path = folder.join(DIGESTS);
    let expected =
        fs::read_to_string(&path).map_err(|error| format!("`{}`: {error}", path.display()))?;
    let expected: BTreeSet<&str> = expected.lines().collect();
    let found = digests(workspace)?;
    let found: BTreeSet<&str> = found.lines().collect();
    if let Some(line) = found.symmetric_difference(&expected).next() {
        let source = line.split_once("  ").map_or(*line, |(_, source)| source);
        return Err(format!(
            "the libraries in `{}` are of other sources: `{source}` differs",
            folder.display()
        ));
    }
    println!("cargo::rerun-if-changed={}", folder.display());
    let failure = |error: std::io::Error| format!("{}: {error}", folder.display());
    let mut embedded = Vec::new();
    for entry in fs::read_dir(folder).map_err(failure)? {
        let entry = entry.map_err(failure)?;
        if !entry.path().is_dir() {
            continue;
        }
        let platform: Platform = entry.file_name().to_string_lossy().parse()?;
        let libraries = RUNTIMES.map(|(_, library)| entry.path().join(platform.library(library)));
        if let Some(missing) = libraries.iter().find(|library| !library.is_file()) {
            return Err(format!("`{}` is missing", missing.display()));
        }
        embedded.push((platform, libraries.to_vec()));
    }
    embedded.sort();
    match host {
        Some(host) if embedded.iter().all(|(platform, _)| *platform != host) => {
            let host = host.folder();
            Err(format!(
                "`{}` has nothing for {host}, which the command itself loads",
                folder.display()
            ))
        }
        _ => Ok(embedded),
    }
}

fn watch_sources() {
    for source in SOURCES.lines() {
        // Relative to this package, so that a copied target folder watches its own sources.
        println!("cargo::rerun-if-changed=../{source}");
    }
}

/// A line for each of the sources: digest and path.
fn digests(workspace: &Path) -> Result<String, String> {
    let mut digests = String::new();
    let mut left: Vec<String> = SOURCES.lines().map(str::to_owned).collect();
    while let Some(source) = left.pop() {
        let path = workspace.join(&source);
        let failure = |error: std::io::Error| format!("{}: {error}", path.display());
        if path.is_dir() {
            for entry in fs::read_dir(&path).map_err(failure)? {
                let name = entry.map_err(failure)?.file_name();
                left.push(format!("{source}/{}", name.to_string_lossy()));
            }
        } else if [".rs", ".toml", ".lock"].iter().any(|end| source.ends_with(end)) {
            let digest = Sha256::digest(fs::read(&path).map_err(failure)?);
            digests.extend(digest.iter().map(|byte| format!("{byte:02x}")));
            digests += &format!("  {source}\n");
        }
    }
    Ok(digests)
}

/// Builds the libraries for the target of this build.
fn built(workspace: &Path) -> Result<Vec<PathBuf>, String> {
    watch_sources();
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
    cargo.env("CARGO_ENCODED_RUSTFLAGS", flags(workspace));
    cargo.env("RUSTC_WRAPPER", "").env("RUSTC_WORKSPACE_WRAPPER", "");
    cargo.current_dir(workspace);
    cargo.args(["build", "--locked", "--profile", "fmu", "--target", &target, "--target-dir"]);
    cargo.arg(&target_folder);
    for (package, _) in RUNTIMES {
        cargo.args(["-p", package]);
    }
    let output = cargo.output().map_err(|error| format!("{cargo:?}: {error}"))?;
    if !output.status.success() {
        return Err(format!("{cargo:?}\n{}", String::from_utf8_lossy(&output.stderr)));
    }

    let folder = target_folder.join(&target).join("fmu");
    let paths = RUNTIMES.map(|(_, library)| folder.join(library_file(&target, library)));
    match paths.iter().find(|path| !path.is_file()) {
        Some(missing) => Err(format!("`{}` is missing after the build", missing.display())),
        None => Ok(paths.to_vec()),
    }
}

/// The table of what is embedded, in Rust.
fn table(embedded: &[Embedded]) -> String {
    let rows = embedded.iter().map(|(platform, libraries)| {
        let bytes = libraries.iter().map(|path| format!("include_bytes!({path:?})"));
        format!("(Platform::{platform:?}, {}),", bytes.collect::<Vec<_>>().join(", "))
    });
    let rows: String = rows.collect();
    format!("const EMBEDDED: &[Embedded] = &[{rows}];\n")
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
