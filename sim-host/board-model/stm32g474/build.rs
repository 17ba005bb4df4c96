//! Writes the register map of the STM32G474 from the metadata of `stm32-metapac`, which is made
//! from ST's own description: addresses as constants for patterns, and a table of every register
//! with its fields.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;
use std::{env, fs};

use stm32_metapac::metadata::ir::{Access, Array, BitOffset, Block, BlockItemInner, FieldSet, IR, Register};
use stm32_metapac::metadata::{METADATA, PeripheralRccRegister};

/// Fields: name, lowest bit and width.
type Fields = &'static [(&'static str, u32, u32)];

/// Registers with wrong fields in the metadata: RM0440 6.4.5, where R1MODE is bit 8 and not 0, and
/// 38.7.5, where BRR has 20 bits. ST's SVD agrees with the manual in both.
const CORRECTIONS: &[(&str, &str, Fields)] = &[("PWR", "CR5", &[("R1MODE", 8, 1)]), ("LPUART1", "BRR", &[("BRR", 0, 20)])];

/// GPIOx_BRR.
static BRR: Register = Register { access: Access::Write, bit_size: 16, fieldset: None };

/// Returns a name without its spelling in the metadata: `TIM_GP16` and `TimGp16` become equal.
fn plain(name: &str) -> String {
    name.replace('_', "").to_lowercase()
}

fn block<'a>(ir: &'a IR, name: &str) -> &'a Block {
    ir.blocks.iter().find(|block| plain(block.name) == plain(name)).expect("a block of this name")
}

/// Returns the offset and the name suffix of each element of an array.
fn elements(array: Option<&Array>) -> Vec<(u32, String)> {
    match array {
        None => vec![(0, String::new())],
        Some(Array::Regular(array)) => (0..array.len).map(|n| (n * array.stride, format!("_{n}"))).collect(),
        Some(Array::Cursed(array)) => array.offsets.iter().enumerate().map(|(n, &at)| (at, format!("_{n}"))).collect(),
    }
}

/// Collects every register of a block: offset, name, description.
fn registers<'a>(ir: &'a IR, of: &'a Block, at: u32, prefix: &str, into: &mut BTreeMap<u32, (String, Vec<&'a Register>)>) {
    for item in of.items {
        for (offset, suffix) in elements(item.array.as_ref()) {
            // CCMR1 and CCMR2 have a view for inputs and one for outputs.
            let name = match (item.name, suffix.as_str()) {
                ("ccmr_input" | "ccmr_output", "_0" | "") => "CCMR1".to_owned(),
                ("ccmr_input" | "ccmr_output", _) => "CCMR2".to_owned(),
                (name, suffix) => format!("{prefix}{}{suffix}", name.to_uppercase()),
            };
            let here = at + item.byte_offset + offset;
            match &item.inner {
                BlockItemInner::Register(register) => {
                    // Some addresses have several views, which share one register.
                    into.entry(here).or_insert((name, Vec::new())).1.push(register);
                }
                BlockItemInner::Block(inner) => registers(ir, block(ir, inner.block), here, &format!("{name}_"), into),
            }
        }
    }
    // Last, because a block has its own view of the registers that it extends.
    if let Some(base) = of.extends {
        registers(ir, block(ir, base), at, prefix, into);
    }
}

/// Collects every field: name, lowest bit, width.
fn fields(ir: &IR, set: &FieldSet, into: &mut Vec<(String, u32, u32)>) {
    if let Some(base) = set.extends.and_then(|base| ir.fieldsets.iter().find(|set| set.name == base)) {
        fields(ir, base, into);
    }
    for field in set.fields {
        for (offset, suffix) in elements(field.array.as_ref()) {
            let name = format!("{}{suffix}", field.name.to_uppercase());
            match &field.bit_offset {
                BitOffset::Regular(at) => into.push((name, at.offset + offset, field.bit_size)),
                BitOffset::Cursed(at) => {
                    for range in at.ranges {
                        into.push((name.clone(), range.start() + offset, range.end() - range.start() + 1));
                    }
                }
            }
        }
    }
}

/// Returns address and bit of a field of RCC.
fn field_of_rcc(of: Option<&PeripheralRccRegister>) -> Option<(u32, u32)> {
    let of = of?;
    let rcc = METADATA.peripherals.iter().find(|peripheral| peripheral.name == "RCC")?;
    let ir = rcc.registers.as_ref()?.ir;
    let item = ir.blocks[0].items.iter().find(|item| item.name.eq_ignore_ascii_case(of.register))?;
    let BlockItemInner::Register(register) = &item.inner else { return None };
    let set = ir.fieldsets.iter().find(|set| Some(set.name) == register.fieldset)?;
    let field = set.fields.iter().find(|field| field.name.eq_ignore_ascii_case(of.field))?;
    let BitOffset::Regular(at) = &field.bit_offset else { return None };
    Some((rcc.address as u32 + item.byte_offset, 1 << at.offset))
}

