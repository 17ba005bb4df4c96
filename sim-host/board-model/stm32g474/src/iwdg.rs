//! Independent watchdog. RM0440 42.

use cortex_m4::{Cycle, Fault, Ports};
use stm32_metapac::dbgmcu::regs::Apb1lfzr;

use crate::finding::Rule;
use crate::map::at;
use crate::map::base::{DBGMCU, IWDG};
use crate::part::{Now, Stm32g474};
use crate::resets::IWDG_FLAG;
use crate::time::{Event, Ps};
use crate::wires::Wires;

/// IWDG_KR (42.4.1).
const START: u32 = 0xcccc;
const UNLOCK: u32 = 0x5555;
const FEED: u32 = 0xaaaa;

/// State of the watchdog.
#[derive(Clone, Debug, Default)]
pub(crate) struct Iwdg {
    pub running: bool,
    unlocked: bool,
    /// Time of the last load of the counter.
    loaded: Ps,
    /// Time at which the last write of PR, RLR or WINR reaches the watchdog's own clock.
    updated: Ps,
    /// Remaining time while a debugger has halted the processor.
    held: Option<Ps>,
}

impl<W: Wires> Stm32g474<W> {
    /// Returns the duration of a count: LSI divided by 4 to 256.
    fn tick(&self) -> Ps {
        let prescaler = 4_u64 << self.regs[IWDG + at::iwdg::PR].min(6);
        prescaler * 1_000_000_000_000 / self.config.lsi_hz
    }

    /// Changes the frequency of LSI; the remaining counts take longer or shorter.
    pub(crate) fn change_lsi(&mut self, at: Cycle, hz: u64) {
        let (before, time) = (self.config.lsi_hz, self.time.ps(at));
        self.config.lsi_hz = hz;
        let due = self.agenda.get(Event::Iwdg);
        if due != Cycle::MAX {
            let left = self.time.ps(due).saturating_sub(time);
            let left = (u128::from(left) * u128::from(before) / u128::from(hz)) as Ps;
            let due = self.time.cycle(time + left);
            self.agenda.set(Event::Iwdg, due);
        }
    }

    fn feed(&mut self, now: Now, left: Option<Ps>) {
        let time = self.time.ps(now.at);
        self.iwdg.loaded = time;
        let left = left.unwrap_or(self.tick() * u64::from(self.regs[IWDG + at::iwdg::RLR] + 1));
        if self.iwdg.running {
            let due = self.time.cycle(time + left);
            self.agenda.set(Event::Iwdg, due);
        }
    }

    pub(crate) fn write_iwdg(&mut self, now: Now, address: u32, value: u32) -> Result<(), Fault> {
        let time = self.time.ps(now.at);
        match address - IWDG {
            at::iwdg::KR => {
                self.iwdg.unlocked = value == UNLOCK;
                match value {
                    START => {
                        self.iwdg.running = true;
                        self.feed(now, None);
                    }
                    FEED => {
                        let window = self.regs[IWDG + at::iwdg::WINR];
                        let counted = ((time - self.iwdg.loaded) / self.tick()) as u32;
                        let counter = self.regs[IWDG + at::iwdg::RLR].saturating_sub(counted);
                        // A feed while the counter is above the window causes a reset (42.3.2).
                        if self.iwdg.running && counter > window {
                            self.agenda.set(Event::Iwdg, now.at);
                        } else {
                            self.feed(now, None);
                        }
                    }
                    UNLOCK => {}
                    _ => return self.refuse(now, address, "a key"),
                }
            }
            register => {
                if !self.iwdg.unlocked {
                    return self.report(now, address, u32::MAX, value, Rule::IwdgLocked);
                }
                // Each register has its own flag.
                let flag = match register {
                    at::iwdg::PR => 1,
                    at::iwdg::RLR => 2,
                    _ => 4,
                };
                let status = self.iwdg_status(now.at);
                if status & flag != 0 {
                    self.report(now, address, u32::MAX, value, Rule::IwdgUpdating)?;
                }
                self.regs[address] = value;
                self.regs[IWDG + at::iwdg::SR] = status | flag;
                // Up to five cycles of LSI (42.4.4).
                self.iwdg.updated = time + 5 * 1_000_000_000_000 / self.config.lsi_hz;
                if register == at::iwdg::WINR {
                    self.feed(now, None);
                }
            }
        }
        Ok(())
    }

    /// Returns IWDG_SR (42.4.4).
    pub(crate) fn iwdg_status(&self, at: Cycle) -> u32 {
        if self.time.ps(at) >= self.iwdg.updated { 0 } else { self.regs[IWDG + at::iwdg::SR] }
    }

    pub(crate) fn iwdg_bites(&mut self, ports: &mut Ports) {
        self.pull_reset(IWDG_FLAG, ports);
    }

    /// Stops or resumes the watchdog when a debugger halts or resumes the processor, if DBGMCU
    /// selects it (47.6.5).
    pub(crate) fn halt_iwdg(&mut self, at: Cycle) {
        let now = self.now(at);
        let stands = self.halted && Apb1lfzr(self.regs[DBGMCU + at::dbgmcu::APB1LFZR]).iwdg();
        match (stands, self.iwdg.held) {
            (true, None) if self.iwdg.running => {
                let due = self.time.ps(self.agenda.get(Event::Iwdg));
                self.iwdg.held = Some(due.saturating_sub(self.time.ps(at)));
                self.agenda.clear(Event::Iwdg);
            }
            (false, Some(left)) => {
                self.iwdg.held = None;
                self.feed(now, Some(left));
            }
            _ => {}
        }
    }
}
