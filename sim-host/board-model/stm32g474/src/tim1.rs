//! TIM1 as a switch: channels that are forced or ended by its counter (`tim1_counter.rs`), and
//! breaks that switch them off without the processor. RM0440 28.

use cortex_m4::{Cycle, Fault, Ports};
use stm32_metapac::dbgmcu::regs::Apb2fzr;
use stm32_metapac::syscfg::regs::Cfgr2;
use stm32_metapac::timer::regs::{BdtrAdv, CcerAdv, Cr2Adv};
use stm32_metapac::timer::vals::{Bkp, Ossi, Ossr};

use crate::finding::Rule;
use crate::map::at::{self, timadv as reg};
use crate::map::base::{DBGMCU, SYSCFG, TIM1};
use crate::map::{SIGNALS, line};
use crate::part::{Now, Stm32g474};
use crate::tim1_counter::Counter;
use crate::wires::{Level, Pin, Wires};

/// Flag of TIM1_SR: break (28.6.5).
const BIF: u32 = 1 << 7;
/// Flag of TIM1_SR: break 2.
const B2IF: u32 = 1 << 8;
/// Flag of TIM1_SR: system break.
const SBIF: u32 = 1 << 13;
const AOE: u32 = 1 << 14;
const MOE: u32 = 1 << 15;

/// State of TIM1 besides its registers.
#[derive(Clone, Debug)]
pub(crate) struct Tim1 {
    /// `true` after a lockup of the processor.
    pub lockup: bool,
    /// `true` after a read of the flash that could not be corrected.
    pub ecc: bool,
    /// Written value of BDTR.LOCK.
    lock: u8,
    /// `true` while break 1 or 2 is active.
    active: [bool; 2],
    levels: [Level; 4],
    pub counter: Counter,
    /// Possible pins of BKIN and BKIN2, with their alternate functions.
    pins: [Vec<(Pin, u8)>; 2],
}

impl Default for Tim1 {
    fn default() -> Self {
        let pins = ["BKIN", "BKIN2"].map(|signal| {
            SIGNALS
                .iter()
                .filter(|(peripheral, name, ..)| (*peripheral, *name) == ("TIM1", signal))
                .filter_map(|(.., pin, af)| Some((Pin::named(pin)?, (*af)?)))
                .collect()
        });
        Tim1 {
            lockup: false,
            ecc: false,
            lock: 0,
            active: [false; 2],
            levels: [Level::Floating; 4],
            counter: Counter::default(),
            pins,
        }
    }
}

impl Tim1 {
    /// Returns the output of a channel, counted from zero.
    pub fn level(&self, channel: usize) -> Level {
        self.levels[channel]
    }
}

impl<W: Wires> Stm32g474<W> {
    fn bdtr(&self) -> BdtrAdv {
        BdtrAdv(self.regs[TIM1 + reg::BDTR])
    }

    pub(crate) fn read_tim1(&mut self, now: Now, address: u32) -> u32 {
        match address - TIM1 {
            reg::CNT => self.tim1_count(now.at),
            reg::SR => {
                self.see_compares(now.at);
                self.regs[address]
            }
            reg::EGR => 0,
            _ => self.regs[address],
        }
    }

