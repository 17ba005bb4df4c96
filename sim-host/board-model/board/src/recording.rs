//! What the controller of an image has seen and answered, block by block, and its replay on the host.
//!
//! The controller decides by orders, trims and sense blocks alone. A host that runs the same controller on a recording of these returns the same
//! codes, bit for bit, or the image has computed something else than the source says.

use firmware::controller::Controller;
use firmware::seam::block::{DriveBlock, LATENCY_BLOCKS, MAX_LANES, Orders, SenseBlock};
use firmware::seam::config::{Config, LaneTrims};
use firmware::seam::telemetry::Telemetry;
use nucleo_g474re::config::SILENCE;
use sim::processor::{Load, Lost, Processor};

/// Samples of a block within which the board's multiplexer has switched.
const SWITCHING: usize = 4;

/// One call of the controller in the image.
#[derive(Clone, Debug, PartialEq)]
pub struct Call {
    /// Orders in force.
    pub orders: Orders,
    /// Trims that were taken over before the call.
    pub trims: Option<LaneTrims>,
    /// What the converters and the slow sensors gave.
    pub sense: SenseBlock,
    /// What the controller returned, to play two blocks later.
    pub drive: DriveBlock,
    /// Where the controller dropped the queue: the sample of the block that was playing from which silence left the DACs.
    pub silent_from: Option<usize>,
    /// Instructions and cycles of the interrupt that made the call.
    pub taken: (u32, u32),
}

/// A replay of the calls that an image has made of its controller.
pub struct Replay {
    controller: Controller,
    calls: std::vec::IntoIter<Call>,
    block: u64,
    taken: (u32, u32),
    silent_from: Option<usize>,
    load: Load,
    /// The block in which the amplifier was off under a code for the first time.
    cut: Option<u64>,
    /// The controller has reported a fault.
    faulted: bool,
    /// The lanes that the last answers order to be measured: first those of the block before the measured one, and of the measured one.
    listens: [u8; LATENCY_BLOCKS + 2],
}

impl Replay {
    /// A controller with the image's configuration that has seen the first `before` calls; the others follow by [`process`](Processor::process). `load` is
    /// what the image's processor was busy with, and `cut` the block in which the amplifier was off under a code for the first time: that must be by a
    /// fault. From there on the plant of a replay, whose amplifier plays to the end, need not give what the board has sampled.
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

    /// One call; fails where the host returns other codes than the image.
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
                "the amplifier was off in block {block}, which played, and no fault says why: a trip, or an enable that came too late"
            )));
        }
        if *drive != call.drive {
            return Err(Lost(format!("in block {block} the image computed other codes than the host does from the same input")));
        }
        Ok((call.sense, telemetry))
    }
}

impl Replay {
    /// Whether the amplifier was off in the block that was processed last, or before.
    fn is_cut(&self) -> bool {
        self.cut.is_some_and(|cut| self.block > cut)
    }
}

impl Processor for Replay {
    fn silence(&self) -> DriveBlock {
        self.controller.silence()
    }

    /// The orders are those of the recording. The sense codes have to be the recorded ones: the plant of a replay is that of the recording.
    fn process(&mut self, _orders: &Orders, sense: &SenseBlock, drive: &mut DriveBlock) -> Result<Telemetry, Lost> {
        let (seen, telemetry) = self.next(drive)?;
        // The plant of a replay listens to another lane from the first sample of a block on, and the board from its interrupt on.
        let first = if self.listens[0] == self.listens[1] { 0 } else { SWITCHING };
        let differs = |seen: &[u16], sense: &[u16]| seen.get(first..) != sense.get(first..);
        if (differs(&seen.v, &sense.v) || differs(&seen.i, &sense.i)) && !self.is_cut() {
            return Err(Lost(format!("in block {} the plant gives other codes than the board has sampled", self.block - 1)));
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

/// Notes from which sample on each queue that was dropped was silent. Returns the first sample at which the codes that left the DACs differ from those that
/// the controller returned; none where all are the same.
///
/// A block plays [`LATENCY_BLOCKS`] blocks after its sense block. One that was dropped plays as it was returned, and from some sample on silence.
pub fn compare(calls: &mut [Call], played: &[[u16; MAX_LANES]]) -> Option<usize> {
    let samples = calls.first()?.drive.lanes.first()?.len();
    for block in LATENCY_BLOCKS..=calls.len() {
        // The answer of the call between had dropped it, or not.
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
