//! Compiles the detector in plain C into a shared library with `cc -O3`.

use std::path::Path;
use std::process::ExitCode;

fn main() -> ExitCode {
    println!("cargo::rerun-if-changed=src/detector.c");
    let folder = std::env::var("OUT_DIR").unwrap_or_default();
    let library = Path::new(&folder).join("libdetector_c.so");
    // No contraction to fused operations: outputs are to be equal bit for bit.
    let status = cc::Build::new()
        .opt_level(3)
        .pic(true)
        .get_compiler()
        .to_command()
        .args(["-ffp-contract=off", "-shared", "-Wall", "-Wextra", "-o"])
        .arg(&library)
        .args(["src/detector.c", "-lm"])
        .status();
    println!("cargo::rustc-env=DETECTOR_C={}", library.display());
    if status.is_ok_and(|status| status.success()) {
        ExitCode::SUCCESS
    } else {
        eprintln!("error: src/detector.c was not compiled: a C compiler is needed");
        ExitCode::FAILURE
    }
}
