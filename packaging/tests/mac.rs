//! Libraries of macOS: every slice is baked, page hashes are renewed, and stale ones are found.

#![allow(clippy::unwrap_used)]

mod common;

use std::io::{Cursor, Read as _};
use std::ops::Range;
use std::sync::LazyLock;

use sha2::{Digest as _, Sha256};
use steerguard::check::check;
use steerguard::fmu::archive::Archive;
use steerguard::fmu::bake::bake;
use steerguard::fmu::package::detector_fmu;
use steerguard::fmu::runtime::Runtimes;
use steerguard::platform::Platform;
use steerguard::report::design_summary::Record;
use steerguard_fmu_core::{BLOCK_SIZE, baked};

const X86_64: u32 = 0x0100_0007;
const ARM64: u32 = 0x0100_000c;

/// The block in an image of [`image`], across three of its pages.
const BLOCK: Range<usize> = 4608..4608 + BLOCK_SIZE;
/// End of what is signed: not at the end of a page.
const END: usize = 16_496;
const PAGE: usize = 4096;
const PAGES: usize = END.div_ceil(PAGE);
/// Where the signature's directory begins, and its page hashes.
const DIRECTORY: usize = END + 28;
const HASHES: usize = DIRECTORY + 96;

fn put(bytes: &mut [u8], at: usize, fields: &[u32], order: fn(u32) -> [u8; 4]) {
    for (field, place) in fields.iter().zip(bytes[at..].chunks_exact_mut(4)) {
        place.copy_from_slice(&order(*field));
    }
}

fn sign(image: &mut [u8]) {
    for page in 0..PAGES {
        let digest = Sha256::digest(&image[page * PAGE..END.min((page + 1) * PAGE)]);
        image[HASHES + page * 32..][..32].copy_from_slice(&digest);
    }
}

fn is_signed_right(image: &[u8]) -> bool {
    let mut signed = image.to_vec();
    sign(&mut signed);
    signed == image
}

/// A library with an unbaked block and nothing else; ad-hoc signed, or not at all.
fn image(processor: u32, is_signed: bool) -> Vec<u8> {
    let mut bytes = vec![0; END + 28 + 96 + PAGES * 32];
    let little = u32::to_le_bytes;
    let (commands, size) = if is_signed { (2, 168) } else { (1, 152) };
    put(&mut bytes, 0, &[0xfeed_facf, processor, 0, 6, commands, size, 0, 0], little);
    // A segment from the beginning to the end with one section.
    put(&mut bytes, 32, &[0x19, 152], little);
    bytes[40..46].copy_from_slice(b"__DATA");
    put(&mut bytes, 56, &[0, 0, END as u32, 0, 0, 0, END as u32, 0, 3, 3, 1, 0], little);
    bytes[104..116].copy_from_slice(b"__steerguard");
    bytes[120..126].copy_from_slice(b"__DATA");
    let (start, length) = (BLOCK.start as u32, BLOCK_SIZE as u32);
    put(&mut bytes, 136, &[start, 0, length, 0, start, 3, 0, 0, 0, 0, 0, 0], little);
    let block = steerguard_fmu_core::Block::UNBAKED.load();
    bytes[BLOCK].copy_from_slice(&block);
    if is_signed {
        let big = u32::to_be_bytes;
        let signature = (bytes.len() - END) as u32;
        put(&mut bytes, 184, &[0x1d, 16, END as u32, signature], little);
        // One blob: the directory.
        put(&mut bytes, END, &[0xfade_0cc0, signature, 1, 0, 28], big);
        let directory = [0xfade_0c02, signature - 28, 0x2_0400, 2, 96, 88, 0];
        put(&mut bytes, DIRECTORY, &directory, big);
        put(&mut bytes, DIRECTORY + 28, &[PAGES as u32, END as u32], big);
        bytes[DIRECTORY + 36..DIRECTORY + 40].copy_from_slice(&[32, 2, 0, 12]);
        sign(&mut bytes);
    }
    bytes
}

/// A universal file, and where its slices are.
fn universal(images: &[Vec<u8>]) -> (Vec<u8>, Vec<Range<usize>>) {
    let mut bytes = vec![0; 1 << 14];
    put(&mut bytes, 0, &[0xcafe_babe, images.len() as u32], u32::to_be_bytes);
    let mut slices = Vec::new();
    for (index, image) in images.iter().enumerate() {
        let processor = u32::from_le_bytes(image[4..8].try_into().unwrap());
        let (offset, size) = (bytes.len() as u32, image.len() as u32);
        put(&mut bytes, 8 + 20 * index, &[processor, 0, offset, size, 14], u32::to_be_bytes);
        slices.push(bytes.len()..bytes.len() + image.len());
        bytes.extend(image);
        bytes.resize(bytes.len().next_multiple_of(1 << 14), 0);
    }
    (bytes, slices)
}

