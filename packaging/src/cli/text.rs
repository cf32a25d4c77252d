//! Reading a file as text.

use std::path::Path;

use crate::cli::failure::Failure;

/// Text of the file at `path`.
pub fn read_text(path: &Path) -> Result<String, Failure> {
    let bytes = std::fs::read(path).map_err(|error| {
        Failure::bad(format!("cannot read `{}`: {error}", path.display())).help(
            "check the path; specifications and scenarios are TOML, designs are made by `steerguard \
             design`",
        )
    })?;
    decoded(bytes).map_err(|failure| failure.at(path.display()))
}

/// UTF-8 as text.
fn decoded(bytes: Vec<u8>) -> Result<String, Failure> {
    if bytes.starts_with(&[0xff, 0xfe]) || bytes.starts_with(&[0xfe, 0xff]) {
        return Err(Failure::bad("the file is UTF-16").help("save it as UTF-8"));
    }
    String::from_utf8(bytes).map_err(|error| {
        let valid = &error.as_bytes()[..error.utf8_error().valid_up_to()];
        let line = valid.iter().filter(|&&byte| byte == b'\n').count() + 1;
        let byte = error.as_bytes()[valid.len()];
        Failure::bad(format!("the file is not UTF-8: byte 0x{byte:02x} in line {line}"))
            .help("save it as UTF-8")
    })
}
