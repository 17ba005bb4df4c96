//! The slow side: commands in, telemetry out, the enable pin, the emergency stop, the watchdog.
//!
//! Generic over embedded-hal and embedded-io, and as slow as it likes to be: what must be fast is in the block task or in
//! hardware. The board calls [`App::poll`] in a loop.
//!
//! * The enable pin is high only while the controller is driving, has no fault, and the emergency stop is not pressed.
//! * The emergency stop drops the enable pin here, without waiting for the controller, and orders a fault that stays.
//! * The watchdog is fed only while blocks keep coming: if the block stream dies, the board resets.

use embedded_hal::digital::{InputPin, OutputPin};
use embedded_io::{Read, ReadReady, Write, WriteReady};
use heapless::spsc::{Consumer, Producer};

use crate::block::Orders;
use crate::command::{Command, Identity, Refusal, Reply};
use crate::link::{self, Encoded, FrameError, Receiver};
use crate::supervisor::Mode;
use crate::telemetry::Telemetry;

/// A watchdog that resets the board unless it is fed in time. embedded-hal 1.0 has no such trait.
pub trait Watchdog {
    /// Starts the time anew.
    fn feed(&mut self);
}

/// The board's peripherals that the slow side needs.
pub struct Peripherals<L, E, S, W> {
    /// The link to the host.
    pub link: L,
    /// Enables the power amplifier; high is on.
    pub enable: E,
    /// The emergency stop's contact; low is pressed, so that a broken wire stops.
    pub stop: S,
    /// The watchdog.
    pub watchdog: W,
}

/// The slow side.
pub struct App<'a, L, E, S, W> {
    peripherals: Peripherals<L, E, S, W>,
    orders: Producer<'a, Orders>,
    telemetry: Consumer<'a, Telemetry>,
    receiver: Receiver,
    latest: Orders,
    seen: Option<Telemetry>,
    telemetry_every: u32,
    next_telemetry: u32,
    telemetry_frames: u16,
}

/// A slow peripheral has failed; the drive is disabled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AppError {
    /// A pin.
    Pin,
    /// The link.
    Link,
}

