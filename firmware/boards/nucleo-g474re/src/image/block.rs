//! The block interrupt: reads a block of samples, runs the controller, writes the block that plays
//! two blocks later. It has the highest priority and runs every 100 us.
//!
//! It runs from the core-coupled RAM (`ccmram.x`). A block that is late or takes too long is
//! reported to the controller with the next block; the controller then mutes the drive with fault
//! 11. A stream that has lost a sample cannot be repaired while it runs: the enable drops, no
//! further block follows, and the watchdog resets the processor.

use core::cell::RefCell;
use core::sync::atomic::{AtomicU32, Ordering};

use boards_common::packing;
use cortex_m::interrupt::{self as masked, Mutex};
use cortex_m::peripheral::DWT;
use firmware::board::block_task::BlockTask;
use firmware::seam::block::{DriveBlock, SenseBlock, SlowSense, Trips};
use nucleo_g474re::blocks::{AHEAD, Beat, Half, Step};
use stm32_metapac::{GPIOC, interrupt};

use super::dac::Lanes;
use super::dma::Place;
use super::encoder::Encoder;
use super::force::ForceChannel;
use super::pins::Pin;
use super::{adc, amplifier_supply, count, panic, protection, temperature, timers};

/// Duration of the longest block, cycles.
static WORST_CYCLES: AtomicU32 = AtomicU32::new(0);
/// State that the interrupt takes over when it runs for the first time.
static HANDOVER: Mutex<RefCell<Option<&'static mut BlockInterrupt>>> = Mutex::new(RefCell::new(None));

/// Returns the duration of the longest block, cycles, of the 17 000 of a block.
pub fn worst_cycles() -> u32 {
    WORST_CYCLES.load(Ordering::Relaxed)
}

/// Number of further samples in which the rings must be out of step.
const CONFIRMED_SAMPLES: usize = 3;
/// Address pins of the sense multiplexer, which select the lane whose voltage and current are
/// measured.
const MULTIPLEXER_PINS: [Pin; 2] = [Pin::new(GPIOC, 8), Pin::new(GPIOC, 9)];

/// State of the block interrupt.
pub struct BlockInterrupt {
    task: BlockTask<'static>,
    lanes: Lanes,
    encoder: Option<Encoder>,
    force: Option<ForceChannel>,
    beat: Beat,
    step: Step,
    sense: SenseBlock,
    drive: DriveBlock,
    /// `true` if the last block was not written in time.
    late: bool,
}

impl BlockInterrupt {
    /// Creates the state before the first block.
    pub fn new(task: BlockTask<'static>, lanes: Lanes, encoder: Option<Encoder>, force: Option<ForceChannel>) -> Self {
        MULTIPLEXER_PINS.into_iter().for_each(Pin::output);
        let drive = task.silence();
        BlockInterrupt {
            task,
            lanes,
            encoder,
            force,
            beat: Beat::default(),
            step: Step::default(),
            sense: SenseBlock::default(),
            drive,
            late: false,
        }
    }

    /// Runs one block.
    fn block(&mut self) {
        let began = DWT::cycle_count();
        // DMA has just left the half of the ring opposite to its position.
        timers::await_quiet();
        let (adc, dac) = (adc::next(), self.lanes.next());
        if adc::CHANNEL.acknowledge()
            || adc::is_overrun()
            || !self.lanes.are_fed()
            || !self.step.holds((adc, dac)) && self.has_lost_sample()
        {
            panic::end_blocks();
            return self.lanes.silence();
        }
        let half = Half::at(adc).other();
        self.multiplex();
        packing::sense(half.filled(adc::SAMPLES.places()), Place::read, &mut self.sense);
        let broken = protection::check_breaks();
        self.sense.slow = SlowSense {
            belt: self.encoder.as_mut().map(Encoder::read),
            temperature: Some(temperature::latest()),
            force: self.force.as_mut().and_then(ForceChannel::read),
            trips: Some(Trips {
                over_current: broken.over_current,
                amplifier_fault: broken.amplifier_fault,
                supply: amplifier_supply::is_out(),
            }),
            // The cycle counter does not count while a debugger has halted the processor, so
            // `stalled` counts as a missed block.
            missed_blocks: Some(self.beat.missed(began) + u32::from(self.late) + u32::from(broken.stalled)),
        };
        if broken.cut {
            // Silent at once, without waiting for the controller.
            self.lanes.silence();
        }
        self.task.run(&self.sense, &mut self.drive);
        if self.drive.drops_queue {
            self.lanes.silence();
        }
        if !broken.cut {
            self.lanes.write(half, &self.drive);
        }
        self.late = !half.is_in_time::<AHEAD>(self.lanes.next());
        WORST_CYCLES.fetch_max(DWT::cycle_count().wrapping_sub(began), Ordering::Relaxed);
        count::count_block();
    }

    /// Returns `true` if the clock has stopped, or the rings remain out of step in the next
    /// samples. While flash is written, single reads are. Not in the core-coupled RAM, which is
    /// full.
    #[cold]
    #[inline(never)]
    fn has_lost_sample(&mut self) -> bool {
        !timers::is_running()
            || (0..CONFIRMED_SAMPLES).all(|_| {
                timers::await_next_quiet();
                !self.step.holds((adc::next(), self.lanes.next()))
            })
    }

    /// Selects the lane to measure in the block that begins, which plays the answer of the previous
    /// call.
    fn multiplex(&mut self) {
        for (bit, pin) in MULTIPLEXER_PINS.into_iter().enumerate() {
            pin.set(self.drive.listen >> bit & 1 == 1);
        }
    }
}

/// Passes its state to the interrupt. Must be called before the interrupt is enabled.
pub fn hand_over(state: &'static mut BlockInterrupt) {
    masked::free(|token| HANDOVER.borrow(token).replace(Some(state)));
}

#[interrupt]
fn DMA1_CHANNEL1() {
    static mut BLOCK_INTERRUPT: Option<&'static mut BlockInterrupt> = None;
    if BLOCK_INTERRUPT.is_none() {
        *BLOCK_INTERRUPT = masked::free(|token| HANDOVER.borrow(token).take());
    }
    if let Some(state) = BLOCK_INTERRUPT {
        state.block();
    }
}
