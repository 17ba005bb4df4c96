//! Updates: a manifest, and the ELF file that an update is made of. Any contents are refused with a
//! reason, or read correctly.

use hal_mock::chance::Chance;
use link::update_file::{PackError, pack};
use nucleo_g474re::slots::ORIGIN;
use update::identity::{Identity, SIZE, SYMBOL};
use update::manifest::{MANIFEST, Manifest};

use super::target::{Tally, Target};
use super::text::kind;

pub(super) const TARGET: Target = Target {
    name: "updates",
    what: "manifests of updates, and the ELF files that updates are made of",
    seeds_per_million: 50,
    feed,
    corpus: |tally| {
        elf(&small_elf(), tally)?;
        if tally.outcomes.contains_key("packed") { Ok(()) } else { Err("the undamaged file is not packed".into()) }
    },
};

/// Number of manifests and of files of each seed.
const TIMES: usize = 5;
/// Size of the header of a 32-bit ELF file, bytes.
const HEADER_BYTES: usize = 52;
/// Size of a segment's header, bytes.
const SEGMENT_BYTES: usize = 32;
/// Size of a section's header, bytes.
const SECTION_BYTES: usize = 40;
/// Size of a symbol's entry, bytes.
const ENTRY_BYTES: usize = 16;
/// Size of the image in the file, bytes.
const IMAGE_BYTES: usize = 256;

fn feed(seed: u64, tally: &mut Tally) -> Result<(), String> {
    let mut chance = Chance::new(seed);
    for _ in 0..TIMES {
        manifest(&mut chance, tally)?;
        let mut bytes = small_elf();
        damage(&mut chance, &mut bytes);
        elf(&bytes, tally)?;
    }
    Ok(())
}

/// Changes some bytes, mostly in the headers, or truncates the file.
fn damage(chance: &mut Chance, bytes: &mut Vec<u8>) {
    for _ in 0..=chance.below(5) {
        let within = if chance.strikes(0.7) { HEADER_BYTES + SEGMENT_BYTES } else { bytes.len() };
        let at = chance.below(within as u64) as usize;
        let new = [0, 1, 0x7f, 0x80, 0xff, chance.byte()][chance.below(6) as usize];
        if let Some(byte) = bytes.get_mut(at) {
            *byte = new;
        }
    }
    if chance.strikes(0.1) {
        bytes.truncate(chance.below(bytes.len() as u64) as usize);
    }
}

/// Decodes a manifest, possibly damaged.
fn manifest(chance: &mut Chance, tally: &mut Tally) -> Result<(), String> {
    let image: Vec<u8> = (0..chance.below(64)).map(|_| chance.byte()).collect();
    let identity: [u8; SIZE] = std::array::from_fn(|_| chance.byte());
    let whole = Manifest::of(Identity::decode(&identity), chance.below(1 << 32) as u32, &image);
    let mut bytes = whole.encode();
    let damaged = chance.strikes(0.7);
    if damaged {
        let at = chance.below(MANIFEST as u64) as usize;
        bytes[at] ^= 1 << chance.below(8);
    }
    tally.input(bytes.len());
    match Manifest::decode(&bytes) {
        // A manifest with a valid checksum must be the original one.
        Ok(read) if read != whole => return Err(format!("{whole:?} is read as {read:?}")),
        Ok(_) => tally.outcome("a manifest"),
        Err(defect) if damaged => tally.outcome(&kind(&format!("{defect:?}"))),
        Err(defect) => return Err(format!("{whole:?} is refused: {defect:?}")),
    }
    Ok(())
}

fn elf(bytes: &[u8], tally: &mut Tally) -> Result<(), String> {
    tally.input(bytes.len());
    match pack(bytes, None) {
        Ok(packed) => {
            let head = packed.first_chunk::<MANIFEST>().ok_or("an update without a manifest")?;
            let manifest = Manifest::decode(head).map_err(|defect| format!("packed, but refused: {defect:?}"))?;
            if manifest.length as usize != packed.len() - MANIFEST {
                return Err(format!("{} bytes packed as {}", packed.len() - MANIFEST, manifest.length));
            }
            tally.outcome("packed");
        }
        Err(PackError::Elf(error)) => tally.outcome(&kind(&error.to_string())),
        Err(error) => tally.outcome(&kind(&error.to_string())),
    }
    Ok(())
}

/// Returns a file with one segment at the address of a slot's image, and the symbol of its
/// identity.
fn small_elf() -> Vec<u8> {
    let mut bytes = vec![0; HEADER_BYTES + SEGMENT_BYTES];
    let image = bytes.len();
    bytes.extend(std::iter::repeat_n(0x5a, IMAGE_BYTES));
    let names = bytes.len();
    bytes.push(0);
    bytes.extend(SYMBOL.bytes());
    bytes.push(0);
    let names_len = bytes.len() - names;
    bytes.resize(bytes.len().next_multiple_of(4), 0);
    let symbols = bytes.len();
    let entry = |name: u32, value: u32, size: u32| [name, value, size, u32::from_le_bytes([0x11, 0, 1, 0])];
    for word in [entry(0, 0, 0), entry(1, ORIGIN + 16, SIZE as u32)].concat() {
        bytes.extend(word.to_le_bytes());
    }
    let sections = bytes.len();
    // The null section; the symbols, whose names are in section 2; the names.
    let place = |at: usize, len: usize| [0, at as u32, len as u32];
    let of = |kind: u32, place: [u32; 3], link: u32, entry: usize| {
        let [address, offset, size] = place;
        [0, kind, 0, address, offset, size, link, 1, 4, entry as u32]
    };
    let all = [of(0, [0; 3], 0, 0), of(2, place(symbols, 2 * ENTRY_BYTES), 2, ENTRY_BYTES), of(3, place(names, names_len), 0, 0)];
    for word in all.concat() {
        bytes.extend(word.to_le_bytes());
    }
    // Class 32, little-endian, version 1; executable, ARM, version 1.
    bytes[..7].copy_from_slice(b"\x7fELF\x01\x01\x01");
    let words = [40 << 16 | 2, 1, ORIGIN, HEADER_BYTES as u32, sections as u32, 0];
    let halves = [HEADER_BYTES, SEGMENT_BYTES, 1, SECTION_BYTES, 3, 2].map(|half| half as u16);
    let header = words.iter().flat_map(|word: &u32| word.to_le_bytes()).chain(halves.iter().flat_map(|half| half.to_le_bytes()));
    bytes[16..HEADER_BYTES].iter_mut().zip(header).for_each(|(to, byte)| *to = byte);
    let segment = [1, image as u32, ORIGIN, ORIGIN, IMAGE_BYTES as u32, IMAGE_BYTES as u32, 5, 4];
    let segment = segment.iter().flat_map(|word: &u32| word.to_le_bytes());
    bytes[HEADER_BYTES..HEADER_BYTES + SEGMENT_BYTES].iter_mut().zip(segment).for_each(|(to, byte)| *to = byte);
    bytes
}
