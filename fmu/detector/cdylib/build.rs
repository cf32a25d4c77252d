//! What the linker of each platform is told beyond the rest. A rule for both libraries.
//!
//! Undefined symbols are refused where that is not so by itself: the panic handler calls one, so that a
//! panic that could be reached fails the build. Nothing of the time and place of a build gets into its
//! result: no time stamp, and no path as a library's own name.

#[path = "../../../modelDescription/src/names.rs"]
#[allow(dead_code, reason = "the files of the FMUs are named elsewhere")]
mod names;

fn main() {
    println!("cargo:rerun-if-env-changed=CARGO_CFG_TARGET_OS");
    let variable = |name: &str| std::env::var(name).unwrap_or_default();
    match (variable("CARGO_CFG_TARGET_OS").as_str(), variable("CARGO_CFG_TARGET_ENV").as_str()) {
        ("windows", "gnu") => println!("cargo:rustc-cdylib-link-arg=-Wl,--no-insert-timestamp"),
        ("windows", _) => println!("cargo:rustc-cdylib-link-arg=/Brepro"),
        ("macos", _) => {
            let is_plant = variable("CARGO_PKG_NAME").contains("plant");
            let library = if is_plant { names::PLANT } else { names::DETECTOR };
            // Known to compilers and to linkers alike.
            println!("cargo:rustc-cdylib-link-arg=-install_name");
            println!("cargo:rustc-cdylib-link-arg=@rpath/{library}.dylib");
        }
        _ => println!("cargo:rustc-cdylib-link-arg=-Wl,-z,defs"),
    }
}
