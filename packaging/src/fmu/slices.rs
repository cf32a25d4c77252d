//! Shared libraries of the platforms of FMI 3.0, which has a folder for each processor: macOS libraries for
//! several are taken apart.

use object::FileKind;
use object::macho::{FatArch32, FatArch64};
use object::read::macho::{FatArch, MachOFatFile};

use crate::platform::Platform;

/// The part of `library` that is for `platform`, if it has parts; otherwise the whole, whatever it is.
pub fn slice(library: &[u8], platform: Platform) -> Option<&[u8]> {
    match FileKind::parse(library) {
        Ok(FileKind::MachOFat32) => of_fat::<FatArch32>(library, platform),
        Ok(FileKind::MachOFat64) => of_fat::<FatArch64>(library, platform),
        _ => Some(library),
    }
}

fn of_fat<Fat: FatArch>(library: &[u8], platform: Platform) -> Option<&[u8]> {
    let fat = MachOFatFile::<Fat>::parse(library).ok()?;
    let arch =
        fat.arches().iter().find(|a| platform.architectures().contains(&a.architecture()))?;
    arch.data(library).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A universal file of two processors, whose parts are told by their bytes.
    fn universal() -> Vec<u8> {
        let mut bytes = Vec::new();
        let arches: [(u32, u8); 2] = [(0x0100_0007, 7), (0x0100_000c, 12)];
        let mut push = |word: u32| bytes.extend(word.to_be_bytes());
        push(0xcafe_babe);
        push(2);
        for (i, (processor, _)) in (0_u32..).zip(arches) {
            for word in [processor, 0, 4096 + 64 * i, 64, 2] {
                push(word);
            }
        }
        bytes.resize(4096, 0);
        for (_, content) in arches {
            bytes.extend([content; 64]);
        }
        bytes
    }

    #[test]
    fn each_processor_gets_its_part() {
        let universal = universal();
        assert_eq!(slice(&universal, Platform::X86_64Darwin), Some(&[7; 64][..]));
        assert_eq!(slice(&universal, Platform::Aarch64Darwin), Some(&[12; 64][..]));
        assert_eq!(slice(&universal, Platform::Darwin32), None);
    }

    #[test]
    fn what_has_no_parts_is_taken_whole() {
        let elf = b"\x7fELF\x02\x01\x01\0\0\0\0\0\0\0\0\0";
        assert_eq!(slice(elf, Platform::X86_64Linux), Some(&elf[..]));
        assert_eq!(slice(b"text", Platform::X86_64Linux), Some(&b"text"[..]));
    }
}
