//! Names the system's OpenBLAS to the linker when the feature `openblas-system` asks for it.

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    if std::env::var_os("CARGO_FEATURE_OPENBLAS_SYSTEM").is_some() {
        println!("cargo:rustc-link-lib=openblas");
    }
}
