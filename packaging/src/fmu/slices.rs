//! Shared libraries of the platforms of FMI 3.0, which has a folder for each processor: macOS libraries for
//! several are taken apart.

use object::FileKind;
use object::macho::{FatArch32, FatArch64};
use object::read::macho::{FatArch, MachOFatFile};

use crate::platform::Platform;

/// The part of `library` that is for `platform`; the whole where it has no parts.
pub fn slice(library: &[u8], platform: Platform) -> Option<&[u8]> {
    match FileKind::parse(library).ok()? {
        FileKind::MachOFat32 => of_fat::<FatArch32>(library, platform),
        FileKind::MachOFat64 => of_fat::<FatArch64>(library, platform),
        _ => Some(library),
    }
}

fn of_fat<Fat: FatArch>(library: &[u8], platform: Platform) -> Option<&[u8]> {
    let fat = MachOFatFile::<Fat>::parse(library).ok()?;
    let arch =
        fat.arches().iter().find(|a| platform.architectures().contains(&a.architecture()))?;
    arch.data(library).ok()
}