    pub(crate) fn write_tim1(&mut self, now: Now, address: u32, value: u32, ports: &mut Ports) -> Result<(), Fault> {
        let old = self.regs[address];
        match address - TIM1 {
            reg::CR2 => self.refuse_bits(now, address, value, !0x5_ff00)?,
            reg::DIER => self.refuse_bits(now, address, value, !(1 << 7 | 1))?,
            reg::SMCR | reg::CCMR3 | reg::DTR2 | reg::ECR | reg::DCR | reg::DMAR | reg::OR | reg::TISEL => {
                self.refuse_bits(now, address, value, u32::MAX)?;
            }
            reg::CCMR1 | reg::CCMR2 => self.check_modes(now, address, value)?,
            _ => self.check_counter(now, address, value)?,
        }
        self.see_compares(now.at);
        let locked = self.locked_bits(address) & (value ^ old);
        if locked != 0 {
            self.report(now, address, locked, value, Rule::TimLocked)?;
        }
        let value = value & !locked | old & locked;
        match address - TIM1 {
            reg::SR => self.regs[address] = old & value,
            reg::EGR => {
                self.refuse_bits(now, address, value, !0x181)?;
                if value & 1 != 0 {
                    self.update_counter(now.at, true);
                }
                for (bit, flag) in [(7, BIF), (8, B2IF)] {
                    if value >> bit & 1 != 0 {
                        self.break_now(flag);
                    }
                }
            }
            reg::BDTR => {
                // Bidirectional breaks.
                self.refuse_bits(now, address, value, 0xf << 26)?;
                self.regs[address] = value & !(3 << 8) | old & 3 << 8;
                if self.tim1.lock == 0 {
                    self.tim1.lock = BdtrAdv(value).lock().to_bits();
                    self.regs[address] = value;
                }
            }
            reg::CNT => self.set_count(now.at, value),
            _ => self.regs[address] = value,
        }
        self.rebase_counter(now.at);
        self.plan_counter(now.at);
        self.update_breaks(now.at, ports);
        Ok(())
    }

    /// Checks the modes: frozen and forced channels, and both modes of edge-aligned PWM without
    /// preload, in which one-pulse mode is permitted (28.6.8).
    fn check_modes(&mut self, now: Now, address: u32, value: u32) -> Result<(), Fault> {
        for half in [0, 8] {
            let mode = value >> (4 + half) & 7 | value >> (16 + half) & 1 << 3;
            if value >> half & 3 != 0 || !matches!(mode, 0 | 4..=7) {
                return self.refuse(now, address, "a mode that is neither forced nor PWM, or an input");
            }
        }
        self.refuse_bits(now, address, value, 0x8c8c)
    }

    /// Returns the bits of a register that BDTR.LOCK protects (28.6.20).
    fn locked_bits(&self, address: u32) -> u32 {
        let level = self.tim1.lock;
        let bits = |from: u8, bits: u32| if level >= from { bits } else { 0 };
        match address - TIM1 {
            // LOCK itself; dead time, breaks and their polarity, automatic output; then OSSI and
            // OSSR.
            reg::BDTR => bits(1, 3 << 8 | 0xff | 7 << 12 | 0x3f << 20 | 0xf << 16 | 0xf << 26) | bits(2, 3 << 10),
            reg::CR2 => bits(1, 0x5_ff00),
            reg::AF1 | reg::AF2 => bits(1, u32::MAX),
            // Polarities.
            reg::CCER => bits(2, 0x22_aaaa),
            reg::CCMR1 | reg::CCMR2 => bits(3, 0x0101_7878),
            _ => 0,
        }
    }

    /// Sets MOE at an update if AOE is set; an active break clears it again (28.6.20).
    pub(crate) fn enable_by_update(&mut self) {
        let bdtr = &mut self.regs[TIM1 + reg::BDTR];
        if *bdtr & AOE != 0 {
            *bdtr |= MOE;
        }
    }

    /// Returns `true` if a debugger has halted the processor and thereby the counter (47.6.7).
    pub(crate) fn tim1_is_halted(&self) -> bool {
        self.halted && Apb2fzr(self.regs[DBGMCU + at::dbgmcu::APB2FZR]).tim1()
    }

    /// Clears MOE and sets the flag of a break.
    fn break_now(&mut self, flag: u32) {
        self.regs[TIM1 + reg::SR] |= flag;
        self.regs[TIM1 + reg::BDTR] &= !MOE;
    }

