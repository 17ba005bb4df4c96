//! The complete driver on mocks: converters, block task, queues, background task, pins, link and
//! watchdog, and a host at the other end of the link. A test drives it block by block and reads its
//! results.
//!
//! ```
//! use sonoglide_hal_mock::bench::{Bench, Queues, Setup};
//! use sonoglide_hal_mock::loop_back::LoopBack;
//! use firmware::board::command::{Command, Reply};
//! use firmware::seam::mode::Mode;
//!
//! # fn main() -> Result<(), firmware::seam::error::Error> {
//! let setup = Setup::default();
//! let load = LoopBack::of(&setup.config);
//! let mut queues = Queues::default();
//! let mut bench = Bench::new(&mut queues, &setup, load)?;
//!
//! assert_eq!(bench.ask(Command::Run), Some(Reply::Ack));
//! assert!(bench.run_until(|report| report.mode == Mode::Run, 200).is_some());
//! assert!(bench.enable.is_high());
//!
//! bench.press_stop();
//! bench.poll();
//! assert!(!bench.enable.is_high());
//! # Ok(())
//! # }
//! ```
//!
//! Both sides of the driver run in one thread. The block task runs after every block, the
//! background task after every [`Setup::poll_every`] blocks or when the test calls [`Bench::poll`].

use std::time::Duration;

use firmware::board::app::{App, AppError, Peripherals};
use firmware::board::block_task::BlockTask;
use firmware::board::command::{Command, Reply};
use firmware::board::link::NO_SESSION;
use firmware::board::power_up::PowerUp;
use firmware::board::queues;
use firmware::board::settings::Settings;
use firmware::board::start::Start;
use firmware::seam::config::Config;
use firmware::seam::error::Error;
use firmware::seam::fault::Fault;
use firmware::seam::mode::Mode;
use firmware::seam::telemetry::Telemetry;

use crate::analog::Analog;
use crate::block_clock::BlockClock;
use crate::flash::Flash;
use crate::host::Host;
use crate::link::{self, End, Wire};
use crate::loop_back;
use crate::pin::{self, Input, Output, Probe, Switch};
use crate::time::{Clock, Timed};
use crate::watchdog::Watchdog;

/// Number of orders that can wait for the block task.
pub const ORDERS_DEPTH: usize = 8;

/// Nonce of the host of a bench for its sessions.
const NONCE: u32 = 0x5eed;
/// Number of turns of the background task within which even a link of one byte per turn sends its
/// answer.
const MAX_CONNECT_TURNS: u32 = 64;

/// Queues and other shared memory of the two sides. They outlive the bench, like the statics of a
/// board. A ring of N holds N - 1 items.
pub type Queues = queues::Queues<{ ORDERS_DEPTH + 1 }, 64>;

/// Setup of a bench.
#[derive(Clone, Debug)]
pub struct Setup {
    /// Configuration of the controller.
    pub config: Config,
    /// Number of blocks between two turns of the background task.
    pub poll_every: u32,
    /// Period of the watchdog.
    pub watchdog: Duration,
    /// Link from the board to the host.
    pub to_host: Wire,
    /// Flash of the settings, which may contain data of an earlier bench.
    pub flash: Flash,
    /// Cause of the start of the board.
    pub start: Start,
}

impl Default for Setup {
    /// Returns the configuration for the loop-back, one turn of the background task per block, a
    /// watchdog of 10 ms, an unlimited link, and five empty pages: one for the marker of stored
    /// settings, and two for each copy.
    fn default() -> Self {
        Setup {
            config: loop_back::config(),
            poll_every: 1,
            watchdog: Duration::from_millis(10),
            to_host: Wire::default(),
            flash: Flash::new(5, 1),
            start: Start::PowerOn,
        }
    }
}

/// Driver on the bench, with mocks of all its peripherals.
pub struct Bench<'a, A> {
    /// Probe of the enable pin.
    pub enable: Probe,
    /// Contact of the emergency stop: low while it is pressed.
    pub stop: Switch,
    /// Watchdog of the board.
    pub watchdog: Watchdog,
    /// Host at the other end of the link.
    pub host: Host,
    /// Simulated time.
    pub clock: Clock,
    blocks: BlockClock<Timed<A>>,
    block_samples: u64,
    poll_every: u32,
    task: BlockTask<'a>,
    app: App<'a, End, Output, Input, Watchdog, Flash>,
    errors: Vec<AppError>,
}

