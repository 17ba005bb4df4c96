//! The lint: what a program does with the registers that the manual forbids, or that loses something.

use std::fmt;

use cortex_m4::{Cycle, Fault};

macro_rules! rules {
    ($($(#[doc = $doc:literal])+ $name:ident, $manual:literal, $text:literal;)+) => {
        /// What a [`Finding`] is about.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
        pub enum Rule {
            $($(#[doc = $doc])+ $name,)+
        }

        impl Rule {
            /// Every rule.
            pub const ALL: &[Rule] = &[$(Rule::$name),+];

            /// The section of RM0440, or the erratum of ES0430, that the rule comes from.
            pub fn manual(self) -> &'static str {
                match self { $(Rule::$name => $manual,)+ }
            }

            /// The rule in words.
            pub fn text(self) -> &'static str {
                match self { $(Rule::$name => $text,)+ }
            }
        }
    };
}

rules! {
    /// A peripheral is accessed whose clock is off.
    Unclocked, "RM0440 7.2.17", "the clock of the peripheral is off";
    /// A peripheral is accessed within two cycles of its enable bit being set.
    ClockSettle, "RM0440 7.2.17", "two cycles after the enable bit have not passed";
    /// A reserved bit is changed.
    Reserved, "RM0440 1.2", "a reserved bit is changed";
    /// A register that can only be read is written.
    ReadOnly, "RM0440 1.2", "the register is read-only";
    /// An access is narrower than the register allows.
    Width, "RM0440 22.7", "the register wants accesses of its own width";
    /// Fewer wait states of the flash than the clock needs.
    WaitStates, "RM0440 3.3.3", "too few wait states for this clock";
    /// More than 150 MHz without boost, or more than voltage range 2 allows.
    Boost, "RM0440 6.1.5", "the voltage range does not allow this clock";
    /// The clock passes 80 MHz without a microsecond at half of it.
    HalfFrequency, "RM0440 7.2.7", "more than 80 MHz must be reached by half the frequency for 1 us";
    /// RCC_PLLCFGR is written while the PLL is on.
    PllRunning, "RM0440 7.4.4", "the PLL is on";
    /// An input or output of the PLL is outside its range.
    PllRange, "RM0440 7.2.4", "a frequency of the PLL is out of its range";
    /// A clock is selected that is not ready.
    ClockNotReady, "RM0440 7.4.3", "the clock that is selected is not ready";
    /// The regulator of an ADC is enabled in deep power-down.
    AdcPower, "RM0440 21.4.6", "the ADC is in deep power-down";
    /// An ADC is calibrated or enabled before its regulator has started up (20 us).
    AdcRegulator, "RM0440 21.4.6", "the regulator of the ADC has not started up";
    /// An ADC is calibrated while it is on, enabled uncalibrated, or enabled within four cycles of its calibration.
    AdcCalibration, "RM0440 21.4.8", "calibration comes before the enable, and four ADC cycles between them";
    /// A conversion is started before the ADC is ready.
    AdcNotReady, "RM0440 21.4.9", "the ADC is not ready";
    /// A register of an ADC is written that must not be while conversions are started.
    AdcStarted, "RM0440 21.4.10", "conversions are started";
    /// A common register is written while one of the ADCs is on.
    AdcCommonEnabled, "RM0440 21.8.2", "an ADC of the group is on";
    /// A channel of the sensor or the reference is converted that is not enabled.
    AdcInternalOff, "RM0440 21.8.2", "the internal channel is not enabled";
    /// A trigger comes while a conversion is under way.
    AdcTriggerLost, "RM0440 21.4.18", "a trigger came during a conversion";
    /// A trigger comes less than a quarter of an ADC cycle after the conversion before it has ended.
    AdcTriggerMargin, "DS12288 ADC characteristics", "a trigger came within a quarter of an ADC cycle of the end of a conversion";
    /// A conversion has ended before the one before it was read.
    AdcOverrun, "RM0440 21.4.26", "a conversion was not read in time";
    /// The mode of a DAC is written while it is on.
    DacEnabled, "RM0440 22.7.17", "the DAC is on";
    /// DAC_MCR.HFSEL does not fit the bus clock.
    DacBusClock, "RM0440 22.7.17", "HFSEL is too low for the bus clock";
    /// A trigger comes before the DMA has served the one before it.
    DacUnderrun, "RM0440 22.4.8", "a trigger came before DMA had served the last one";
    /// A channel of a DMA is configured while it is on.
    DmaEnabled, "RM0440 12.4.3", "the channel is on";
    /// A DMA transfer goes to an address that nothing answers.
    DmaError, "RM0440 12.4.5", "nothing answers at the address of the transfer";
    /// The counter of TIM1 is enabled with nothing to count to.
    TimBlocked, "RM0440 28.6.14", "the counter is blocked while ARR is zero";
    /// A field of TIM1 is changed that BDTR.LOCK protects.
    TimLocked, "RM0440 28.6.20", "TIMx_BDTR.LOCK protects the field";
    /// A comparator, op-amp or SYSCFG register is changed after its lock.
    Locked, "RM0440 24.6.1", "the register is locked until the next reset";
    /// A register of the flash is written while it is locked, or a wrong key.
    FlashLocked, "RM0440 3.3.5", "the flash is locked";
    /// The flash is ordered something while it is busy.
    FlashBusy, "RM0440 3.3.6", "the flash is busy";
    /// The flash is written in the wrong order, width or alignment.
    FlashSequence, "RM0440 3.3.7", "the order, width or alignment of programming is wrong";
    /// A double word is programmed that is not erased.
    FlashNotErased, "RM0440 3.3.7", "the double word is not erased";
    /// The flash is programmed or erased with its data cache on.
    FlashDataCache, "ES0430 2.2.2", "the data cache is on while the flash is changed";
    /// A cache is reset while it is on.
    CacheReset, "RM0440 3.7.1", "a cache is reset while it is on";
    /// A read has met a double word that cannot be corrected.
    EccDouble, "RM0440 3.3.11", "the double word cannot be corrected";
    /// A register of the watchdog is written without its key.
    IwdgLocked, "RM0440 42.3.4", "the key 0x5555 is missing";
    /// A register of the watchdog is written while the last write is under way.
    IwdgUpdating, "RM0440 42.4.4", "the last write is still under way";
    /// The first DMA interrupt comes, and the watchdog is not started. Ignored unless it is asked for.
    IwdgMissing, "RM0440 42.3", "blocks run, and the watchdog does not";
    /// The divider of the UART is out of its range.
    UartDivider, "RM0440 38.4.7", "the divider is out of its range";
    /// A register of the UART is written that must not be while it is on.
    UartEnabled, "RM0440 38.7.1", "the UART is on";
    /// A byte is written to a full transmitter, or lost by a full receiver.
    UartLost, "RM0440 38.4.5", "a byte is lost";
}

impl Rule {
    /// Whether the rule is about something that happens by itself: no instruction does it, and it may come a million times a second.
    fn comes_by_itself(self) -> bool {
        matches!(
            self,
            Rule::AdcTriggerLost
                | Rule::AdcTriggerMargin
                | Rule::AdcOverrun
                | Rule::DacUnderrun
                | Rule::DmaError
                | Rule::IwdgMissing
                | Rule::UartLost
        )
    }
}

impl fmt::Display for Rule {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(self.text())
    }
}

/// Something that a program does wrong with a register.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "{peripheral}_{register}{} = {value:#010x}: {rule} ({manual}; pc {pc:#010x}, cycle {at})",
    if names.is_empty() { String::new() } else { format!(".{}", names.join("+")) }
)]
pub struct Finding {
    /// The peripheral, `ADC1`.
    pub peripheral: &'static str,
    /// The register, `CFGR`.
    pub register: &'static str,
    /// The bits that are wrong; all of them where the access itself is.
    pub bits: u32,
    /// Names of the fields that have them.
    pub names: Vec<&'static str>,
    /// The value that was written, or the one that tells.
    pub value: u32,
    /// What is wrong.
    pub rule: Rule,
    /// Where that is written.
    pub manual: &'static str,
    /// The instruction that did it, or that ran when it came out.
    pub pc: u32,
    /// When, in cycles.
    pub at: Cycle,
}