    /// Returns the level of a break's sources before its polarity: pins and comparators (28.3.17,
    /// AF1 and AF2).
    fn break_level(&mut self, at: Cycle, number: usize) -> bool {
        let af = self.regs[TIM1 + if number == 0 { reg::AF1 } else { reg::AF2 }];
        let mut level = false;
        if af & 1 != 0 {
            level |= self.routed_level(at, number) ^ (af >> 9 & 1 != 0);
        }
        for comparator in 0..7 {
            if af >> (1 + comparator) & 1 != 0 {
                let inverted = comparator < 4 && af >> (10 + comparator) & 1 != 0;
                level |= (self.compared >> comparator & 1 != 0) ^ inverted;
            }
        }
        level
    }

    /// Returns the level of the pin of a break; low without a pin.
    fn routed_level(&mut self, at: Cycle, number: usize) -> bool {
        let pin = self.tim1.pins[number].iter().find(|(pin, af)| self.alternate(*pin) == Some(*af)).map(|(pin, _)| *pin);
        pin.is_some_and(|pin| self.input_level(at, pin))
    }

    /// Breaks after a failure of the crystal, which needs no bit of SYSCFG (28.3.17).
    pub(crate) fn clock_failure_break(&mut self, at: Cycle, ports: &mut Ports) {
        if self.bdtr().bke(0) {
            self.break_now(SBIF);
        }
        self.update_breaks(at, ports);
    }

    /// Returns `true` if the system requests a break (SYSCFG_CFGR2): lockup, low supply, flash. BKE
    /// enables it together with break 1 (28.6.20).
    fn system_break(&self) -> bool {
        let cfgr2 = Cfgr2(self.regs[SYSCFG + at::syscfg::CFGR2]);
        (cfgr2.cll() && self.tim1.lockup) || (cfgr2.pvdl() && self.pvd()) || (cfgr2.eccl() && self.tim1.ecc)
    }

    /// Updates the breaks from their inputs, and then the outputs.
    pub(crate) fn update_breaks(&mut self, at: Cycle, ports: &mut Ports) {
        let bdtr = self.bdtr();
        for (number, flag) in [(0, BIF), (1, B2IF)] {
            let active = bdtr.bke(number) && self.break_level(at, number) == (bdtr.bkp(number) == Bkp::ACTIVE_HIGH);
            self.tim1.active[number] = active;
            if active {
                // While it is active, the flag is set again and MOE cannot be set.
                self.break_now(flag);
            }
        }
        if bdtr.bke(0) && self.system_break() {
            self.break_now(SBIF);
        }
        let flags = self.regs[TIM1 + reg::SR] & (BIF | B2IF | SBIF) != 0;
        self.counter_line(ports);
        ports.interrupts.set(line::TIM1_BRK_TIM15, flags && self.regs[TIM1 + reg::DIER] & 1 << 7 != 0);
        self.update_enable(at, ports);
    }

    /// Updates the levels of the channels (28.6.20, table of output control bits).
    pub(crate) fn update_enable(&mut self, at: Cycle, _ports: &mut Ports) {
        let (bdtr, ccer, cr2) = (self.bdtr(), CcerAdv(self.regs[TIM1 + reg::CCER]), Cr2Adv(self.regs[TIM1 + reg::CR2]));
        let stands = self.tim1_is_halted();
        let level = |high: bool| if high { Level::High } else { Level::Low };
        let levels: [Level; 4] = std::array::from_fn(|channel| {
            let inverted = ccer.ccp(channel);
            match (bdtr.moe() && !stands, ccer.cce(channel)) {
                (true, true) => level(self.tim1_reference(at, channel) ^ inverted),
                (true, false) if bdtr.ossr() == Ossr::IDLE_LEVEL => level(inverted),
                (false, _) if bdtr.ossi() == Ossi::IDLE_LEVEL => {
                    let broken = self.tim1.active[1];
                    level(if broken { inverted } else { cr2.ois(channel) })
                }
                _ => Level::Floating,
            }
        });
        if levels != self.tim1.levels {
            self.tim1.levels = levels;
            self.pins_changed(at);
        }
    }
}
