//! Loading of ELF files, and refused files.

use crate::support::{CODE, Part, RAM};
use sonoglide_cortex_m4::{ImageError, Machine, Memory, Region};

const ARM: u16 = 40;

/// Variable fields of a file.
struct File {
    machine: u16,
    entry: u32,
    load: u32,
    symbols: bool,
}

impl Default for File {
    fn default() -> File {
        File { machine: ARM, entry: CODE + 9, load: CODE, symbols: true }
    }
}

/// Builds a file of one segment: a vector table of two words, and `MOVS R0, #6; B` to itself in a
/// function with a mangled name.
fn build(file: &File) -> Vec<u8> {
    let names = b"\0_ZN5board4main17h0123456789abcdefE\0.symtab\0.strtab\0";
    let text: Vec<u8> = [RAM + 0x100, CODE + 9, 0xE7FE_2006].iter().flat_map(|word| word.to_le_bytes()).collect();
    let (text_at, symbols_at) = (52 + 32, 52 + 32 + text.len() as u32);
    let names_at = symbols_at + 32;
    let sections_at = names_at + names.len() as u32;
    let mut bytes = b"\x7fELF\x01\x01\x01\0\0\0\0\0\0\0\0\0".to_vec();
    let half = |bytes: &mut Vec<u8>, values: &[u16]| bytes.extend(values.iter().flat_map(|value| value.to_le_bytes()));
    let word = |bytes: &mut Vec<u8>, values: &[u32]| bytes.extend(values.iter().flat_map(|value| value.to_le_bytes()));
    half(&mut bytes, &[2, file.machine]);
    word(&mut bytes, &[1, file.entry, 52, if file.symbols { sections_at } else { 0 }, 0x0500_0000]);
    half(&mut bytes, &[52, 32, 1, 40, if file.symbols { 3 } else { 0 }, if file.symbols { 2 } else { 0 }]);
    // PT_LOAD: the run address differs from the load address, as for initialised data.
    word(&mut bytes, &[1, text_at, RAM, file.load, text.len() as u32, text.len() as u32, 5, 4]);
    bytes.extend(&text);
    word(&mut bytes, &[0; 4]);
    // STT_FUNC, global, absolute.
    word(&mut bytes, &[1, CODE + 9, 4]);
    half(&mut bytes, &[0x12, 0xFFF1]);
    bytes.extend(names);
    word(&mut bytes, &[0; 10]);
    word(&mut bytes, &[36, 2, 0, 0, symbols_at, 32, 2, 1, 4, 16]);
    word(&mut bytes, &[44, 3, 0, 0, names_at, names.len() as u32, 0, 0, 1, 0]);
    bytes
}

fn load(file: &File) -> Result<Machine<Part>, ImageError> {
    let mut memory = Memory::default();
    memory.add(Region { base: CODE, bytes: vec![0xFF; 4096], writable: false, waits: true });
    memory.add(Region { base: RAM, bytes: vec![0; 4096], writable: true, waits: false });
    Machine::new(&build(file), memory, Part::default(), 4)
}

#[test]
fn an_image_is_loaded_and_starts_at_its_vector() {
    let mut machine = load(&File::default()).expect("the file is loaded");
    assert_eq!((machine.register(13), machine.register(15)), (RAM + 0x100, CODE + 8));
    machine.run_until(20).expect("the program runs");
    assert_eq!(machine.register(0), 6);
}

#[test]
fn functions_have_their_demangled_names() {
    let machine = load(&File::default()).expect("the file is loaded");
    let function = machine.symbols().function(CODE + 10).expect("the function");
    assert_eq!((function.name.as_str(), function.address, function.size), ("board::main", CODE + 8, 4));
    assert_eq!(machine.symbols().address("_ZN5board4main17h0123456789abcdefE"), Some(CODE + 8));
    assert!(machine.symbols().function(CODE + 12).is_none());
}

#[test]
fn unsuitable_files_are_refused_by_name() {
    let refused = |file: File| load(&file).expect_err("the file is refused");
    assert!(matches!(refused(File { machine: 62, ..File::default() }), ImageError::NotArm));
    assert!(matches!(refused(File { entry: CODE + 8, ..File::default() }), ImageError::NotThumb(_)));
    assert!(matches!(refused(File { symbols: false, ..File::default() }), ImageError::Stripped));
    let outside = refused(File { load: CODE + 4090, ..File::default() });
    assert_eq!(outside.to_string(), "the segment of 12 bytes at 0x08000ffa lies outside of the part's memories");
    let memory = Memory::default();
    assert!(matches!(Machine::new(b"no ELF", memory, Part::default(), 4), Err(ImageError::Unreadable(_))));
}