/// What the model does not know: the run stops, since any answer would be invented.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("not modelled: {what} at {address:#010x} (pc {pc:#010x}, cycle {at})")]
pub struct NotModelled {
    /// The address.
    pub address: u32,
    /// Peripheral, register, feature.
    pub what: String,
    /// The instruction.
    pub pc: u32,
    /// When, in cycles.
    pub at: Cycle,
}

/// What becomes of a finding.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// It stops the run.
    Stop,
    /// It is collected, and the run goes on as the part would.
    Collect,
    /// Nothing.
    Ignore,
}

/// The settings of the lint, and what it has collected.
#[derive(Clone, Debug)]
pub struct Lint {
    verdicts: Vec<Verdict>,
    /// What was collected, in order. One of the same instruction, or one that comes by itself, is counted once.
    pub findings: Vec<Finding>,
}

impl Default for Lint {
    fn default() -> Self {
        let mut lint = Lint { verdicts: vec![Verdict::Stop; Rule::ALL.len()], findings: Vec::new() };
        lint.set(Rule::IwdgMissing, Verdict::Ignore);
        lint
    }
}

impl Lint {
    /// Sets what becomes of findings of a rule.
    pub fn set(&mut self, rule: Rule, verdict: Verdict) {
        self.verdicts[rule as usize] = verdict;
    }

    /// Sets what becomes of all findings.
    pub fn set_all(&mut self, verdict: Verdict) {
        self.verdicts.fill(verdict);
    }

    /// What becomes of findings of a rule.
    pub fn verdict(&self, rule: Rule) -> Verdict {
        self.verdicts[rule as usize]
    }

    pub(crate) fn take(&mut self, finding: Finding) -> Result<(), Fault> {
        match self.verdict(finding.rule) {
            Verdict::Stop => return Err(Fault::Stop(Box::new(finding))),
            Verdict::Collect => {
                let known = |old: &Finding| {
                    (old.rule, old.peripheral, old.register, old.bits)
                        == (finding.rule, finding.peripheral, finding.register, finding.bits)
                        && (old.pc == finding.pc || finding.rule.comes_by_itself())
                };
                if !self.findings.iter().any(known) {
                    self.findings.push(finding);
                }
            }
            Verdict::Ignore => {}
        }
        Ok(())
    }
}
