//! Registers and state of the processor.

use std::sync::Arc;

use crate::chip::Cycle;
use crate::exceptions::{Dwt, Mpu, Nvic, Scb, SysTick};
use crate::op::{Decoded, Sets, Shift};
use crate::timing::Timing;
use crate::watch::Watch;

/// Condition flags, saturation flag and the four greater-or-equal flags of the DSP extension.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Flags {
    pub(crate) n: bool,
    pub(crate) z: bool,
    pub(crate) c: bool,
    pub(crate) v: bool,
    pub(crate) q: bool,
    pub(crate) ge: u8,
}

impl Flags {
    /// Converts to the layout of APSR (B1.4.2).
    pub(crate) fn bits(self) -> u32 {
        let bit = |flag: bool, at: u32| u32::from(flag) << at;
        bit(self.n, 31) | bit(self.z, 30) | bit(self.c, 29) | bit(self.v, 28) | bit(self.q, 27) | u32::from(self.ge) << 16
    }

    /// Converts from the layout of APSR.
    pub(crate) fn from_bits(apsr: u32) -> Flags {
        let bit = |at: u32| apsr >> at & 1 == 1;
        Flags { n: bit(31), z: bit(30), c: bit(29), v: bit(28), q: bit(27), ge: (apsr >> 16 & 15) as u8 }
    }

    /// Returns `true` if a condition code of four bits holds (A7.3.1).
    #[inline]
    pub(crate) fn hold(self, condition: u8) -> bool {
        match condition {
            0b0000 => self.z,
            0b0001 => !self.z,
            0b0010 => self.c,
            0b0011 => !self.c,
            0b0100 => self.n,
            0b0101 => !self.n,
            0b0110 => self.v,
            0b0111 => !self.v,
            0b1000 => self.c && !self.z,
            0b1001 => !self.c || self.z,
            0b1010 => self.n == self.v,
            0b1011 => self.n != self.v,
            0b1100 => !self.z && self.n == self.v,
            0b1101 => self.z || self.n != self.v,
            _ => true,
        }
    }
}

/// Reason for which an instruction did not finish. Small and `Copy`, because every access returns
/// it; [`Cpu`] holds the details.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Trap {
    Undefined,
    NoCoprocessor,
    /// Branch to an even address.
    InvalidState,
    /// `EXC_RETURN` that matches no active exception.
    InvalidReturn,
    Unaligned,
    DivideByZero,
    /// Bus fault of the data at [`Cpu::fault_address`].
    Bus,
    Fetch,
    /// MPU violation of the data at [`Cpu::fault_address`].
    Memory,
    MemoryFetch,
    Breakpoint,
    /// `SVC`: an exception instead of a fault, with the next instruction as the return address.
    Supervisor,
    /// End of the run, with [`Cpu::stop`] as the reason.
    Stop,
}

/// Last load or arithmetic instruction, for instructions that overlap with it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Last {
    pub(crate) register: u8,
    /// Number of the following instruction.
    pub(crate) next: u64,
}

impl Default for Last {
    fn default() -> Self {
        Last { register: 0, next: u64::MAX }
    }
}

/// Processor without memories and chip.
#[derive(Clone, Debug)]
pub(crate) struct Cpu {
    /// R0 to R15. While an instruction runs, R15 is its address plus 4.
    pub(crate) r: [u32; 16],
    /// Address of the current or next instruction.
    pub(crate) pc: u32,
    /// Address of the following instruction.
    pub(crate) next: u32,
    pub(crate) flags: Flags,
    /// ITSTATE: 0 outside an IT block.
    pub(crate) it: u8,
    /// S0 to S31.
    pub(crate) s: [u32; 32],
    pub(crate) fpscr: u32,

    /// Inactive stack pointer: PSP, or MSP while `on_process_stack`.
    pub(crate) other_sp: u32,
    pub(crate) on_process_stack: bool,
    /// CONTROL.nPRIV
    pub(crate) unprivileged: bool,
    /// CONTROL.FPCA
    pub(crate) float_active: bool,
    pub(crate) primask: bool,
    pub(crate) faultmask: bool,
    pub(crate) basepri: u8,
    /// IPSR: number of the active exception, 0 in thread mode.
    pub(crate) ipsr: u16,

    pub(crate) nvic: Nvic,
    pub(crate) scb: Scb,
    pub(crate) systick: SysTick,
    pub(crate) mpu: Mpu,
    pub(crate) dwt: Dwt,

    /// `true` if floating-point instructions need no check of CPACR and the lazy state.
    pub(crate) float_ready: bool,
    /// Address that is marked exclusive.
    pub(crate) exclusive: Option<u32>,
    /// Event register of `WFE`.
    pub(crate) event: bool,
    pub(crate) asleep: Option<Sleep>,
    pub(crate) locked: bool,
    /// `true` in a debugger's step: interrupts, PendSV and SysTick wait.
    pub(crate) holds_interrupts: bool,

