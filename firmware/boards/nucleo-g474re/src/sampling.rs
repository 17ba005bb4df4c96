//! Timing of a conversion: how long the ADC samples, when it samples, and what is left until the next trigger.
//!
//! ```text
//! trigger |-- latency --|-- sampling --|-- successive approximation --|-- margin --| next trigger
//!              2.125           3.5                  12.5                  3.125        21.25 cycles of the ADC
//! ```
//!
//! Latency with a clock that is a fourth of the bus's, and duration of a conversion: DS12288, ADC characteristics (t_LATR, t_CONV). The sampling time is
//! 2.5 cycles and the one that ADC_SMPR1.SMPPLUS adds (RM0440 21.7.6). Times here are in eighths of a cycle of the ADC, which are halves of a cycle
//! of the processor.

use crate::blocks::CYCLES_PER_SAMPLE;

/// Cycles of the processor in one of the ADC.
pub const DIVIDER: u32 = 4;
/// Eighths in a cycle of the ADC, and in one of the processor.
const EIGHTHS: u32 = 8;
const EIGHTHS_PER_CYCLE: u32 = EIGHTHS / DIVIDER;
/// From the trigger to the sampling, eighths.
const LATENCY: u32 = 17;
/// Sampling, eighths.
const SAMPLING: u32 = 28;
/// Successive approximation of 12 bits, eighths.
const APPROXIMATION: u32 = 100;
/// The margin that must be left for what the data sheet does not specify, eighths: two cycles.
const LEAST_MARGIN: u32 = 2 * EIGHTHS;

/// Cycles of the processor from one conversion to the next: two conversions in a sample.
pub const CYCLES_PER_CONVERSION: u32 = CYCLES_PER_SAMPLE / 2;
/// What is left between the end of a conversion and the next trigger, eighths of a cycle of the ADC.
pub const MARGIN: u32 = CYCLES_PER_CONVERSION * EIGHTHS_PER_CYCLE - LATENCY - SAMPLING - APPROXIMATION;
const _: () = assert!(MARGIN >= LEAST_MARGIN, "a conversion must end two cycles before the next trigger");

/// Cycles of the processor that a trigger takes from TIM3 to TIM4 (estimated).
const TRIGGER_DELAY: u32 = 3;
/// Cycles of the processor from a step of the DAC to the first trigger, so that the sampling ends a quarter of a sample after the step; that of the second
/// conversion then ends at three quarters.
pub const TRIGGER_AFTER: u32 =
    (CYCLES_PER_SAMPLE * EIGHTHS_PER_CYCLE / 4 - TRIGGER_DELAY * EIGHTHS_PER_CYCLE - LATENCY - SAMPLING) / EIGHTHS_PER_CYCLE;

/// A line of the data sheet's table of the largest source resistance for 12 bits on a fast channel at 60 MHz: sampling time, ns, and resistance, ohm.
const SOURCES: [(f32, f32); 2] = [(41.67, 100.0), (108.33, 330.0)];

/// The sampling time, ns.
pub fn sampling_ns(system_hz: f32) -> f32 {
    SAMPLING as f32 / EIGHTHS_PER_CYCLE as f32 / system_hz * 1e9
}

/// The largest resistance of the source with which the input settles within this sampling time, ohm (DS12288, maximum ADC R_AIN; between two lines of
/// the table).
pub fn source_ohm(sampling_ns: f32) -> f32 {
    let [(short_ns, short_ohm), (long_ns, long_ohm)] = SOURCES;
    short_ohm + (long_ohm - short_ohm) * (sampling_ns - short_ns) / (long_ns - short_ns)
}
