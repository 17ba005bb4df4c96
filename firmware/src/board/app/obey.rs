//! Execution of a command by the background task: its answer, and the orders that follow from it.

use embedded_hal::digital::{InputPin, OutputPin};
use embedded_io::{Read, ReadReady, Write, WriteReady};
use embedded_storage::nor_flash::NorFlash;

use super::{App, AppError, Watchdog};
use crate::board::command::{Command, Identity, Reply};
use crate::board::link::{self, Frame, FrameError, NO_SESSION};
use crate::seam::block::Orders;
use crate::seam::refusal::Refusal;

impl<'a, L, E, S, W, F> App<'a, L, E, S, W, F>
where
    L: Read + ReadReady + Write + WriteReady,
    E: OutputPin,
    S: InputPin,
    W: Watchdog,
    F: NorFlash,
{
    /// Obeys the commands that the link has received, while there is room for answers.
    pub(super) fn obey_link(&mut self) -> Result<(), AppError> {
        // One byte at a time: a frame that ends in this byte must find room for its reply.
        while !self.resetting && self.outbox.has_room() && self.peripherals.link.read_ready().map_err(|_| AppError::Link)? {
            let mut byte = [0];
            if self.peripherals.link.read(&mut byte).map_err(|_| AppError::Link)? == 0 {
                break;
            }
            if let Some(frame) = self.receiver.take::<Command>(byte[0]) {
                let nak = |refusal| Some(Reply::Nak(refusal));
                let (sequence, session, reply) = match frame {
                    Ok(Frame { sequence, body: Command::Identify(nonce), .. }) => (sequence, nonce, Some(self.identify(nonce))),
                    Ok(frame) if self.session.admit(frame.session) => (frame.sequence, frame.session, self.obey(&frame)),
                    Err(FrameError::Unknown(sequence, session)) if self.session.admit(session) => {
                        (sequence, session, nak(Refusal::Unknown))
                    }
                    Ok(Frame { sequence, session, .. }) | Err(FrameError::Unknown(sequence, session)) => {
                        (sequence, session, nak(Refusal::Session))
                    }
                    Err(FrameError::Version(sequence)) => (sequence, NO_SESSION, nak(Refusal::Version)),
                    Err(FrameError::TooLong | FrameError::Damaged) => (0, NO_SESSION, nak(Refusal::Damaged)),
                };
                if let Some(reply) = reply {
                    self.outbox.send(sequence, session, reply);
                }
            }
        }
        Ok(())
    }

    /// Answers with the identity of the board, in a new session. This is not a sign of life of the
    /// host, because the frame may be an old one.
    fn identify(&mut self, nonce: u32) -> Reply {
        let session = self.session.begin(nonce, self.block());
        Reply::Identity(Identity { protocol: link::VERSION, firmware: firmware_version(), converters: self.converters, session })
    }

    /// Obeys a command of the present session; returns `None` if its answer comes later.
    fn obey(&mut self, frame: &Frame<Command>) -> Option<Reply> {
        self.host.update(self.block());
        self.host_obeyed = true;
        Some(match frame.body {
            Command::TelemetryEvery(blocks) => {
                self.telemetry_every = blocks;
                // The first frame is due at once.
                self.last_telemetry = self.block().wrapping_sub(blocks);
                Reply::Ack
            }
            Command::Resonances => Reply::Resonances(self.resonances()),
            Command::Settings(verb) => {
                let silent = self.is_silent();
                self.settings_store.obey(verb, silent, &mut self.peripherals.settings, self.built_in)
            }
            Command::Status => Reply::Status(self.seen),
            Command::Update(verb) => self.update(&verb),
            Command::Hardware => Reply::Hardware(self.hardware),
            // Else the amplifier would wake in the middle of a drive.
            Command::Mute(false) if !self.is_silent() => Reply::Nak(Refusal::Driving),
            Command::Mute(muted) => {
                self.hardware.muted = muted;
                Reply::Ack
            }
            Command::Faults(later) => Reply::Faults(self.faults.report(later, self.peripherals.start)),
            Command::Reset if !self.is_silent() => Reply::Nak(Refusal::Driving),
            Command::Reset => {
                self.resetting = true;
                Reply::Ack
            }
            Command::Capture(verb) => return self.captures.obey(frame.sequence, frame.session, verb),
            Command::Friction(Some(_)) if !self.switches_friction => Reply::Nak(Refusal::NotConfigured),
            Command::Occupant(Some(_)) if !self.restrains => Reply::Nak(Refusal::NotConfigured),
            Command::Run | Command::Scan | Command::Calibrate if self.limits_unsure => Reply::Nak(Refusal::LimitsUnsure),
            // The controller would refuse this too, with fault 47.
            Command::Run | Command::Scan | Command::Calibrate if self.belt_unscaled => Reply::Nak(Refusal::NoBeltScale),
            command => self.obey_order(&command).map_or_else(Reply::Nak, |()| Reply::Ack),
        })
    }

    /// Obeys a command that changes the orders or the host timeout.
    fn obey_order(&mut self, command: &Command) -> Result<(), Refusal> {
        let orders = command.applied_to(&self.latest)?;
        if let Command::Patience(seconds) = *command {
            self.host.set(seconds);
        }
        // A host that orders something is not lost.
        orders.map_or(Ok(()), |orders| self.order(Orders { host_lost: false, ..orders }))
    }

    /// Sends the answer of the recorder, once there is room.
    pub(super) fn answer_capture(&mut self) {
        if self.outbox.has_room()
            && let Some((sequence, session, reply)) = self.captures.answer()
        {
            self.outbox.send(sequence, session, reply);
        }
    }
}

/// Returns the version of the package as numbers.
fn firmware_version() -> [u8; 3] {
    [env!("CARGO_PKG_VERSION_MAJOR"), env!("CARGO_PKG_VERSION_MINOR"), env!("CARGO_PKG_VERSION_PATCH")]
        .map(|part| part.parse().unwrap_or(0))
}
