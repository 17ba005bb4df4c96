//! Timing of a conversion: start and length of the sampling, and the margin before the next
//! trigger.
//!
//! ```text
//! trigger |-- latency --|-- sampling --|-- successive approximation --|-- margin --| next trigger
//!              2.125           3.5                  12.5                  3.125        21.25 cycles of the ADC
//! ```
//!
//! Latency with a clock of a fourth of the bus clock, and duration of a conversion: DS12288, ADC
//! characteristics (t_LATR, t_CONV). The sampling time is 2.5 cycles plus the cycle that
//! ADC_SMPR1.SMPPLUS adds (RM0440 21.7.6). Times are in eighths of an ADC cycle, which are halves
//! of a processor cycle.

use crate::blocks::CYCLES_PER_SAMPLE;

/// Processor cycles per ADC cycle.
pub const DIVIDER: u32 = 4;
/// Eighths per ADC cycle.
const EIGHTHS_PER_ADC_CYCLE: u32 = 8;
/// Eighths per processor cycle.
const EIGHTHS_PER_CYCLE: u32 = EIGHTHS_PER_ADC_CYCLE / DIVIDER;
/// Latency from the trigger to the sampling, eighths.
const LATENCY_EIGHTHS: u32 = 17;
/// Duration of the sampling, eighths.
const SAMPLING_EIGHTHS: u32 = 28;
/// Duration of the successive approximation of 12 bits, eighths.
const APPROXIMATION_EIGHTHS: u32 = 100;
/// Smallest permitted margin, eighths: two cycles, for delays that the data sheet does not specify.
const MIN_MARGIN_EIGHTHS: u32 = 2 * EIGHTHS_PER_ADC_CYCLE;

/// Processor cycles between two conversions: there are two conversions in a sample.
pub const CYCLES_PER_CONVERSION: u32 = CYCLES_PER_SAMPLE / 2;
/// Margin between the end of a conversion and the next trigger, eighths of an ADC cycle.
pub const MARGIN_EIGHTHS: u32 =
    CYCLES_PER_CONVERSION * EIGHTHS_PER_CYCLE - LATENCY_EIGHTHS - SAMPLING_EIGHTHS - APPROXIMATION_EIGHTHS;
const _: () = assert!(MARGIN_EIGHTHS >= MIN_MARGIN_EIGHTHS, "a conversion must end two cycles before the next trigger");

/// Delay of a trigger from TIM3 to TIM4, processor cycles (estimated).
const TRIGGER_DELAY_CYCLES: u32 = 3;
/// Processor cycles from a step of the DAC to the first trigger.
///
/// The first sampling then ends a quarter of a sample after the step, and that of the second
/// conversion at three quarters.
pub const TRIGGER_AFTER: u32 =
    (CYCLES_PER_SAMPLE * EIGHTHS_PER_CYCLE / 4 - TRIGGER_DELAY_CYCLES * EIGHTHS_PER_CYCLE - LATENCY_EIGHTHS - SAMPLING_EIGHTHS)
        / EIGHTHS_PER_CYCLE;

/// Largest source resistance for 12 bits on a fast channel at 60 MHz, from the table of the data
/// sheet: sampling time, ns, and resistance, ohm.
const SOURCES: [(f32, f32); 2] = [(41.67, 100.0), (108.33, 330.0)];

/// Returns the sampling time, ns.
pub fn sampling_ns(system_hz: f32) -> f32 {
    SAMPLING_EIGHTHS as f32 / EIGHTHS_PER_CYCLE as f32 / system_hz * 1e9
}

/// Returns the largest source resistance with which the input settles within this sampling time,
/// ohm. Interpolates between two lines of the table (DS12288, maximum ADC R_AIN).
pub fn source_ohm(sampling_ns: f32) -> f32 {
    let [(short_ns, short_ohm), (long_ns, long_ohm)] = SOURCES;
    short_ohm + (long_ohm - short_ohm) * (sampling_ns - short_ns) / (long_ns - short_ns)
}
