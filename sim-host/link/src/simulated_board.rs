//! Simulated board: the firmware's block interrupt, background task, settings and watchdog on
//! mocks, with the plant of a scene at its converters, and a UART with the speed of the real one.
//!
//! Time advances with the played blocks. A byte takes ten bits at [`BAUD`], in either direction, so
//! that a dialogue has the timing of a real board: a telemetry report takes about sixty blocks.

use std::cell::RefCell;
use std::collections::VecDeque;
use std::io;
use std::rc::Rc;
use std::time::Duration;

use firmware::board::start::Start;
use firmware::seam::block::{DriveBlock, SenseBlock};
use firmware::seam::config::{Config, FrontEnd};
use hal_mock::analog::Analog;
use hal_mock::bench::{Bench, Setup};
use hal_mock::fault_injector::FaultInjector;
use hal_mock::flash::Flash;
use hal_mock::link::{WhenFull, Wire};
use hal_mock::tracer::Tracer;

use crate::port::{BAUD, InProcess};
use plant::Plant;
use scene::Driven;
use scene::settings;
use sim::run::breakable_plant;

/// Number of bits per byte on the wire.
const BITS_PER_BYTE: u64 = 10;
/// Transmit buffer of the UART.
const TRANSMIT_BUFFER: Wire = Wire { capacity: Some(64), when_full: WhenFull::Refuses };

/// Plant with injected faults, and a record of the last blocks at the converters.
pub type Rig = Tracer<FaultInjector<Plant>>;

/// Plant that outlives the board: a reset of the board does not stop it.
#[derive(Clone)]
struct Shared {
    rig: Rc<RefCell<Rig>>,
    jumper: Option<Jumper>,
}

/// Wire from the first lane to the inputs of both sense channels, instead of the plant. Noise and
/// offset of the channels remain.
#[derive(Clone, Copy)]
struct Jumper {
    sense_max_code: u16,
    drive_mid_code: u16,
    /// Sense codes per drive code.
    ratio: f64,
}

impl Jumper {
    fn new(config: &Config) -> Self {
        let FrontEnd { sense_mid_code, sense_max_code, drive_mid_code, .. } = config.front_end;
        Jumper { sense_max_code, drive_mid_code, ratio: f64::from(sense_mid_code) / f64::from(drive_mid_code) }
    }

    fn connect(&self, lane: &[u16], channel: &mut [u16]) {
        for (code, &drive) in channel.iter_mut().zip(lane) {
            let moved = self.ratio * (f64::from(drive) - f64::from(self.drive_mid_code));
            *code = (f64::from(*code) + moved).round().clamp(0.0, self.sense_max_code.into()) as u16;
        }
    }
}

impl Analog for Shared {
    fn exchange(&mut self, drive: &DriveBlock, sense: &mut SenseBlock) {
        let mut rig = self.rig.borrow_mut();
        let Some((jumper, lane)) = self.jumper.zip(drive.lanes.first()) else { return rig.exchange(drive, sense) };
        rig.exchange(&DriveBlock::silent(drive.lanes.len(), lane.len(), jumper.drive_mid_code), sense);
        [&mut sense.v, &mut sense.i].into_iter().for_each(|channel| jumper.connect(lane, channel));
    }
}

/// Simulated board with its plant and its serial port.
pub struct SimulatedBoard {
    setup: Setup,
    /// Running board; `None` if it no longer starts.
    bench: Option<Bench<'static, Shared>>,
    rig: Rc<RefCell<Rig>>,
    jumper: Option<Jumper>,
    to_board: VecDeque<u8>,
    to_host: VecDeque<u8>,
    /// Fraction of a byte that the wire has transferred, in bytes times the sampling rate in Hz.
    credit: u64,
    blocks: u64,
}

impl SimulatedBoard {
    /// Powers on the board of a scene. The last `keep` blocks at the converters are recorded.
    pub fn new(scene: &Driven, keep: usize) -> Result<Self, firmware::seam::error::Error> {
        Self::with_flash(scene, keep, Setup::default().flash)
    }

    /// Powers on the board of a scene with the flash of an earlier board.
    pub fn with_flash(scene: &Driven, keep: usize, flash: Flash) -> Result<Self, firmware::seam::error::Error> {
        let setup = Setup { config: settings::config(scene), to_host: TRANSMIT_BUFFER, flash, ..Setup::default() };
        let rig = Rc::new(RefCell::new(Tracer::new(breakable_plant(scene), keep)));
        let bench = Some(powered(&setup, &rig, None)?);
        let (to_board, to_host) = Default::default();
        Ok(SimulatedBoard { setup, bench, rig, jumper: None, to_board, to_host, credit: 0, blocks: 0 })
    }

