//! The archive: headers, names, sizes. Reads what the other rules need.

use std::collections::BTreeSet;
use std::io::{self, BufReader, Read, Seek};

use steerguard_model_description::xml::Level;
use zip::result::ZipError;
use zip::{CompressionMethod, ZipArchive};

use super::digests::BINARIES;
use super::findings::{Contents, DESCRIPTION, Findings};
use super::surroundings::ICON;
use crate::fmu::bill::BILL;
use crate::fmu::package::{ICON_FMI3, TERMINALS};
use crate::importer::{MAX_ENTRIES, MAX_UNPACKED_BYTES};

/// Most bytes of an entry that are kept, from its beginning.
const MAX_KEPT_BYTES: u64 = 256 << 20;
/// Largest description that is examined.
const MAX_DESCRIPTION_BYTES: u64 = 32 << 20;
/// Up to here an entry may unpack to any multiple of its size in the archive.
const HARMLESS_BYTES: u64 = 16 << 20;
/// Largest unpacked size, as a multiple of the size in the archive, of larger entries. Deflate
/// reaches 1032; tables and libraries reach 20.
const MAX_RATIO: u64 = 200;

/// What the central directory says of an entry.
struct Entry {
    name: String,
    /// The name is text in the encoding that the entry declares.
    has_text_name: bool,
    is_symlink: bool,
    is_encrypted: bool,
    uses_data_descriptor: bool,
    compression: CompressionMethod,
}

impl Entry {
    fn parts(&self) -> impl Iterator<Item = &str> {
        self.name.trim_end_matches('/').split(['/', '\\'])
    }

    fn is_compressed_readably(&self) -> bool {
        matches!(self.compression, CompressionMethod::Stored | CompressionMethod::Deflated)
    }
}

/// A rule on single entries.
struct Rule {
    code: &'static str,
    level: Level,
    /// Verb phrase: `<entry> ...`.
    what: &'static str,
    help: &'static str,
    is_broken_by: fn(&Entry) -> bool,
}

const RULES: [Rule; 10] = [
    Rule {
        code: "entry-name",
        level: Level::Error,
        what: "has a name that is empty, is no text, or has empty parts",
        help: "name entries as dir/file, in ASCII",
        is_broken_by: |entry| {
            !entry.has_text_name
                || entry.name.contains('\0')
                || entry.name.strip_prefix('/').unwrap_or(&entry.name).is_empty()
                || entry
                    .parts()
                    .enumerate()
                    .any(|(i, part)| part == "." || i > 0 && part.is_empty())
        },
    },
    Rule {
        code: "backslash",
        level: Level::Error,
        what: "has a backslash in its name",
        help: "separate directories by /, whatever the operating system",
        is_broken_by: |entry| entry.name.contains('\\'),
    },
    Rule {
        code: "absolute-path",
        level: Level::Error,
        what: "has an absolute path",
        help: "make names relative to the root of the archive",
        is_broken_by: |entry| entry.name.starts_with(['/', '\\']) || entry.name.contains(':'),
    },
    Rule {
        code: "parent-path",
        level: Level::Error,
        what: "has `..` in its path",
        help: "importers refuse it, or write outside their folder: remove the entry",
        is_broken_by: |entry| entry.parts().any(|part| part == ".."),
    },
    Rule {
        code: "symlink",
        level: Level::Error,
        what: "is a symbolic link",
        help: "store the file that it points to",
        is_broken_by: |entry| entry.is_symlink,
    },
    Rule {
        code: "encrypted",
        level: Level::Error,
        what: "is encrypted",
        help: "importers have no password: store it in the clear",
        is_broken_by: |entry| entry.is_encrypted,
    },
    Rule {
        code: "compression",
        level: Level::Error,
        what: "is compressed by another method than deflate",
        help: "FMI knows stored and deflated entries only",
        is_broken_by: |entry| !entry.is_compressed_readably(),
    },
    Rule {
        code: "data-descriptor",
        level: Level::Warning,
        what: "has its sizes in a data descriptor behind its data",
        help: "some importers cannot read that: write the archive to a file, not to a pipe",
        is_broken_by: |entry| entry.uses_data_descriptor,
    },
    Rule {
        code: "non-ascii-name",
        level: Level::Warning,
        what: "has a name with characters outside ASCII",
        help: "importers disagree on their encoding: use ASCII",
        is_broken_by: |entry| !entry.name.is_ascii(),
    },
    Rule {
        code: "control-character",
        level: Level::Error,
        what: "has a control character in its name",
        help: "Windows cannot unpack it, and terminals obey it: rename the entry",
        is_broken_by: |entry| entry.name.chars().any(|c| c.is_control() && c != '\0'),
    },
];

