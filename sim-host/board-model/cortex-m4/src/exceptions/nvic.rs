//! Nested vectored interrupt controller (B3.4), and priorities of all exceptions (B1.5.4).

use super::{DEBUG_MONITOR, EXTERNAL, HARD_FAULT, NMI, PENDSV};
use crate::cpu::Cpu;
use crate::interrupts::{Interrupts, LINES};

/// Pending, enabled and active exceptions, one bit each; exception 16 is interrupt line 0.
#[derive(Clone, Debug)]
pub(crate) struct Nvic {
    /// Pending exceptions below 16.
    pub(crate) system_pending: u16,
    /// Active exceptions below 16.
    pub(crate) system_active: u16,
    /// Pending interrupt lines.
    pub(crate) pending: u128,
    pub(crate) enabled: u128,
    pub(crate) active: u128,
    /// Levels of the lines at the last update.
    pub(crate) levels: u128,
    /// Priorities by exception number.
    priorities: [u8; (EXTERNAL + LINES) as usize],
    /// Implemented bits of a priority.
    mask: u8,
}

impl Nvic {
    pub(crate) fn new(priority_bits: u8) -> Nvic {
        Nvic {
            system_pending: 0,
            system_active: 0,
            pending: 0,
            enabled: 0,
            active: 0,
            levels: 0,
            priorities: [0; (EXTERNAL + LINES) as usize],
            mask: !(0xFFu16 >> priority_bits.min(8)) as u8,
        }
    }

    /// Returns the number of implemented bits of a priority.
    pub(crate) fn priority_bits(&self) -> u8 {
        self.mask.count_ones() as u8
    }

    /// Returns the implemented bits of a priority.
    pub(crate) fn implemented(&self, priority: u8) -> u8 {
        priority & self.mask
    }

    pub(crate) fn set_priority(&mut self, exception: u16, priority: u8) {
        if let Some(place) = self.priorities.get_mut(usize::from(exception)) {
            *place = priority & self.mask;
        }
    }

    pub(crate) fn stored_priority(&self, exception: u16) -> u8 {
        self.priorities.get(usize::from(exception)).copied().unwrap_or(0)
    }

    /// Returns the priority of an exception; lower is more urgent.
    pub(crate) fn priority(&self, exception: u16) -> i16 {
        match exception {
            1 => -3,
            NMI => -2,
            HARD_FAULT => -1,
            _ => self.stored_priority(exception).into(),
        }
    }

    pub(crate) fn pend_system(&mut self, exception: u16) {
        self.system_pending |= 1 << exception;
    }

    /// Moves the exception from pending to active.
    pub(crate) fn activate(&mut self, exception: u16) {
        if exception < EXTERNAL {
            self.system_pending &= !(1 << exception);
            self.system_active |= 1 << exception;
        } else {
            let bit = 1 << (exception - EXTERNAL);
            self.pending &= !bit;
            self.active |= bit;
        }
    }

    /// Ends an active exception. A line that is still high pends it again.
    pub(crate) fn deactivate(&mut self, exception: u16) {
        if exception < EXTERNAL {
            self.system_active &= !(1 << exception);
        } else {
            let bit = 1 << (exception - EXTERNAL);
            self.active &= !bit;
            self.pending |= self.levels & bit;
        }
    }

    pub(crate) fn pend(&mut self, exception: u16) {
        if exception < EXTERNAL {
            self.pend_system(exception);
        } else {
            self.pending |= 1 << (exception - EXTERNAL);
        }
    }

    pub(crate) fn is_active(&self, exception: u16) -> bool {
        match exception {
            0..EXTERNAL => self.system_active >> exception & 1 == 1,
            _ => exception < EXTERNAL + LINES && self.active >> (exception - EXTERNAL) & 1 == 1,
        }
    }

    pub(crate) fn active_count(&self) -> u32 {
        self.system_active.count_ones() + self.active.count_ones()
    }

    /// Reads the lines; a rising line pends its interrupt.
    pub(crate) fn update(&mut self, interrupts: &mut Interrupts) {
        let levels = interrupts.levels();
        self.pending |= levels & !self.levels;
        self.levels = levels;
        if interrupts.take_nmi() {
            self.pend_system(NMI);
        }
    }

    /// Iterates over the exceptions of a set, in order of their numbers.
    fn each(system: u16, external: u128) -> impl Iterator<Item = u16> {
        let (mut system, mut external) = (system, external);
        std::iter::from_fn(move || {
            if system != 0 {
                let number = system.trailing_zeros() as u16;
                system &= system - 1;
                Some(number)
            } else if external != 0 {
                let number = EXTERNAL + external.trailing_zeros() as u16;
                external &= external - 1;
                Some(number)
            } else {
                None
            }
        })
    }

    /// Returns the most urgent pending and enabled exception; among equals the one with the lowest
    /// number.
    pub(crate) fn most_urgent(&self) -> Option<u16> {
        // The debug monitor is not modelled: it is never enabled.
        let system = self.system_pending & !(1 << DEBUG_MONITOR);
        Self::each(system, self.pending & self.enabled).min_by_key(|number| (self.priority(*number), *number))
    }

    /// Returns the group priority of the most urgent active exception.
    pub(crate) fn active_priority(&self, group: u8) -> i16 {
        Self::each(self.system_active, self.active).map(|number| self.group_priority(number, group)).min().unwrap_or(256)
    }

    /// Returns the priority without its subpriority, by AIRCR.PRIGROUP.
    pub(crate) fn group_priority(&self, exception: u16, group: u8) -> i16 {
        in_group(self.priority(exception), group)
    }
}

/// Returns a priority without the bits of the subpriority. Negative ones, of system exceptions,
/// have no subpriority.
fn in_group(priority: i16, group: u8) -> i16 {
    if priority < 0 { priority } else { priority & !((2 << group) - 1) }
}

impl Cpu {
    /// Computes `ExecutionPriority` (B1.5.4).
    pub(crate) fn execution_priority(&self) -> i16 {
        let group = self.scb.priority_group();
        let mut priority = self.nvic.active_priority(group);
        if self.basepri != 0 {
            priority = priority.min(in_group(self.basepri.into(), group));
        }
        if self.primask {
            priority = priority.min(0);
        }
        if self.faultmask {
            priority = priority.min(-1);
        }
        priority
    }

    /// Returns the pending exception that preempts a given priority now. Exceptions that a
    /// debugger's step masks (C_MASKINTS, C1.6.2) stay pending.
    pub(crate) fn enters(&self, priority: i16) -> Option<u16> {
        self.preempting(priority).filter(|exception| !self.holds_interrupts || *exception < PENDSV)
    }

    /// Returns the pending exception that would preempt a given priority.
    pub(crate) fn preempting(&self, priority: i16) -> Option<u16> {
        let number = self.nvic.most_urgent()?;
        (self.nvic.group_priority(number, self.scb.priority_group()) < priority).then_some(number)
    }
}
