//! Updates: a manifest, and the ELF file that an update is made of. Whatever they hold, they are refused by name, or are what they say.

use hal_mock::chance::Chance;
use link::update_file::{PackError, pack};
use nucleo_g474re::slots::ORIGIN;
use update::identity::{Identity, SIZE, SYMBOL};
use update::manifest::{MANIFEST, Manifest};

use super::target::{Seen, Target};
use super::text::kind;

pub(super) const TARGET: Target = Target {
    name: "updates",
    what: "manifests of updates, and ELF files they are made of",
    seeds_per_million: 50,
    feed,
    corpus: |seen| {
        elf(&small_elf(), seen)?;
        if seen.outcomes.contains_key("packed") { Ok(()) } else { Err("the whole file is not packed".into()) }
    },
};

/// Manifests and files of each seed.
const TIMES: usize = 5;
/// Bytes of the header of an ELF file of 32 bits, of a segment's, of a section's, and of a symbol's entry.
const HEADER: usize = 52;
const SEGMENT: usize = 32;
const SECTION: usize = 40;
const ENTRY: usize = 16;
/// Bytes of the image in it.
const IMAGE: usize = 256;

fn feed(seed: u64, seen: &mut Seen) -> Result<(), String> {
    let mut chance = Chance::new(seed);
    for _ in 0..TIMES {
        manifest(&mut chance, seen)?;
        let mut bytes = small_elf();
        damage(&mut chance, &mut bytes);
        elf(&bytes, seen)?;
    }
    Ok(())
}

/// Damages the bytes here and there, mostly where numbers are, or cuts them short.
fn damage(chance: &mut Chance, bytes: &mut Vec<u8>) {
    for _ in 0..=chance.below(5) {
        let within = if chance.strikes(0.7) { HEADER + SEGMENT } else { bytes.len() };
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

/// A manifest as it is, damaged, or of bytes whose checksum is right.
fn manifest(chance: &mut Chance, seen: &mut Seen) -> Result<(), String> {
    let image: Vec<u8> = (0..chance.below(64)).map(|_| chance.byte()).collect();
    let identity: [u8; SIZE] = std::array::from_fn(|_| chance.byte());
    let whole = Manifest::of(Identity::decode(&identity), chance.below(1 << 32) as u32, &image);
    let mut bytes = whole.encode();
    let damaged = chance.strikes(0.7);
    if damaged {
        let at = chance.below(MANIFEST as u64) as usize;
        bytes[at] ^= 1 << chance.below(8);
    }
    seen.input(bytes.len());
    match Manifest::decode(&bytes) {
        // Behind the checksum nothing is said.
        Ok(read) if read != whole => return Err(format!("{whole:?} is read as {read:?}")),
        Ok(_) => seen.outcome("a manifest"),
        Err(defect) if damaged => seen.outcome(&kind(&format!("{defect:?}"))),
        Err(defect) => return Err(format!("{whole:?} is refused: {defect:?}")),
    }
    Ok(())
}

fn elf(bytes: &[u8], seen: &mut Seen) -> Result<(), String> {
    seen.input(bytes.len());
    match pack(bytes, None) {
        Ok(packed) => {
            let head = packed.first_chunk::<MANIFEST>().ok_or("an update without a manifest")?;
            let manifest = Manifest::decode(head).map_err(|defect| format!("packed, and refused: {defect:?}"))?;
            if manifest.length as usize != packed.len() - MANIFEST {
                return Err(format!("{} bytes packed as {}", packed.len() - MANIFEST, manifest.length));
            }
            seen.outcome("packed");
        }
        Err(PackError::Elf(error)) => seen.outcome(&kind(&error.to_string())),
        Err(error) => seen.outcome(&kind(&error.to_string())),
    }
    Ok(())
}

/// A file of one segment at the place of a slot's image, and the symbol that says what it is.
fn small_elf() -> Vec<u8> {
    let mut bytes = vec![0; HEADER + SEGMENT];
    let image = bytes.len();
    bytes.extend(std::iter::repeat_n(0x5a, IMAGE));
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
    // None; the symbols, whose names are in section 2; the names.
    let place = |at: usize, len: usize| [0, at as u32, len as u32];
    let of = |kind: u32, place: [u32; 3], link: u32, entry: usize| {
        let [address, offset, size] = place;
        [0, kind, 0, address, offset, size, link, 1, 4, entry as u32]
    };
    let all = [of(0, [0; 3], 0, 0), of(2, place(symbols, 2 * ENTRY), 2, ENTRY), of(3, place(names, names_len), 0, 0)];
    for word in all.concat() {
        bytes.extend(word.to_le_bytes());
    }
    // Class 32, little-endian, version 1; executable, ARM, version 1.
    bytes[..7].copy_from_slice(b"\x7fELF\x01\x01\x01");
    let words = [40 << 16 | 2, 1, ORIGIN, HEADER as u32, sections as u32, 0];
    let halves = [HEADER, SEGMENT, 1, SECTION, 3, 2].map(|half| half as u16);
    let header = words.iter().flat_map(|word: &u32| word.to_le_bytes()).chain(halves.iter().flat_map(|half| half.to_le_bytes()));
    bytes[16..HEADER].iter_mut().zip(header).for_each(|(to, byte)| *to = byte);
    let segment = [1, image as u32, ORIGIN, ORIGIN, IMAGE as u32, IMAGE as u32, 5, 4];
    let segment = segment.iter().flat_map(|word: &u32| word.to_le_bytes());
    bytes[HEADER..HEADER + SEGMENT].iter_mut().zip(segment).for_each(|(to, byte)| *to = byte);
    bytes
}
