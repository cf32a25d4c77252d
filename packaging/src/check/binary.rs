//! The shared libraries: one for each platform and implementation, of the platform's format, that
//! exports the functions of the standard; and, in our own, what is baked into them.

use std::collections::BTreeSet;

use object::read::NameOrOrdinal;
use object::{Architecture, BinaryFormat, Object as _, ObjectSection as _};
use steerguard_fmu::BakedDesign;
use steerguard_fmu_core::{BLOCK_SIZE, BakedError, baked};
use steerguard_model_description::detector::INFO as DETECTOR;
use steerguard_model_description::xml::{Header, Implementation, digest};

use super::findings::{Contents, DESCRIPTION, Findings};
use super::functions::{Wanted, is_known, wanted};
use crate::mach_o::{self, Hashed};
use crate::platform::Platform;

pub(super) fn check(contents: &Contents, xml: &str, header: &Header, findings: &mut Findings) {
    let folders: BTreeSet<&str> = contents
        .names
        .iter()
        .filter_map(|name| {
            name.strip_prefix("binaries/")?.split_once('/').map(|(folder, _)| folder)
        })
        .filter(|folder| !folder.is_empty())
        .collect();
    if folders.is_empty() {
        let has_sources = contents.names.iter().any(|name| name.starts_with("sources/"));
        if has_sources {
            let help = "importers without a compiler cannot run it: add binaries/<platform>/";
            findings.note("no-binary", "the FMU has sources and no binaries", "", help);
        } else {
            let help = "add binaries/<platform>/<modelIdentifier> with its library";
            findings.error("no-binary", "the FMU has neither binaries nor sources", "", help);
        }
    }
    for folder in folders {
        let platform = Platform::of_folder(folder);
        match platform.filter(|platform| !header.is_version_3 || platform.is_of_fmi3()) {
            Some(platform) => libraries(contents, xml, header, platform, findings),
            None => {
                let message = format!("binaries/{folder:?} is no platform that importers look for");
                let help = if header.is_version_3 {
                    "FMI 3.0 has x86-, x86_64- and aarch64- before linux, windows and darwin"
                } else {
                    "FMI 2.0 has win32, win64, linux32, linux64, darwin32, darwin64"
                };
                findings.warning("unknown-platform", message, "", help);
            }
        }
    }
}

/// The libraries of a platform.
fn libraries(
    contents: &Contents,
    xml: &str,
    header: &Header,
    platform: Platform,
    findings: &mut Findings,
) {
    let identifiers: BTreeSet<&str> =
        header.implementations.iter().map(|i| i.model_identifier.as_str()).collect();
    for identifier in identifiers {
        let path = platform.library_path(identifier);
        if !contents.names.contains(&path) {
            let message = format!("no library for modelIdentifier {identifier:?}");
            let help =
                "importers on this platform find nothing to load: add it, or remove the folder";
            findings.error("binary-missing", message, &path, help);
        } else if let Some(bytes) = contents.files.get(&path) {
            let served = header.implementations.iter().filter(|i| i.model_identifier == identifier);
            let served: Vec<&Implementation> = served.collect();
            let is_version_3 = header.is_version_3;
            let library = Library { path, served, is_version_3, guid: &header.guid, xml };
            library.check(bytes, platform, findings);
        }
    }
}

struct Library<'a> {
    path: String,
    served: Vec<&'a Implementation>,
    is_version_3: bool,
    guid: &'a str,
    xml: &'a str,
}

