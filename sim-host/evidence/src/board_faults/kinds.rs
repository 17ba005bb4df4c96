//! The kinds of faults: defect, random parameters, and required response.

use stm32g474::{Defect, Ram};

use super::limits::{Limit, Verdict};
use super::limits::{Limit::*, Verdict::*};

/// A kind of fault.
#[derive(Clone, Copy, Debug)]
pub struct Kind {
    /// Name in tables and messages.
    pub name: &'static str,
    /// Description of the defect, with the parameters that are drawn for each run.
    pub what: &'static str,
    /// The fault to inject.
    pub fault: Fault,
    /// Required response.
    pub verdict: Verdict,
    /// Reasons that the board may report: faults by number, restarts by cause.
    pub reasons: &'static [&'static str],
}

/// The defect of a kind.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Fault {
    /// A defect of the part without random parameters.
    Part(Defect),
    /// A sense converter returns one constant code, any.
    StuckAny,
    /// A sense converter returns the middle of its range.
    StuckMiddle,
    /// A sense converter returns an end of its range.
    StuckEnd,
    /// A sense pin is at a constant voltage.
    OpenSense,
    /// The current is above the upper threshold of the trips.
    CurrentUp,
    /// The current is below the lower threshold of the trips.
    CurrentDown,
    /// The emergency stop is pressed, or its wire breaks.
    Stop,
    /// A comparator trips at any current.
    ComparatorActs,
    /// A comparator never trips.
    ComparatorDead,
    /// Several triggers of the DAC are lost.
    DacTriggers,
    /// Several triggers of the ADCs are lost.
    AdcTriggers,
    /// The samples' DMA is switched off.
    AdcChannelOff,
    /// The codes' DMA is switched off.
    DacChannelOff,
    /// The DMA of the serial line stops.
    LinkStream,
    /// The PLL stops.
    Pll,
    /// The supply falls below the level of its detector.
    SupplyFalls,
    /// Two bits of the code flip.
    CodeTwoBits,
    /// One bit of the code flips.
    CodeOneBit,
    /// Two bits of the settings flip.
    SettingsTwoBits,
    /// A bit of the static memory flips.
    StaticBit,
    /// A bit of the stack flips.
    StackBit,
    /// A bit of the code in core-coupled RAM flips.
    FastCodeBit,
    /// A bit of a register of the processor flips.
    RegisterBit,
    /// The processor jumps to an address without memory.
    HardFault,
    /// The stack pointer points to an address without memory.
    Lockup,
    /// Interrupts are masked permanently.
    Masked,
    /// The block interrupt is switched off permanently.
    BlockMasked,
    /// The background task loops forever.
    BackgroundLoops,
    /// A debugger halts the processor for a time.
    Debugger,
    /// Bytes from the host arrive with noise.
    Noise,
    /// Bytes from the host arrive with a low stop bit.
    Framing,
}