/// Reads the archive and reports on it; `None` if there is nothing that can be examined further.
pub(super) fn read(fmu: impl Read + Seek, findings: &mut Findings) -> io::Result<Option<Contents>> {
    let mut archive = match ZipArchive::new(BufReader::new(fmu)) {
        Ok(archive) => archive,
        Err(ZipError::Io(error)) if error.kind() != io::ErrorKind::UnexpectedEof => {
            return Err(error);
        }
        Err(error) => {
            let message = match error {
                ZipError::InvalidArchive(_) | ZipError::Io(_) => {
                    "not a whole zip archive: its directory, the last that an archive has, is not at the \
                     end of the file"
                        .into()
                }
                other => format!("not a zip archive: {other}"),
            };
            let help = "an FMU is a zip archive: the file is something else, is cut short, or has \
                        something behind its archive; fetch it or write it again";
            findings.error("not-a-zip", message, "", help);
            return Ok(None);
        }
    };
    if archive.len() > MAX_ENTRIES {
        let message = format!("{} entries, more than {MAX_ENTRIES}", archive.len());
        findings.error("zip-bomb", message, "", "an FMU has a few dozen files");
        return Ok(None);
    }
    let entries = entries(&archive);
    rules(&entries, findings);
    let sound = structure(&mut archive, &entries, findings);
    let mut contents = Contents {
        names: entries.iter().map(|entry| entry.name.clone()).collect(),
        ..Contents::default()
    };
    place_of_description(&contents, findings);
    // Overlapping entries can unpack to far more than any of them claims.
    if sound {
        unpack(&mut archive, &entries, &mut contents, findings);
    }
    Ok(Some(contents))
}

fn entries<R: Read + Seek>(archive: &ZipArchive<R>) -> Vec<Entry> {
    let entry = |index| {
        let entry = archive.by_index_data(index).ok()?;
        let name = entry.name();
        Some(Entry {
            has_text_name: name.is_ok(),
            name: name.map_or_else(
                |_| String::from_utf8_lossy(entry.name_raw()).into_owned(),
                |name| name.into_owned(),
            ),
            is_symlink: entry.is_symlink(),
            is_encrypted: entry.encrypted(),
            uses_data_descriptor: entry.flags().is_using_data_descriptor(),
            compression: entry.compression(),
        })
    };
    (0..archive.len()).filter_map(entry).collect()
}

fn rules(entries: &[Entry], findings: &mut Findings) {
    for rule in &RULES {
        let mut broken = entries.iter().filter(|entry| (rule.is_broken_by)(entry));
        let Some(first) = broken.next() else { continue };
        let message = match broken.count() {
            0 => format!("{:?} {}", first.name, rule.what),
            others => format!("{:?} {}, like {others} more", first.name, rule.what),
        };
        findings.add(rule.level, rule.code, message, "", rule.help);
    }
}

/// How entries lie in the file and relate to each other; false if they cannot be read one by one.
fn structure<R: Read + Seek>(
    archive: &mut ZipArchive<R>,
    entries: &[Entry],
    findings: &mut Findings,
) -> bool {
    if archive.offset() > 0 {
        let message = format!("{} bytes stand before the archive", archive.offset());
        findings.warning("leading-data", message, "", "let the file begin with the archive");
    }
    if archive.has_duplicate_names() {
        let message = "several entries have the same name";
        findings.error("duplicate-name", message, "", "importers differ in which they take");
    }
    let mut seen = BTreeSet::new();
    if let Some(entry) = entries.iter().find(|entry| !seen.insert(entry.name.to_lowercase())) {
        let message = format!("{:?} differs from another name in upper case only", entry.name);
        findings.warning("name-case", message, "", "they are one file on Windows: rename one");
    }
    file_and_folder(entries, findings);
    match archive.has_overlapping_entries() {
        Ok(false) => {}
        Ok(true) => {
            let message = "entries overlap each other or the directory";
            findings.error("overlapping-entries", message, "", "write the archive again");
            return false;
        }
        Err(error) => {
            let message = format!("an entry is not where the directory says: {error}");
            findings.error("header-mismatch", message, "", "write the archive again");
            return false;
        }
    }
    if !archive.has_duplicate_names()
        && let Err(error) = archive.validate_header_consistency()
    {
        let message = format!("directory and entries contradict each other: {error}");
        findings.error("header-mismatch", message, "", "write the archive again");
    }
    true
}

/// A name that is both a file and a folder: `a` beside `a/` or `a/b`.
fn file_and_folder(entries: &[Entry], findings: &mut Findings) {
    let names = entries.iter().map(|entry| entry.name.as_str());
    let files: BTreeSet<&str> = names.clone().filter(|name| !name.ends_with('/')).collect();
    // Of long names with many parts, only those that can be unpacked: time stays linear.
    let folders = names
        .filter(|name| name.len() < 1024)
        .flat_map(|name| name.match_indices('/').filter_map(|(at, _)| name.get(..at)));
    let mut both = folders.filter(|folder| files.contains(folder));
    if let Some(name) = both.next() {
        let message = format!("{name:?} is a file and a folder");
        findings.error("file-and-folder", message, "", "no importer can unpack both: rename one");
    }
}

