//! System control block (B3.2) and control of the floating-point context (B3.2.20 to B3.2.22).

use super::{BUS_FAULT, MEMORY_FAULT, USAGE_FAULT};

/// FPCCR: automatic state preservation.
pub(crate) const ASPEN: u32 = 1 << 31;
/// FPCCR: lazy state preservation.
pub(crate) const LSPEN: u32 = 1 << 30;
/// FPCCR: lazy state preservation pending.
pub(crate) const LSPACT: u32 = 1;

/// CFSR (B3.2.15).
pub(crate) const DACCVIOL: u32 = 1 << 1;
pub(crate) const IACCVIOL: u32 = 1;
pub(crate) const MUNSTKERR: u32 = 1 << 3;
pub(crate) const MSTKERR: u32 = 1 << 4;
pub(crate) const MLSPERR: u32 = 1 << 5;
pub(crate) const MMARVALID: u32 = 1 << 7;
pub(crate) const IBUSERR: u32 = 1 << 8;
pub(crate) const PRECISERR: u32 = 1 << 9;
pub(crate) const UNSTKERR: u32 = 1 << 11;
pub(crate) const STKERR: u32 = 1 << 12;
pub(crate) const LSPERR: u32 = 1 << 13;
pub(crate) const BFARVALID: u32 = 1 << 15;
pub(crate) const UNDEFINSTR: u32 = 1 << 16;
pub(crate) const INVSTATE: u32 = 1 << 17;
pub(crate) const INVPC: u32 = 1 << 18;
pub(crate) const NOCP: u32 = 1 << 19;
pub(crate) const UNALIGNED: u32 = 1 << 24;
pub(crate) const DIVBYZERO: u32 = 1 << 25;

/// HFSR: fault while reading a vector.
pub(crate) const VECTTBL: u32 = 1 << 1;
/// HFSR: escalated fault.
pub(crate) const FORCED: u32 = 1 << 30;
/// HFSR: breakpoint without a debugger.
pub(crate) const DEBUGEVT: u32 = 1 << 31;

/// Registers that only hold a written value, or a status that faults set.
#[derive(Clone, Debug)]
pub(crate) struct Scb {
    pub(crate) vtor: u32,
    pub(crate) aircr: u32,
    pub(crate) scr: u32,
    pub(crate) ccr: u32,
    /// Enable bits of SHCSR.
    pub(crate) shcsr: u32,
    pub(crate) cfsr: u32,
    pub(crate) hfsr: u32,
    pub(crate) dfsr: u32,
    pub(crate) mmfar: u32,
    pub(crate) bfar: u32,
    pub(crate) cpacr: u32,
    pub(crate) actlr: u32,
    pub(crate) demcr: u32,
    pub(crate) fpccr: u32,
    pub(crate) fpcar: u32,
    pub(crate) fpdscr: u32,
}

impl Default for Scb {
    /// Returns the values after reset.
    fn default() -> Scb {
        Scb {
            vtor: 0,
            aircr: 0,
            scr: 0,
            ccr: 0x200,
            shcsr: 0,
            cfsr: 0,
            hfsr: 0,
            dfsr: 0,
            mmfar: 0,
            bfar: 0,
            cpacr: 0,
            actlr: 0,
            demcr: 0,
            fpccr: ASPEN | LSPEN,
            fpcar: 0,
            fpdscr: 0,
        }
    }
}

impl Scb {
    /// AIRCR.PRIGROUP
    pub(crate) fn priority_group(&self) -> u8 {
        (self.aircr >> 8 & 7) as u8
    }

    /// CCR.UNALIGN_TRP
    pub(crate) fn traps_unaligned(&self) -> bool {
        self.ccr & 1 << 3 != 0
    }

    /// CCR.DIV_0_TRP
    pub(crate) fn traps_division(&self) -> bool {
        self.ccr & 1 << 4 != 0
    }

    /// CCR.STKALIGN
    pub(crate) fn aligns_stack(&self) -> bool {
        self.ccr & 1 << 9 != 0
    }

    /// SCR.SLEEPONEXIT
    pub(crate) fn sleeps_on_exit(&self) -> bool {
        self.scr & 1 << 1 != 0
    }

    /// SCR.SEVONPEND
    pub(crate) fn events_on_pend(&self) -> bool {
        self.scr & 1 << 4 != 0
    }

    /// Returns `true` if a configurable fault has its own handler enabled.
    pub(crate) fn handles(&self, fault: u16) -> bool {
        match fault {
            MEMORY_FAULT => self.shcsr & 1 << 16 != 0,
            BUS_FAULT => self.shcsr & 1 << 17 != 0,
            USAGE_FAULT => self.shcsr & 1 << 18 != 0,
            _ => true,
        }
    }
}