impl Library<'_> {
    fn check(&self, bytes: &[u8], platform: Platform, findings: &mut Findings) {
        let images = mach_o::images(bytes).and_then(|images| {
            let parse = |bytes| Ok((object::File::parse(bytes)?, bytes));
            images.into_iter().filter_map(|range| bytes.get(range)).map(parse).collect()
        });
        let images: Vec<(object::File<'_>, &[u8])> = match images {
            Ok(images) => images,
            Err(error) => {
                let message = format!("not a shared library: {error}");
                findings.error("binary-format", message, &self.path, "importers cannot load it");
                return;
            }
        };
        for (image, bytes) in images {
            self.image(&image, bytes, platform, findings);
        }
    }

    /// An object file; universal binaries of macOS have several.
    fn image(
        &self,
        image: &object::File<'_>,
        bytes: &[u8],
        platform: Platform,
        findings: &mut Findings,
    ) {
        let folder = platform.folder();
        if !platform.accepts(image) {
            let (found, processor) = (image.format(), image.architecture());
            let message = format!("{found:?} for {processor:?} in the folder of {folder}");
            let help = "importers on this platform cannot load it";
            findings.error("binary-format", message, &self.path, help);
            return;
        }
        match exported(image) {
            Ok(exported) => self.exports(&exported, findings),
            Err(error) => {
                let message = format!("its exported symbols cannot be read: {error}");
                findings.error("binary-format", message, &self.path, "link it again");
            }
        }
        if image.format() == BinaryFormat::MachO {
            self.signature(image, bytes, findings);
        }
        self.baked(image, findings);
    }

    /// The code signature, which Macs with Arm processors insist on.
    fn signature(&self, image: &object::File<'_>, bytes: &[u8], findings: &mut Findings) {
        let help = "sign it again, after the last change: codesign --force --sign - FILE";
        let processor = image.architecture();
        match mach_o::compare(bytes) {
            Ok(None) if processor == Architecture::Aarch64 => {
                let message = "not signed for Arm, where macOS loads no unsigned code";
                findings.error("unsigned", message, &self.path, help);
            }
            Ok(Some(Hashed { pages, stale })) if stale > 0 => {
                let message = format!(
                    "changed after it was signed: {stale} of {pages} page hashes are stale for \
                     {processor:?}, and macOS ends the process that loads it"
                );
                findings.error("stale-signature", message, &self.path, help);
            }
            Ok(_) => {}
            Err(error) => findings.error("signature", error.to_string(), &self.path, help),
        }
    }

    fn exports(&self, exported: &BTreeSet<String>, findings: &mut Findings) {
        let missing = wanted(self.is_version_3, &self.served).into_iter();
        let missing = missing.filter(|function| !exported.contains(function.name));
        let (dispensable, needed): (Vec<_>, Vec<_>) = missing.partition(|f| f.dispensable);
        let names = |functions: &[Wanted]| listed(functions.iter().map(|f| f.name));
        if !needed.is_empty() {
            let message = format!("not exported: {}", names(&needed));
            findings.error("missing-function", message, &self.path, "export every function");
        }
        if !dispensable.is_empty() {
            let message = format!("not exported: {}", names(&dispensable));
            let help = "no flag announces them, yet some importers look for every function";
            findings.warning("missing-function", message, &self.path, help);
        }
        let others: Vec<&str> = exported
            .iter()
            .map(String::as_str)
            .filter(|name| !is_known(self.is_version_3, name))
            .collect();
        if !others.is_empty() {
            let message = format!("exports more than FMI: {}", listed(others.into_iter()));
            let help = "they can clash with those of other FMUs in one process: hide them";
            findings.warning("other-symbols", message, &self.path, help);
        }
    }

    /// The block of libraries on our FMI layer.
    fn baked(&self, image: &object::File<'_>, findings: &mut Findings) {
        let Some(block) = block(image) else { return };
        let error = |findings: &mut Findings, code, message: String, help| {
            findings.error(code, message, &self.path, help);
        };
        let content = match baked::open(block) {
            Ok(content) => content,
            Err(reason) => {
                let code = match reason {
                    BakedError::Unbaked => "unbaked",
                    BakedError::Damaged => "baked-block",
                };
                let help = "package the design again: this library refuses to run";
                return error(findings, code, reason.description().to_owned(), help);
            }
        };
        if content.guid != self.guid {
            let message = format!("made for GUID {:?}, described as {:?}", content.guid, self.guid);
            let help = "description and library are of different FMUs: package the design again";
            error(findings, "guid-mismatch", message, help);
        }
        let token = if self.is_version_3 { "instantiationToken" } else { "guid" };
        let stated = format!("{token}=\"{}\"", self.guid);
        let digest = digest(&self.xml.replacen(&stated, &format!("{token}=\"\""), 1));
        if digest != self.guid {
            let message = "the description was changed: its GUID is not the digest of its content";
            findings.error("guid-digest", message, DESCRIPTION, "package the design again");
        }
        if self.served.iter().any(|i| i.model_identifier == DETECTOR.identifier) {
            match BakedDesign::decode(content.payload) {
                Ok(design) if self.xml.contains(&*String::from_utf8_lossy(&design.hash)) => {}
                Ok(_) => {
                    let message = "the design in it is not the one that is described";
                    let help = "package the design again";
                    error(findings, "baked-block", message.to_owned(), help);
                }
                Err(reason) => {
                    error(findings, "baked-block", reason.to_string(), "package the design again");
                }
            }
        }
    }
}

/// Names of the exported symbols, as C knows them.
fn exported(image: &object::File<'_>) -> object::read::Result<BTreeSet<String>> {
    let underscore = image.format() == BinaryFormat::MachO;
    let mut names = BTreeSet::new();
    for export in image.exports()? {
        if let NameOrOrdinal::Name(name) = export?.name() {
            let name = String::from_utf8_lossy(name);
            let name = if underscore { name.strip_prefix('_').unwrap_or(&name) } else { &name };
            names.insert(name.to_owned());
        }
    }
    Ok(names)
}

fn block<'data>(image: &object::File<'data>) -> Option<&'data [u8; BLOCK_SIZE]> {
    [baked::SECTION_ELF, baked::SECTION_PE, baked::SECTION_MACH_O]
        .into_iter()
        .find_map(|name| image.section_by_name(name)?.data().ok()?.first_chunk())
}

/// The first few names and how many more there are.
fn listed<'a>(names: impl ExactSizeIterator<Item = &'a str>) -> String {
    const SHOWN: usize = 8;
    let more = names.len().saturating_sub(SHOWN);
    let shown: Vec<&str> = names.take(SHOWN).collect();
    let shown = shown.join(", ");
    if more == 0 { shown } else { format!("{shown} and {more} more") }
}
