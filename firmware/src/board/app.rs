//! The background task: commands in, telemetry out, the enable pin, the emergency stop, the
//! watchdog, and the stored settings.
//!
//! The task is generic over embedded-hal, embedded-io and embedded-storage. It has no deadline:
//! everything with a deadline is in the block task or in hardware. The board calls [`App::poll`] in
//! a loop.
//!
//! * The enable pin is high only if the controller is driving or an attempt to drive has just been
//!   ordered, there is no fault, and the emergency stop is not pressed.
//! * A muted enable stays low: a bench without an amplifier plays tones that way.
//! * The emergency stop lowers the enable pin here, without waiting for the controller, and orders
//!   a fault that stays. The pin stays low until the controller is silent, however short the press.
//! * The watchdog is fed only while blocks arrive: if the block stream stops, the board resets.
//! * Trims found by a calibration are [stored](crate::board::settings) once the drive is silent,
//!   because erasing the flash may stall the processor.
//! * Only frames of the latest [session](crate::board::command::Command::Identify) are obeyed, and
//!   only they are signs of life of the host.
//! * A host that is silent for longer than the host timeout while the drive is on causes a fault
//!   that stays, like the emergency stop.
//! * Nothing here waits for the link, except an ordered reset, which waits until its answer has
//!   left. Output goes through a buffer. While a reply would not fit, no further command is read;
//!   telemetry that does not fit is dropped.

mod captures;
mod host_session;
mod host_watch;
mod obey;
mod outbox;
mod updates;

use embedded_hal::digital::{InputPin, OutputPin};
use embedded_io::{Read, ReadReady, Write, WriteReady};
use embedded_storage::nor_flash::NorFlash;
use heapless::spsc::{Consumer, Producer};

use self::captures::Captures;
use self::host_session::HostSession;
use self::host_watch::HostWatch;
use self::outbox::Outbox;
use crate::board::command::{Converters, Reply, ResonanceReport};
use crate::board::fault_log::FaultLog;
use crate::board::hardware::HardwareReport;
use crate::board::link::Receiver;
use crate::board::power_up::PowerUp;
use crate::board::queues::BackgroundEnds;
use crate::board::settings::Settings;
use crate::board::settings_store::SettingsStore;
use crate::board::start::Start;
use crate::board::update::Updates;
use crate::seam::block::{LATENCY_BLOCKS, Orders, Request};
use crate::seam::config::Config;
use crate::seam::mode::Mode;
use crate::seam::refusal::Refusal;
use crate::seam::telemetry::Telemetry;
use crate::seam::transducer::{MOST_MODES, Resonance};

/// A watchdog that resets the board unless it is fed in time. embedded-hal 1.0 has no such trait.
pub trait Watchdog {
    /// Restarts the watchdog's period.
    fn feed(&mut self);

    /// Resets the board at once, and records that the reset was ordered. Does not return on a
    /// board.
    fn reset(&mut self);
}

/// Peripherals of the board that the background task needs.
pub struct Peripherals<L, E, S, W, F: NorFlash> {
    /// Link to the host.
    pub link: L,
    /// Enable pin of the power amplifier; high is on.
    pub enable: E,
    /// Contact of the emergency stop; low is pressed, so that a broken wire stops the drive.
    pub stop: S,
    /// Watchdog, which this task feeds while blocks arrive.
    pub watchdog: W,
    /// Settings in flash.
    pub settings: Settings<F>,
    /// Cause of the last start.
    pub start: Start,
}

/// The background task of a board, over its peripherals.
pub struct App<'a, L, E, S, W, F: NorFlash> {
    peripherals: Peripherals<L, E, S, W, F>,
    orders: Producer<'a, Orders>,
    telemetry: Consumer<'a, &'static mut Telemetry>,
    read: Producer<'a, &'static mut Telemetry>,
    captures: Captures<'a>,
    settings_store: SettingsStore<'a>,
    /// Configuration of the image, on which settings are built before they are stored.
    built_in: Option<&'a dyn Fn() -> Config>,
    receiver: Receiver,
    outbox: Outbox,
    latest: Orders,
    /// Sequence number of the order that began the latest attempt to drive.
    attempted: Option<u32>,
    /// `true` from a press of the emergency stop until the controller is silent.
    stopping: bool,
    /// `true` from a press of the emergency stop until it is in the queue of orders.
    stop_unordered: bool,
    seen: Option<Telemetry>,
    /// Number of blocks until the last driven block has played; zero in silence and after a fault.
    queued: usize,
    telemetry_every: u32,
    last_telemetry: u32,
    telemetry_frames: u16,
    /// Resonances of the last scan, as far as the telemetry has reported them.
    resonances: [Option<Resonance>; MOST_MODES],
    converters: Converters,
    /// `true` if a friction switch is configured.
    switches_friction: bool,
    /// `true` if the restraint of a belt is configured.
    restrains: bool,
    /// `true` if a restraint is configured without the scale of its belt's encoder.
    belt_unscaled: bool,
    /// `true` if a stored limit may not act.
    limits_unsure: bool,
    faults: FaultLog,
    host: HostWatch,
    session: HostSession,
    /// `true` from the order to reset until its answer has left.
    resetting: bool,
    /// Receiver of updates, on a board that can be updated.
    updates: Option<&'a mut dyn Updates>,
    /// Hardware of the board, for reports to the host.
    hardware: HardwareReport,
    /// `true` if a host has been obeyed since the start.
    host_obeyed: bool,
}