    /// Wires the first lane to both sense channels, instead of the plant, and restarts the board.
    pub fn wire_jumper(&mut self) {
        self.jumper = Some(Jumper::new(&self.setup.config));
        self.power_cycle(|_| ());
    }

    /// Returns the configuration of the board's controller.
    pub fn config(&self) -> &Config {
        &self.setup.config
    }

    /// Returns the time since power-on.
    pub fn now(&self) -> Duration {
        Duration::from_secs_f64(self.blocks as f64 * self.block_s())
    }

    /// Returns the duration of a block, s.
    pub fn block_s(&self) -> f64 {
        f64::from(self.setup.config.block_samples) / f64::from(self.setup.config.sample_hz)
    }

    /// Puts bytes on the wire to the board.
    pub fn send(&mut self, bytes: &[u8]) {
        self.to_board.extend(bytes);
    }

    /// Returns the number of bytes on the wire to the board.
    pub fn waiting(&self) -> usize {
        self.to_board.len()
    }

    /// Takes bytes from the board; returns 0 if there are none.
    pub fn receive(&mut self, into: &mut [u8]) -> usize {
        let count = into.len().min(self.to_host.len());
        into.iter_mut().zip(self.to_host.drain(..count)).for_each(|(into, byte)| *into = byte);
        count
    }

    /// Plays one block of the board and its plant.
    pub fn block(&mut self) {
        self.blocks += 1;
        let Some(bench) = &mut self.bench else {
            self.to_board.clear();
            return;
        };
        let sample_hz = self.setup.config.sample_hz as u64;
        self.credit += u64::from(BAUD) / BITS_PER_BYTE * u64::from(self.setup.config.block_samples);
        let bytes = (self.credit / sample_hz) as usize;
        self.credit %= sample_hz;
        let there: Vec<u8> = self.to_board.drain(..bytes.min(self.to_board.len())).collect();
        // The wire of the mock to the board has no limit and does not fail.
        let _ = bench.host.send_bytes(&there);
        bench.block();
        self.to_host.extend(bench.host.link.inner.take(bytes));
        let start = match bench.watchdog.bitten() {
            Some(_) => Some(Start::Watchdog),
            // The UART sends its remaining bytes before the chip resets.
            None if bench.watchdog.resets() > 0 && bench.host.link.inner.waiting() == 0 => Some(Start::Ordered),
            None => None,
        };
        if let Some(start) = start {
            self.reset(start);
        }
    }

    /// Restarts the board with the same flash. Bytes on the way to the board are lost; the plant
    /// continues.
    fn reset(&mut self, start: Start) {
        self.reset_with(start, |_| ());
    }

    /// Powers the board off and on, and changes its flash meanwhile, as another image or ageing
    /// would.
    pub fn power_cycle(&mut self, change: impl FnOnce(&mut Flash)) {
        self.reset_with(Start::PowerOn, change);
    }

    fn reset_with(&mut self, start: Start, change: impl FnOnce(&mut Flash)) {
        let Some(bench) = self.bench.take() else { return };
        self.setup.flash = bench.power_off();
        change(&mut self.setup.flash);
        self.setup.start = start;
        self.to_board.clear();
        // The board has started before, and `PowerUp` falls back to the built-in settings.
        self.bench = powered(&self.setup, &self.rig, self.jumper).ok();
    }

    /// Passes the plant and the recorded blocks to `look`.
    pub fn with_rig<T>(&self, look: impl FnOnce(&Rig) -> T) -> T {
        look(&self.rig.borrow())
    }

    /// Changes the plant or its injected faults.
    pub fn change_rig(&mut self, change: impl FnOnce(&mut Rig)) {
        change(&mut self.rig.borrow_mut());
    }
}

/// Powers on a board with the flash of this setup.
fn powered(
    setup: &Setup,
    rig: &Rc<RefCell<Rig>>,
    jumper: Option<Jumper>,
) -> Result<Bench<'static, Shared>, firmware::seam::error::Error> {
    // Leaked like the statics of a board, which exist as long as the process.
    Bench::new(Box::leak(Box::default()), setup, Shared { rig: rig.clone(), jumper })
}

impl InProcess for SimulatedBoard {
    fn send(&mut self, bytes: &[u8]) {
        SimulatedBoard::send(self, bytes);
    }

    fn waiting(&self) -> usize {
        SimulatedBoard::waiting(self)
    }

    fn receive(&mut self, into: &mut [u8]) -> usize {
        SimulatedBoard::receive(self, into)
    }

    fn now(&self) -> Duration {
        SimulatedBoard::now(self)
    }

    fn block(&mut self) -> io::Result<()> {
        SimulatedBoard::block(self);
        Ok(())
    }
}
