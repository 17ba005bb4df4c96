//! Execution of instructions (ARM DDI 0403, A7.7).

mod data;
mod dsp;
mod float;
mod load_store;
mod multiply;
mod special;

use std::sync::Arc;

use crate::breakpoints::BreakpointInstruction;
use crate::chip::Chip;
use crate::cpu::{Sleep, Trap};
use crate::machine::Machine;
use crate::op::{Index, Op, Sets, Size};
use crate::timing::Target;

impl<C: Chip> Machine<C> {
    /// Executes one decoded instruction.
    #[inline(always)]
    pub(crate) fn execute(&mut self, op: Op) -> Result<(), Trap> {
        let cpu = &mut self.cpu;
        match op {
            Op::AddImm { d, n, sets, imm } => cpu.add(d, cpu.get(n), imm, false, sets),
            Op::SubImm { d, n, sets, imm } => cpu.add(d, cpu.get(n), !imm, true, sets),
            Op::CmpImm { n, imm } => cpu.compare(cpu.get(n), imm),
            Op::MovImm { d, sets: Sets::Never, imm, .. } => cpu.set(d, imm),
            Op::MovImm { d, sets, rotated, imm } => {
                let (imm, carry) = cpu.expanded(imm, rotated);
                cpu.logical(d, imm, carry, sets);
            }
            Op::AddReg { d, n, m, sets } => cpu.add(d, cpu.get(n), cpu.get(m), false, sets),
            Op::SubReg { d, n, m, sets } => cpu.add(d, cpu.get(n), !cpu.get(m), true, sets),
            Op::CmpReg { n, m } => cpu.compare(cpu.get(n), cpu.get(m)),
            Op::MovReg { d, m, sets } => cpu.logical(d, cpu.get(m), cpu.flags.c, sets),
            Op::AluImm { alu, d, n, sets, rotated, imm } => cpu.alu(alu, d, n, cpu.expanded(imm, rotated), sets),
            Op::AluReg { alu, d, n, m, sets } => cpu.alu(alu, d, n, (cpu.get(m), cpu.flags.c), sets),
            Op::AluShift { alu, d, n, m, sets, shift, amount } => {
                let operand = cpu.shift(cpu.get(m), shift, amount);
                cpu.alu(alu, d, n, operand, sets);
            }
            Op::ShiftImm { d, m, sets, shift, amount } => cpu.shift_imm(d, m, sets, shift, amount),
            Op::ShiftReg { d, n, m, sets, shift } => {
                let (result, carry) = cpu.shift(cpu.get(n), shift, cpu.get(m) as u8);
                cpu.logical(d, result, carry, sets);
            }
            Op::MovTop { d, imm } => cpu.set(d, cpu.get(d) & 0xFFFF | u32::from(imm) << 16),
            Op::MovPc { m } => cpu.branch(cpu.get(m), Target::Register),
            Op::AddPc { m } => cpu.branch(cpu.get(15).wrapping_add(cpu.get(m)), Target::Register),
            Op::Bits { bits, d, m } => cpu.bits(bits, d, m),
            Op::Extend { extend, d, n, m, rotate } => cpu.extend(extend, d, n, m, rotate),
            Op::Extract { signed, d, n, lsb, width } => cpu.extract(signed, d, n, lsb, width),
            Op::Insert { d, n, lsb, width } => cpu.insert(d, n, lsb, width),
            Op::Saturate { signed, d, n, bits, shift, amount } => cpu.saturate(signed, d, n, bits, shift, amount),
            Op::Saturate16 { signed, d, n, bits } => cpu.saturate16(signed, d, n, bits),
            Op::SaturatingAdd { d, n, m, double, subtract } => cpu.saturating_add(d, n, m, double, subtract),
            Op::Pack { d, n, m, top, amount } => cpu.pack(d, n, m, top, amount),
            Op::Select { d, n, m } => cpu.select(d, n, m),
            Op::Parallel { lanes, parallel, d, n, m } => cpu.parallel(lanes, parallel, d, n, m),
            Op::Mul { d, n, m, sets } => {
                let result = cpu.get(n).wrapping_mul(cpu.get(m));
                cpu.logical(d, result, cpu.flags.c, sets);
            }
            Op::Mla { d, n, m, a } => cpu.set(d, cpu.get(n).wrapping_mul(cpu.get(m)).wrapping_add(cpu.get(a))),
            Op::Mls { d, n, m, a } => cpu.set(d, cpu.get(a).wrapping_sub(cpu.get(n).wrapping_mul(cpu.get(m)))),
            Op::Product { product, d, n, m, a } => cpu.product(product, d, n, m, a),
            Op::Long { long, lo, hi, n, m } => cpu.long(long, lo, hi, n, m),
            Op::Divide { signed, d, n, m } => return cpu.divide(signed, d, n, m),

            Op::Branch { target } => cpu.branch(target, Target::Immediate),
            Op::BranchIf { condition, target } => {
                if cpu.flags.hold(condition) {
                    cpu.branch(target, Target::Immediate);
                }
            }
            Op::BranchLink { target } => {
                cpu.r[14] = cpu.next | 1;
                cpu.branch(target, Target::Immediate);
            }
            Op::BranchExchange { m } => cpu.branch_exchange(cpu.get(m), Target::Register),
            Op::BranchLinkExchange { m } => {
                let target = cpu.get(m);
                cpu.r[14] = cpu.next | 1;
                cpu.branch_to(target, Target::Register);
            }
            Op::BranchZero { n, nonzero, target } => {
                if (cpu.get(n) != 0) == nonzero {
                    cpu.branch(target, Target::Immediate);
                }
            }
            Op::It { state } => cpu.it = state,
            Op::Nop | Op::Barrier => {}
            Op::WaitInterrupt => {
                cpu.asleep = Some(Sleep::Interrupt);
                cpu.schedule_check();
            }
            Op::WaitEvent if cpu.event => cpu.event = false,
            Op::WaitEvent => {
                cpu.asleep = Some(Sleep::Event);
                cpu.schedule_check();
            }
            Op::SendEvent => cpu.event = true,
            Op::Supervisor => return Err(Trap::Supervisor),
            Op::ClearExclusive => cpu.exclusive = None,
            Op::ChangeState { disable, primask, faultmask } => cpu.change_state(disable, primask, faultmask),
            Op::ReadSpecial { d, special } => cpu.read_special(d, special),
            Op::WriteSpecial { n, special, mask } => cpu.write_special(n, special, mask),
            Op::Undefined => return Err(Trap::Undefined),
            Op::NoCoprocessor => return Err(Trap::NoCoprocessor),
            Op::Breakpoint { number } => return self.breakpoint(number),

            Op::LdrImm { t, n, offset } => {
                let address = cpu.get(n).wrapping_add_signed(offset.into());
                self.load_to(Size::Word, t, address, n, n)?;
            }
            Op::StrImm { t, n, offset } => {
                let address = cpu.get(n).wrapping_add_signed(offset.into());
                let value = cpu.get(t);
                self.store(Size::Word, address, value)?;
            }
            Op::LoadImm { size, t, n, offset } => {
                let address = cpu.get(n).wrapping_add_signed(offset.into());
                self.load_to(size, t, address, n, n)?;
            }
            Op::StoreImm { size, t, n, offset } => {
                let address = cpu.get(n).wrapping_add_signed(offset.into());
                let value = cpu.get(t);
                self.store(size, address, value)?;
            }
            Op::LoadReg { size, t, n, m, shift } => {
                let address = cpu.get(n).wrapping_add(cpu.get(m) << shift);
                self.load_to(size, t, address, n, m)?;
            }
            Op::StoreReg { size, t, n, m, shift } => {
                let address = cpu.get(n).wrapping_add(cpu.get(m) << shift);
                let value = cpu.get(t);
                cpu.pipeline(n, m);
                self.store(size, address, value)?;
            }
            Op::LoadLiteral { size, t, address } => {
                cpu.load_from_code();
                self.load_to(size, t, address, 15, 15)?;
            }
            Op::LoadIndexed { size, t, n, after, offset } => {
                let base = cpu.get(n);
                let moved = base.wrapping_add_signed(offset.into());
                self.load_to(size, t, if after { base } else { moved }, n, n)?;
                self.cpu.set(n, moved);
            }
            Op::StoreIndexed { size, t, n, after, offset } => {
                let base = cpu.get(n);
                let moved = base.wrapping_add_signed(offset.into());
                let value = cpu.get(t);
                self.store(size, if after { base } else { moved }, value)?;
                self.cpu.set(n, moved);
            }
            Op::LoadPc { n, index, offset } => {
                let (address, moved) = cpu.indexed(n, index, offset);
                let target = self.load(Size::Word, address)?;
                self.cpu.set(n, moved);
                self.cpu.branch_exchange(target, Target::Loaded);
            }
            Op::LoadPcReg { n, m, shift } => {
                let address = cpu.get(n).wrapping_add(cpu.get(m) << shift);
                let target = self.load(Size::Word, address)?;
                self.cpu.branch_exchange(target, Target::Loaded);
            }
            Op::LoadPcLiteral { address } => {
                cpu.load_from_code();
                let target = self.load(Size::Word, address)?;
                self.cpu.branch_exchange(target, Target::Loaded);
            }
            Op::Unprivileged { load, size, t, n, offset } => {
                let address = cpu.get(n).wrapping_add(offset.into());
                return self.unprivileged(load, size, t, address);
            }
            Op::LoadDouble { t, t2, n, index, offset } => {
                let (address, moved) = cpu.indexed(n, index, offset);
                self.load_double(t, t2, address)?;
                if index != Index::Offset {
                    self.cpu.set(n, moved);
                }
            }
            Op::StoreDouble { t, t2, n, index, offset } => {
                let (address, moved) = cpu.indexed(n, index, offset);
                let (first, second) = (cpu.get(t), cpu.get(t2));
                self.store_aligned(address, first)?;
                self.store_aligned(address.wrapping_add(4), second)?;
                self.cpu.set(n, moved);
            }
            Op::LoadDoubleLiteral { t, t2, address } => {
                cpu.load_from_code();
                self.load_double(t, t2, address)?;
            }
            Op::LoadMany { n, list, before, back } => self.load_many(n, list, before, back)?,
            Op::StoreMany { n, list, before, back } => self.store_many(n, list, before, back)?,
            Op::Push { list } => self.store_many(13, list, true, true)?,
            Op::Pop { list } => self.load_many(13, list, false, true)?,
            Op::LoadExclusive { size, t, n, offset } => self.load_exclusive(size, t, n, offset)?,
            Op::StoreExclusive { size, d, t, n, offset } => self.store_exclusive(size, d, t, n, offset)?,
            Op::TableBranch { n, m, half } => {
                let (base, index) = (cpu.get(n), cpu.get(m));
                let offset = match half {
                    true => self.load(Size::Half, base.wrapping_add(index << 1))?,
                    false => self.load(Size::Byte, base.wrapping_add(index))?,
                };
                self.cpu.branch(self.cpu.get(15).wrapping_add(offset << 1), Target::Loaded);
            }

            _ => return self.execute_float(op),
        }
        Ok(())
    }

    /// Passes a breakpoint to the chip, which may answer it as a semihosting host does.
    fn breakpoint(&mut self, number: u8) -> Result<(), Trap> {
        let call = crate::chip::Breakpoint { number, r0: self.cpu.r[0], r1: self.cpu.r[1], pc: self.cpu.pc, at: self.cpu.cycle };
        let answer =
            self.chip.breakpoint(call, crate::chip::Ports { memory: &mut self.memory, interrupts: &mut self.interrupts });
        self.update_from_chip();
        match answer {
            Ok(Some(r0)) => {
                self.cpu.r[0] = r0;
                Ok(())
            }
            Ok(None) if self.debugged => {
                self.cpu.stop = Some(Arc::new(BreakpointInstruction));
                Err(Trap::Stop)
            }
            Ok(None) => Err(Trap::Breakpoint),
            Err(fault) => Err(self.cpu.trap(fault)),
        }
    }
}
