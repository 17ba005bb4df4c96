//! What boards of the Sonoglide controller share: what a board with rings of DMA, a cycle counter
//! and the usual sensors does with the numbers that its registers and rings hold. No register, no
//! part, no length of a block stands here: a board states its own as constants.
//!
//! | module | for a board that has |
//! |---|---|
//! | [`half`], [`position`](mod@position), [`playback`], [`step`], [`packing`] | an ADC and DACs, each with a ring of two blocks that DMA serves |
//! | [`beat`] | a counter of cycles |
//! | [`reader`] | a UART whose bytes come by DMA |
//! | [`note`] | RAM that a reset leaves as it is |
//! | [`area`] | pages of flash |
//! | [`stack_guard`] | a memory protection unit of ARMv7-M |
//! | [`thermistor`], [`supply_window`], [`wires`], [`led`] | a thermistor at the heat sink, the amplifier's supply, an encoder with complements, a status LED |
//!
//! All of it is `#[inline]`: it is compiled with the board's package, at the level of that one.
//!
//! Most of it is generic over the length of a ring (`RING`, two blocks), over how many words a DAC
//! fetches before it plays them (`AHEAD`), or over the cycles of a block, so that the compiler
//! knows them:
//!
//! ```
//! use boards_common::{beat, half, packing, position::position, step};
//! use core::sync::atomic::{AtomicU32, Ordering::Relaxed};
//! use firmware::{DriveBlock, SenseBlock};
//!
//! // A board: blocks of 64 samples at 500 kHz, a processor of 150 MHz, a DAC that holds one word.
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
//! // In the interrupt, at half and end of the ADC's ring; the positions are those of two counters of DMA.
//! let (adc, dac) = (position::<RING>(BLOCK), position::<RING>(BLOCK - 1));
//! assert!(Step::default().holds((adc, dac), || (adc, dac)), "the rings are in step");
//! let half = Half::at(adc).other();
//! let mut sense = SenseBlock::default();
//! packing::sense(half.filled(&SAMPLES), |place| place.load(Relaxed), &mut sense);
//! sense.slow.missed_blocks = Some(Beat::default().missed(12_345));
//! // Here `BlockTask::run` answers.
//! let drive = DriveBlock::silent(2, BLOCK, SILENCE);
//! packing::drive(&drive, 0, SILENCE, half.played::<AHEAD, _>(&CODES), |place, word| place.store(word, Relaxed));
//! assert!(half.is_in_time::<AHEAD>(dac), "otherwise the next block says that one was missed");
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
