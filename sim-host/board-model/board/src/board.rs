//! Driver board: an image on a model of its microcontroller, with a scene's plant at the pins.

use std::collections::VecDeque;
use std::time::Duration;

use cortex_m4::{Cycle, Fetches, ImageError, Machine, Memory, Passage, Stop};
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

/// Exception number of the block interrupt: DMA1 channel 1, interrupt 11 (RM0440 table 97), plus
/// 16.
const BLOCK_INTERRUPT: u16 = 16 + 11;
/// Number of implemented bits of an interrupt priority (PM0214 4.3).
const PRIORITY_BITS: u8 = 4;
/// Clock frequency after the image has set up its clocks, Hz.
const CORE_HZ: u64 = 170_000_000;

/// Error at the start or during the run of a board.
#[derive(Debug, thiserror::Error)]
pub enum BoardError {
    /// Image that cannot be loaded.
    #[error("the image cannot be run: {0}")]
    Image(#[from] ImageError),
    /// Image whose debug information cannot be read.
    #[error("the image cannot be observed: {0}")]
    DebugInfo(#[from] DebugInfoError),
    /// Image without a variable of this name.
    #[error("the image cannot be observed: it has no variable `{0}`, so it is not a driver board image of this version")]
    Unlike(&'static str),
    /// Variable whose type differs from that of this program.
    #[error("the image cannot be observed: {0}")]
    Variable(#[from] ReadError),
    /// Scene with settings that the image does not support.
    #[error(transparent)]
    Misfit(#[from] Misfit),
    /// Scene with a plant or faults that the board does not support.
    #[error("this scene cannot run on the board: {0}")]
    Plant(&'static str),
    /// Finding of the model that stopped the run.
    #[error(transparent)]
    Stopped(#[from] Stop),
}

/// Options of a board.
#[derive(Clone, Copy, Debug, Default)]
pub struct Options {
    /// Cycles of time per cycle of cost of the block interrupt; below one it is faster than the
    /// hardware.
    pub rate: Option<f64>,
    /// `true` to record each call of the controller, for a replay.
    pub record: bool,
    /// `true` to count the cycles of each function in the block interrupt.
    pub profile: bool,
    /// `true` for a bare Nucleo: a wire from PA4 to PA0, PA1 and PA7 instead of the plant.
    pub jumper: bool,
}

/// Board that runs an image. A clone continues from the same state.
#[derive(Clone, Debug)]
pub struct Board {
    machine: Machine<Stm32g474<Bench>>,
    config: Config,
    variables: BlockVariables,
    record: bool,
    rate: f64,
    /// Calls of the controller so far, if recorded.
    pub calls: Vec<Call>,
    /// Cycles of the block interrupt, including entry and return.
    pub load: Taken,
    /// Instruction fetches of the block interrupt.
    fetches: Fetches,
    entered: Option<Passage>,
}

/// Places of the variables of the image's block interrupt.
#[derive(Clone, Debug)]
struct BlockVariables {
    /// Reference to the state of the interrupt; empty until the interrupt has it.
    state: Place,
    queues: Place,
    /// Read position of the queue of trims at the last call.
    trims_head: usize,
}

impl Board {
    /// Powers a board with this image and with the settings of a scene in its flash.
    pub fn start(elf: &[u8], scene: &Driven, options: Options) -> Result<Self, BoardError> {
        Board::from_memory(elf, elf, Stm32g474::<Bench>::memory(), scene, options)
    }

    /// Powers a board with a first stage, and with this [update file](link::update_file) in its
    /// slot; `elf` is the source of the update file.
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
        Board::from_memory(first_stage, elf, memory, scene, options)
    }

    /// Powers a board that boots the ELF file `boots`, and observes the variables of `elf`.
    fn from_memory(boots: &[u8], elf: &[u8], mut memory: Memory, scene: &Driven, options: Options) -> Result<Self, BoardError> {
        let stored = configure::stored(scene)?;
        if let Some(flash) = memory.get_mut(pages::FLASH, (pages::START + pages::SIZE - pages::FLASH) as usize) {
            configure::store(stored.overrides, flash)?;
        }
        let samples = usize::from(stored.config.block_samples);
        check(scene)?;
        let mut bench = Bench::new(scene, stored.config.lanes, samples, options.record);
        bench.jumper = options.jumper;
        let chip = Stm32g474::new(stm32g474::Config::default(), bench);
        let mut machine = Machine::new(boots, memory, chip, PRIORITY_BITS)?;
        machine.watch(Some(BLOCK_INTERRUPT));
        let rate = options.rate.unwrap_or(1.0);
        machine.set_rate(rate);
        if options.profile {
            machine.start_profile(Some(BLOCK_INTERRUPT));
        }
        let found = Variables::from_elf(elf, &[STATE, QUEUES])?;
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

    /// Returns the configuration of the image's controller.
    pub fn config(&self) -> &Config {
        &self.config
    }

    /// Runs for a time.
    pub fn run_for(&mut self, time: Duration) -> Result<(), BoardError> {
        let cycles = (time.as_secs_f64() * self.machine.chip.hz() as f64).ceil() as Cycle;
        self.run_until(self.machine.cycle() + cycles.max(1))
    }

    /// Runs for the duration of a block.
    pub fn run_block(&mut self) -> Result<(), BoardError> {
        self.run_for(self.block_time())
    }

    /// Returns the duration of a block.
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

    /// Handles an entry or return of the block interrupt.
    pub(crate) fn pass(&mut self, passage: Passage) -> Result<(), BoardError> {
        if passage.entered {
            self.entered = Some(passage);
            Ok(())
        } else {
            self.block_ended(passage)
        }
    }

    /// Handles the return of the block interrupt: reads its input and answer from its variables.
    fn block_ended(&mut self, returned: Passage) -> Result<(), BoardError> {
        let (mut cycles, mut instructions) = (0, 0);
        if let Some(entered) = self.entered.take() {
            // Cost at the speed of the hardware, without the rate.
            cycles = ((returned.at - entered.at) as f64 / self.rate).round() as Cycle;
            instructions = returned.instructions - entered.instructions;
            self.fetches.all += returned.fetches.all - entered.fetches.all;
            self.fetches.waiting += returned.fetches.waiting - entered.fetches.waiting;
            self.load.add(cycles as u32);
        }
        if !self.record && self.machine.chip.wires.first_block().is_some() {
            // No more data is needed, and an injected fault may have left invalid values.
            return Ok(());
        }
        if self.was_reset().is_some_and(|reset| reset.at >= returned.at) {
            // A power cut came before this read, so the memory is undefined.
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

    /// Plans a defect of the microcontroller at a future cycle.
    pub fn inject(&mut self, at: Cycle, defect: Defect) {
        self.machine.chip.inject(at, defect);
    }

    /// Returns the use of the processor's time since the last call.
    pub fn take_load(&mut self) -> Load {
        let Fetches { all, waiting } = std::mem::take(&mut self.fetches);
        let profile = self.machine.take_profile();
        let functions = profile.as_ref().map(|profile| self.machine.functions_of(profile)).unwrap_or_default();
        let named = |of: cortex_m4::InFunction| InFunction {
            name: of.name.unwrap_or("code without a symbol").to_owned(),
            instructions: of.all.instructions,
            cycles: of.all.cycles,
            flash_fetches: of.all.fetches,
            longest_instructions: of.longest.instructions,
            longest_cycles: of.longest.cycles,
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

    /// Sends bytes over the serial line to the board.
    pub fn send(&mut self, bytes: &[u8]) {
        self.bench_mut().to_board.extend(bytes);
    }

    /// Takes bytes from the board and returns their number.
    pub fn receive(&mut self, into: &mut [u8]) -> usize {
        let from: &mut VecDeque<u8> = &mut self.bench_mut().to_host;
        let count = into.len().min(from.len());
        into.iter_mut().zip(from.drain(..count)).for_each(|(into, byte)| *into = byte);
        count
    }

    /// Returns the time since power-on.
    pub fn now(&self) -> Duration {
        Duration::from_secs_f64(self.machine.chip.seconds(self.machine.cycle()))
    }

    /// Returns the last reset, if there was one since power-on.
    pub fn was_reset(&self) -> Option<Reset> {
        self.machine.chip.wires.resets.last().copied()
    }

    /// Returns the circuit at the pins.
    pub fn bench(&self) -> &Bench {
        &self.machine.chip.wires
    }

    /// Returns the circuit at the pins, mutable.
    pub fn bench_mut(&mut self) -> &mut Bench {
        &mut self.machine.chip.wires
    }

    /// Returns the processor, its memories and the chip.
    pub fn machine(&self) -> &Machine<Stm32g474<Bench>> {
        &self.machine
    }

    /// Returns the processor, its memories and the chip, mutable.
    pub fn machine_mut(&mut self) -> &mut Machine<Stm32g474<Bench>> {
        &mut self.machine
    }

    /// Returns the cycles of a block, which is the maximum for its interrupt.
    pub fn block_cycles(&self) -> Cycle {
        (f64::from(self.config.block_samples) / f64::from(self.config.sample_hz) * CORE_HZ as f64) as Cycle
    }
}

/// Static of the image with the state of the block interrupt.
const STATE: &str = "BLOCK_INTERRUPT";
/// Static of the image with the queues.
const QUEUES: &str = "QUEUES";

impl BlockVariables {
    /// Returns the trims that the interrupt has taken from its queue since the last call.
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

/// Refuses a scene with converter faults, which the board does not have, and a scene that
/// calibrates its lanes, because the run command does not calibrate. Faults of the plant and of its
/// sensors are supported.
fn check(scene: &Driven) -> Result<(), BoardError> {
    let of_converters = |kind: FaultKind| {
        use FaultKind::{CurrentLate, Dropout, LateBlock, Open, Saturation, SensorStuck, Swapped};
        matches!(kind, CurrentLate | Dropout | LateBlock | Open | Saturation | SensorStuck | Swapped)
    };
    if scene.fault.iter().any(|fault| of_converters(fault.kind)) {
        return Err(BoardError::Plant("it has faults of converters, which the board model does not support"));
    }
    if scene.controller.phasing.calibrate {
        return Err(BoardError::Plant("it calibrates its lanes; calibrate with `link board:SCENE calibrate` instead"));
    }
    Ok(())
}
