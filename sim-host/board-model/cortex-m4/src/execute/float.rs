//! Floating-point instructions (A7.7, VABS to VSUB).

use crate::chip::Chip;
use crate::cpu::{Cpu, Last, Trap};
use crate::float::{self, Rounding};
use crate::machine::Machine;
use crate::op::{Float1, Float2, Op};

impl Cpu {
    #[inline(always)]
    fn float(&self, s: u8) -> u32 {
        self.s[usize::from(s & 31)]
    }

    #[inline(always)]
    fn set_float(&mut self, s: u8, value: u32) {
        self.s[usize::from(s & 31)] = value;
    }

    /// Stores an arithmetic result. The very next instruction waits one cycle if it uses it.
    #[inline(always)]
    fn result(&mut self, d: u8, value: u32) {
        self.set_float(d, value);
        self.last_float = Last { register: d, next: self.instructions + 1 };
    }

    /// Adds the wait for operands that the previous instruction has computed.
    #[inline(always)]
    fn operands(&mut self, n: u8, m: u8) {
        let last = self.last_float;
        if last.next == self.instructions && (last.register == n || last.register == m) {
            self.cost += 1;
        }
    }

    fn float2(&mut self, op: Float2, d: u8, n: u8, m: u8) -> u32 {
        let (x, y, a) = (self.float(n), self.float(m), self.float(d));
        let fpscr = &mut self.fpscr;
        match op {
            Float2::Sub => float::subtract(x, y, fpscr),
            Float2::Nmul => float::negate(float::multiply(x, y, fpscr)),
            Float2::Div => float::divide(x, y, fpscr),
            Float2::Mla => float::add(a, float::multiply(x, y, fpscr), fpscr),
            Float2::Mls => float::add(a, float::negate(float::multiply(x, y, fpscr)), fpscr),
            Float2::Nmla => float::add(float::negate(a), float::negate(float::multiply(x, y, fpscr)), fpscr),
            Float2::Nmls => float::add(float::negate(a), float::multiply(x, y, fpscr), fpscr),
            Float2::Fma => float::multiply_add(a, x, y, fpscr),
            Float2::Fms => float::multiply_add(a, float::negate(x), y, fpscr),
            Float2::Fnma => float::multiply_add(float::negate(a), float::negate(x), y, fpscr),
            Float2::Fnms => float::multiply_add(float::negate(a), x, y, fpscr),
        }
    }

    fn float1(&mut self, op: Float1, d: u8, m: u8) -> u32 {
        let x = self.float(m);
        let old = self.float(d);
        let fpscr = &mut self.fpscr;
        let mode = Rounding::from_fpscr(*fpscr);
        match op {
            Float1::Mov => x,
            Float1::Abs => x & !(1 << 31),
            Float1::Neg => float::negate(x),
            Float1::Sqrt => float::square_root(x, fpscr),
            Float1::FromHalf { top } => float::from_half((if top { x >> 16 } else { x }) as u16, fpscr),
            Float1::ToHalf { top: false } => old & 0xFFFF_0000 | float::to_half(x, fpscr),
            Float1::ToHalf { top: true } => old & 0xFFFF | float::to_half(x, fpscr) << 16,
            Float1::FromInt { signed } => float::from_fixed(x, signed, false, 0, mode, fpscr),
            Float1::ToInt { signed, by_mode } => {
                float::to_fixed(x, signed, false, 0, if by_mode { mode } else { Rounding::Zero }, fpscr)
            }
            Float1::FromFixed { signed, half, fraction } => {
                float::from_fixed(old, signed, half, fraction, Rounding::Nearest, fpscr)
            }
            Float1::ToFixed { signed, half, fraction } => float::to_fixed(old, signed, half, fraction, Rounding::Zero, fpscr),
        }
    }
}

