//! Private peripheral bus: addresses of the processor's registers (B3.1).

use std::sync::Arc;

use super::{EXTERNAL, NMI, PENDSV, SYSTICK};
use crate::chip::{Chip, Width};
use crate::cpu::{Cpu, Trap};
use crate::interrupts::LINES;
use crate::machine::Machine;

/// Access to a register of the processor that is not modelled.
#[derive(Debug, thiserror::Error)]
#[error("{} of the processor register {address:#010x}, which is not modelled", if *.write { "write" } else { "read" })]
pub struct UnknownRegister {
    /// Address of the register.
    pub address: u32,
    /// `true` if the access is a write.
    pub write: bool,
}

/// States of handlers in SHCSR: exception number, and bits of active and pending (B3.2.13).
const HANDLERS: [(u16, u32, u32); 6] = [(4, 0, 13), (5, 1, 14), (6, 3, 12), (11, 7, 15), (14, 10, 32), (15, 11, 32)];

/// Returns the word of 32 interrupt lines with this number.
fn word(set: u128, number: u32) -> u32 {
    set.checked_shr(32 * number).unwrap_or(0) as u32
}

fn lines(number: u32, value: u32) -> u128 {
    u128::from(value).checked_shl(32 * number).unwrap_or(0)
}

impl<C: Chip> Machine<C> {
    fn unknown(&mut self, address: u32, write: bool) -> Trap {
        self.cpu.stop = Some(Arc::new(UnknownRegister { address, write }));
        Trap::Stop
    }

    /// Returns `true` if a register may be accessed by byte or halfword.
    fn is_divisible(address: u32) -> bool {
        matches!(address, 0xE000_E400..0xE000_E500 | 0xE000_ED18..0xE000_ED24 | 0xE000_ED28..0xE000_ED2C)
    }

    pub(crate) fn read_private(&mut self, width: Width, address: u32) -> Result<u32, Trap> {
        if !self.cpu.privileged() || self.as_user {
            return Err(Trap::Bus);
        }
        if width != Width::Word && !Self::is_divisible(address) {
            return Err(self.unknown(address, false));
        }
        let value = self.read_register(address & !3).ok_or_else(|| self.unknown(address, false))?;
        Ok(value >> (8 * (address & 3)))
    }

    pub(crate) fn write_private(&mut self, width: Width, address: u32, value: u32) -> Result<(), Trap> {
        let triggers = address == 0xE000_EF00 && self.cpu.scb.ccr & 2 != 0;
        if (!self.cpu.privileged() || self.as_user) && !triggers {
            return Err(Trap::Bus);
        }
        let shift = 8 * (address & 3);
        let mask = match width {
            Width::Word => u32::MAX,
            Width::Half => 0xFFFF << shift,
            Width::Byte => 0xFF << shift,
        };
        let mut value = value << shift;
        if width != Width::Word {
            if !Self::is_divisible(address) {
                return Err(self.unknown(address, true));
            }
            // Writing ones clears CFSR, so the bytes that are not written must be zero.
            if address & !3 != 0xE000_ED28 {
                value |= self.read_register(address & !3).unwrap_or(0) & !mask;
            }
        }
        let known = self.write_register(address & !3, value);
        self.cpu.float_ready = false;
        self.cpu.schedule_check();
        known.ok_or_else(|| self.unknown(address, true))
    }

