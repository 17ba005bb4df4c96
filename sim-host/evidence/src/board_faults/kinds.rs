//! The kinds of faults: what breaks, how it is drawn, and what must come of it.

use super::limits::{Limit, Verdict};
use super::limits::{Limit::*, Verdict::*};

/// A kind of fault.
#[derive(Clone, Copy, Debug)]
pub struct Kind {
    /// Name in tables and messages.
    pub name: &'static str,
    /// What breaks, and what of it is drawn at random for each run.
    pub what: &'static str,
    /// How it is made to happen.
    pub fault: Fault,
    /// What must come of it.
    pub verdict: Verdict,
    /// The reasons that may be named: faults by their number, restarts by their cause.
    pub reasons: &'static [&'static str],
}

/// What breaks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// A sense converter gives one code, any.
    StuckAny,
    /// A sense converter gives the middle of its range.
    StuckMiddle,
    /// A sense converter gives an end of its range.
    StuckEnd,
    /// A sense pin stands at a voltage.
    OpenSense,
    /// The current is above the upper threshold of the trips.
    CurrentUp,
    /// The current is below the lower threshold of the trips.
    CurrentDown,
    /// The emergency stop is pressed, or its wire breaks.
    Stop,
    /// A comparator trips at any current.
    ComparatorActs,
    /// A comparator trips at no current.
    ComparatorDead,
    /// The timer of the DAC stands.
    SampleClock,
    /// The timer of the ADCs stands.
    ConversionClock,
    /// One trigger of the DAC is lost.
    DacTrigger,
    /// Several triggers of the DAC are lost.
    DacTriggers,
    /// One trigger of the ADCs is lost.
    AdcTrigger,
    /// Several triggers of the ADCs are lost.
    AdcTriggers,
    /// The samples' DMA is switched off.
    AdcChannelOff,
    /// The codes' DMA is switched off.
    DacChannelOff,
    /// The samples' DMA stands.
    AdcStream,
    /// The codes' DMA stands.
    DacStream,
    /// The DMA of the serial line stands.
    LinkStream,
    /// A transfer of the samples' DMA fails.
    AdcTransfer,
    /// A transfer of the codes' DMA fails.
    DacTransfer,
    /// The samples' DMA misses a request.
    AdcOverrun,
    /// The codes' DMA misses a request.
    DacUnderrun,
    /// The crystal stops.
    Crystal,
    /// The PLL stops.
    Pll,
    /// The supply falls below the level of its detector.
    SupplyFalls,
    /// The supply dips, and the RAM is lost.
    BrownOut,
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
    /// The processor jumps to where no memory is.
    HardFault,
    /// The stack pointer points to where no memory is.
    Lockup,
    /// Interrupts are masked for ever.
    Masked,
    /// The block interrupt is switched off for ever.
    BlockMasked,
    /// The background task loops for ever.
    BackgroundStands,
    /// A debugger halts the processor for a time.
    Debugger,
    /// Bytes of the host arrive with noise.
    Noise,
    /// Bytes of the host arrive with a low stop bit.
    Framing,
}

