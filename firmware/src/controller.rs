//! The controller: built from a [`Config`](crate::seam::config::Config), then called once a block.
//!
//! The codes returned for sense block `k` play as block `k + 2` ([`LATENCY_BLOCKS`]). After `build`
//! no call can fail: a failure is reported as a numbered fault in the telemetry, with a muted
//! drive. The block that enters a fault also drops the queued blocks ([`DriveBlock::drops_queue`]).

mod build;
mod chain;
mod guarded;
mod lanes;
mod report;
mod stages;

use crate::controller::chain::{Chain, Measured};
use crate::controller::stages::Stages;
use crate::generate::phasing::check_calibration;
use crate::generate::signal_generator::Played;
use crate::generate::step::Plan;
use crate::seam::block::{DriveBlock, LATENCY_BLOCKS, Orders, SenseBlock};
use crate::seam::config::LaneTrims;
use crate::seam::mode::Mode;
use crate::seam::telemetry::Telemetry;
use crate::sense::demod::demodulate;

/// Controller of a board; called once a block.
#[derive(Clone)]
#[repr(C)]
pub struct Controller {
    /// Drives that are queued or playing; `played[slot]` was played when the codes of a block
    /// arrive.
    played: [Played; LATENCY_BLOCKS],
    chain: Chain,
    stages: Stages,
}

impl Controller {
    /// Returns a block of silence, to play until the first call has returned.
    pub fn silence(&self) -> DriveBlock {
        self.chain.generator.silence()
    }

    /// Processes one block: takes orders and the converters' codes, writes the codes to play two
    /// blocks later, and returns the telemetry.
    pub fn process(&mut self, orders: &Orders, sense: &SenseBlock, drive: &mut DriveBlock) -> Telemetry {
        let mut report = Telemetry::default();
        self.process_into(orders, sense, drive, &mut report);
        report
    }

    /// Does the same as [`process`](Self::process), but overwrites an earlier report.
    pub fn process_into(&mut self, orders: &Orders, sense: &SenseBlock, drive: &mut DriveBlock, report: &mut Telemetry) {
        let Controller { played, chain, stages } = self;
        let slot = (chain.block % LATENCY_BLOCKS as u64) as usize;
        let (mut sensed, suspect) = demodulate(&chain.convert, sense, &played[slot].tone);
        // A scan has no time for the other lanes, and does not need them.
        let scans = matches!(chain.supervisor.mode(), Mode::Scan | Mode::Clamped);
        if chain.lanes.are_several() && !(scans && chain.lanes.are_at_home()) {
            chain.listen_to_lanes(orders, &played[slot], &mut sensed);
        }
        let motional = chain.track.tracker.motional_current(&sensed, played[slot].relative);

        chain.belt.update(sense.slow.belt);
        let restrained = chain.restrained(orders, sense);
        let orders = restrained.as_ref().unwrap_or(orders);
        let measured = Measured { orders, sense, sensed: &sensed, motional, played: &played[slot] };
        let found = chain.inspect(stages, &measured, suspect);
        if chain.supervisor.judge(orders, found) {
            chain.begin(orders.request);
            stages.begin(chain);
        }
        let step = stages.step(chain, &measured);
        let plan = Plan::of(step, |offset_hz| chain.generator.sweep.hold.retune(offset_hz));
        chain.supervisor.advance(orders, plan.progress);

        let modes = (chain.supervisor.mode(), chain.track.tracker.observes());
        chain.generator.play(orders, &plan, modes, chain.block, drive, &mut played[slot]);
        drive.drops_queue = chain.supervisor.take_raised();
        if drive.drops_queue {
            // The new blocks are silent already; the ones returned before are still queued.
            played.iter_mut().enumerate().filter(|(other, _)| *other != slot).for_each(|(_, queued)| queued.drop_rest());
        }
        stages.follow.work(chain, &plan, &played[slot]);
        chain.block += 1;
        self.report(orders, &plan, slot, (&sensed, motional), report);
    }

    /// Returns the active trims, from a calibration or from the configuration.
    pub(crate) fn calibration(&self) -> &LaneTrims {
        self.chain.generator.phasing.calibration()
    }

    /// Returns the number of complete calibrations. If it has grown, there are new trims to store.
    pub(crate) fn calibrations(&self) -> u32 {
        self.stages.calibrate.completed()
    }

    /// Sets the trims of the lanes, and returns `true` if they were accepted.
    ///
    /// Trims are accepted only in silence, because the drive would jump; only within the range of
    /// trims; and only if a scan with them stays within the voltage limit.
    #[inline(never)]
    pub fn trim(&mut self, trims: LaneTrims) -> bool {
        let silent = matches!(self.chain.supervisor.mode(), Mode::Idle | Mode::Fault);
        if !silent || check_calibration(&trims).is_err() {
            return false;
        }
        let generator = &mut self.chain.generator;
        self.stages.calibrate.abandon(&mut generator.phasing);
        let before = generator.phasing.trim(trims);
        let fits = generator.set_loudest() >= generator.amplitude.start_volts();
        if !fits {
            generator.phasing.trim(before);
            generator.set_loudest();
        }
        fits
    }
}

#[cfg(test)]
mod tests;
