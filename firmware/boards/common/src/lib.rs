//! Shared parts of the boards: processing of the values in DMA rings, cycle counters and sensors.
//!
//! This crate contains no registers, no part numbers and no block length; each board defines its
//! own as constants.
//!
//! | module | for a board that has |
//! |---|---|
//! | [`half`], [`position`](mod@position), [`playback`], [`step`], [`packing`] | an ADC and DACs, each with a ring of two blocks that DMA serves |
//! | [`beat`] | a counter of cycles |
//! | [`reader`] | a UART that receives bytes by DMA |
//! | [`note`] | RAM that keeps its contents through a reset |
//! | [`area`] | pages of flash |
//! | [`stack_guard`] | a memory protection unit of ARMv7-M |
//! | [`thermistor`], [`supply_window`], [`wires`], [`led`] | a thermistor at the heat sink, a measured amplifier supply, an encoder with complementary outputs, a status LED |
//!
//! All functions are `#[inline]`, so they are compiled at the optimization level of the board's
//! package.
//!
//! Most items are generic over constants, so that the compiler knows their values:
//!
//! * `RING`: length of a ring, two blocks;
//! * `AHEAD`: number of words that a DAC fetches before it plays them;
//! * `CYCLES_PER_BLOCK`: number of cycles of a block.
//!
//! ```
//! use boards_common::{beat, half, packing, position::position, step};
//! use core::sync::atomic::{AtomicU32, Ordering::Relaxed};
//! use firmware::{DriveBlock, SenseBlock};
//!
//! // An example board: blocks of 64 samples at 500 kHz, a 150 MHz processor, a DAC that holds one word.
//! const BLOCK: usize = 64;
//! const RING: usize = 2 * BLOCK;
//! const AHEAD: usize = 1;
//! const CYCLES_PER_BLOCK: u32 = 150_000_000 / 500_000 * BLOCK as u32;
//! const SILENCE: u16 = 2048;
//! type Half = half::Half<RING>;
//! type Step = step::Step<RING>;
//! type Beat = beat::Beat<CYCLES_PER_BLOCK>;
//!
//! static SAMPLES: [AtomicU32; RING] = [const { AtomicU32::new(0) }; RING];
//! static CODES: [AtomicU32; RING] = [const { AtomicU32::new(packing::word(SILENCE, SILENCE)) }; RING];
//!
//! // In the interrupt, at half and end of the ADC's ring. Both positions come from DMA counters,
//! // in a part of the sample in which neither moves.
//! let (adc, dac) = (position::<RING>(BLOCK), position::<RING>(BLOCK - 1));
//! assert!(Step::default().holds((adc, dac)), "the rings are in step");
//! let half = Half::at(adc).other();
//! let mut sense = SenseBlock::default();
//! packing::sense(half.filled(&SAMPLES), |place| place.load(Relaxed), &mut sense);
//! sense.slow.missed_blocks = Some(Beat::default().missed(12_345));
//! // A real board calls `BlockTask::run` here.
//! let drive = DriveBlock::silent(2, BLOCK, SILENCE);
//! packing::drive(&drive, 0, SILENCE, half.played::<AHEAD, _>(&CODES), |place, word| place.store(word, Relaxed));
//! assert!(half.is_in_time::<AHEAD>(dac), "if it is late, the next block reports a missed block");
//! ```
#![no_std]
#![forbid(unsafe_code)]

pub mod area;
pub mod beat;
pub mod half;
pub mod led;
pub mod note;
pub mod packing;
pub mod playback;
pub mod position;
pub mod reader;
pub mod stack_guard;
pub mod step;
pub mod supply_window;
pub mod thermistor;
pub mod wires;
