//! Makes the linker refuse undefined symbols where it would not do so by itself: the panic handler
//! calls one, so that a panic that could be reached fails the build.

fn main() {
    println!("cargo:rerun-if-env-changed=CARGO_CFG_TARGET_OS");
    let os = std::env::var("CARGO_CFG_TARGET_OS").unwrap_or_default();
    if !matches!(os.as_str(), "windows" | "macos" | "ios") {
        println!("cargo:rustc-cdylib-link-arg=-Wl,-z,defs");
    }
}
