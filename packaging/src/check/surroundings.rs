//! What comes with an FMU: documentation and icon.

use super::findings::{Contents, Findings};
use crate::fmu::package::ICON_FMI3;

/// Path of the icon.
pub(super) const ICON: &str = "model.png";
/// Path of the page that importers show.
const PAGE: &str = "documentation/index.html";
/// Least width and height of an icon, pixels.
const MIN_ICON_SIDE: u32 = 100;

pub(super) fn check(contents: &Contents, findings: &mut Findings) {
    if !contents.names.iter().any(|name| name == PAGE) {
        let help = "a page there tells the reader how to use the FMU";
        findings.note("no-documentation", format!("{PAGE} is missing"), "", help);
    }
    // FMI 2.0 and 3.0 have other names for it.
    let Some(icon) =
        [ICON, ICON_FMI3].into_iter().find(|icon| contents.names.iter().any(|n| n == icon))
    else {
        let help = "importers show it where they show the FMU";
        findings.note("no-icon", format!("{ICON} is missing"), "", help);
        return;
    };
    if let Some(bytes) = contents.files.get(icon) {
        match png_size(bytes) {
            None => findings.note("icon-format", "the icon is no PNG", icon, "save it as PNG"),
            Some([width, height]) if width.min(height) < MIN_ICON_SIDE => {
                let message = format!("the icon has {width} x {height} pixels");
                let help = "draw it at 200 x 200 or more: importers scale it";
                findings.note("icon-size", message, icon, help);
            }
            Some(_) => {}
        }
    }
}

/// Width and height of a PNG, pixels.
fn png_size(bytes: &[u8]) -> Option<[u32; 2]> {
    let bytes = bytes.strip_prefix(b"\x89PNG\r\n\x1a\n")?;
    let bytes = bytes.get(4..)?.strip_prefix(b"IHDR")?;
    let (width, bytes) = bytes.split_first_chunk()?;
    let (height, _) = bytes.split_first_chunk()?;
    Some([u32::from_be_bytes(*width), u32::from_be_bytes(*height)])
}