/// Failure of a slow peripheral; the drive is disabled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AppError {
    /// The enable pin cannot be written, or the contact of the emergency stop cannot be read.
    Pin,
    /// The link cannot be read or written.
    Link,
}

impl<'a, L, E, S, W, F> App<'a, L, E, S, W, F>
where
    L: Read + ReadReady + Write + WriteReady,
    E: OutputPin,
    S: InputPin,
    W: Watchdog,
    F: NorFlash,
{
    /// Creates a background task at its ends of the queues, for the settings of this power-up.
    ///
    /// Lowers the enable pin; if that fails, the first [`App::poll`] reports it.
    pub fn new(mut peripherals: Peripherals<L, E, S, W, F>, ends: BackgroundEnds<'a>, power_up: &PowerUp) -> Self {
        let _ = peripherals.enable.set_low();
        let config = &power_up.config;
        App {
            peripherals,
            orders: ends.orders,
            telemetry: ends.reports,
            read: ends.read,
            captures: Captures::new(ends.requests, ends.replies, ends.memory, config.lanes),
            settings_store: SettingsStore::new(ends.trims_out, ends.trims_in, power_up),
            built_in: None,
            receiver: Receiver::default(),
            outbox: Outbox::default(),
            latest: Orders::default(),
            attempted: None,
            stopping: false,
            stop_unordered: false,
            seen: None,
            queued: 0,
            telemetry_every: 0,
            last_telemetry: 0,
            telemetry_frames: 0,
            resonances: Default::default(),
            faults: FaultLog::default(),
            converters: Converters::of(config),
            switches_friction: config.friction.is_some(),
            restrains: config.restraint.is_some(),
            belt_unscaled: config.restraint.is_some() && config.front_end.metre_per_count.is_none(),
            limits_unsure: power_up.limits_are_unsure(),
            host: HostWatch::new(config.link.patience_s, f32::from(config.block_samples) / config.sample_hz),
            session: HostSession::default(),
            resetting: false,
            updates: None,
            hardware: HardwareReport::default(),
            host_obeyed: false,
        }
    }

    /// Sets the receiver of updates.
    pub fn set_updates(&mut self, updates: &'a mut dyn Updates) {
        self.updates = Some(updates);
    }

    /// Sets the configuration of the image, on which settings are built before they are stored. The
    /// configuration and the small parts of a controller are built on the stack.
    pub fn set_built_in(&mut self, built_in: &'a dyn Fn() -> Config) {
        self.built_in = Some(built_in);
    }

    /// Sets the hardware of the board, for reports to the host.
    pub fn set_hardware(&mut self, hardware: HardwareReport) {
        self.hardware = hardware;
    }

    /// Sets the longest block interrupt since the start, cycles, for reports to the host.
    pub fn set_worst_cycles(&mut self, worst_cycles: u32) {
        self.hardware.worst_cycles = worst_cycles;
    }

    /// Executes one pass of the loop. After an error the enable pin is low, if it can be written.
    pub fn poll(&mut self) -> Result<(), AppError> {
        let turn = self.turn();
        if turn.is_err() {
            let _ = self.peripherals.enable.set_low();
        }
        turn
    }

    /// Returns the peripherals in their present state.
    pub fn into_peripherals(self) -> Peripherals<L, E, S, W, F> {
        self.peripherals
    }

    /// Returns the report of the latest block.
    pub fn latest(&self) -> Option<&Telemetry> {
        self.seen.as_ref()
    }

    fn turn(&mut self) -> Result<(), AppError> {
        let blocks_came = self.drain_telemetry();
        self.watch_stop()?;
        self.watch_host();
        // Before the link: an order to clear must come after the trims that were found.
        self.settings_store.store_trims(self.is_silent(), &mut self.peripherals.settings);
        self.answer_capture();
        self.obey_link()?;
        self.serve_updates();
        self.report();
        self.outbox.flush(&mut self.peripherals.link).map_err(|_| AppError::Link)?;
        self.set_enable()?;
        if blocks_came {
            self.peripherals.watchdog.feed();
        }
        self.reset_if_ordered()
    }

    fn drain_telemetry(&mut self) -> bool {
        let mut came = false;
        while let Some(telemetry) = self.telemetry.dequeue() {
            match telemetry.listed {
                None => self.resonances = Default::default(),
                Some(listed) => {
                    // A list of another length belongs to another scan.
                    let (places, rest) = self.resonances.split_at_mut(usize::from(listed.of).min(MOST_MODES));
                    rest.fill(None);
                    places.get_mut(usize::from(listed.place)).into_iter().for_each(|place| *place = Some(listed.resonance));
                }
            }
            self.faults.record(telemetry, self.seen.as_ref());
            self.seen = Some(*telemetry);
            // A drive that ends is queued, and fades; a fault does not wait for its queued blocks.
            self.queued = match telemetry.mode {
                Mode::Fault => 0,
                Mode::Idle => self.queued.saturating_sub(1),
                _ => LATENCY_BLOCKS + 1,
            };
            // There is room: no more reports circulate than the queue holds.
            let _ = self.read.enqueue(telemetry);
            came = true;
        }
        came
    }

    fn resonances(&self) -> ResonanceReport {
        let chosen = self.seen.and_then(|seen| seen.transducer).map(|transducer| transducer.chosen);
        ResonanceReport { chosen, found: self.resonances }
    }

    fn is_driving(&self) -> bool {
        self.seen.is_some_and(|seen| !matches!(seen.mode, Mode::Idle | Mode::Fault))
    }

    /// Returns `true` if the drive is silent and no other request is pending.
    fn is_silent(&self) -> bool {
        self.seen.is_some_and(|seen| seen.orders_sequence == self.latest.sequence) && self.queued == 0
    }

    fn watch_stop(&mut self) -> Result<(), AppError> {
        let pressed = self.peripherals.stop.is_low().map_err(|_| AppError::Pin)?;
        self.stop_unordered |= pressed && !self.latest.emergency_stop;
        self.stopping = pressed || self.stop_unordered || (self.stopping && self.queued > 0);
        if self.stopping {
            self.peripherals.enable.set_low().map_err(|_| AppError::Pin)?;
        }
        let stop = pressed || self.stop_unordered;
        if stop != self.latest.emergency_stop {
            let sequence = self.latest.sequence.wrapping_add(1);
            // If the queue is full, the next pass tries again; the enable pin is low already.
            if self.order(Orders { sequence, emergency_stop: stop, clear_fault: false, ..self.latest }).is_ok() {
                self.stop_unordered = false;
            }
        }
        Ok(())
    }

    /// Returns `true` if an attempt to drive is ordered that no block has reported yet: the
    /// amplifier must be on before the first tone. Other orders after a finished scan do not count.
    fn attempt_is_pending(&self) -> bool {
        let reported = |order: u32| self.seen.is_some_and(|seen| seen.orders_sequence.wrapping_sub(order) as i32 >= 0);
        self.latest.request != Request::Idle && self.attempted.is_some_and(|order| !reported(order))
    }

    fn set_enable(&mut self) -> Result<(), AppError> {
        let faulted = self.seen.is_some_and(|seen| seen.mode == Mode::Fault);
        let on = (self.queued > 0 || (self.attempt_is_pending() && !faulted)) && !self.stopping && !self.hardware.muted;
        self.peripherals.enable.set_state(on.into()).map_err(|_| AppError::Pin)
    }

    /// Orders the fault of a lost host, and withdraws the order once a frame of the host is
    /// received again.
    fn watch_host(&mut self) {
        let lost = self.host.detect_loss(self.block(), self.is_driving());
        if lost != self.latest.host_lost {
            let sequence = self.latest.sequence.wrapping_add(1);
            // If the queue is full, the next pass tries again.
            let _ = self.order(Orders { sequence, host_lost: lost, clear_fault: false, ..self.latest });
        }
    }

    /// Returns the number of the latest block that was reported; zero before the first.
    fn block(&self) -> u32 {
        self.seen.as_ref().map_or(0, |seen| seen.block)
    }

    /// Resets the board once the answer has left.
    fn reset_if_ordered(&mut self) -> Result<(), AppError> {
        if self.resetting && self.outbox.is_empty() {
            self.peripherals.link.flush().map_err(|_| AppError::Link)?;
            self.peripherals.watchdog.reset();
            // If the processor continues nevertheless, the link continues too.
            self.resetting = false;
        }
        Ok(())
    }

    fn order(&mut self, orders: Orders) -> Result<(), Refusal> {
        self.orders.enqueue(orders).map_err(|_| Refusal::Busy)?;
        if orders.attempt != self.latest.attempt {
            self.attempted = Some(orders.sequence);
        }
        self.latest = orders;
        Ok(())
    }

    fn report(&mut self) {
        let Some(seen) = self.seen.filter(|_| self.telemetry_every > 0 && !self.resetting) else { return };
        let passed = seen.block.wrapping_sub(self.last_telemetry);
        if passed < self.telemetry_every || !self.outbox.has_room() {
            return;
        }
        // Whole intervals keep the average rate, however rarely this is polled.
        self.last_telemetry = self.last_telemetry.wrapping_add(passed - passed % self.telemetry_every);
        self.telemetry_frames = self.telemetry_frames.wrapping_add(1);
        self.outbox.send(self.telemetry_frames, self.session.number(), Reply::Telemetry(seen));
    }
}
