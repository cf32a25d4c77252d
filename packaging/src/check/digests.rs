//! Whether somebody would notice that a library is another one: digests in the bill of materials.
//!
//! # Conventions
//! - FMI has no digests. Those examined are of files in a CycloneDX bill where our FMUs have theirs.
//! - Digests tell damage and mix-ups. Who changes a library on purpose can change the bill as well.

use super::findings::{Contents, Findings};
use crate::digest::sha256;
use crate::fmu::bill::{BILL, digests};

/// Folder of the libraries.
pub(super) const BINARIES: &str = "binaries/";
/// Largest bill that is read, bytes; ours have ten thousand.
const MAX_BILL_BYTES: usize = 16 << 20;

pub(super) fn check(contents: &Contents, findings: &mut Findings) {
    let bill = contents.files.get(BILL).filter(|bill| bill.len() <= MAX_BILL_BYTES);
    let stated = bill.map(|bill| digests(bill)).unwrap_or_default();
    let mut uncovered = Vec::new();
    let files = contents
        .files
        .iter()
        .filter(|(path, _)| path.starts_with(BINARIES) && !path.ends_with('/'));
    for (path, bytes) in files {
        match stated.get(path) {
            None => uncovered.push(path),
            Some(stated) if stated.eq_ignore_ascii_case(&sha256(bytes)) => {}
            Some(_) => {
                let message = format!("the file is not the one whose SHA-256 is in {BILL}");
                let help = "it was changed after packaging: package again, or fetch the FMU again";
                findings.error("digest", message, path, help);
            }
        }
    }
    if let [first, others @ ..] = uncovered.as_slice() {
        let message = match others.len() {
            0 => format!("no digest covers {first:?}"),
            more => format!("no digest covers {first:?}, like {more} more"),
        };
        let help = "nobody can tell whether it is what was built: state its SHA-256 in \
                    documentation/sbom.cdx.json, or publish that of the FMU";
        findings.note("no-digest", message, "", help);
    }
}