fn main() -> std::fmt::Result {
    let (mut offsets, mut bases, mut table) = (BTreeMap::new(), String::new(), Vec::new());
    for peripheral in METADATA.peripherals {
        let Some(of) = &peripheral.registers else { continue };
        let mut found = BTreeMap::new();
        registers(of.ir, block(of.ir, of.block), 0, "", &mut found);
        if of.kind == "gpio" {
            // GPIOx_BRR (RM0440 9.4.11) is missing in the metadata: the upper half of BSRR at its
            // own address.
            found.insert(0x28, ("BRR".to_owned(), vec![&BRR]));
        }
        writeln!(bases, "    pub const {}: u32 = {:#x};", peripheral.name, peripheral.address)?;
        offsets.entry(plain(of.block)).or_insert_with(|| {
            found.iter().map(|(at, (name, _))| format!("        pub const {name}: u32 = {at:#x};\n")).collect::<String>()
        });
        for (at, (name, views)) in &found {
            let mut list = Vec::new();
            for view in views {
                let set = view.fieldset.and_then(|name| of.ir.fieldsets.iter().find(|set| set.name == name));
                match set {
                    Some(set) => fields(of.ir, set, &mut list),
                    None => list.push((name.clone(), 0, view.bit_size)),
                }
            }
            if let Some((.., corrected)) =
                CORRECTIONS.iter().find(|(of, register, _)| (*of, *register) == (peripheral.name, name))
            {
                list = corrected.iter().map(|(name, at, size)| ((*name).to_owned(), *at, *size)).collect();
            }
            list.sort_by_key(|(_, at, size)| (*at, *size));
            list.dedup();
            let list: String = list.iter().map(|(name, at, size)| format!("({name:?}, {at}, {size}), ")).collect();
            let access = match views[0].access {
                Access::ReadWrite => "ReadWrite",
                Access::Read => "Read",
                Access::Write => "Write",
            };
            table.push((
                peripheral.address as u32 + at,
                format!(
                    "Register {{ peripheral: {:?}, name: {name:?}, base: {:#x}, address: {:#x}, access: Access::{access}, enable: {:?}, reset: {:?}, \
                     fields: &[{list}] }},\n",
                    peripheral.name,
                    peripheral.address,
                    peripheral.address as u32 + at,
                    field_of_rcc(peripheral.rcc.as_ref().and_then(|rcc| rcc.enable.as_ref())),
                    field_of_rcc(peripheral.rcc.as_ref().and_then(|rcc| rcc.reset.as_ref())),
                ),
            ));
        }
    }
    table.sort();
    let mut text = format!(
        "/// First address of each peripheral.\npub mod base {{\n{bases}}}\n/// Offsets of the registers, by kind of peripheral.\npub mod at {{\n"
    );
    for (kind, list) in offsets {
        writeln!(text, "    pub mod {kind} {{\n{list}    }}")?;
    }
    writeln!(text, "}}\n/// Interrupt lines.\npub mod line {{")?;
    for interrupt in METADATA.interrupts {
        writeln!(text, "    pub const {}: u16 = {};", interrupt.name, interrupt.number)?;
    }
    writeln!(
        text,
        "}}\n/// Peripheral, signal, pin and alternate function.\npub static SIGNALS: &[(&str, &str, &str, Option<u8>)] = &["
    )?;
    for peripheral in METADATA.peripherals {
        for pin in peripheral.pins {
            writeln!(text, "({:?}, {:?}, {:?}, {:?}),", peripheral.name, pin.signal, pin.pin, pin.af)?;
        }
    }
    writeln!(
        text,
        "];\n/// Peripheral, number among its triggers, and source.\npub static TRIGGERS: &[(&str, &str, &str)] = &["
    )?;
    for peripheral in METADATA.peripherals {
        for trigger in peripheral.triggers {
            writeln!(text, "({:?}, {:?}, {:?}),", peripheral.name, trigger.signal, trigger.source)?;
        }
    }
    writeln!(text, "];\n/// Every register of the part, by address.\npub static REGISTERS: &[Register] = &[")?;
    table.iter().for_each(|(_, row)| text.push_str(row));
    text.push_str("];\n");
    let to = env::var("OUT_DIR").expect("the directory that cargo names");
    fs::write(Path::new(&to).join("registers.rs"), text).expect("a directory that can be written");
    println!("cargo:rerun-if-changed=build.rs");
    Ok(())
}
