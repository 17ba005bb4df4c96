//! Simulated microcontroller with an ADC and two DACs, each served by DMA in a ring, on a clock of
//! cycles.
//!
//! ```text
//! trigger n          the DACs play the oldest held word, and one more is fetched
//! 30 cycles later    the played value has been converted and is written; half and end of the ring cause the interrupt
//! ```

use std::cell::Cell;
use std::collections::VecDeque;

use boards_common::packing::word;
use firmware::seam::block::{DriveBlock, SenseBlock};
use hal_mock::analog::Analog;
use hal_mock::loop_back::LoopBack;

use crate::board::{AHEAD, BLOCK, CYCLES_PER_SAMPLE, RING, SILENCE};

/// Time from a trigger to the end of its conversion, cycles.
const CONVERSION_CYCLES: u32 = 30;

/// Sample stream of the microcontroller.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stream {
    /// Voltage and current.
    Adc,
    /// Both lanes.
    Dac,
}

/// Simulated microcontroller.
pub struct Part {
    /// Ring of the ADC.
    pub samples: [Cell<u32>; RING],
    /// Ring of the DACs.
    pub codes: [Cell<u32>; RING],
    /// All words played so far.
    pub played: Vec<u32>,
    now: u64,
    load: LoopBack,
    held: VecDeque<u32>,
    plays: u32,
    converted: usize,
    fetched: usize,
    is_pending: bool,
    loses: Option<Stream>,
}

impl Part {
    /// Creates a silent microcontroller before its first trigger.
    pub fn new(load: LoopBack) -> Self {
        let silence = word(SILENCE, SILENCE);
        Part {
            samples: [const { Cell::new(0) }; RING],
            codes: [const { Cell::new(word(SILENCE, SILENCE)) }; RING],
            played: Vec::new(),
            // The cycle counter wraps soon after the start.
            now: u64::from(u32::MAX) / u64::from(CYCLES_PER_SAMPLE) * u64::from(CYCLES_PER_SAMPLE)
                - 10_000 * u64::from(CYCLES_PER_SAMPLE),
            load,
            held: [silence; AHEAD].into(),
            plays: silence,
            converted: 0,
            fetched: 0,
            is_pending: false,
            loses: None,
        }
    }

    /// Returns the cycle counter, which wraps.
    pub fn cycle_count(&self) -> u32 {
        self.now as u32
    }

    /// Returns the number of transfers until the ADC's ring restarts.
    pub fn adc_remaining(&self) -> usize {
        RING - self.converted % RING
    }

    /// Returns the number of transfers until the DACs' ring restarts.
    pub fn dac_remaining(&self) -> usize {
        RING - self.fetched % RING
    }

    /// Waits until neither ring can move, even if it is half a sample late.
    pub fn await_quiet(&mut self) {
        while !(CONVERSION_CYCLES + 1..CYCLES_PER_SAMPLE / 2).contains(&((self.now % u64::from(CYCLES_PER_SAMPLE)) as u32)) {
            self.cycle();
        }
    }

    /// Makes one future trigger miss this stream.
    pub fn lose_a_trigger(&mut self, stream: Stream) {
        self.loses = Some(stream);
    }

    /// Simulates this number of cycles.
    pub fn advance(&mut self, cycles: u32) {
        (0..cycles).for_each(|_| self.cycle());
    }

    /// Simulates cycles until half or end of the ADC's ring is reached, and acknowledges the
    /// interrupt. Returns at once if it is already pending.
    pub fn wait_for_interrupt(&mut self) {
        while !self.is_pending {
            self.cycle();
        }
        self.is_pending = false;
    }

    fn cycle(&mut self) {
        match (self.now % u64::from(CYCLES_PER_SAMPLE)) as u32 {
            0 if self.loses.take_if(|lost| *lost == Stream::Dac).is_none() => self.play(),
            CONVERSION_CYCLES if self.loses.take_if(|lost| *lost == Stream::Adc).is_none() => self.convert(),
            _ => {}
        }
        self.now += 1;
    }

    fn play(&mut self) {
        self.held.push_back(self.codes[self.fetched % RING].get());
        self.plays = self.held.pop_front().unwrap_or_default();
        self.played.push(self.plays);
        self.fetched += 1;
    }

    fn convert(&mut self) {
        let lane = [self.plays as u16].into_iter().collect();
        let mut sense = SenseBlock::default();
        self.load.exchange(&DriveBlock { lanes: [lane].into_iter().collect(), ..DriveBlock::default() }, &mut sense);
        self.samples[self.converted % RING].set(word(sense.v[0], sense.i[0]));
        self.converted += 1;
        self.is_pending |= self.converted.is_multiple_of(BLOCK);
    }
}
