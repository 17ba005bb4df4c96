//! What the controller of an image has seen and answered, block by block, and its replay on the host.
//!
//! The controller decides by orders, trims and sense blocks alone. A host that runs the same controller on a recording of these returns the same
//! codes, bit for bit, or the image has computed something else than the source says.

use firmware::controller::Controller;
use firmware::seam::block::{DriveBlock, LATENCY_BLOCKS, Orders, SenseBlock};
use firmware::seam::config::{Config, LaneTrims};
use firmware::seam::telemetry::Telemetry;
use sim::processor::{Load, Lost, Processor};

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
    /// Instructions and cycles of the interrupt that made the call.
    pub taken: (u32, u32),
}

/// A replay of the calls that an image has made of its controller.
pub struct Replay {
    controller: Controller,
    calls: std::vec::IntoIter<Call>,
    block: u64,
    taken: (u32, u32),
    load: Load,
}

impl Replay {
    /// A controller with the image's configuration that has seen the first `before` calls; the others follow by [`process`](Processor::process). `load` is
    /// what the image's processor was busy with.
    pub fn new(config: &Config, calls: Vec<Call>, before: usize, load: Load) -> Result<Self, Lost> {
        let controller = Controller::build(config).map_err(|error| Lost(error.to_string()))?;
        let mut drive = controller.silence();
        let mut replay = Replay { controller, calls: calls.into_iter(), block: 0, taken: (0, 0), load };
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
        self.taken = call.taken;
        if *drive != call.drive {
            return Err(Lost(format!("in block {block} the image computed other codes than the host does from the same input")));
        }
        Ok((call.sense, telemetry))
    }
}

impl Processor for Replay {
    fn silence(&self) -> DriveBlock {
        self.controller.silence()
    }

    /// The orders are those of the recording. The sense codes have to be the recorded ones: the plant of a replay is that of the recording.
    fn process(&mut self, _orders: &Orders, sense: &SenseBlock, drive: &mut DriveBlock) -> Result<Telemetry, Lost> {
        let (seen, telemetry) = self.next(drive)?;
        if (&seen.v, &seen.i) != (&sense.v, &sense.i) {
            return Err(Lost(format!("in block {} the plant gives other codes than the board has sampled", self.block - 1)));
        }
        Ok(telemetry)
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

/// The first sample at which the codes that left the DAC differ from those that the controller returned; none where all are the same.
///
/// A block plays [`LATENCY_BLOCKS`] blocks after its sense block.
pub fn first_difference(calls: &[Call], played: &[u16]) -> Option<usize> {
    let returned = calls.iter().flat_map(|call| call.drive.lanes.first().map_or(&[][..], |lane| lane.as_slice()));
    let samples = calls.first().and_then(|call| call.drive.lanes.first()).map_or(0, |lane| lane.len());
    let from = LATENCY_BLOCKS * samples;
    let both = returned.zip(played.get(from..).unwrap_or(&[]));
    both.enumerate().find(|(_, (returned, played))| returned != played).map(|(n, _)| from + n)
}