const fn off(name: &'static str, fault: Fault, limit: Limit, reasons: &'static [&'static str], what: &'static str) -> Kind {
    Kind { name, what, fault, verdict: Off(limit), reasons }
}

/// Creates a defect of the part by which the stream of blocks is lost.
const fn lost(name: &'static str, defect: Defect, what: &'static str) -> Kind {
    off(name, Fault::Part(defect), OneBlock, LOST_STREAM, what)
}

const fn on(name: &'static str, fault: Fault, what: &'static str) -> Kind {
    Kind { name, what, fault, verdict: DrivesOn, reasons: &[] }
}

const fn either(name: &'static str, fault: Fault, reasons: &'static [&'static str], what: &'static str) -> Kind {
    Kind { name, what, fault, verdict: OffOrDrivesOn, reasons }
}

const SENSE: &[&str] = &["fault 20", "fault 21", "fault 23", "fault 28", "fault 32", "fault 33"];
const LOST_STREAM: &[&str] = &["a lost stream"];
const WATCHDOG: &[&str] = &["the watchdog"];
const ANY: &[&str] = super::run::ANY_REASON;

/// All kinds.
pub const KINDS: &[Kind] = &[
    off("adc-stuck-code", Fault::StuckAny, Blocks(8), SENSE, "ADC1 (voltage) or ADC2 (current) returns one code, any of 4096"),
    off("adc-stuck-middle", Fault::StuckMiddle, Blocks(8), SENSE, "ADC1 or ADC2 returns 2048"),
    off("adc-stuck-end", Fault::StuckEnd, Blocks(8), SENSE, "ADC1 or ADC2 returns 0 or 4095"),
    off("sense-wire-open", Fault::OpenSense, Blocks(8), SENSE, "PA0 or PA1 is at 0, 1.65 or 3.3 V"),
    off("current-above-trip", Fault::CurrentUp, Hardware, &["fault 21"], "PA1 and PA7 are at 3.06 to 3.3 V"),
    off("current-below-trip", Fault::CurrentDown, Hardware, &["fault 21"], "PA1 and PA7 are at 0 to 0.21 V; hysteresis 30 mV"),
    off("emergency-stop", Fault::Stop, Hardware, &["fault 10"], "PC3 goes low"),
    off("comparator-acts", Fault::ComparatorActs, Hardware, &["fault 21"], "the output of COMP1 or COMP2 is stuck high"),
    on(
        "comparator-dead",
        Fault::ComparatorDead,
        "the output of COMP1 or COMP2 is stuck low; the test at the next start finds it",
    ),
    lost("sample-clock", Defect::TimerHalts { timer: 3 }, "TIM3 stops: the DAC holds its code"),
    off(
        "conversion-clock",
        Fault::Part(Defect::TimerHalts { timer: 4 }),
        NoBlock,
        WATCHDOG,
        "TIM4 stops: there are no more conversions",
    ),
    lost("dac-trigger-lost", Defect::TriggersLost { timer: 3, triggers: 1 }, "one trigger of TIM3 is lost: one sample"),
    off("dac-triggers-lost", Fault::DacTriggers, OneBlock, LOST_STREAM, "2 to 5 triggers of TIM3 are lost"),
    lost("adc-trigger-lost", Defect::TriggersLost { timer: 4, triggers: 1 }, "one trigger of TIM4 is lost: half a sample"),
    off("adc-triggers-lost", Fault::AdcTriggers, OneBlock, LOST_STREAM, "2 to 4 triggers of TIM4 are lost"),
    off("adc-channel-off", Fault::AdcChannelOff, OneBlock, LOST_STREAM, "the enable of channel 1 of DMA1 is cleared"),
    off("dac-channel-off", Fault::DacChannelOff, OneBlock, LOST_STREAM, "the enable of channel 2 of DMA1 is cleared"),
    lost("adc-stream", Defect::DmaHalts { dma: 1, channel: 1 }, "channel 1 of DMA1 serves no more requests, also after resets"),
    lost("dac-stream", Defect::DmaHalts { dma: 1, channel: 2 }, "channel 2 of DMA1 serves no more requests, also after resets"),
    lost("adc-transfer", Defect::DmaFails { dma: 1, channel: 1 }, "a transfer of channel 1 of DMA1 fails"),
    lost("dac-transfer", Defect::DmaFails { dma: 1, channel: 2 }, "a transfer of channel 2 of DMA1 fails"),
    lost("adc-overrun", Defect::DmaMisses { dma: 1, channel: 1, requests: 1 }, "channel 1 of DMA1 misses a request"),
    lost("dac-underrun", Defect::DmaMisses { dma: 1, channel: 2, requests: 1 }, "channel 2 of DMA1 misses a request"),
    off("link-stream", Fault::LinkStream, HostTimeout, &["fault 12"], "channel 1 of DMA2 stops: no byte from the host arrives"),
    off("crystal-stops", Fault::Part(Defect::HseStops), Hardware, &["the crystal"], "the crystal stops"),
    off("pll-unlocks", Fault::Pll, Watchdog, WATCHDOG, "the PLL stops, with everything that counts cycles; LSI within 5 %"),
    off("supply-falls", Fault::SupplyFalls, Hardware, &["a low supply"], "the supply falls below 2.9 V for 1 to 6 ms"),
    off(
        "brown-out",
        Fault::Part(Defect::BrownOut { ram: Ram::Lost }),
        Hardware,
        &["power-on"],
        "the supply dips: power-on reset, the contents of the RAM are lost",
    ),
    either(
        "code-two-bits",
        Fault::CodeTwoBits,
        &["a damaged word of the code"],
        "two bits of a double word of the code flip; takes effect once it is read",
    ),
    on("code-one-bit", Fault::CodeOneBit, "one bit of a double word of the code flips, and is corrected"),
    on(
        "settings-two-bits",
        Fault::SettingsTwoBits,
        "two bits of a double word of the settings flip; settings are not read under drive",
    ),
    either("static-memory-bit", Fault::StaticBit, ANY, "a bit of the static RAM flips: controller, queues, rings, log"),
    either("stack-bit", Fault::StackBit, ANY, "a bit of the 1 KiB above the stack pointer flips"),
    either("fast-code-bit", Fault::FastCodeBit, ANY, "a bit of the code in core-coupled RAM flips (parity off, as delivered)"),
    either("register-bit", Fault::RegisterBit, ANY, "a bit of R0 to R12, SP, LR or PC flips"),
    off("hard-fault", Fault::HardFault, OneBlock, &["a hard fault"], "the processor jumps to an address without memory"),
    off("lockup", Fault::Lockup, OneBlock, WATCHDOG, "the stack pointer leaves the memory: the next use of the stack locks up"),
    off("interrupts-masked", Fault::Masked, NoBlock, WATCHDOG, "PRIMASK is set permanently; LSI within 5 %"),
    off(
        "block-interrupt-off",
        Fault::BlockMasked,
        NoBlock,
        WATCHDOG,
        "the enable of the block interrupt is cleared permanently; LSI within 5 %",
    ),
    off(
        "background-stands",
        Fault::BackgroundLoops,
        Watchdog,
        WATCHDOG,
        "the background task loops forever, blocks continue; LSI within 5 %",
    ),
    off("debugger", Fault::Debugger, NoBlock, &["fault 11"], "a debugger halts the processor for 0.2 to 20 ms, then resumes it"),
    on("uart-noise", Fault::Noise, "1 to 40 bytes from the host arrive with a flipped bit, during requests"),
    on("uart-framing", Fault::Framing, "1 to 40 bytes from the host arrive with a low stop bit, during requests"),
];

/// Finds the kind of this name.
pub fn named(name: &str) -> Option<&'static Kind> {
    KINDS.iter().find(|kind| kind.name == name)
}