    pub(crate) fn read_register(&mut self, address: u32) -> Option<u32> {
        let cpu = &mut self.cpu;
        let number = (address & 0x7F) / 4;
        Some(match address {
            0xE000_1000 => cpu.dwt.control | 4 << 28,
            0xE000_1004 => cpu.dwt.count(cpu.cycle),
            0xE000_E004 => u32::from(LINES) / 32 - 1,
            0xE000_E008 => cpu.scb.actlr,
            0xE000_E010..0xE000_E020 => cpu.systick.read(address & 15, cpu.cycle),
            0xE000_E100..0xE000_E140 | 0xE000_E180..0xE000_E1C0 => word(cpu.nvic.enabled, number),
            0xE000_E200..0xE000_E240 | 0xE000_E280..0xE000_E2C0 => word(cpu.nvic.pending, number),
            0xE000_E300..0xE000_E340 => word(cpu.nvic.active, number),
            0xE000_E400..0xE000_E500 => priorities(cpu, EXTERNAL + (address & 0xFF) as u16),
            0xE000_ED00 => 0x410F_C241,
            0xE000_ED04 => interrupt_state(cpu),
            0xE000_ED08 => cpu.scb.vtor,
            0xE000_ED0C => 0xFA05_0000 | cpu.scb.aircr,
            0xE000_ED10 => cpu.scb.scr,
            0xE000_ED14 => cpu.scb.ccr,
            0xE000_ED18 | 0xE000_ED1C | 0xE000_ED20 => priorities(cpu, (address - 0xE000_ED14) as u16),
            0xE000_ED24 => handler_states(cpu),
            0xE000_ED28 => cpu.scb.cfsr,
            0xE000_ED2C => cpu.scb.hfsr,
            0xE000_ED30 => cpu.scb.dfsr,
            0xE000_ED34 => cpu.scb.mmfar,
            0xE000_ED38 => cpu.scb.bfar,
            0xE000_ED3C => 0,
            0xE000_ED40..0xE000_ED74 => IDENTITY[((address - 0xE000_ED40) / 4) as usize],
            0xE000_ED88 => cpu.scb.cpacr,
            0xE000_ED90..0xE000_EDBC => cpu.mpu.read(address - 0xE000_ED90),
            // C_DEBUGEN of DHCSR.
            0xE000_EDF0 => self.debugged.into(),
            0xE000_EDFC => cpu.scb.demcr,
            0xE000_EF34 => cpu.scb.fpccr,
            0xE000_EF38 => cpu.scb.fpcar,
            0xE000_EF3C => cpu.scb.fpdscr,
            0xE000_EF40 => 0x1011_0021,
            0xE000_EF44 => 0x1100_0011,
            _ => return None,
        })
    }

    fn write_register(&mut self, address: u32, value: u32) -> Option<()> {
        let cpu = &mut self.cpu;
        let number = (address & 0x7F) / 4;
        let now = cpu.cycle;
        match address {
            0xE000_1000 => cpu.dwt.set_control(value & 0x007F_1FFF, cpu.dwt.enabled, now),
            0xE000_1004 => cpu.dwt.set_count(value, now),
            // Lock access register: there is no lock to open.
            0xE000_1FB0 => {}
            0xE000_E008 => cpu.scb.actlr = value & 0x307,
            0xE000_E010..0xE000_E01C => cpu.systick.write(address & 15, value, now),
            0xE000_E100..0xE000_E140 => cpu.nvic.enabled |= lines(number, value),
            0xE000_E180..0xE000_E1C0 => cpu.nvic.enabled &= !lines(number, value),
            0xE000_E200..0xE000_E240 => cpu.nvic.pending |= lines(number, value),
            // The interrupt of a high line stays pending.
            0xE000_E280..0xE000_E2C0 => cpu.nvic.pending &= !lines(number, value) | cpu.nvic.levels & !cpu.nvic.active,
            0xE000_E400..0xE000_E500 => set_priorities(cpu, EXTERNAL + (address & 0xFF) as u16, value),
            0xE000_ED04 => {
                let bit = |at: u32| value >> at & 1 == 1;
                for (sets, clears, exception) in [(31, 32, NMI), (28, 27, PENDSV), (26, 25, SYSTICK)] {
                    if bit(sets) {
                        cpu.nvic.pend_system(exception);
                    } else if clears < 32 && bit(clears) {
                        cpu.nvic.system_pending &= !(1 << exception);
                    }
                }
            }
            0xE000_ED08 => cpu.scb.vtor = value & !0x7F,
            0xE000_ED0C if value >> 16 == 0x05FA => {
                cpu.scb.aircr = value & 0x700;
                if value & 4 != 0 {
                    self.interrupts.pull_reset();
                }
            }
            // A write without the key does nothing.
            0xE000_ED0C => {}
            0xE000_ED10 => cpu.scb.scr = value & 0x16,
            0xE000_ED14 => cpu.scb.ccr = value & 0x31B,
            0xE000_ED18 | 0xE000_ED1C | 0xE000_ED20 => set_priorities(cpu, (address - 0xE000_ED14) as u16, value),
            0xE000_ED24 => set_handler_states(cpu, value),
            0xE000_ED28 => cpu.scb.cfsr &= !value,
            0xE000_ED2C => cpu.scb.hfsr &= !value,
            0xE000_ED30 => cpu.scb.dfsr &= !value,
            0xE000_ED34 => cpu.scb.mmfar = value,
            0xE000_ED38 => cpu.scb.bfar = value,
            0xE000_ED3C => {}
            0xE000_ED88 => cpu.scb.cpacr = value & 0x00F0_0000,
            0xE000_ED94..0xE000_EDBC => cpu.mpu.write(address - 0xE000_ED90, value),
            0xE000_EDFC => {
                cpu.scb.demcr = value & 0x010F_07F1;
                cpu.dwt.set_control(cpu.dwt.control, value >> 24 & 1 == 1, now);
            }
            0xE000_EF00 => cpu.nvic.pending |= 1 << (value & 0x7F),
            0xE000_EF34 => cpu.scb.fpccr = value & 0xC000_017B,
            0xE000_EF38 => cpu.scb.fpcar = value & !7,
            0xE000_EF3C => cpu.scb.fpdscr = value & 0x07C0_0000,
            _ => return None,
        }
        Some(())
    }
}