impl<C: Chip> Machine<C> {
    /// Executes an instruction of the FPU.
    #[inline]
    pub(super) fn execute_float(&mut self, op: Op) -> Result<(), Trap> {
        if !self.cpu.float_ready {
            self.prepare_float()?;
        }
        let cpu = &mut self.cpu;
        match op {
            Op::FloatAdd { d, n, m } => {
                cpu.operands(n, m);
                let result = float::add(cpu.float(n), cpu.float(m), &mut cpu.fpscr);
                cpu.result(d, result);
            }
            Op::FloatMul { d, n, m } => {
                cpu.operands(n, m);
                let result = float::multiply(cpu.float(n), cpu.float(m), &mut cpu.fpscr);
                cpu.result(d, result);
            }
            Op::Float2 { float, d, n, m } => {
                cpu.operands(n, m);
                if !matches!(float, Float2::Sub | Float2::Nmul | Float2::Div) && n != d && m != d {
                    cpu.operands(d, d);
                }
                let result = cpu.float2(float, d, n, m);
                cpu.result(d, result);
            }
            Op::Float1 { float, d, m } => {
                cpu.operands(m, d);
                let result = cpu.float1(float, d, m);
                match float {
                    Float1::Mov | Float1::Abs | Float1::Neg => cpu.set_float(d, result),
                    _ => cpu.result(d, result),
                }
            }
            Op::FloatImm { d, bits } => cpu.set_float(d, bits),
            Op::FloatCompare { d, m, signal } => {
                cpu.operands(d, m);
                let other = if m == 255 { 0 } else { cpu.float(m) };
                let flags = float::compare(cpu.float(d), other, signal, &mut cpu.fpscr);
                cpu.fpscr = cpu.fpscr & 0x0FFF_FFFF | flags << 28;
            }
            Op::FloatLoad { d, n, double, offset } => {
                if n == 15 {
                    cpu.load_from_code();
                }
                let (address, _) = cpu.indexed(n, crate::op::Index::Offset, offset);
                let first = self.load_aligned(address)?;
                if double {
                    let second = self.load_aligned(address.wrapping_add(4))?;
                    self.cpu.set_float(d + 1, second);
                }
                self.cpu.set_float(d, first);
            }
            Op::FloatStore { d, n, double, offset } => {
                let (address, _) = cpu.indexed(n, crate::op::Index::Offset, offset);
                cpu.operands(d, if double { d + 1 } else { d });
                self.store_aligned(address, self.cpu.float(d))?;
                if double {
                    self.store_aligned(address.wrapping_add(4), self.cpu.float(d + 1))?;
                }
            }
            Op::FloatLoadMany { n, first, count, before, back } => {
                let (mut address, moved) = cpu.block(n, count, before);
                for s in first..first + count {
                    let value = self.load_aligned(address)?;
                    self.cpu.set_float(s, value);
                    address = address.wrapping_add(4);
                }
                if back {
                    self.cpu.set(n, moved);
                }
            }
            Op::FloatStoreMany { n, first, count, before, back } => {
                let (mut address, moved) = cpu.block(n, count, before);
                cpu.operands(first, first + count - 1);
                for s in first..first + count {
                    self.store_aligned(address, self.cpu.float(s))?;
                    address = address.wrapping_add(4);
                }
                if back {
                    self.cpu.set(n, moved);
                }
            }
            Op::ToFloat { s, t } => cpu.set_float(s, cpu.get(t)),
            Op::FromFloat { s, t } => {
                cpu.operands(s, s);
                cpu.set(t, cpu.float(s));
            }
            Op::ToFloats { s, t, t2 } => {
                cpu.set_float(s, cpu.get(t));
                cpu.set_float(s + 1, cpu.get(t2));
            }
            Op::FromFloats { s, t, t2 } => {
                cpu.operands(s, s + 1);
                cpu.set(t, cpu.float(s));
                cpu.set(t2, cpu.float(s + 1));
            }
            Op::ReadFpscr { t: 15 } => {
                let flags = cpu.fpscr;
                let bit = |at: u32| flags >> at & 1 == 1;
                (cpu.flags.n, cpu.flags.z, cpu.flags.c, cpu.flags.v) = (bit(31), bit(30), bit(29), bit(28));
            }
            Op::ReadFpscr { t } => cpu.set(t, cpu.fpscr),
            Op::WriteFpscr { t } => cpu.fpscr = cpu.get(t) & float::FPSCR_BITS,
            _ => return Err(Trap::Undefined),
        }
        Ok(())
    }
}

impl Cpu {
    /// Returns the start address of `VLDM`, `VSTM`, and the base register afterwards.
    fn block(&self, n: u8, count: u8, before: bool) -> (u32, u32) {
        let (base, bytes) = (self.get(n), 4 * u32::from(count));
        if before { (base.wrapping_sub(bytes), base.wrapping_sub(bytes)) } else { (base, base.wrapping_add(bytes)) }
    }
}
