//! The signal chain, which all stages share, and the block that they look at.

use crate::act::restraint::Restraint;
use crate::find::lanes::Lanes;
use crate::generate::signal_generator::{Played, SignalGenerator};
use crate::guard::Guard;
use crate::guard::continuity::Continuity;
use crate::guard::supervisor::Supervisor;
use crate::seam::block::{Orders, Request, SenseBlock};
use crate::seam::phasor::Phasor;
use crate::sense::belt::Belt;
use crate::sense::convert::Convert;
use crate::sense::demod::Sensed;
use crate::track::tracked_transducer::TrackedTransducer;

/// The signal chain. What every block reads stands first and in this order, within reach of one instruction.
#[derive(Clone, Debug)]
#[repr(C)]
pub(crate) struct Chain {
    /// The number of this block.
    pub(crate) block: u64,
    pub(crate) supervisor: Supervisor,
    pub(crate) track: TrackedTransducer,
    pub(crate) generator: SignalGenerator,
    pub(crate) convert: Convert,
    pub(crate) guard: Guard,
    pub(crate) belt: Belt,
    pub(crate) restraint: Option<Restraint>,
    /// The attempt is a calibration.
    pub(crate) calibrates: bool,
    pub(crate) lanes: Lanes,
    pub(crate) continuity: Continuity,
}

impl Chain {
    /// A new attempt begins: forgets what an earlier one has found.
    #[inline(never)]
    pub(super) fn begin(&mut self, request: Request) {
        // A run that follows a calibration counts from there.
        if !self.calibrates {
            self.generator.begin_schedule(self.block);
        }
        self.calibrates = request == Request::Calibrate;
        self.guard.begin();
        self.continuity.restart();
        self.lanes.begin();
        self.track.restart();
        self.generator.restart();
        self.restraint.iter_mut().for_each(Restraint::restart);
    }

    /// The orders with the gate where a crash, or none, wants it; `None` where no belt is served.
    #[inline]
    pub(super) fn restrained(&mut self, orders: &Orders, sense: &SenseBlock) -> Option<Orders> {
        let restraint = self.restraint.as_mut()?;
        let fresh = self.belt.is_expected().then(|| self.belt.fresh_counts());
        Some(restraint.decide(orders, sense.slow.force, fresh, self.supervisor.mode()))
    }
}

/// The block that has just been measured.
#[derive(Clone, Copy)]
pub(crate) struct Measured<'a> {
    /// The orders that it obeys.
    pub(crate) orders: &'a Orders,
    /// Codes and readings.
    pub(crate) sense: &'a SenseBlock,
    /// Voltage and current.
    pub(crate) sensed: &'a Sensed,
    /// Motional current, A peak.
    pub(crate) motional: Phasor,
    /// What was played in it.
    pub(crate) played: &'a Played,
}