impl<'a, A: Analog> Bench<'a, A> {
    /// Creates a bench with `analog` at its converters. The power has just been switched on, and
    /// the emergency stop is released. Settings stored in the flash override the configuration.
    pub fn new(queues: &'a mut Queues, setup: &Setup, analog: A) -> Result<Self, Error> {
        let (hot, slow) = queues.split(Box::leak(Box::default()));
        let mut settings = Settings::new(setup.flash.clone())?;
        let mut power_up = PowerUp::read(&setup.config, &mut settings);
        let task = power_up.build(&setup.config, hot)?;

        let clock = Clock::new(setup.config.sample_hz as u32);
        let (enable_pin, enable) = pin::output(&clock);
        let (stop_pin, stop) = pin::input(true);
        let watchdog = Watchdog::new(&clock, setup.watchdog);
        let (board_end, host_end) = link::duplex(setup.to_host, Wire::default());
        let peripherals = Peripherals {
            link: board_end,
            enable: enable_pin,
            stop: stop_pin,
            watchdog: watchdog.clone(),
            settings,
            start: setup.start,
        };

        let mut app = App::new(peripherals, slow, &power_up);
        let built_in = setup.config.clone();
        app.set_built_in(Box::leak(Box::new(move || built_in.clone())));
        Ok(Bench {
            enable,
            stop,
            watchdog,
            host: Host::new(host_end),
            blocks: BlockClock::new(Timed::new(analog, clock.clone()), &task.silence()),
            clock,
            block_samples: setup.config.block_samples.into(),
            poll_every: setup.poll_every.max(1),
            task,
            app,
            errors: Vec::new(),
        })
    }

    /// Switches everything off and returns the flash.
    pub fn power_off(self) -> Flash {
        self.app.into_peripherals().settings.release()
    }

    /// Returns the analog side at the converters.
    pub fn analog(&mut self) -> &mut A {
        &mut self.blocks.analog.inner
    }

    /// Plays one block, and gives the background task its turn if it is due.
    pub fn block(&mut self) {
        let task = &mut self.task;
        self.blocks.tick(|sense, drive| task.run(sense, drive));
        if self.blocks.blocks().is_multiple_of(self.poll_every.into()) {
            self.poll();
        }
    }

    /// Plays this number of blocks.
    pub fn blocks(&mut self, count: u64) {
        (0..count).for_each(|_| self.block());
    }

    /// Returns the number of blocks played so far.
    pub fn played(&self) -> u64 {
        self.blocks.blocks()
    }

    /// Plays blocks until the latest report fulfils a condition. Returns the number of blocks, or
    /// `None` after `at_most` blocks.
    pub fn run_until(&mut self, mut seen: impl FnMut(&Telemetry) -> bool, at_most: u64) -> Option<u64> {
        (1..=at_most).find(|_| {
            self.block();
            self.app.latest().is_some_and(&mut seen)
        })
    }

    /// Lets time pass without blocks: the block stream has stopped, and only the background task
    /// continues.
    pub fn stall(&mut self, time: Duration) {
        let until = self.clock.now() + time;
        while self.clock.now() < until {
            self.clock.advance(self.block_samples * u64::from(self.poll_every));
            self.poll();
        }
    }

    /// Gives the background task one turn.
    pub fn poll(&mut self) {
        if let Err(error) = self.app.poll() {
            self.errors.push(error);
        }
    }

    /// Returns the errors of the background task so far.
    pub fn errors(&self) -> &[AppError] {
        &self.errors
    }

    /// Begins a session of the host and returns its number. No time passes, however many turns a
    /// narrow link takes.
    pub fn connect(&mut self) -> u32 {
        let asked = self.host.send(Command::Identify(NONCE)).ok();
        for _ in 0..MAX_CONNECT_TURNS {
            self.poll();
            self.host.receive(usize::MAX);
            if asked.is_some_and(|sequence| self.host.answer_to(sequence).is_some()) {
                break;
            }
        }
        self.host.session()
    }

    /// Sends a command, gives the background task a turn, and returns the answer. A host without a
    /// session begins one before. No time passes.
    pub fn ask(&mut self, command: Command) -> Option<Reply> {
        if self.host.session() == NO_SESSION && !matches!(command, Command::Identify(_)) {
            self.connect();
        }
        let sequence = self.host.send(command).ok()?;
        self.poll();
        self.host.receive(usize::MAX);
        self.host.answer_to(sequence)
    }

    /// Presses the emergency stop.
    pub fn press_stop(&mut self) {
        self.stop.set(false);
    }

    /// Releases the emergency stop.
    pub fn release_stop(&mut self) {
        self.stop.set(true);
    }

    /// Returns the latest report that the background task has received.
    pub fn latest(&self) -> Option<&Telemetry> {
        self.app.latest()
    }

    /// Returns the mode of the latest report, or idle before the first.
    pub fn mode(&self) -> Mode {
        self.latest().map_or(Mode::Idle, |report| report.mode)
    }

    /// Returns the fault of the latest report.
    pub fn fault(&self) -> Option<Fault> {
        self.latest().and_then(|report| report.fault)
    }
}
