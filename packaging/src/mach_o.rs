//! Libraries of macOS beyond what all formats share: the slices of a universal file, and the hashes
//! that their code signatures hold.
//!
//! # Conventions
//! - An image is an object file for one processor: a slice of a universal file, or a whole file.
//! - A signature holds a hash of each page of its image in front of it. Who changes a page afterwards
//!   has to renew its hash: macOS ends the process that touches a page whose hash is another.
//! - Nothing in a file is trusted.

use std::ops::Range;

use object::endian::BigEndian;
use object::macho::{
    CS_ADHOC, CS_HASHTYPE_SHA256, CSMAGIC_BLOBWRAPPER, CsFlags, FatArch32, FatArch64,
    LC_CODE_SIGNATURE,
};
use object::read::macho::{
    CodeDirectory, CodeSignature, FatArch, LoadCommandVariant, MachHeader, MachOFatFile, MachOFile,
};
use object::{File, FileKind};
use sha2::{Digest as _, Sha256};

/// Most slices of a file and blobs of a signature that are read: real ones have up to four and six.
const MAX_PARTS: usize = 16;
const HASH_BYTES: usize = 32;

/// A signature that cannot be read or renewed.
#[derive(Debug, thiserror::Error)]
pub enum SignatureError {
    /// The image or its signature is damaged.
    #[error("the code signature cannot be read: {0}")]
    Unreadable(#[from] object::read::Error),
    /// Its hashes are not where it says, or not as many as its pages.
    #[error("the code signature cannot be read: its page hashes are not those of the image")]
    Pages,
    /// Only its owner can renew it.
    #[error("signed with a certificate, which a changed library needs anew: take an unsigned one")]
    Certificate,
    /// Hashes of a kind that is not written any more.
    #[error("signed by other hashes than SHA-256: sign it again (codesign --force --sign - FILE)")]
    Hash,
}

/// A page of an image, and where the signature holds its hash: both from the image's beginning.
#[derive(Debug)]
struct Page {
    bytes: Range<usize>,
    hash: Range<usize>,
}

impl Page {
    fn digest(&self, image: &[u8]) -> Option<[u8; HASH_BYTES]> {
        Some(Sha256::digest(image.get(self.bytes.clone())?).into())
    }
}

/// A signature as far as it can be renewed.
#[derive(Debug, Default)]
struct Signature {
    /// Pages with SHA-256 hashes.
    pages: Vec<Page>,
    /// There are hashes of other kinds as well.
    has_other_hashes: bool,
    has_certificate: bool,
}

/// How the hashes of a signature compare with the pages of its image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Hashed {
    /// Pages with a hash.
    pub pages: usize,
    /// Those whose hash is another.
    pub stale: usize,
}

/// Where the images of a file are: one that is no universal file is an image as a whole.
///
/// # Errors
/// What reading the table of a universal file says.
pub fn images(file: &[u8]) -> object::read::Result<Vec<Range<usize>>> {
    match FileKind::parse(file)? {
        FileKind::MachOFat32 => slices::<FatArch32>(file),
        FileKind::MachOFat64 => slices::<FatArch64>(file),
        _ => Ok(std::iter::once(0..file.len()).collect()),
    }
}

fn slices<Fat: FatArch>(file: &[u8]) -> object::read::Result<Vec<Range<usize>>> {
    let slice = |arch: &Fat| {
        arch.data(file)?; // refuses a range beyond the file
        let (offset, size) = arch.file_range();
        Ok(offset as usize..(offset + size) as usize)
    };
    MachOFatFile::<Fat>::parse(file)?.arches().iter().take(MAX_PARTS).map(slice).collect()
}

/// Compares the hashes of an image's signature with its pages; `None` if it has no signature.
///
/// # Errors
/// [`SignatureError`] if the signature cannot be read.
pub fn compare(image: &[u8]) -> Result<Option<Hashed>, SignatureError> {
    let Some(signature) = signature(image)? else { return Ok(None) };
    let is_stale = |page: &&Page| {
        page.digest(image).is_none_or(|digest| image.get(page.hash.clone()) != Some(&digest[..]))
    };
    let stale = signature.pages.iter().filter(is_stale).count();
    Ok(Some(Hashed { pages: signature.pages.len(), stale }))
}

