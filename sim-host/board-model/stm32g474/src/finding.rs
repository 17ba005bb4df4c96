//! Checks of a program's register accesses: accesses that the manual forbids, or that lose
//! something.

use std::fmt;

use cortex_m4::{Cycle, Fault};

macro_rules! rules {
    ($($(#[doc = $doc:literal])+ $name:ident, $manual:literal, $text:literal;)+) => {
        /// Rule that a [`Finding`] violates.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
        pub enum Rule {
            $($(#[doc = $doc])+ $name,)+
        }

        impl Rule {
            /// All rules.
            pub const ALL: &[Rule] = &[$(Rule::$name),+];

            /// Returns the section of RM0440, or the erratum of ES0430, that contains the rule.
            pub fn manual(self) -> &'static str {
                match self { $(Rule::$name => $manual,)+ }
            }

            /// Returns a short description of the violation.
            pub fn text(self) -> &'static str {
                match self { $(Rule::$name => $text,)+ }
            }
        }
    };
}

rules! {
    /// Access to a peripheral whose clock is off.
    Unclocked, "RM0440 7.2.17", "the clock of the peripheral is off";
    /// Access to a peripheral less than two cycles after its enable bit was set.
    ClockSettle, "RM0440 7.2.17", "access less than two cycles after the enable bit";
    /// Change of a reserved bit.
    Reserved, "RM0440 1.2", "a reserved bit is changed";
    /// Write to a read-only register.
    ReadOnly, "RM0440 1.2", "the register is read-only";
    /// Access that is narrower than the register allows.
    Width, "RM0440 22.7", "the register requires accesses of its full width";
    /// Fewer wait states of the flash than the clock needs.
    WaitStates, "RM0440 3.3.3", "too few wait states for this clock";
    /// More than 150 MHz without boost, or more than voltage range 2 allows.
    Boost, "RM0440 6.1.5", "the voltage range does not allow this clock";
    /// Clock above 80 MHz without a step of a microsecond at half of it.
    HalfFrequency, "RM0440 7.2.7", "a clock above 80 MHz requires 1 us at half of it first";
    /// Write to RCC_PLLCFGR while the PLL is on.
    PllRunning, "RM0440 7.4.4", "the PLL is on";
    /// Input or output of the PLL outside its range.
    PllRange, "RM0440 7.2.4", "a frequency of the PLL is out of range";
    /// Selection of a clock that is not ready.
    ClockNotReady, "RM0440 7.4.3", "the selected clock is not ready";
    /// Enable of the regulator of an ADC in deep power-down.
    AdcPower, "RM0440 21.4.6", "the ADC is in deep power-down";
    /// Calibration or enable of an ADC before its regulator has started up (20 us).
    AdcRegulator, "RM0440 21.4.6", "the regulator of the ADC has not started up";
    /// Calibration of an ADC that is on, or enable of an ADC without calibration or within four
    /// cycles of it.
    AdcCalibration, "RM0440 21.4.8", "an ADC must be calibrated while off, four ADC cycles before its enable";
    /// Start of a conversion before the ADC is ready.
    AdcNotReady, "RM0440 21.4.9", "the ADC is not ready";
    /// Write to a register of an ADC that must not change while conversions are started.
    AdcStarted, "RM0440 21.4.10", "conversions are started";
    /// Write to a common register while one of the ADCs is on.
    AdcCommonEnabled, "RM0440 21.8.2", "an ADC of the group is on";
    /// Conversion of a disabled channel of the sensor or the reference.
    AdcInternalOff, "RM0440 21.8.2", "the internal channel is not enabled";
    /// Trigger during a conversion.
    AdcTriggerLost, "RM0440 21.4.18", "a trigger came during a conversion";
    /// Trigger less than a quarter of an ADC cycle after the end of the previous conversion.
    AdcTriggerMargin, "DS12288 ADC characteristics", "a trigger came within a quarter of an ADC cycle of the end of a conversion";
    /// End of a conversion before the previous one was read.
    AdcOverrun, "RM0440 21.4.26", "a conversion was not read in time";
    /// Start of a pair whose values one DMA channel reads together, with the FIFO of ADC_DR on
    /// (OVRMOD = 0).
    AdcDualFifo, "ES0430 2.7.6", "OVRMOD must be 1 in both ADCs of a pair that one DMA channel reads";
    /// Write to the mode of a DAC while it is on.
    DacEnabled, "RM0440 22.7.17", "the DAC is on";
    /// DAC_MCR.HFSEL too low for the bus clock.
    DacBusClock, "RM0440 22.7.17", "HFSEL is too low for the bus clock";
    /// Trigger before DMA has served the previous one.
    DacUnderrun, "RM0440 22.4.8", "a trigger came before DMA served the previous one";
    /// Configuration of a DMA channel while it is on.
    DmaEnabled, "RM0440 12.4.3", "the channel is on";
    /// DMA transfer to an address without an answer.
    DmaError, "RM0440 12.4.5", "the address of the transfer does not answer";
    /// Enable of the counter of TIM1 with ARR = 0.
    TimBlocked, "RM0440 28.6.14", "the counter is blocked while ARR is zero";
    /// Change of a field of TIM1 that BDTR.LOCK protects.
    TimLocked, "RM0440 28.6.20", "TIMx_BDTR.LOCK protects the field";
    /// Change of a comparator, op-amp or SYSCFG register after its lock.
    Locked, "RM0440 24.6.1", "the register is locked until the next reset";
    /// Write to a register of the flash while it is locked, or with a wrong key.
    FlashLocked, "RM0440 3.3.5", "the flash is locked";
    /// Command to the flash while it is busy.
    FlashBusy, "RM0440 3.3.6", "the flash is busy";
    /// Write to the flash in the wrong order, width or alignment.
    FlashSequence, "RM0440 3.3.7", "the order, width or alignment of programming is wrong";
    /// Programming of a double word that is not erased.
    FlashNotErased, "RM0440 3.3.7", "the double word is not erased";
    /// Programming or erase of the flash with its data cache on.
    FlashDataCache, "ES0430 2.2.2", "the data cache is on while the flash is changed";
    /// Reset of a cache while it is on.
    CacheReset, "RM0440 3.7.1", "a cache is reset while it is on";
    /// Read of a double word that cannot be corrected.
    EccDouble, "RM0440 3.3.11", "the double word cannot be corrected";
    /// Write to a register of the watchdog without its key.
    IwdgLocked, "RM0440 42.3.4", "the key 0x5555 is missing";
    /// Write to a register of the watchdog during the last write.
    IwdgUpdating, "RM0440 42.4.4", "the last write is still in progress";
    /// First DMA interrupt without a running watchdog. Ignored by default.
    IwdgMissing, "RM0440 42.3", "blocks run without the watchdog";
    /// Divider of the UART outside its range.
    UartDivider, "RM0440 38.4.7", "the divider is out of range";
    /// Write to a register of the UART that must not change while it is on.
    UartEnabled, "RM0440 38.7.1", "the UART is on";
    /// Byte that is written to a full transmitter, or lost by a full receiver.
    UartLost, "RM0440 38.4.5", "a byte is lost";
}

impl Rule {
    /// Returns `true` if the violation is not caused by an instruction. It may occur a million
    /// times a second.
    fn is_spontaneous(self) -> bool {
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

/// Violation of a rule by a program's register access.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "{peripheral}_{register}{} = {value:#010x}: {rule} ({manual}; pc {pc:#010x}, cycle {at})",
    if names.is_empty() { String::new() } else { format!(".{}", names.join("+")) }
)]
pub struct Finding {
    /// Peripheral, such as `ADC1`.
    pub peripheral: &'static str,
    /// Register, such as `CFGR`.
    pub register: &'static str,
    /// Wrong bits; all bits if the access itself is wrong.
    pub bits: u32,
    /// Names of the fields with these bits.
    pub names: Vec<&'static str>,
    /// Written value, or the value that shows the violation.
    pub value: u32,
    /// Violated rule.
    pub rule: Rule,
    /// Section of the manual.
    pub manual: &'static str,
    /// Address of the instruction that caused the finding, or ran when it was detected.
    pub pc: u32,
    /// Cycle of the finding.
    pub at: Cycle,
}

/// Behaviour that the model lacks. The run stops, because any answer would be invented.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("not modelled: {what} at {address:#010x} (pc {pc:#010x}, cycle {at})")]
pub struct NotModelled {
    /// Address of the access.
    pub address: u32,
    /// Peripheral, register, feature.
    pub what: String,
    /// Address of the instruction.
    pub pc: u32,
    /// Cycle of the access.
    pub at: Cycle,
}

/// Treatment of a finding.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// The run stops.
    Stop,
    /// The finding is collected, and the run continues as on hardware.
    Collect,
    /// The finding is dropped.
    Ignore,
}

/// Treatment of findings by rule, and the collected findings.
#[derive(Clone, Debug)]
pub struct Lint {
    verdicts: Vec<Verdict>,
    /// Collected findings, in order. Repetitions by the same instruction, or without an
    /// instruction, are counted once.
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
    /// Sets the treatment of findings of a rule.
    pub fn set(&mut self, rule: Rule, verdict: Verdict) {
        self.verdicts[rule as usize] = verdict;
    }

    /// Sets the treatment of all findings.
    pub fn set_all(&mut self, verdict: Verdict) {
        self.verdicts.fill(verdict);
    }

    /// Returns the treatment of findings of a rule.
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
                        && (old.pc == finding.pc || finding.rule.is_spontaneous())
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