fn place_of_description(contents: &Contents, findings: &mut Findings) {
    let place = contents.names.iter().position(|name| name == DESCRIPTION);
    let elsewhere =
        || contents.names.iter().find(|name| name.ends_with(&format!("/{DESCRIPTION}")));
    match (place, elsewhere()) {
        (Some(0), _) => {}
        (Some(_), _) => {
            let message = "the description is not the first entry";
            let help = "readers of a stream find it sooner when it comes first";
            findings.note("description-not-first", message, DESCRIPTION, help);
        }
        (None, Some(name)) => {
            let message = format!("{DESCRIPTION} is missing: there is {name:?}");
            let help = "zip the contents of the folder, not the folder";
            findings.error("no-description", message, "", help);
        }
        (None, None) => {
            let message = format!("{DESCRIPTION} is missing");
            findings.error("no-description", message, "", "every FMU has one at its root");
        }
    }
}

/// Why an entry is not read to its end.
enum Stop {
    /// It unpacks to too much.
    Bomb(String),
    /// It cannot be unpacked.
    Damaged(String),
}

/// Unpacks every entry within bounds, checks its length and CRC, and keeps what is needed.
fn unpack<R: Read + Seek>(
    archive: &mut ZipArchive<R>,
    entries: &[Entry],
    contents: &mut Contents,
    findings: &mut Findings,
) {
    let mut left = MAX_UNPACKED_BYTES;
    let mut damaged = Vec::new();
    for (index, entry) in entries.iter().enumerate() {
        if entry.is_encrypted || !entry.is_compressed_readably() {
            continue;
        }
        let kept = is_needed(&entry.name);
        match unpack_entry(archive, index, kept, &mut left) {
            Ok(bytes) if kept => {
                if entry.name == DESCRIPTION && bytes.len() as u64 > MAX_DESCRIPTION_BYTES {
                    let message = format!("more than {MAX_DESCRIPTION_BYTES} bytes: not examined");
                    let help = "importers may refuse it as well";
                    findings.error("description-size", message, DESCRIPTION, help);
                } else {
                    contents.files.insert(entry.name.clone(), bytes);
                }
            }
            Ok(_) => {}
            Err(Stop::Bomb(message)) => {
                let message = format!("{:?} {message}", entry.name);
                findings.error("zip-bomb", message, "", "importers refuse to unpack it");
                break;
            }
            Err(Stop::Damaged(reason)) => damaged.push((&entry.name, reason)),
        }
    }
    if let [(name, reason), others @ ..] = damaged.as_slice() {
        let message = match others.len() {
            0 => format!("{name:?} cannot be unpacked: {reason}"),
            more => format!("{name:?} cannot be unpacked, like {more} more: {reason}"),
        };
        findings.error("damaged-entry", message, "", "write the archive again");
    }
}

/// Whether the bytes of an entry are examined.
fn is_needed(name: &str) -> bool {
    [DESCRIPTION, TERMINALS, ICON, ICON_FMI3, BILL].contains(&name) || name.starts_with(BINARIES)
}

fn unpack_entry<R: Read + Seek>(
    archive: &mut ZipArchive<R>,
    index: usize,
    keep: bool,
    left: &mut u64,
) -> Result<Vec<u8>, Stop> {
    let damaged = |error: &dyn std::fmt::Display| Stop::Damaged(error.to_string());
    let mut entry = archive.by_index(index).map_err(|error| damaged(&error))?;
    let packed = entry.compressed_size();
    let declared = entry.size();
    let mut unpacked: u64 = 0;
    let mut kept = Vec::new();
    let mut buffer = vec![0; 1 << 16];
    loop {
        let length = entry.read(&mut buffer).map_err(|error| damaged(&error))?;
        if length == 0 {
            return match unpacked == declared {
                true => Ok(kept),
                false => Err(Stop::Damaged(format!(
                    "{declared} bytes are declared, {unpacked} are there"
                ))),
            };
        }
        unpacked += length as u64;
        *left = left.checked_sub(length as u64).ok_or_else(|| {
            Stop::Bomb(format!("brings the FMU over {MAX_UNPACKED_BYTES} bytes unpacked"))
        })?;
        if unpacked > HARMLESS_BYTES && unpacked / MAX_RATIO > packed {
            let message = format!("unpacks to more than {MAX_RATIO} times its {packed} bytes");
            return Err(Stop::Bomb(message));
        }
        if keep && unpacked <= MAX_KEPT_BYTES {
            kept.extend_from_slice(buffer.get(..length).unwrap_or_default());
        }
    }
}
