//! Direct branches between the functions of a thumb image, read from its instructions (ARM DDI 0403
//! A6, A7.7.12, A7.7.18).
//!
//! Calls and tail calls are both included. Calls to an address in a register are only counted.

use std::collections::BTreeMap;

use object::{Object as _, ObjectSection as _, ObjectSymbol as _, SymbolKind};
use rustc_demangle::demangle;

/// Prefix of the linker for the name of a thunk, which reaches a function that is too far away for
/// a direct call.
const THUNK: &str = "__Thumbv7ABSLongThunk_";

/// Function of the image.
pub struct Function {
    pub address: u32,
    pub name: String,
    /// Indices of the functions that it branches to, with the number of branches.
    pub branches: BTreeMap<usize, u32>,
    /// Number of calls to an address in a register.
    pub indirect: u32,
}

/// Returns all functions of an image, by rising addresses.
pub fn functions(elf: &[u8]) -> Vec<Function> {
    let file = object::File::parse(elf).expect("an ELF file");
    let mut found = BTreeMap::<u32, (u32, &str)>::new();
    // If a function has several names, the first one is used.
    for symbol in file.symbols().filter(|symbol| symbol.kind() == SymbolKind::Text && symbol.size() > 0) {
        found.entry(symbol.address() as u32 & !1).or_insert((symbol.size() as u32, symbol.name().expect("a name")));
    }
    let places: BTreeMap<u32, usize> = found.keys().copied().enumerate().map(|(place, address)| (address, place)).collect();
    // A branch to a thunk counts as a branch to its target.
    let by_name: BTreeMap<&str, usize> = found.iter().map(|(address, (_, name))| (*name, places[address])).collect();
    let meant = |place: usize, name: &str| name.strip_prefix(THUNK).and_then(|name| by_name.get(name).copied()).unwrap_or(place);
    let meant: Vec<usize> = found.iter().map(|(address, (_, name))| meant(places[address], name)).collect();
    let data = data(&file);
    let mut functions = Vec::new();
    for (&address, &(size, name)) in &found {
        let mut function = Function { address, name: format!("{:#}", demangle(name)), branches: BTreeMap::new(), indirect: 0 };
        for branch in branches(&halves(&file, address, size), address, &data) {
            match branch {
                Branch::To(target) => {
                    let to = places.get(&target).map(|&place| meant[place]);
                    to.into_iter().for_each(|to| *function.branches.entry(to).or_default() += 1);
                }
                Branch::Register => function.indirect += 1,
            }
        }
        functions.push(function);
    }
    functions
}

/// Returns the addresses at which data begins (`$d`, `true`) or ends (`$t`, `false`) within the
/// code.
fn data(file: &object::File) -> BTreeMap<u32, bool> {
    let marks = file.symbols().filter_map(|symbol| {
        let name = symbol.name().ok()?;
        let is = |mark: &str| name == mark || name.strip_prefix(mark).is_some_and(|rest| rest.starts_with('.'));
        (is("$d") || is("$t")).then(|| (symbol.address() as u32 & !1, is("$d")))
    });
    marks.collect()
}

/// Returns the halfwords of the function with this name.
pub fn code(file: &object::File, name: &str) -> Vec<u16> {
    let symbol = file.symbols().find(|symbol| symbol.name() == Ok(name)).expect("the function");
    halves(file, symbol.address() as u32 & !1, symbol.size() as u32)
}

/// Returns the halfwords of a function.
fn halves(file: &object::File, address: u32, size: u32) -> Vec<u16> {
    let holds = |section: &object::Section| (section.address()..section.address() + section.size()).contains(&u64::from(address));
    let bytes = file.sections().find(holds).and_then(|section| section.data_range(address.into(), size.into()).ok().flatten());
    bytes.unwrap_or_default().chunks_exact(2).map(|pair| u16::from_le_bytes([pair[0], pair[1]])).collect()
}

