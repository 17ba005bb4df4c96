//! The signal chain that all stages share, and the measured block.

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

/// Signal chain. The fields of every block come first, in this order, within reach of one
/// instruction.
#[derive(Clone, Debug)]
#[repr(C)]
pub(crate) struct Chain {
    /// Number of the present block.
    pub(crate) block: u64,
    pub(crate) supervisor: Supervisor,
    pub(crate) track: TrackedTransducer,
    pub(crate) generator: SignalGenerator,
    pub(crate) convert: Convert,
    pub(crate) guard: Guard,
    pub(crate) belt: Belt,
    pub(crate) restraint: Option<Restraint>,
    /// `true` if the present attempt is a calibration.
    pub(crate) calibrates: bool,
    pub(crate) lanes: Lanes,
    pub(crate) continuity: Continuity,
}

impl Chain {
    /// Resets the chain for a new attempt.
    #[inline(never)]
    pub(super) fn begin(&mut self, request: Request) {
        // A run after a calibration keeps the calibration's start of the schedule.
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

    /// Returns the orders with the gate set by the belt restraint; `None` without a restraint.
    #[inline]
    pub(super) fn restrained(&mut self, orders: &Orders, sense: &SenseBlock) -> Option<Orders> {
        let restraint = self.restraint.as_mut()?;
        let fresh = self.belt.is_expected().then(|| self.belt.fresh_counts());
        Some(restraint.decide(orders, sense.slow.force, fresh, self.supervisor.mode()))
    }
}

/// Block that has just been measured.
#[derive(Clone, Copy)]
pub(crate) struct Measured<'a> {
    /// Orders of the block.
    pub(crate) orders: &'a Orders,
    /// Codes and readings.
    pub(crate) sense: &'a SenseBlock,
    /// Voltage and current phasors.
    pub(crate) sensed: &'a Sensed,
    /// Motional current, A peak.
    pub(crate) motional: Phasor,
    /// Drive played in the block.
    pub(crate) played: &'a Played,
}
