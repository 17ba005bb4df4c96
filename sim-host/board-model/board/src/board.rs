//! The board: an image on its part, with a scene's plant at the pins.

use std::collections::VecDeque;
use std::time::Duration;

use cortex_m4::{Cycle, Fetches, ImageError, Machine, Memory, Passage, Spent, Stop};
use firmware::seam::block::{DriveBlock, Orders, Request, SenseBlock};
use firmware::seam::config::{Config, LaneTrims};
use nucleo_g474re::{pages, slots};
use scene::{Driven, FaultKind};
use sim::processor::{InFunction, Load};
use sim::record::Taken;
use stm32g474::{Defect, Stm32g474};

use crate::configure::{self, Misfit};
use crate::recording::Call;
use crate::reset::Reset;
use crate::variables::{DebugInfoError, Place, ReadError, Variables};
use crate::wires::Bench;

/// The block interrupt: DMA1 channel 1, interrupt 11 (RM0440 table 97), the exception 16 later.
const BLOCK_INTERRUPT: u16 = 16 + 11;
/// Bits of an interrupt priority that the part has (PM0214 4.3).
const PRIORITY_BITS: u8 = 4;
/// Cycles a second once the image has set up its clocks.
const HZ: u64 = 170_000_000;

/// Why a board could not be started, or did not go on.
#[derive(Debug, thiserror::Error)]
pub enum BoardError {
    /// The image cannot be loaded.
    #[error("the image cannot be run: {0}")]
    Image(#[from] ImageError),
    /// Its variables cannot be read.
    #[error("the image cannot be observed: {0}")]
    DebugInfo(#[from] DebugInfoError),
    /// The image has no variable of this name.
    #[error("the image cannot be observed: it has no variable `{0}`, so it is not the driver board's image of this version")]
    Unlike(&'static str),
    /// A variable has another type than here.
    #[error("the image cannot be observed: {0}")]
    Variable(#[from] ReadError),
    /// The scene asks for what the image cannot do.
    #[error(transparent)]
    Misfit(#[from] Misfit),
    /// The board has no place for this plant.
    #[error("this scene has no place on the board: {0}")]
    Plant(&'static str),
    /// A finding of the model.
    #[error(transparent)]
    Stopped(#[from] Stop),
}

/// How a board is started.
#[derive(Clone, Copy, Debug, Default)]
pub struct Options {
    /// Cycles of time for each cycle that the block interrupt costs, in place of one: below one it is shorter than the part would be at it.
    pub rate: Option<f64>,
    /// Records each call of the controller, for a replay.
    pub record: bool,
    /// Counts what each function takes of the block interrupt.
    pub profile: bool,
}

/// A board that runs an image. A clone goes on from the same state.
#[derive(Clone, Debug)]
pub struct Board {
    machine: Machine<Stm32g474<Bench>>,
    config: Config,
    variables: BlockVariables,
    record: bool,
    rate: f64,
    /// Calls of the controller so far, if recorded.
    pub calls: Vec<Call>,
    /// Cycles that the block interrupt has cost, entry and return included.
    pub load: Taken,
    /// Its instruction fetches.
    fetches: Fetches,
    entered: Option<Passage>,
}

/// Where the block interrupt of the image has its variables.
#[derive(Clone, Debug)]
struct BlockVariables {
    /// The reference to all that the interrupt has, once it has it.
    state: Place,
    queues: Place,
    /// Where the queue of trims was read from at the last call.
    trims_head: usize,
}

impl Board {
    /// Powers a board with this image and with the settings of a scene in its flash.
    pub fn start(elf: &[u8], scene: &Driven, options: Options) -> Result<Self, BoardError> {
        Board::of_memory(elf, elf, Stm32g474::<Bench>::memory(), scene, options)
    }

    /// Powers a board with a first stage, and with this [update file](link::update_file) in its slot; `elf` is the file that it was made of.
    pub fn start_in_slot(
        first_stage: &[u8],
        slot: &[u8],
        elf: &[u8],
        scene: &Driven,
        options: Options,
    ) -> Result<Self, BoardError> {
        let mut memory = Stm32g474::<Bench>::memory();
        if let Some(bytes) = memory.get_mut(slots::SLOT.start, slot.len().min(slots::SLOT.size as usize)) {
            bytes.copy_from_slice(&slot[..bytes.len()]);
        }
        Board::of_memory(first_stage, elf, memory, scene, options)
    }

    /// Powers a board that boots the ELF file `boots`, and observes the variables of `elf`.
    fn of_memory(boots: &[u8], elf: &[u8], mut memory: Memory, scene: &Driven, options: Options) -> Result<Self, BoardError> {
        let stored = configure::stored(scene)?;
        if let Some(flash) = memory.get_mut(pages::FLASH, (pages::START + pages::SIZE - pages::FLASH) as usize) {
            configure::store(stored.overrides, flash)?;
        }
        let samples = usize::from(stored.config.block_samples);
        check(scene)?;
        let bench = Bench::new(scene, stored.config.lanes, samples, options.record);
        let chip = Stm32g474::new(stm32g474::Config::default(), bench);
        let mut machine = Machine::new(boots, memory, chip, PRIORITY_BITS)?;
        machine.watch(Some(BLOCK_INTERRUPT));
        let rate = options.rate.unwrap_or(1.0);
        machine.set_rate(rate);
        if options.profile {
            machine.start_profile(Some(BLOCK_INTERRUPT));
        }
        let found = Variables::of(elf, &[STATE, QUEUES])?;
        let place = |name| found.get(name).cloned().ok_or(BoardError::Unlike(name));
        let variables = BlockVariables { state: place(STATE)?, queues: place(QUEUES)?, trims_head: 0 };
        Ok(Board {
            machine,
            config: stored.config,
            variables,
            record: options.record,
            rate,
            calls: Vec::new(),
            load: Taken::default(),
            fetches: Fetches::default(),
            entered: None,
        })
    }

    /// The configuration of the image's controller.
    pub fn config(&self) -> &Config {
        &self.config
    }

    /// Runs for a time.
    pub fn run_for(&mut self, time: Duration) -> Result<(), BoardError> {
        let cycles = (time.as_secs_f64() * self.machine.chip.hz() as f64).ceil() as Cycle;
        self.run_until(self.machine.cycle() + cycles.max(1))
    }

    /// Runs for the time of a block.
    pub fn run_block(&mut self) -> Result<(), BoardError> {
        self.run_for(self.block_time())
    }

    /// Time of a block.
    pub(crate) fn block_time(&self) -> Duration {
        Duration::from_secs_f64(f64::from(self.config.block_samples) / f64::from(self.config.sample_hz))
    }

    fn run_until(&mut self, until: Cycle) -> Result<(), BoardError> {
        while self.machine.cycle() < until {
            if let Some(passage) = self.machine.run_until(until)? {
                self.pass(passage)?;
            }
        }
        Ok(())
    }

    /// The block interrupt was entered, or has returned.
    pub(crate) fn pass(&mut self, passage: Passage) -> Result<(), BoardError> {
        if passage.entered {
            self.entered = Some(passage);
            Ok(())
        } else {
            self.block_ended(passage)
        }
    }

    /// The block interrupt has returned: what it saw and answered stands in its variables.
    fn block_ended(&mut self, returned: Passage) -> Result<(), BoardError> {
        let (mut cycles, mut instructions) = (0, 0);
        if let Some(entered) = self.entered.take() {
            // What it costs the part, whatever time it was given.
            cycles = ((returned.at - entered.at) as f64 / self.rate).round() as Cycle;
            instructions = returned.instructions - entered.instructions;
            self.fetches.all += returned.fetches.all - entered.fetches.all;
            self.fetches.waiting += returned.fetches.waiting - entered.fetches.waiting;
            self.load.add(cycles as u32);
        }
        if !self.record && self.machine.chip.wires.first_block().is_some() {
            // Nothing more is to be known of it; and a fault that is injected may have left values in it that no type has.
            return Ok(());
        }
        if self.was_reset().is_some_and(|reset| reset.at >= returned.at) {
            // Power was cut before anybody looked: what stands in the memory is anything.
            return Ok(());
        }
        let memory = &self.machine.memory;
        let Some(state) = self.variables.state.target(memory) else { return Ok(()) };
        let field = |place: &Place, name| place.field(name).ok_or(BoardError::Unlike(name));
        let orders: Orders = field(&field(&state, "task")?, "latest")?.read(memory)?;
        if self.record {
            let trims = self.variables.trims(memory)?;
            let sense: SenseBlock = field(&state, "sense")?.read(memory)?;
            let drive: DriveBlock = field(&state, "drive")?.read(memory)?;
            let taken = (instructions as u32, cycles as u32);
            self.calls.push(Call { orders, trims, sense, drive, silent_from: None, taken });
        }
        if orders.request != Request::Idle {
            self.machine.chip.wires.begin();
        }
        Ok(())
    }

    /// Plans a defect of the part at a cycle that is to come.
    pub fn inject(&mut self, at: Cycle, defect: Defect) {
        self.machine.chip.inject(at, defect);
    }

    /// What the processor's time has gone to since this was last asked for.
    pub fn take_load(&mut self) -> Load {
        let Fetches { all, waiting } = std::mem::take(&mut self.fetches);
        let profile = self.machine.take_profile();
        let functions = profile.as_ref().map(|profile| self.machine.functions_of(profile)).unwrap_or_default();
        let named = |(name, spent): (Option<&str>, Spent)| InFunction {
            name: name.unwrap_or("code without a symbol").to_owned(),
            instructions: spent.instructions,
            cycles: spent.cycles,
            flash_fetches: spent.fetches,
        };
        let functions = functions.into_iter().map(named).collect();
        if profile.is_some() {
            self.machine.start_profile(Some(BLOCK_INTERRUPT));
        }
        Load {
            functions,
            block_cycles: self.block_cycles() as u32,
            flash_fetches: waiting as f64 / all.max(1) as f64,
            longest_masked: self.machine.take_longest_masked() as u32,
        }
    }

    /// Puts bytes on the wire to the board.
    pub fn send(&mut self, bytes: &[u8]) {
        self.bench_mut().to_board.extend(bytes);
    }

    /// Takes bytes that have come from the board; 0 where none have.
    pub fn receive(&mut self, into: &mut [u8]) -> usize {
        let from: &mut VecDeque<u8> = &mut self.bench_mut().to_host;
        let count = into.len().min(from.len());
        into.iter_mut().zip(from.drain(..count)).for_each(|(into, byte)| *into = byte);
        count
    }

    /// Time since the power came.
    pub fn now(&self) -> Duration {
        Duration::from_secs_f64(self.machine.chip.seconds(self.machine.cycle()))
    }

    /// Why the part was last reset, if it was since it was powered.
    pub fn was_reset(&self) -> Option<Reset> {
        self.machine.chip.wires.resets.last().copied()
    }

    /// What hangs on the pins.
    pub fn bench(&self) -> &Bench {
        &self.machine.chip.wires
    }

    /// What hangs on the pins, to be changed.
    pub fn bench_mut(&mut self) -> &mut Bench {
        &mut self.machine.chip.wires
    }

    /// The processor, its memories and the part.
    pub fn machine(&self) -> &Machine<Stm32g474<Bench>> {
        &self.machine
    }

    /// The processor, its memories and the part, to be changed.
    pub fn machine_mut(&mut self) -> &mut Machine<Stm32g474<Bench>> {
        &mut self.machine
    }

    /// Cycles of a block: what the interrupt may take at most.
    pub fn block_cycles(&self) -> Cycle {
        (f64::from(self.config.block_samples) / f64::from(self.config.sample_hz) * HZ as f64) as Cycle
    }
}

/// The statics of the image that are read: the block interrupt's own, and the queues.
const STATE: &str = "BLOCK_INTERRUPT";
const QUEUES: &str = "QUEUES";

impl BlockVariables {
    /// The trims that the interrupt has taken from its queue since the last call.
    fn trims(&mut self, memory: &Memory) -> Result<Option<LaneTrims>, BoardError> {
        let field = |place: &Place, name| place.field(name).ok_or(BoardError::Unlike(name));
        let queue = field(&self.queues, "trims_in")?;
        let head: usize = field(&queue, "head")?.read(memory)?;
        let before = std::mem::replace(&mut self.trims_head, head);
        if before == head {
            return Ok(None);
        }
        Ok(Some(field(&queue, "buffer")?.element(before).ok_or(BoardError::Unlike("buffer"))?.read(memory)?))
    }
}

/// Refuses a scene with faults of converters that the board does not have (those of the plant and of its sensors have a place here), and one that
/// calibrates its lanes, which the order to run does not.
fn check(scene: &Driven) -> Result<(), BoardError> {
    let of_converters = |kind: FaultKind| {
        use FaultKind::{Dropout, LateBlock, Open, Saturation, SensorStuck, Swapped};
        matches!(kind, Dropout | LateBlock | Open | Saturation | SensorStuck | Swapped)
    };
    if scene.fault.iter().any(|fault| of_converters(fault.kind)) {
        return Err(BoardError::Plant("its faults are those of converters that the board does not have"));
    }
    if scene.controller.phasing.calibrate {
        return Err(BoardError::Plant("it calibrates its lanes, which a client orders: `link board:SCENE calibrate`"));
    }
    Ok(())
}
