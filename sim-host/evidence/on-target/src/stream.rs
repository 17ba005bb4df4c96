//! A power-up of the controller on the transducer of the bench: the same blocks on the host, where
//! the build script plays them, and on the target.
//!
//! Transducer and controller use only additions and multiplications of f32. If any bit differs
//! anywhere, the hash differs.

use firmware::controller::Controller;
use firmware::seam::block::{Codes, DriveBlock, Orders, Request, SenseBlock};
use firmware::seam::config::TrackingMode;
use firmware::seam::error::Error;
use firmware::seam::mode::Mode;
use firmware::seam::telemetry::Telemetry;
use qemu_m4::bench::{SAMPLES, Transducer, config};

/// Number of blocks of silence before the order to run.
pub const IDLE_BLOCKS: u32 = 20;
/// Number of blocks in all: 96 ms, of which the last 35 ms are bursts with the tracker locked.
pub const BLOCKS: u32 = 3000;

/// Result of playing a stream.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Played {
    /// Hash of every code played and every code sensed (FNV-1a, 64 bits).
    pub codes: u64,
    /// Hash of every tuning word reported.
    pub words: u64,
    /// Number of blocks under drive in mode `Run`.
    pub driven: u32,
}

/// Plays the stream. `each` receives the number of each block and must call its argument once.
pub fn play(mut each: impl FnMut(u32, &mut dyn FnMut())) -> Result<Played, Error> {
    let mut controller = Controller::build(&config(TrackingMode::Observer, 1, SAMPLES))?;
    let mut playing = [controller.silence(), controller.silence()];
    let (mut transducer, mut sense) = (Transducer::new(), SenseBlock::default());
    let mut played = Played { codes: OFFSET, words: OFFSET, driven: 0 };
    for block in 0..BLOCKS {
        let drive: &mut DriveBlock = &mut playing[block as usize % 2];
        transducer.exchange(drive, &mut sense);
        played.codes = [&drive.lanes[0], &sense.i].into_iter().fold(played.codes, hash_codes);
        let orders = orders(block);
        let mut report = Telemetry::default();
        each(block, &mut || controller.process_into(&orders, &sense, drive, &mut report));
        played.words = hash(played.words, &report.tuning_word.to_le_bytes());
        played.driven += u32::from(report.mode == Mode::Run && report.drive.0 * report.envelope > 0.0);
    }
    Ok(played)
}

fn orders(block: u32) -> Orders {
    let request = if block < IDLE_BLOCKS { Request::Idle } else { Request::Run };
    Orders { sequence: 1, attempt: 1, request, ..Orders::default() }
}

const OFFSET: u64 = 0xcbf2_9ce4_8422_2325;
const PRIME: u64 = 0x0100_0000_01b3;

fn hash(before: u64, bytes: &[u8]) -> u64 {
    bytes.iter().fold(before, |hash, &byte| (hash ^ u64::from(byte)).wrapping_mul(PRIME))
}

fn hash_codes(before: u64, codes: &Codes) -> u64 {
    codes.iter().fold(before, |before, code| hash(before, &code.to_le_bytes()))
}