    pub(crate) cycle: Cycle,
    pub(crate) instructions: u64,
    /// Cycles of the current instruction.
    pub(crate) cost: u32,
    /// Cycle up to which instructions run without a check for events.
    pub(crate) deadline: Cycle,
    /// `EXC_RETURN` that the instruction has written to the PC.
    pub(crate) exception_return: Option<u32>,
    /// Aligned address of the 8 bytes of the last fetch; 1, which is not aligned, before the first.
    pub(crate) fetched: u32,
    /// Register that the previous instruction has computed, none, or the mark of a branch.
    pub(crate) computed: u8,
    pub(crate) timing: Timing,
    /// Number of successive 32-bit instructions that are not aligned.
    pub(crate) unaligned: u32,
    pub(crate) last_load: Last,
    pub(crate) last_float: Last,
    pub(crate) fault_address: u32,
    /// Reason of the stop; shared, so that a processor can be cloned.
    pub(crate) stop: Option<Arc<dyn std::error::Error + Send + Sync>>,
    pub(crate) watch: Watch,
}

/// Event that ends the sleep.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Sleep {
    Interrupt,
    Event,
}

impl Cpu {
    /// Returns the state after power-on, with `bits` implemented bits of interrupt priorities.
    pub(crate) fn new(priority_bits: u8) -> Cpu {
        Cpu {
            r: [0; 16],
            pc: 0,
            next: 0,
            flags: Flags::default(),
            it: 0,
            s: [0; 32],
            fpscr: 0,
            other_sp: 0,
            on_process_stack: false,
            unprivileged: false,
            float_active: false,
            primask: false,
            faultmask: false,
            basepri: 0,
            ipsr: 0,
            nvic: Nvic::new(priority_bits),
            scb: Scb::default(),
            systick: SysTick::default(),
            mpu: Mpu::default(),
            dwt: Dwt::default(),
            float_ready: false,
            exclusive: None,
            event: false,
            asleep: None,
            locked: false,
            holds_interrupts: false,
            cycle: 0,
            instructions: 0,
            cost: 0,
            deadline: 0,
            exception_return: None,
            fetched: 1,
            computed: Decoded::NONE,
            timing: Timing::Longest,
            unaligned: 0,
            last_load: Last::default(),
            last_float: Last::default(),
            fault_address: 0,
            stop: None,
            watch: Watch::default(),
        }
    }

    #[inline(always)]
    pub(crate) fn get(&self, n: u8) -> u32 {
        self.r[usize::from(n & 15)]
    }

    /// Writes a register. The two lowest bits of the stack pointer are always 0.
    #[inline(always)]
    pub(crate) fn set(&mut self, d: u8, value: u32) {
        self.r[usize::from(d & 15)] = value & !(3 * u32::from(d == 13));
    }

    #[inline(always)]
    pub(crate) fn sets(&self, sets: Sets) -> bool {
        match sets {
            Sets::Never => false,
            Sets::Always => true,
            Sets::OutsideIt => self.it == 0,
        }
    }

    #[inline(always)]
    pub(crate) fn set_nz(&mut self, result: u32) {
        self.flags.n = result >> 31 == 1;
        self.flags.z = result == 0;
    }

    /// Returns the shifted value and the carry out: `Shift_C` (A2.2.1).
    #[inline]
    pub(crate) fn shift(&self, value: u32, shift: Shift, amount: u8) -> (u32, bool) {
        let carry = self.flags.c;
        let amount = u32::from(amount);
        if amount == 0 {
            return (value, carry);
        }
        let bit = |at: u32| value.checked_shr(at).unwrap_or(0) & 1 == 1;
        match shift {
            Shift::Lsl => (value.checked_shl(amount).unwrap_or(0), amount <= 32 && bit(32 - amount)),
            Shift::Lsr => (value.checked_shr(amount).unwrap_or(0), bit(amount - 1)),
            Shift::Asr => ((value as i32 >> amount.min(31)) as u32, bit(amount.min(32) - 1)),
            Shift::Ror => {
                let result = value.rotate_right(amount);
                (result, result >> 31 == 1)
            }
            Shift::Rrx => (u32::from(carry) << 31 | value >> 1, bit(0)),
        }
    }

    /// Returns `true` in privileged state: in handlers, and in thread mode unless CONTROL.nPRIV is
    /// set.
    pub(crate) fn privileged(&self) -> bool {
        self.ipsr != 0 || !self.unprivileged
    }

    /// Selects the active stack pointer.
    pub(crate) fn use_process_stack(&mut self, process: bool) {
        if process != self.on_process_stack {
            std::mem::swap(&mut self.r[13], &mut self.other_sp);
            self.on_process_stack = process;
        }
    }

    /// Forces a check for events before the next instruction.
    #[inline]
    pub(crate) fn schedule_check(&mut self) {
        self.deadline = 0;
    }
}

/// Bit of the program counter that marks a branch out of Thumb state.
pub(crate) const INVALID: u32 = 1;