enum Branch {
    To(u32),
    /// `blx` of a register.
    Register,
}

/// Returns the branches of a function.
fn branches(halves: &[u16], address: u32, data: &BTreeMap<u32, bool>) -> Vec<Branch> {
    let mut found = Vec::new();
    let mut n = 0;
    while let Some(&first) = halves.get(n) {
        let at = address + 2 * n as u32;
        if data.range(..=at).next_back().is_some_and(|(_, is_data)| *is_data) {
            n += 1;
            continue;
        }
        // First halfwords with these bits begin an instruction of 32 bits.
        let second = if first >> 11 >= 0b11101 { halves.get(n + 1).copied() } else { None };
        let offset = match second {
            Some(second) => long(first, second),
            None => short(first),
        };
        found.extend(offset.map(|offset| Branch::To(at.wrapping_add(4).wrapping_add_signed(offset))));
        if first & 0xFF87 == 0x4780 {
            found.push(Branch::Register);
        }
        n += if second.is_some() { 2 } else { 1 };
    }
    found
}

/// Sign-extends a number of this many bits.
fn signed(value: u32, bits: u32) -> i32 {
    (value << (32 - bits)) as i32 >> (32 - bits)
}

/// Returns the offset of a branch of 16 bits.
fn short(code: u16) -> Option<i32> {
    let code = u32::from(code);
    match code >> 12 {
        // The conditions 14 and 15 are other instructions.
        0b1101 if code >> 8 & 15 < 14 => Some(signed((code & 0xFF) << 1, 9)),
        0b1110 if code >> 11 == 0b11100 => Some(signed((code & 0x7FF) << 1, 12)),
        _ => None,
    }
}

/// Returns the offset of a branch or call of 32 bits.
fn long(first: u16, second: u16) -> Option<i32> {
    let (first, second) = (u32::from(first), u32::from(second));
    if first >> 11 != 0b11110 || second >> 15 == 0 {
        return None;
    }
    let (sign, j1, j2, low) = (first >> 10 & 1, second >> 13 & 1, second >> 11 & 1, second & 0x7FF);
    if second >> 12 & 1 == 1 {
        let (i1, i2) = (1 ^ j1 ^ sign, 1 ^ j2 ^ sign);
        return Some(signed(sign << 24 | i1 << 23 | i2 << 22 | (first & 0x3FF) << 12 | low << 1, 25));
    }
    // A conditional branch, or not a branch.
    let is_call = second >> 14 & 1 == 1;
    (!is_call && first >> 6 & 0xE != 0xE).then(|| signed(sign << 20 | j2 << 19 | j1 << 18 | (first & 0x3F) << 12 | low << 1, 21))
}

#[test]
fn branches_are_decoded_as_in_the_manual() {
    // b.n -4; beq +0; bl +0x1000; bl -4; b.w -8; beq.w +0x100. Neither dmb nor data is a branch.
    assert_eq!([short(0xE7FE), short(0xD000), short(0xDE00)], [Some(-4), Some(0), None]);
    assert_eq!(long(0xF001, 0xF800), Some(0x1000));
    assert_eq!(long(0xF7FF, 0xFFFE), Some(-4));
    assert_eq!(long(0xF7FF, 0xBFFC), Some(-8));
    assert_eq!(long(0xF000, 0x8080), Some(0x100));
    assert_eq!(long(0xF3BF, 0x8F5F), None);
    let halves = [0xF001, 0xF800, 0x4780, 0xE7FE];
    let places = |data: &BTreeMap<u32, bool>| {
        let of = |branch: &Branch| if let Branch::To(target) = branch { *target } else { 0 };
        branches(&halves, 0x100, data).iter().map(of).collect::<Vec<_>>()
    };
    assert_eq!(places(&BTreeMap::new()), [0x1104, 0, 0x106]);
    assert_eq!(places(&BTreeMap::from([(0x104, true), (0x106, false)])), [0x1104, 0x106]);
}
