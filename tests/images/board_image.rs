//! ELF file of the flashed image: its size, and the functions that can panic.

mod branches;
mod panics;
mod size;

use branches::functions;
use object::{Object as _, ObjectSymbol as _};

/// A pushed register, or a store relative to the stack pointer, would be the first write to the RAM
/// of the stack, which may be lost (ES0430 2.2.7).
#[test]
fn the_first_access_to_each_ram_is_not_needed() {
    let Some(elf) = size::image(&[]) else { return };
    let all = functions(&elf);
    let first = all.iter().position(|function| function.name == "__pre_init").expect("`__pre_init` is not the empty default");
    let reset = all.iter().find(|function| function.name == "Reset").expect("the reset handler");
    assert_eq!(reset.branches.get(&first), Some(&1), "the reset handler calls it");
    let file = object::File::parse(&*elf).expect("an ELF file");
    let code = branches::code(&file, "__pre_init");
    let text: Vec<String> = code.iter().map(|half| format!("{half:04x}")).collect();
    let bss = file.symbols().find(|symbol| symbol.name() == Ok("__sbss")).expect("the variables").address();
    assert!((0x2000_0000..0x2000_8000).contains(&bss), "{bss:#x} is not in the first part of the RAM");
    // movw, movt, movs r1, #0; str; mov.w, add.w, ldr three times; dsb; bx lr.
    assert_eq!(text[4..].join(" "), "2100 6001 f04f 5000 f500 4000 6801 f500 4000 6801 f500 4080 6801 f3bf 8f4f 4770");
}