/// ID_PFR0 to ID_ISAR4 (ARM DDI 0439, table 4-1).
const IDENTITY: [u32; 13] = [
    0x0000_0030,
    0x0000_0200,
    0x0010_0000,
    0,
    0x0010_0030,
    0,
    0x0100_0000,
    0,
    0x0114_1110,
    0x0211_2000,
    0x2123_2231,
    0x0111_1131,
    0x0131_0132,
];

/// Returns four priorities, starting with exception `first`.
fn priorities(cpu: &Cpu, first: u16) -> u32 {
    (0..4).map(|at| u32::from(cpu.nvic.stored_priority(first + at)) << (8 * at)).sum()
}

fn set_priorities(cpu: &mut Cpu, first: u16, value: u32) {
    for (at, priority) in value.to_le_bytes().into_iter().enumerate() {
        cpu.nvic.set_priority(first + at as u16, priority);
    }
}

/// ICSR (B3.2.4)
fn interrupt_state(cpu: &Cpu) -> u32 {
    let nvic = &cpu.nvic;
    let pending = |exception: u16, at: u32| u32::from(nvic.system_pending >> exception & 1) << at;
    let external = u32::from(nvic.pending & nvic.enabled != 0) << 22;
    let next = u32::from(nvic.most_urgent().unwrap_or(0)) << 12;
    let alone = u32::from(nvic.active_count() <= 1) << 11;
    pending(NMI, 31) | pending(PENDSV, 28) | pending(SYSTICK, 26) | external | next | alone | u32::from(cpu.ipsr)
}

/// SHCSR (B3.2.13)
fn handler_states(cpu: &Cpu) -> u32 {
    let bit = |set: u16, exception: u16, at: u32| u32::from(set >> exception & 1).checked_shl(at).unwrap_or(0);
    HANDLERS.iter().fold(cpu.scb.shcsr, |value, (exception, active, pending)| {
        value | bit(cpu.nvic.system_active, *exception, *active) | bit(cpu.nvic.system_pending, *exception, *pending)
    })
}

fn set_handler_states(cpu: &mut Cpu, value: u32) {
    cpu.scb.shcsr = value & 0x7_0000;
    let put = |set: &mut u16, exception: u16, at: u32| {
        if at < 32 {
            *set = *set & !(1 << exception) | ((value >> at & 1) as u16) << exception;
        }
    };
    for (exception, active, pending) in HANDLERS {
        put(&mut cpu.nvic.system_active, exception, active);
        put(&mut cpu.nvic.system_pending, exception, pending);
    }
}
