//! The Sonoglide controller: ultrasonic friction control on a microcontroller, in a simulation, or
//! in a test.
//!
//! One `no_std` controller generates the ultrasonic drive, keeps a piezo stack at its series
//! resonance by its motional current, and switches friction on and off in bursts. The same code
//! runs as thumb code on a driver board, in an emulator, and on the host against a simulated
//! stack and contact. Transcendental functions come from `libm` or from compile-time tables, and
//! no multiply-add is fused, so that all targets agree bit for bit.
//!
//! # The signal chain
//!
//! ```text
//! SenseBlock -> convert -> demod -> motional -> tracker -> supervisor -> burst -> shaper -> DriveBlock
//!                                                   \------------- Telemetry, by value
//! ```
//!
//! Once a block, an interrupt passes the measured codes to [`Controller::process`], which returns
//! the codes to play two blocks later. A background task, [`App`], serves the link, the pins, the
//! watchdog and the flash, without a deadline. Orders and telemetry pass between the two through
//! queues.
//!
//! # Layers
//!
//! | you write | you need |
//! |---|---|
//! | a simulation or a test of the control | [`Controller`], with the values of [`seam`] |
//! | a board | [`board`]: [`BlockTask`] for the interrupt, [`App`] for the background task |
//! | a host that talks to a board | [`board::command`], [`board::link`] and [`seam`] |
//! | a study of a single stage | [`generate`], [`sense`], [`find`], [`track`], [`act`] or [`guard`] |
//!
//! Each layer depends only on layers before it in this order: `seam`, `generate`, `sense`, `find`,
//! `track`, `act`, `guard`, `controller`, `board`. `guard` needs only the first three.
//!
//! # Example: a whole board
//!
//! A complete board with mocks of its peripherals and a capacitor instead of the stack. The host
//! orders a run, and after the self-test the amplifier is enabled and driven. Then the emergency
//! stop is pressed.
//!
//! ```
//! use sonoglide_firmware::board::{app::Peripherals, power_up::PowerUp, queues::Queues, start::Start};
//! use sonoglide_firmware::{App, Command, Fault, Mode, Settings};
//! use hal_mock::{block_clock::BlockClock, flash::Flash, host::Host, link, loop_back, pin, time::Clock, watchdog};
//!
//! # fn main() -> Result<(), Box<dyn core::error::Error>> {
//! // Peripherals: mocks here, registers on a board.
//! let config = loop_back::config();
//! let clock = Clock::new(config.sample_hz as u32);
//! let ((enable, amplifier), (stop, button)) = (pin::output(&clock), pin::input(true));
//! let (link, host) = link::duplex(link::Wire::default(), link::Wire::default());
//! let (watchdog, mut host) = (watchdog::Watchdog::new(&clock, std::time::Duration::from_secs(1)), Host::new(host));
//!
//! // Power-up: stored settings replace those of the image; both tasks share the queues.
//! let mut settings = Settings::new(Flash::new(4, 1))?;
//! let mut power_up = PowerUp::read(&config, &mut settings);
//! let mut queues = Queues::<9, 65>::new();
//! let (interrupt_ends, background_ends) = queues.split(Box::leak(Box::default()));
//! let mut interrupt = power_up.build(&config, interrupt_ends)?;
//! let peripherals = Peripherals { link, enable, stop, watchdog, settings, start: Start::PowerOn };
//! let mut background = App::new(peripherals, background_ends, &power_up);
//!
//! // Operation: one block of the interrupt, then one pass of the background task.
//! let mut converters = BlockClock::new(loop_back::LoopBack::of(&config), &interrupt.silence());
//! let mut block = || {
//!     converters.tick(|sense, drive| interrupt.run(sense, drive));
//!     background.poll().ok()?;
//!     background.latest().copied()
//! };
//! // The board obeys only the latest session.
//! host.send(Command::Identify(7))?;
//! block();
//! host.receive(usize::MAX);
//! host.send(Command::Run)?;
//! let running = (0..200).find_map(|_| block().filter(|report| report.mode == Mode::Run && report.envelope > 0.0));
//! assert_eq!(running.map(|report| report.drive.0), Some(3.0), "volts");
//! assert!(amplifier.is_high());
//!
//! button.set(false);
//! let stopped = (0..4).find_map(|_| block().filter(|report| report.mode == Mode::Fault));
//! assert_eq!(stopped.and_then(|report| report.fault), Some(Fault::EmergencyStop));
//! assert!(!amplifier.is_high());
//! # Ok(())
//! # }
//! ```
#![no_std]
#![forbid(unsafe_code)]
#![warn(unreachable_pub)]

#[cfg(any(test, feature = "scene"))]
extern crate std;

pub mod act;
pub mod board;
pub mod controller;
pub mod find;
pub mod generate;
pub mod guard;
pub mod seam;
pub mod sense;
pub mod track;

pub use crate::board::app::App;
pub use crate::board::block_task::BlockTask;
pub use crate::board::command::Command;
pub use crate::board::settings::Settings;
pub use crate::controller::Controller;
pub use crate::seam::block::{DriveBlock, Orders, SenseBlock};
pub use crate::seam::config::Config;
pub use crate::seam::error::Error;
pub use crate::seam::fault::{Fault, Limit};
pub use crate::seam::mode::Mode;
pub use crate::seam::telemetry::Telemetry;
