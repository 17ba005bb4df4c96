//! Special registers: `MRS`, `MSR`, `CPS` (B5.2).

use crate::cpu::{Cpu, Flags};

impl Cpu {
    /// Changes PRIMASK and FAULTMASK in privileged state. FAULTMASK cannot be set at the priority
    /// of a hard fault or above.
    pub(super) fn change_state(&mut self, disable: bool, primask: bool, faultmask: bool) {
        if !self.privileged() {
            return;
        }
        if primask {
            self.set_primask(disable);
        }
        if faultmask && (!disable || self.execution_priority() > -1) {
            self.faultmask = disable;
        }
        self.schedule_check();
    }

    /// `MRS`
    pub(super) fn read_special(&mut self, d: u8, special: u8) {
        let privileged = self.privileged();
        let value = match special {
            // APSR, EPSR (reads as zero) and IPSR, selected by the bits of the number.
            0..=7 => {
                let ipsr = if special & 1 == 1 { u32::from(self.ipsr) } else { 0 };
                let apsr = if special & 4 == 0 { self.flags.bits() } else { 0 };
                apsr | ipsr
            }
            8 if privileged => self.stack_pointer(false),
            9 if privileged => self.stack_pointer(true),
            16 if privileged => u32::from(self.primask),
            17 | 18 if privileged => u32::from(self.basepri),
            19 if privileged => u32::from(self.faultmask),
            20 => {
                u32::from(self.float_active) << 2 | u32::from(self.process_stack_selected()) << 1 | u32::from(self.unprivileged)
            }
            _ => 0,
        };
        self.set(d, value);
    }

    /// `MSR`
    pub(super) fn write_special(&mut self, n: u8, special: u8, mask: u8) {
        let value = self.get(n);
        let privileged = self.privileged();
        match special {
            0..=3 => {
                let old = self.flags.bits();
                let mut bits = 0;
                if mask & 2 != 0 {
                    bits |= 0xF800_0000;
                }
                if mask & 1 != 0 {
                    bits |= 0x000F_0000;
                }
                self.flags = Flags::from_bits(old & !bits | value & bits);
            }
            _ if !privileged => {}
            8 => self.set_stack_pointer(false, value),
            9 => self.set_stack_pointer(true, value),
            16 => self.set_primask(value & 1 == 1),
            17 => self.basepri = self.nvic.implemented(value as u8),
            // BASEPRI_MAX: can only become more urgent.
            18 => {
                let priority = self.nvic.implemented(value as u8);
                if priority != 0 && (self.basepri == 0 || priority < self.basepri) {
                    self.basepri = priority;
                }
            }
            19 if value & 1 == 0 || self.execution_priority() > -1 => self.faultmask = value & 1 == 1,
            20 => {
                self.unprivileged = value & 1 == 1;
                if self.ipsr == 0 {
                    self.use_process_stack(value & 2 != 0);
                }
                self.float_active = value & 4 != 0;
                self.float_ready = false;
            }
            _ => {}
        }
        self.schedule_check();
    }

    fn set_primask(&mut self, masked: bool) {
        self.primask = masked;
        self.watch.mask(masked, self.cycle);
    }

    /// Returns CONTROL.SPSEL. In handlers it reads as 0, because the main stack is active.
    fn process_stack_selected(&self) -> bool {
        self.on_process_stack
    }

    /// Returns MSP or PSP.
    pub(crate) fn stack_pointer(&self, process: bool) -> u32 {
        if process == self.on_process_stack { self.r[13] } else { self.other_sp }
    }

    fn set_stack_pointer(&mut self, process: bool, value: u32) {
        let place = if process == self.on_process_stack { &mut self.r[13] } else { &mut self.other_sp };
        *place = value & !3;
    }
}