const fn off(name: &'static str, fault: Fault, limit: Limit, reasons: &'static [&'static str], what: &'static str) -> Kind {
    Kind { name, what, fault, verdict: Off(limit), reasons }
}

const fn on(name: &'static str, fault: Fault, what: &'static str) -> Kind {
    Kind { name, what, fault, verdict: DrivesOn, reasons: &[] }
}

const fn either(name: &'static str, fault: Fault, reasons: &'static [&'static str], what: &'static str) -> Kind {
    Kind { name, what, fault, verdict: OffOrDrivesOn, reasons }
}

const SENSE: &[&str] = &["fault 20", "fault 21", "fault 23", "fault 28", "fault 32", "fault 33"];
const LOST: &[&str] = &["a lost stream"];
const DOG: &[&str] = &["the watchdog"];
const ANY: &[&str] = super::run::ANY_REASON;

/// All kinds.
pub const KINDS: &[Kind] = &[
    off("adc-stuck-code", Fault::StuckAny, Blocks(8), SENSE, "ADC1 (voltage) or ADC2 (current) gives one code, any of 4096"),
    off("adc-stuck-middle", Fault::StuckMiddle, Blocks(8), SENSE, "ADC1 or ADC2 gives 2048"),
    off("adc-stuck-end", Fault::StuckEnd, Blocks(8), SENSE, "ADC1 or ADC2 gives 0 or 4095"),
    off("sense-wire-open", Fault::OpenSense, Blocks(8), SENSE, "PA0, or PA1, stands at 0, 1.65 or 3.3 V"),
    off("current-above-trip", Fault::CurrentUp, Hardware, &["fault 21"], "PA1 and PA7 at 3.06 to 3.3 V"),
    off("current-below-trip", Fault::CurrentDown, Hardware, &["fault 21"], "PA1 and PA7 at 0 to 0.21 V: the hysteresis is 30 mV"),
    off("emergency-stop", Fault::Stop, Hardware, &["fault 10"], "PC3 goes low"),
    off("comparator-acts", Fault::ComparatorActs, Hardware, &["fault 21"], "the output of COMP1 or COMP2 is stuck high"),
    on(
        "comparator-dead",
        Fault::ComparatorDead,
        "the output of COMP1 or COMP2 is stuck low; the test at the next start finds it",
    ),
    off("sample-clock", Fault::SampleClock, OneBlock, LOST, "TIM3 stands: the DAC holds its code"),
    off("conversion-clock", Fault::ConversionClock, NoBlock, DOG, "TIM4 stands: nothing is converted any more"),
    off("dac-trigger-lost", Fault::DacTrigger, OneBlock, LOST, "a trigger of TIM3 is lost: a sample"),
    off("dac-triggers-lost", Fault::DacTriggers, OneBlock, LOST, "2 to 5 triggers of TIM3 are lost"),
    off("adc-trigger-lost", Fault::AdcTrigger, OneBlock, LOST, "a trigger of TIM4 is lost: half a sample"),
    off("adc-triggers-lost", Fault::AdcTriggers, OneBlock, LOST, "2 to 4 triggers of TIM4 are lost"),
    off("adc-channel-off", Fault::AdcChannelOff, OneBlock, LOST, "the enable of channel 1 of DMA1 is cleared"),
    off("dac-channel-off", Fault::DacChannelOff, OneBlock, LOST, "the enable of channel 2 of DMA1 is cleared"),
    off("adc-stream", Fault::AdcStream, OneBlock, LOST, "channel 1 of DMA1 serves no request any more, after resets neither"),
    off("dac-stream", Fault::DacStream, OneBlock, LOST, "channel 2 of DMA1 serves no request any more, after resets neither"),
    off("adc-transfer", Fault::AdcTransfer, OneBlock, LOST, "a transfer of channel 1 of DMA1 fails"),
    off("dac-transfer", Fault::DacTransfer, OneBlock, LOST, "a transfer of channel 2 of DMA1 fails"),
    off("adc-overrun", Fault::AdcOverrun, OneBlock, LOST, "channel 1 of DMA1 misses a request"),
    off("dac-underrun", Fault::DacUnderrun, OneBlock, LOST, "channel 2 of DMA1 misses a request"),
    off("link-stream", Fault::LinkStream, HostTimeout, &["fault 12"], "channel 1 of DMA2 stands: no byte of the host arrives"),
    off("crystal-stops", Fault::Crystal, Hardware, &["the crystal"], "the crystal stops"),
    off("pll-unlocks", Fault::Pll, Watchdog, DOG, "the PLL stops, and with it all that counts cycles; LSI within 5 %"),
    off("supply-falls", Fault::SupplyFalls, Hardware, &["a low supply"], "the supply falls below 2.9 V for 1 to 6 ms"),
    off("brown-out", Fault::BrownOut, Hardware, &["power-on"], "the supply dips: power-on reset, the RAM has other bits"),
    either(
        "code-two-bits",
        Fault::CodeTwoBits,
        &["a damaged word of the code"],
        "two bits of a double word of the code flip; acts once it is read",
    ),
    on("code-one-bit", Fault::CodeOneBit, "one bit of a double word of the code flips, and is corrected"),
    on(
        "settings-two-bits",
        Fault::SettingsTwoBits,
        "two bits of a double word of the settings flip; they are not read while it drives",
    ),
    either("static-memory-bit", Fault::StaticBit, ANY, "a bit of the static RAM flips: controller, queues, rings, log"),
    either("stack-bit", Fault::StackBit, ANY, "a bit of the 1 KiB above the stack pointer flips"),
    either("fast-code-bit", Fault::FastCodeBit, ANY, "a bit of the code in core-coupled RAM flips (parity off, as delivered)"),
    either("register-bit", Fault::RegisterBit, ANY, "a bit of R0 to R12, SP, LR or PC flips"),
    off("hard-fault", Fault::HardFault, OneBlock, &["a hard fault"], "the processor jumps to an address without memory"),
    off("lockup", Fault::Lockup, OneBlock, DOG, "the stack pointer leaves the memory: the next use of the stack locks up"),
    off("interrupts-masked", Fault::Masked, NoBlock, DOG, "PRIMASK is set for ever; LSI within 5 %"),
    off(
        "block-interrupt-off",
        Fault::BlockMasked,
        NoBlock,
        DOG,
        "the enable of the block interrupt is cleared for ever; LSI within 5 %",
    ),
    off(
        "background-stands",
        Fault::BackgroundStands,
        Watchdog,
        DOG,
        "the background task loops for ever, blocks come; LSI within 5 %",
    ),
    off(
        "debugger",
        Fault::Debugger,
        NoBlock,
        &["fault 11"],
        "a debugger halts the processor for 0.2 to 20 ms, and lets it go on",
    ),
    on("uart-noise", Fault::Noise, "1 to 40 bytes of the host arrive with a flipped bit, while it asks"),
    on("uart-framing", Fault::Framing, "1 to 40 bytes of the host arrive with a low stop bit, while it asks"),
];

/// The kind of this name.
pub fn named(name: &str) -> Option<&'static Kind> {
    KINDS.iter().find(|kind| kind.name == name)
}
