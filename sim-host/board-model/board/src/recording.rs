//! Recording of the calls of an image's controller, block by block, and its replay on the host.
//!
//! The controller depends only on commands, trims and sense blocks. The same controller on the host
//! must return the same codes for a recording of these, bit for bit; otherwise the image computes
//! something else than the source.

use firmware::controller::Controller;
use firmware::seam::block::{DriveBlock, LATENCY_BLOCKS, MAX_LANES, Orders, SenseBlock};
use firmware::seam::config::{Config, LaneTrims};
use firmware::seam::telemetry::Telemetry;
use nucleo_g474re::config::SILENCE;
use sim::processor::{Load, Lost, Processor};

/// Number of samples at the start of a block in which the board's multiplexer switches.
const SWITCH_SAMPLES: usize = 4;

/// Call of the controller in the image.
#[derive(Clone, Debug, PartialEq)]
pub struct Call {
    /// Commands in force.
    pub orders: Orders,
    /// Trims that were applied before the call.
    pub trims: Option<LaneTrims>,
    /// Samples of the converters and the slow sensors.
    pub sense: SenseBlock,
    /// Codes that the controller returned, to play two blocks later.
    pub drive: DriveBlock,
    /// Sample of the playing block from which the DACs are silent, if the controller dropped the
    /// queue.
    pub silent_from: Option<usize>,
    /// Instructions and cycles of the interrupt of the call.
    pub taken: (u32, u32),
}

/// Replay of the recorded calls of an image's controller.
pub struct Replay {
    controller: Controller,
    calls: std::vec::IntoIter<Call>,
    block: u64,
    taken: (u32, u32),
    silent_from: Option<usize>,
    load: Load,
    /// First block in which the amplifier was off although a code played.
    cut: Option<u64>,
    /// `true` after the controller has reported a fault.
    faulted: bool,
    /// Lanes that the last answers select for measurement, beginning with the block before the
    /// measured one.
    listens: [u8; LATENCY_BLOCKS + 2],
}

impl Replay {
    /// Creates a controller with the image's configuration and replays the first `before` calls;
    /// the others follow by [`process`](Processor::process).
    ///
    /// `load` is the use of the image's processor. `cut` is the first block in which the amplifier
    /// was off although a code played, which requires a fault. From there on the plant of the
    /// replay may differ from the board's samples, because its amplifier plays to the end.
    pub fn new(config: &Config, calls: Vec<Call>, before: usize, load: Load, cut: Option<u64>) -> Result<Self, Lost> {
        let controller = Controller::build(config).map_err(|error| Lost(error.to_string()))?;
        let mut drive = controller.silence();
        let (calls, taken) = (calls.into_iter(), (0, 0));
        let mut replay = Replay {
            controller,
            calls,
            block: 0,
            taken,
            silent_from: None,
            load,
            cut,
            faulted: false,
            listens: Default::default(),
        };
        for _ in 0..before {
            replay.next(&mut drive)?;
        }
        Ok(replay)
    }

    /// Replays one call. Fails if the host returns other codes than the image.
    fn next(&mut self, drive: &mut DriveBlock) -> Result<(SenseBlock, Telemetry), Lost> {
        let block = self.block;
        self.block += 1;
        let call = self.calls.next().ok_or_else(|| Lost(format!("the recording ends before block {block}")))?;
        if let Some(trims) = call.trims {
            self.controller.trim(trims);
        }
        let telemetry = self.controller.process(&call.orders, &call.sense, drive);
        (self.taken, self.silent_from) = (call.taken, call.silent_from);
        self.listens.rotate_left(1);
        self.listens[LATENCY_BLOCKS + 1] = call.drive.listen;
        self.faulted |= telemetry.fault.is_some();
        if self.is_cut() && !self.faulted {
            return Err(Lost(format!(
                "the amplifier was off in block {block}, which played, without a fault: a trip, or a late enable"
            )));
        }
        if *drive != call.drive {
            return Err(Lost(format!("in block {block} the image computed other codes than the host from the same input")));
        }
        Ok((call.sense, telemetry))
    }
}

impl Replay {
    /// Returns `true` if the amplifier was off in the last processed block, or earlier.
    fn is_cut(&self) -> bool {
        self.cut.is_some_and(|cut| self.block > cut)
    }
}

impl Processor for Replay {
    fn silence(&self) -> DriveBlock {
        self.controller.silence()
    }

    /// Replays the next recorded call; `orders` are ignored. The sense codes must equal the
    /// recorded ones, because the plant is the same.
    fn process(&mut self, _orders: &Orders, sense: &SenseBlock, drive: &mut DriveBlock) -> Result<Telemetry, Lost> {
        let (seen, telemetry) = self.next(drive)?;
        // The plant of a replay switches lanes at the first sample of a block, the board in its
        // interrupt.
        let first = if self.listens[0] == self.listens[1] { 0 } else { SWITCH_SAMPLES };
        let differs = |seen: &[u16], sense: &[u16]| seen.get(first..) != sense.get(first..);
        if (differs(&seen.v, &sense.v) || differs(&seen.i, &sense.i)) && !self.is_cut() {
            return Err(Lost(format!("in block {} the plant returns other codes than the board sampled", self.block - 1)));
        }
        Ok(telemetry)
    }

    fn silent_from(&self) -> Option<usize> {
        self.silent_from
    }

    fn instructions(&self) -> Option<u32> {
        Some(self.taken.0)
    }

    fn load(&self) -> Option<Load> {
        Some(self.load.clone())
    }

    fn cycles(&self) -> Option<u32> {
        Some(self.taken.1)
    }
}

/// Compares the codes at the DACs with those of the controller, and returns the first sample at
/// which they differ. Records the first silent sample of each dropped queue.
///
/// A block plays [`LATENCY_BLOCKS`] blocks after its sense block. A dropped block plays as it was
/// returned up to some sample, and then silence.
pub fn compare(calls: &mut [Call], played: &[[u16; MAX_LANES]]) -> Option<usize> {
    let samples = calls.first()?.drive.lanes.first()?.len();
    for block in LATENCY_BLOCKS..=calls.len() {
        // The answer of the call between them may have dropped it.
        let answered = &calls[block - LATENCY_BLOCKS].drive.lanes;
        let dropped = calls[block - 1].drive.drops_queue;
        let first = block * samples;
        let Some(played) = played.get(first..first + samples) else { break };
        let differs = |n: usize| answered.iter().enumerate().any(|(lane, codes)| codes[n] != played[n][lane]);
        let different = (0..samples).find(|&n| differs(n));
        if dropped {
            let from = different.unwrap_or(samples);
            let silent = |codes: &[u16; MAX_LANES]| codes[..answered.len()].iter().all(|&code| code == SILENCE);
            if let Some(n) = (from..samples).find(|&n| !silent(&played[n])) {
                return Some(first + n);
            }
            calls[block - 1].silent_from = Some(from);
        } else if let Some(n) = different {
            return Some(first + n);
        }
    }
    None
}
