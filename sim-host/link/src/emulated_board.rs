//! Complete board under QEMU, with the plant of a scene at its converters, and its serial port.
//!
//! The image (`link`, of the package `qemu-m4`) contains the block interrupt and the background
//! task, as on a board. Its UART is that of QEMU, connected to a socket. The board receives sent
//! bytes in the next block, and its answer is available after that block, so that a dialogue is
//! reproducible. Bytes take no time on the wire.

use std::io::{self, ErrorKind, Read, Write};
use std::os::unix::net::UnixStream;
use std::path::Path;
use std::time::Duration;

use firmware::board::lockstep::{Beat, Board, Closing, Opening, Played};
use firmware::seam::block::DriveBlock;
use firmware::seam::config::Config;
use hal_mock::block_clock::BlockClock;
use hal_mock::tracer::Tracer;

use crate::simulated_board::Rig;
use pil::PilError;
use pil::cpu_affinity::CpuAffinity;
use pil::emulator::Serial;
use pil::pipes::Pipes;
use scene::Driven;
use scene::settings;
use sim::processor::Lost;
use sim::run::breakable_plant;

/// Board that runs in QEMU, with a simulated plant.
pub struct EmulatedBoard {
    pipes: Pipes,
    config: Config,
    serial: UnixStream,
    clock: BlockClock<Rig>,
    block_s: f64,
    beat: Beat,
    played: Played,
    resets: u32,
    _core: CpuAffinity,
}

impl EmulatedBoard {
    /// Starts an [image](pil::link_image()) as the board of a scene, just powered on. The last
    /// `keep` blocks at the converters are recorded.
    pub fn start(image: &Path, scene: &Driven, keep: usize) -> Result<Self, PilError> {
        let core = CpuAffinity::pin();
        let (serial, at_board) = UnixStream::pair()?;
        serial.set_nonblocking(true)?;
        let mut pipes = Pipes::start(image, Serial::Socket(at_board))?;
        let config = settings::config(scene);
        let rig = Tracer::new(breakable_plant(scene), keep);
        let clock = BlockClock::new(rig, &powered(&mut pipes, &config)?);
        let block_s = f64::from(config.block_samples) / f64::from(config.sample_hz);
        let (beat, played) = Default::default();
        Ok(EmulatedBoard { pipes, config, serial, clock, block_s, beat, played, resets: 0, _core: core })
    }

    /// Returns the configuration of the board's controller.
    pub fn config(&self) -> &Config {
        &self.config
    }

    /// Returns the plant with its injected faults and recorded blocks.
    pub fn rig(&self) -> &Rig {
        &self.clock.analog
    }

    /// Returns the time since power-on.
    pub fn now(&self) -> Duration {
        Duration::from_secs_f64(self.clock.blocks() as f64 * self.block_s)
    }

    /// Plays one block of the board and its plant.
    pub fn block(&mut self) -> Result<(), Lost> {
        let EmulatedBoard { pipes, clock, beat, played, .. } = self;
        clock.tick(|sense, drive| {
            beat.sense.clone_from(sense);
            pipes.ask(beat, played)?;
            drive.clone_from(&played.drive);
            Ok(())
        })?;
        if self.played.board.resets {
            self.restart()?;
        }
        Ok(())
    }

    /// Returns the state of its pins and its watchdog.
    pub fn pins(&self) -> &Board {
        &self.played.board
    }

    /// Returns the number of resets of the board by itself.
    pub fn resets(&self) -> u32 {
        self.resets
    }

    /// Returns the maximum stack depth of the board: until its controller was built, and in the
    /// blocks since, with block interrupt and background task.
    pub fn stack(&mut self) -> Result<Closing, Lost> {
        self.pipes.close()
    }

    /// Presses or releases the emergency stop.
    pub fn press_stop(&mut self, pressed: bool) {
        self.beat.pins.stop = pressed;
    }

    /// Waits for a board that has reset itself, and configures it again.
    fn restart(&mut self) -> Result<(), Lost> {
        self.resets += 1;
        self.beat.pins.sent = 0;
        let silence = powered(&mut self.pipes, &self.config).map_err(|error| Lost(error.to_string()))?;
        self.clock.restart(&silence);
        Ok(())
    }
}

/// Configures a board that was just powered on or reset. Returns the drive block that it plays
/// until it has answered.
fn powered(pipes: &mut Pipes, config: &Config) -> Result<DriveBlock, PilError> {
    let mut opening = Opening::default();
    pipes.ask(config, &mut opening)?;
    opening.built.map_err(|reason| PilError::Config(reason.as_str().to_owned()))?;
    Ok(opening.silence)
}

/// Bytes from the board. A read never waits, and returns zero bytes if none have arrived.
impl Read for EmulatedBoard {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        match self.serial.read(into) {
            Err(error) if error.kind() == ErrorKind::WouldBlock => Ok(0),
            read => read,
        }
    }
}

/// Bytes that the board receives in the next block.
impl Write for EmulatedBoard {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let count = self.serial.write(bytes)?;
        self.beat.pins.sent = self.beat.pins.sent.wrapping_add(count as u32);
        Ok(count)
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}
