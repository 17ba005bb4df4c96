//! Code of the example board: its constants, its statics, and its interrupt.

use boards_common::position::position;
use boards_common::{beat, half, packing, step};
use firmware::board::block_task::BlockTask;
use firmware::board::queues::{BackgroundEnds, Loans, Queues};
use firmware::seam::block::{DriveBlock, Orders, SenseBlock};
use firmware::seam::config::Config;
use firmware::seam::telemetry::Telemetry;
use hal_mock::loop_back::{self, LoopBack};

use crate::part::Part;

/// Number of samples in a block.
pub const BLOCK: usize = 64;
/// Number of samples in a ring.
pub const RING: usize = 2 * BLOCK;
/// Number of words that the DACs fetch before they play them.
pub const AHEAD: usize = 4;
/// Sample rate, Hz.
const SAMPLE_HZ: u32 = 500_000;
/// Processor cycles per sample, at 150 MHz.
pub const CYCLES_PER_SAMPLE: u32 = 150_000_000 / SAMPLE_HZ;
/// Processor cycles per block.
pub const CYCLES_PER_BLOCK: u32 = CYCLES_PER_SAMPLE * BLOCK as u32;
/// Code of zero volts.
pub const SILENCE: u16 = 2048;

type Half = half::Half<RING>;
type Step = step::Step<RING>;
type Beat = beat::Beat<CYCLES_PER_BLOCK>;

/// Returns the settings: a capacitor instead of the stack, on two lanes.
fn config() -> Config {
    let mut config = Config { sample_hz: SAMPLE_HZ as f32, block_samples: BLOCK as u16, lanes: 2, ..loop_back::config() };
    // This board has no multiplexer at its converters.
    config.phasing.watch = false;
    config
}

/// Simulated board, with the background's ends of the queues.
pub struct Board {
    /// Simulated microcontroller.
    pub part: Part,
    /// Answers of the controller, one per block.
    pub answers: Vec<DriveBlock>,
    /// `true` if a stream has lost a sample and no further block follows.
    pub has_ended: bool,
    task: BlockTask<'static>,
    beat: Beat,
    step: Step,
    sense: SenseBlock,
    drive: DriveBlock,
    late: bool,
    background: BackgroundEnds<'static>,
    latest: Telemetry,
}

impl Board {
    /// Creates a silent board.
    pub fn new() -> Self {
        let config = config();
        let queues: &mut Queues<9, 5> = Box::leak(Box::default());
        let (ends, background) = queues.split(Box::leak(Box::<Loans<5>>::default()));
        let task = BlockTask::build(&config, ends).expect("the settings are valid");
        let drive = task.silence();
        Board {
            part: Part::new(LoopBack::of(&config)),
            answers: Vec::new(),
            has_ended: false,
            task,
            beat: Beat::default(),
            step: Step::default(),
            sense: SenseBlock::default(),
            drive,
            late: false,
            background,
            latest: Telemetry::default(),
        }
    }

    /// Sends an order to the controller.
    pub fn order(&mut self, orders: Orders) {
        self.background.orders.enqueue(orders).expect("there is room");
    }

    /// Returns the report of the last block.
    pub fn latest(&self) -> &Telemetry {
        &self.latest
    }

    /// Returns the number of missed blocks before the last one, as reported to the controller.
    pub fn missed(&self) -> Option<u32> {
        self.sense.slow.missed_blocks
    }

    /// Waits for the interrupt, serves it in `cycles`, and reads the reports.
    pub fn block(&mut self, cycles: u32) {
        self.part.wait_for_interrupt();
        self.interrupt(cycles);
        while let Some(report) = self.background.reports.dequeue() {
            self.latest = *report;
            let _ = self.background.read.enqueue(report);
        }
    }

    /// Waits for the next interrupt and leaves it unserved for `cycles`.
    pub fn mask(&mut self, cycles: u32) {
        self.part.wait_for_interrupt();
        self.part.advance(cycles);
    }

    /// Runs the block interrupt.
    fn interrupt(&mut self, cycles: u32) {
        let began = self.part.cycle_count();
        self.part.await_quiet();
        let (adc, dac) = (position::<RING>(self.part.adc_remaining()), position::<RING>(self.part.dac_remaining()));
        if !self.step.holds((adc, dac)) {
            self.has_ended = true;
            return self.silence();
        }
        let half = Half::at(adc).other();
        packing::sense(half.filled(&self.part.samples), |place| place.get(), &mut self.sense);
        self.sense.slow.missed_blocks = Some(self.beat.missed(began) + u32::from(self.late));
        self.task.run(&self.sense, &mut self.drive);
        self.part.advance(cycles);
        if self.drive.drops_queue {
            self.silence();
        }
        packing::drive(&self.drive, 0, SILENCE, half.played::<AHEAD, _>(&self.part.codes), |place, word| place.set(word));
        self.late = !half.is_in_time::<AHEAD>(position::<RING>(self.part.dac_remaining()));
        self.answers.push(self.drive.clone());
    }

    /// Writes silence to both halves.
    fn silence(&self) {
        self.part.codes.iter().for_each(|place| place.set(packing::word(SILENCE, SILENCE)));
    }
}