/// Renews the hashes of an image's signature; does nothing if it has none.
///
/// # Errors
/// [`SignatureError`] if the signature cannot be read, or not be renewed.
pub fn renew(image: &mut [u8]) -> Result<(), SignatureError> {
    let Some(signature) = signature(image)? else { return Ok(()) };
    if signature.has_certificate {
        return Err(SignatureError::Certificate);
    }
    if signature.has_other_hashes {
        return Err(SignatureError::Hash);
    }
    for page in signature.pages {
        let digest = page.digest(image).ok_or(SignatureError::Pages)?;
        image.get_mut(page.hash).ok_or(SignatureError::Pages)?.copy_from_slice(&digest);
    }
    Ok(())
}

fn signature(image: &[u8]) -> Result<Option<Signature>, SignatureError> {
    let Some((offset, blobs)) = (match File::parse(image)? {
        File::MachO32(file) => embedded(&file, image)?,
        File::MachO64(file) => embedded(&file, image)?,
        _ => None,
    }) else {
        return Ok(None);
    };
    let mut signature = Signature::default();
    for blob in blobs.blobs().take(MAX_PARTS) {
        let blob = blob?;
        // An ad-hoc signature may have an empty one.
        signature.has_certificate |=
            blob.magic() == CSMAGIC_BLOBWRAPPER && !blob.contents().is_empty();
        let Some(directory) = blob.code_directory()? else { continue };
        let CsFlags(flags) = directory.header().flags.get(BigEndian);
        signature.has_certificate |= flags & CS_ADHOC.0 == 0;
        if directory.header().hash_type == CS_HASHTYPE_SHA256 {
            let place = offset.checked_add(blob.offset() as usize).ok_or(SignatureError::Pages)?;
            pages(&directory, place, &mut signature.pages).ok_or(SignatureError::Pages)?;
        } else {
            signature.has_other_hashes = true;
        }
    }
    Ok(Some(signature))
}

/// The signature of an image, and where it begins.
fn embedded<'data, Mach: MachHeader>(
    file: &MachOFile<'data, Mach>,
    image: &'data [u8],
) -> object::read::Result<Option<(usize, CodeSignature<'data>)>> {
    let mut commands = file.macho_load_commands()?;
    while let Some(command) = commands.next()? {
        if command.cmd() == LC_CODE_SIGNATURE
            && let LoadCommandVariant::LinkeditData(data) = command.variant()?
        {
            let signature = data.code_signature(file.endian(), image)?;
            return Ok(Some((data.dataoff.get(file.endian()) as usize, signature)));
        }
    }
    Ok(None)
}

/// Adds the pages of `directory`, which begins at `place` in the image.
fn pages(directory: &CodeDirectory<'_>, place: usize, pages: &mut Vec<Page>) -> Option<()> {
    let header = directory.header();
    let end = usize::try_from(directory.code_limit()).ok()?;
    let count = header.n_code_slots.get(BigEndian);
    let page_size = match header.page_size {
        0 => end, // one page, of any size
        power => 1_usize.checked_shl(power.into())?,
    };
    if usize::from(header.hash_size) != HASH_BYTES
        || end.checked_div(page_size).map_or(0, |_| end.div_ceil(page_size)) != count as usize
    {
        return None;
    }
    for index in 0..count {
        // Inside the directory, and of SHA-256's size.
        directory.code_hash(index).ok()?;
        let index = index as usize;
        let first = index.checked_mul(page_size)?;
        let hash = place
            .checked_add(header.hash_offset.get(BigEndian) as usize)?
            .checked_add(index * HASH_BYTES)?;
        pages.push(Page {
            bytes: first..first.checked_add(page_size)?.min(end),
            hash: hash..hash.checked_add(HASH_BYTES)?,
        });
    }
    Some(())
}
