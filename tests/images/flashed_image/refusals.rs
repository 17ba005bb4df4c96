//! Files that are not an image of this board are refused, with the reason.

use object::elf::PT_LOAD;
use object::read::elf::{ElfFile32, ProgramHeader as _};
use object::{LittleEndian, Object as _, ObjectSymbol as _};

use super::*;

/// Returns the message with which a board refuses an image.
fn refused(elf: &[u8]) -> String {
    let loaded = dummy_load();
    let scene = loaded.scene.driven().expect("a driven scene");
    Board::start(elf, &scene, Options::default()).expect_err("the image is refused").to_string()
}

fn put(elf: &mut [u8], at: usize, bytes: &[u8]) {
    elf[at..at + bytes.len()].copy_from_slice(bytes);
}

/// Offset of the address of the section headers in an ELF header of 32 bits.
const E_SHOFF: usize = 32;
/// Offset of the number of section headers.
const E_SHNUM: usize = 48;
/// Offset of the machine.
const E_MACHINE: usize = 18;

#[test]
fn an_image_for_another_processor_is_refused() {
    let Some(elf) = elf() else { return };
    assert_eq!(refused(b"nothing"), "the image cannot be run: not a readable ELF file");
    let host = std::fs::read(std::env::current_exe().expect("this program")).expect("this program is readable");
    let not_arm = "the image cannot be run: not for a little-endian 32-bit ARM processor";
    assert_eq!(refused(&host), not_arm);
    let mut risc_v = elf.to_vec();
    put(&mut risc_v, E_MACHINE, &243_u16.to_le_bytes());
    assert_eq!(refused(&risc_v), not_arm);
    // Linked for a microcontroller whose flash is at another address.
    let file: ElfFile32<LittleEndian> = ElfFile32::parse(elf).expect("an ELF file");
    let first = file.elf_program_headers().iter().position(|header| header.p_type(LittleEndian) == PT_LOAD).expect("a segment");
    let (program_headers, entry, physical_address) = (u32::from_le_bytes(elf[28..32].try_into().expect("four")) as usize, 32, 12);
    let mut moved = elf.to_vec();
    put(&mut moved, program_headers + first * entry + physical_address, &0x0020_0000_u32.to_le_bytes());
    let message = refused(&moved);
    assert!(message.contains("at 0x00200000 lies outside of the part's memories"), "{message}");
}

#[test]
fn a_stripped_image_is_refused() {
    let Some(elf) = elf() else { return };
    let mut stripped = elf.to_vec();
    put(&mut stripped, E_SHOFF, &[0; 4]);
    put(&mut stripped, E_SHNUM, &[0; 4]);
    assert_eq!(refused(&stripped), "the image cannot be run: stripped: there is no symbol table");
}

#[test]
fn an_unknown_access_stops_the_run_with_its_address() {
    let Some(elf) = elf() else { return };
    let file: ElfFile32<LittleEndian> = ElfFile32::parse(elf).expect("an ELF file");
    let reset = file.symbols().find(|symbol| symbol.name() == Ok("Reset")).expect("the first function").address() as u32 & !1;
    let segments = file.elf_program_headers().iter();
    let offset = |header: &&object::elf::ProgramHeader32<LittleEndian>| {
        let (from, size) = (header.p_paddr(LittleEndian), header.p_filesz(LittleEndian));
        (from..from + size).contains(&reset).then(|| (header.p_offset(LittleEndian) + reset - from) as usize)
    };
    let at =
        segments.filter(|header| header.p_type(LittleEndian) == PT_LOAD).find_map(|header| offset(&header)).expect("its bytes");
    // MOVW R0, #0x1058; MOVT R0, #0x4002; MOV R1, #1 << 25; STR R1, [R0]; LDR R1, [R0]:
    // RCC_APB1ENR1.FDCANEN.
    let clock = [0xF241_u16, 0x0058, 0xF2C4, 0x0002, 0xF04F, 0x7100, 0x6001, 0x6801];
    // MOVW R0, #0x6400; MOVT R0, #0x4000; LDR R0, [R0]: FDCAN1, which the microcontroller has and
    // the model lacks.
    let load = [0xF246_u16, 0x4000, 0xF2C4, 0x0000, 0x6800];
    let code: Vec<u8> = clock.iter().chain(&load).flat_map(|half| half.to_le_bytes()).collect();
    let mut other = elf.to_vec();
    put(&mut other, at, &code);
    let mut board = powered(&other, &[]);
    let message = board.run_for(Duration::from_millis(1)).expect_err("the run stops").to_string();
    assert!(message.contains("0x40006400") && message.contains("Reset"), "{message}");
}
