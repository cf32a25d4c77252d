//! Writing a design into the shared library of an FMU: data into a reserved section, no compiler.

use object::{Object as _, ObjectSection as _};
use steerguard_fmu_core::{SealError, baked};

use crate::mach_o::{self, SignatureError};
use crate::platform::Platform;

/// A library that a design cannot be baked into.
#[derive(Debug, thiserror::Error)]
pub enum BakeError {
    /// The file is no object file.
    #[error("not a shared library: {0}")]
    NotALibrary(#[from] object::read::Error),
    /// The library is for another platform.
    #[error("not a shared library for {}", .0.folder())]
    Platform(Platform),
    /// The library is none of ours.
    #[error("no section `{0}` to bake a design into: not a steerguard runtime")]
    NoSection(&'static str),
    /// The section does not take the design.
    #[error(transparent)]
    Seal(#[from] SealError),
    /// Its code signature cannot be renewed.
    #[error(transparent)]
    Signature(#[from] SignatureError),
}

/// `library`, a file for `platform`, with GUID and payload baked into it: into every slice of a
/// universal file, whose page hashes are renewed.
///
/// # Errors
/// [`BakeError`].
pub fn bake(
    library: &[u8],
    platform: Platform,
    guid: &str,
    payload: &[u8],
) -> Result<Vec<u8>, BakeError> {
    let mut library = library.to_vec();
    for range in mach_o::images(&library)? {
        if let Some(image) = library.get_mut(range) {
            bake_image(image, platform, guid, payload)?;
        }
    }
    Ok(library)
}

fn bake_image(
    image: &mut [u8],
    platform: Platform,
    guid: &str,
    payload: &[u8],
) -> Result<(), BakeError> {
    let name = platform.section();
    let file = object::File::parse(&*image)?;
    if !platform.accepts(&file) {
        return Err(BakeError::Platform(platform));
    }
    let range = file.section_by_name(name).and_then(|section| section.file_range());
    let (offset, size) = range.ok_or(BakeError::NoSection(name))?;
    let section = usize::try_from(offset)
        .ok()
        .zip(usize::try_from(size).ok())
        .and_then(|(offset, size)| image.get_mut(offset..offset.checked_add(size)?));
    baked::seal(section.ok_or(BakeError::NoSection(name))?, guid, payload)?;
    Ok(mach_o::renew(image)?)
}
