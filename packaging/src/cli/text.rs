//! Reading a file as text.

use std::path::Path;

use crate::bounded::{self, MAX_TEXT_BYTES};
use crate::cli::failure::Failure;

/// Text of the file at `path`.
pub fn read_text(path: &Path) -> Result<String, Failure> {
    let bytes = bounded::read(path, MAX_TEXT_BYTES).map_err(|error| {
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
        return Err(Failure::bad("the file is UTF-16")
            .help("save it as UTF-8, or convert it: iconv -f UTF-16 -t UTF-8 FILE > NEW"));
    }
    String::from_utf8(bytes).map_err(|error| {
        let valid = &error.as_bytes()[..error.utf8_error().valid_up_to()];
        let line = valid.iter().filter(|&&byte| byte == b'\n').count() + 1;
        let byte = error.as_bytes()[valid.len()];
        let begin = valid.iter().rposition(|&byte| byte == b'\n').map_or(0, |at| at + 1);
        // Counted in characters: the line is UTF-8 up to there.
        let before = String::from_utf8_lossy(&valid[begin..]).chars().count();
        Failure::bad(format!(
            "the file is not UTF-8: byte 0x{byte:02x} in line {line}, column {}",
            before + 1
        ))
        .help(
            "save it as UTF-8, or convert it, from Windows-1252 for example: iconv -f WINDOWS-1252 \
             -t UTF-8 FILE > NEW",
        )
    })
}

#[cfg(test)]
mod tests {
    use super::decoded;

    #[test]
    fn what_is_no_utf_8_is_told_with_its_place_and_how_to_convert_it() {
        let failure = decoded(b"a = 1\n# \xc3\xbc m\xfctter".to_vec()).unwrap_err();
        let said = &failure.diagnostics[0];
        assert_eq!(said.message, "the file is not UTF-8: byte 0xfc in line 2, column 6");
        assert!(said.help[0].contains("iconv -f WINDOWS-1252"), "{:?}", said.help);
        let failure = decoded(b"\xff\xfea\0".to_vec()).unwrap_err();
        assert!(failure.diagnostics[0].help[0].contains("iconv -f UTF-16"));
    }
}