impl<'a, L, E, S, W> App<'a, L, E, S, W>
where
    L: Read + ReadReady + Write + WriteReady,
    E: OutputPin,
    S: InputPin,
    W: Watchdog,
{
    /// A slow side that leaves orders in one queue and takes telemetry from the other.
    pub fn new(peripherals: Peripherals<L, E, S, W>, orders: Producer<'a, Orders>, telemetry: Consumer<'a, Telemetry>) -> Self {
        App {
            peripherals,
            orders,
            telemetry,
            receiver: Receiver::default(),
            latest: Orders::default(),
            seen: None,
            telemetry_every: 0,
            next_telemetry: 0,
            telemetry_frames: 0,
        }
    }

    /// One turn of the loop. An error has already dropped the enable pin, as far as that goes.
    pub fn poll(&mut self) -> Result<(), AppError> {
        let turn = self.turn();
        if turn.is_err() {
            let _ = self.peripherals.enable.set_low();
        }
        turn
    }

    /// The report of the latest block.
    pub fn latest(&self) -> Option<&Telemetry> {
        self.seen.as_ref()
    }

    fn turn(&mut self) -> Result<(), AppError> {
        let blocks_came = self.drain_telemetry();
        self.watch_stop()?;
        self.set_enable()?;
        self.obey_link()?;
        self.report()?;
        if blocks_came {
            self.peripherals.watchdog.feed();
        }
        Ok(())
    }

    fn drain_telemetry(&mut self) -> bool {
        let mut came = false;
        while let Some(telemetry) = self.telemetry.dequeue() {
            self.seen = Some(telemetry);
            came = true;
        }
        came
    }

    fn watch_stop(&mut self) -> Result<(), AppError> {
        let pressed = self.peripherals.stop.is_low().map_err(|_| AppError::Pin)?;
        if pressed {
            self.peripherals.enable.set_low().map_err(|_| AppError::Pin)?;
        }
        if pressed != self.latest.emergency_stop {
            let sequence = self.latest.sequence.wrapping_add(1);
            // If the queue is full this is tried again at the next turn; the enable pin is down already.
            let _ = self.order(Orders { sequence, emergency_stop: pressed, clear_fault: false, ..self.latest });
        }
        Ok(())
    }

    fn set_enable(&mut self) -> Result<(), AppError> {
        let driving = self.seen.is_some_and(|seen| !matches!(seen.mode, Mode::Idle | Mode::Fault));
        let on = driving && !self.latest.emergency_stop;
        self.peripherals.enable.set_state(on.into()).map_err(|_| AppError::Pin)
    }

    fn obey_link(&mut self) -> Result<(), AppError> {
        let mut bytes = [0; 32];
        while self.peripherals.link.read_ready().map_err(|_| AppError::Link)? {
            let count = self.peripherals.link.read(&mut bytes).map_err(|_| AppError::Link)?;
            for &byte in &bytes[..count] {
                if let Some(frame) = self.receiver.take::<Command>(byte) {
                    let (sequence, reply) = match frame {
                        Ok(frame) => (frame.sequence, self.obey(&frame.body)),
                        Err(FrameError::Version(sequence)) => (sequence, Reply::Nak(Refusal::Version)),
                        Err(FrameError::TooLong | FrameError::Damaged) => (0, Reply::Nak(Refusal::Damaged)),
                    };
                    self.send(sequence, reply)?;
                }
            }
        }
        Ok(())
    }

    fn obey(&mut self, command: &Command) -> Reply {
        match command {
            Command::Identify => {
                return Reply::Identity(Identity { protocol: link::VERSION, firmware: firmware_version() });
            }
            Command::TelemetryEvery(blocks) => {
                self.telemetry_every = *blocks;
                self.next_telemetry = self.seen.map_or(0, |seen| seen.block);
            }
            _ => {}
        }
        match command.applied_to(&self.latest) {
            Ok(None) => Reply::Ack,
            Ok(Some(orders)) => self.order(orders).map_or_else(Reply::Nak, |()| Reply::Ack),
            Err(refusal) => Reply::Nak(refusal),
        }
    }

    fn order(&mut self, orders: Orders) -> Result<(), Refusal> {
        self.orders.enqueue(orders).map_err(|_| Refusal::Busy)?;
        self.latest = orders;
        Ok(())
    }

    fn report(&mut self) -> Result<(), AppError> {
        let Some(seen) = self.seen.filter(|_| self.telemetry_every > 0) else { return Ok(()) };
        // Wraps with the block counter; the difference is small as long as anybody polls.
        if (seen.block.wrapping_sub(self.next_telemetry) as i32) < 0 {
            return Ok(());
        }
        // Telemetry gives way: if the link is busy, the next block's will do.
        if self.peripherals.link.write_ready().map_err(|_| AppError::Link)? {
            self.next_telemetry = seen.block.wrapping_add(self.telemetry_every);
            self.telemetry_frames = self.telemetry_frames.wrapping_add(1);
            self.send(self.telemetry_frames, Reply::Telemetry(seen))?;
        }
        Ok(())
    }

    fn send(&mut self, sequence: u16, reply: Reply) -> Result<(), AppError> {
        let frame: Encoded = link::encode(sequence, reply).map_err(|_| AppError::Link)?;
        self.peripherals.link.write_all(&frame).map_err(|_| AppError::Link)
    }
}

/// The package's version, as numbers.
fn firmware_version() -> [u8; 3] {
    [env!("CARGO_PKG_VERSION_MAJOR"), env!("CARGO_PKG_VERSION_MINOR"), env!("CARGO_PKG_VERSION_PATCH")]
        .map(|part| part.parse().unwrap_or(0))
}
