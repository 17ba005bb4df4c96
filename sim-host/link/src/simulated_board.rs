//! A simulated board: the firmware's block interrupt, background task, settings and watchdog on mocks, a scene's plant behind its converters, and the
//! bytes of its UART at the pace of the real one.
//!
//! Time is what is played. A byte takes ten bits at [`BAUD`], in either direction, so that a dialogue meets here what it meets on a board: a
//! report of telemetry takes about sixty blocks to come.

use std::cell::RefCell;
use std::collections::VecDeque;
use std::io;
use std::rc::Rc;
use std::time::Duration;

use firmware::board::start::Start;
use firmware::seam::block::{DriveBlock, SenseBlock};
use firmware::seam::config::Config;
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

/// Bits of a byte on the wire.
const BITS: u64 = 10;
/// Bytes that the UART holds before the wire has taken them.
const FIFO: Wire = Wire { capacity: Some(64), when_full: WhenFull::Refuses };

/// The plant with what can break on the way, and the last blocks that went over the converters.
pub type Rig = Tracer<FaultInjector<Plant>>;

/// A plant that outlives the board: a reset of the board does not stop it.
#[derive(Clone)]
struct Shared(Rc<RefCell<Rig>>);

impl Analog for Shared {
    fn exchange(&mut self, drive: &DriveBlock, sense: &mut SenseBlock) {
        self.0.borrow_mut().exchange(drive, sense);
    }
}

/// A simulated board with its plant and its serial port.
pub struct SimulatedBoard {
    setup: Setup,
    /// None where it does not start any more.
    bench: Option<Bench<'static, Shared>>,
    rig: Rc<RefCell<Rig>>,
    to_board: VecDeque<u8>,
    to_host: VecDeque<u8>,
    /// Parts of a byte, in bytes times samples a second, that the wires have taken.
    credit: u64,
    blocks: u64,
}

impl SimulatedBoard {
    /// The board that a scene describes, just powered. The last `keep` blocks at the converters are recorded.
    pub fn new(scene: &Driven, keep: usize) -> Result<Self, firmware::seam::error::Error> {
        Self::with_flash(scene, keep, Setup::default().flash)
    }

    /// The same board with what an earlier one has left in its flash.
    pub fn with_flash(scene: &Driven, keep: usize, flash: Flash) -> Result<Self, firmware::seam::error::Error> {
        let setup = Setup { config: settings::config(scene), to_host: FIFO, flash, ..Setup::default() };
        let rig = Rc::new(RefCell::new(Tracer::new(breakable_plant(scene), keep)));
        let bench = Some(powered(&setup, &rig)?);
        let (to_board, to_host) = Default::default();
        Ok(SimulatedBoard { setup, bench, rig, to_board, to_host, credit: 0, blocks: 0 })
    }

    /// Configuration of the board's controller.
    pub fn config(&self) -> &Config {
        &self.setup.config
    }

    /// Turns the board off: what is left is its flash.
    pub fn power_off(&mut self) -> Flash {
        self.bench.take().map_or_else(|| self.setup.flash.clone(), Bench::power_off)
    }

    /// Time since the power came.
    pub fn now(&self) -> Duration {
        Duration::from_secs_f64(self.blocks as f64 * self.block_s())
    }

    /// Duration of a block, s.
    pub fn block_s(&self) -> f64 {
        f64::from(self.setup.config.block_samples) / f64::from(self.setup.config.sample_hz)
    }

    /// Puts bytes on the wire to the board.
    pub fn send(&mut self, bytes: &[u8]) {
        self.to_board.extend(bytes);
    }

    /// How many bytes are on the wire to the board.
    pub fn waiting(&self) -> usize {
        self.to_board.len()
    }

    /// Takes bytes that have come from the board; 0 where none have.
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
        self.credit += u64::from(BAUD) / BITS * u64::from(self.setup.config.block_samples);
        let bytes = (self.credit / sample_hz) as usize;
        self.credit %= sample_hz;
        let there: Vec<u8> = self.to_board.drain(..bytes.min(self.to_board.len())).collect();
        // The mock's wire to the board is endless, and is never cut.
        let _ = bench.host.send_bytes(&there);
        bench.block();
        self.to_host.extend(bench.host.link.inner.take(bytes));
        let start = match bench.watchdog.bitten() {
            Some(_) => Some(Start::Watchdog),
            // What the UART still holds leaves before the part resets.
            None if bench.watchdog.resets() > 0 && bench.host.link.inner.waiting() == 0 => Some(Start::Ordered),
            None => None,
        };
        if let Some(start) = start {
            self.reset(start);
        }
    }

    /// Restarts the board on the same flash; bytes on their way to the board are lost, and the plant goes on.
    fn reset(&mut self, start: Start) {
        self.reset_with(start, |_| ());
    }

    /// Powers the board off and on, with something done to its flash meanwhile: what another image has left there, or age.
    pub fn power_cycle(&mut self, change: impl FnOnce(&mut Flash)) {
        self.reset_with(Start::PowerOn, change);
    }

    fn reset_with(&mut self, start: Start, change: impl FnOnce(&mut Flash)) {
        let Some(bench) = self.bench.take() else { return };
        self.setup.flash = bench.power_off();
        change(&mut self.setup.flash);
        self.setup.start = start;
        self.to_board.clear();
        // What has been built once from what is built in can be again: `PowerUp` falls back on that.
        self.bench = powered(&self.setup, &self.rig).ok();
    }

    /// Looks at the plant behind the board.
    pub fn with_rig<T>(&self, look: impl FnOnce(&Rig) -> T) -> T {
        look(&self.rig.borrow())
    }

    /// Changes something at the plant or at what is between.
    pub fn change_rig(&mut self, change: impl FnOnce(&mut Rig)) {
        change(&mut self.rig.borrow_mut());
    }
}

/// A board that is powered on this flash.
fn powered(setup: &Setup, rig: &Rc<RefCell<Rig>>) -> Result<Bench<'static, Shared>, firmware::seam::error::Error> {
    // As a board's statics: they stay for as long as the process does.
    Bench::new(Box::leak(Box::default()), setup, Shared(rig.clone()))
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
