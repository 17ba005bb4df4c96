//! The block interrupt: reads a block of samples, runs the controller, writes the block that plays two blocks later. At top priority, every 100 us.
//!
//! It runs from the core-coupled RAM (`ccmram.x`). A block that comes late, or takes too long, is reported to the controller with the next one, which
//! mutes: fault 11. A stream that has lost a sample cannot be repaired while it runs: the enable drops, no block follows, and the watchdog resets the part.

use core::cell::RefCell;
use core::sync::atomic::{AtomicU32, Ordering};

use boards_common::packing;
use cortex_m::asm::delay;
use cortex_m::interrupt::{self as masked, Mutex};
use cortex_m::peripheral::DWT;
use firmware::board::block_task::BlockTask;
use firmware::seam::block::{DriveBlock, SenseBlock, SlowSense, Trips};
use nucleo_g474re::blocks::{AHEAD, Beat, CYCLES_PER_SAMPLE, Half, Step};
use stm32_metapac::{GPIOC, interrupt};

use super::dac::Lanes;
use super::dma::Place;
use super::encoder::Encoder;
use super::force::ForceChannel;
use super::pins::Pin;
use super::{adc, amplifier_supply, count, panic, protection, temperature};

/// The most cycles that a block has taken.
static WORST: AtomicU32 = AtomicU32::new(0);
/// The state that the interrupt takes over when it is raised for the first time.
static HANDOVER: Mutex<RefCell<Option<&'static mut BlockInterrupt>>> = Mutex::new(RefCell::new(None));

/// The most cycles that a block has taken, of 17 000.
pub fn worst_cycles() -> u32 {
    WORST.load(Ordering::Relaxed)
}

/// What `delay` is told to take a third of a sample together with the two positions that are read: its loop takes three to five cycles for each of these.
const A_THIRD: u32 = CYCLES_PER_SAMPLE / 14;

/// The sense multiplexer's address: the lane whose voltage and current are measured.
const LISTEN: [Pin; 2] = [Pin::new(GPIOC, 8), Pin::new(GPIOC, 9)];

/// The state of the block interrupt.
pub struct BlockInterrupt {
    task: BlockTask<'static>,
    lanes: Lanes,
    encoder: Option<Encoder>,
    force: Option<ForceChannel>,
    beat: Beat,
    step: Step,
    sense: SenseBlock,
    drive: DriveBlock,
    /// The last block was not written in time.
    late: bool,
}

impl BlockInterrupt {
    /// The state before the first block.
    pub fn new(task: BlockTask<'static>, lanes: Lanes, encoder: Option<Encoder>, force: Option<ForceChannel>) -> Self {
        LISTEN.into_iter().for_each(Pin::output);
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
        // DMA has just left the half of the ring that it is not in.
        let (adc, dac) = (adc::next(), self.lanes.next());
        let again = || {
            delay(A_THIRD);
            (adc::next(), self.lanes.next())
        };
        if adc::CHANNEL.acknowledge() || adc::is_overrun() || !self.lanes.are_fed() || !self.step.holds((adc, dac), again) {
            panic::end_blocks();
            return self.lanes.silence();
        }
        let half = Half::at(adc).other();
        self.multiplex();
        packing::sense(half.filled(adc::SAMPLES.places()), Place::read, &mut self.sense);
        let broken = protection::look();
        self.sense.slow = SlowSense {
            belt: self.encoder.as_mut().map(Encoder::read),
            temperature: Some(temperature::latest()),
            force: self.force.as_mut().and_then(ForceChannel::read),
            trips: Some(Trips {
                over_current: broken.over_current,
                amplifier_fault: broken.amplifier_fault,
                supply: amplifier_supply::is_out(),
            }),
            // The cycle counter stands while a debugger has halted the processor.
            missed_blocks: Some(self.beat.missed(began) + u32::from(self.late) + u32::from(broken.stood)),
        };
        if broken.cut {
            // Before the controller has had its time.
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
        WORST.fetch_max(DWT::cycle_count().wrapping_sub(began), Ordering::Relaxed);
        count::count_block();
    }

    /// Connects the lane that is measured while the block plays that the last call returned, which begins.
    fn multiplex(&mut self) {
        for (bit, pin) in LISTEN.into_iter().enumerate() {
            pin.set(self.drive.listen >> bit & 1 == 1);
        }
    }
}

/// Gives the interrupt its state, before it is enabled.
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