fn baked_in(library: &[u8]) -> Vec<u8> {
    bake(library, Platform::Darwin64, "{guid}", b"payload").unwrap()
}

static DESCRIPTION: LazyLock<String> = LazyLock::new(|| {
    let fmu = detector_fmu(&common::design(), &Record::default(), &Runtimes::detector()).unwrap();
    let mut zip = zip::ZipArchive::new(Cursor::new(fmu)).unwrap();
    let mut description = String::new();
    let mut entry = zip.by_name("modelDescription.xml").unwrap();
    entry.read_to_string(&mut description).unwrap();
    description
});

/// What `check` says of a library of macOS: codes of findings about signatures, and their messages.
fn found(library: &[u8]) -> Vec<(&'static str, String)> {
    let mut archive = Archive::new(DESCRIPTION.as_str());
    archive.insert(Platform::Darwin64.library_path("SteeringFaultDetector"), library);
    let findings = check(Cursor::new(archive.to_bytes().unwrap()), "mac").unwrap();
    let of_signature = |code: &str| ["stale-signature", "unsigned", "signature"].contains(&code);
    let found = findings.into_iter().filter(|finding| of_signature(finding.code));
    found.map(|finding| (finding.code, finding.message)).collect()
}

#[test]
fn every_slice_is_baked_and_its_page_hashes_renewed() {
    let images = [image(X86_64, false), image(ARM64, true)];
    let (library, slices) = universal(&images);
    let library = baked_in(&library);
    for slice in &slices {
        let block = library[slice.clone()][BLOCK].first_chunk().unwrap();
        let content = baked::open(block).unwrap();
        assert_eq!((content.guid, content.payload), ("{guid}", &b"payload"[..]));
    }
    assert!(is_signed_right(&library[slices[1].clone()]));
    assert_eq!(found(&library), []);
    // Everything but blocks and hashes is as it was.
    for (slice, image) in slices.iter().zip(&images) {
        for (at, (new, old)) in library[slice.clone()].iter().zip(image).enumerate() {
            assert!(new == old || BLOCK.contains(&at) || at >= HASHES, "byte {at}");
        }
    }
    // A single image is one as well.
    assert!(is_signed_right(&baked_in(&image(ARM64, true))));
}

#[test]
fn a_stale_page_hash_is_found_in_any_slice() {
    for (slice, processor) in [(0, "X86_64"), (1, "Aarch64")] {
        let (library, slices) = universal(&[image(X86_64, true), image(ARM64, true)]);
        let mut library = baked_in(&library);
        assert_eq!(found(&library), []);
        library[slices[slice].start + END - 1] ^= 1; // on the last page, which is not a whole one
        let [(code, message)] = &found(&library)[..] else { unreachable!("{slice}") };
        assert_eq!(*code, "stale-signature");
        assert!(message.contains(&format!("1 of {PAGES} page hashes are stale for {processor}")));
    }
}

#[test]
fn code_for_arm_has_to_be_signed() {
    assert_eq!(found(&image(X86_64, false)), []);
    assert!(matches!(found(&image(ARM64, false))[..], [("unsigned", _)]));
}

#[test]
fn signatures_that_cannot_be_renewed_are_refused() {
    let refused = |edit: fn(&mut [u8])| {
        let mut image = image(ARM64, true);
        edit(&mut image);
        bake(&image, Platform::Darwin64, "{guid}", b"payload").unwrap_err().to_string()
    };
    // Not ad-hoc; SHA-1; more pages than hashes; no directory where it should be.
    assert!(refused(|image| image[DIRECTORY + 15] = 0).contains("certificate"));
    assert!(refused(|image| image[DIRECTORY + 37] = 1).contains("SHA-256"));
    assert!(refused(|image| image[DIRECTORY + 31] = 4).contains("page hashes"));
    assert!(refused(|image| image[END + 19] = 255).contains("cannot be read"));
}

/// Whatever a signature says, reading it ends without a panic.
#[test]
fn damaged_signatures_are_survived() {
    let sound = image(ARM64, true);
    for at in (0..200).chain(END..HASHES) {
        for value in [0, 1, 0x7f, 0xff] {
            let mut image = sound.clone();
            image[at] = value;
            let (library, _) = universal(&[image]);
            let _ = bake(&library, Platform::Darwin64, "{guid}", b"payload");
            if at % 8 == 0 || at >= DIRECTORY {
                found(&library);
            }
        }
    }
}
