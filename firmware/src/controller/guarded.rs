//! What the guard has to know of a block, and what its faults are called.

use crate::controller::chain::{Chain, Measured};
use crate::controller::stages::Stages;
use crate::guard::{Driven, Stage};
use crate::seam::block::Amplitude;
use crate::seam::fault::Fault;
use crate::seam::mode::Mode;
use crate::sense::demod::Suspect;

impl Chain {
    /// What the guard says is wrong with this block, if anything.
    pub(super) fn inspect(&mut self, stages: &Stages, measured: &Measured, suspect: Suspect) -> Option<Fault> {
        let Measured { sense, sensed, played, .. } = *measured;
        let volts = played.audible.filter(|_| played.flat).map(|part| part * played.volts * played.envelope.abs());
        let electrical = self.guard.inspect(&self.convert, sense, sensed, volts, suspect);
        let watches = self.guard.watches(sense, &self.belt);
        let found = if watches { electrical.or(self.watch(stages, measured, volts)) } else { electrical }?;
        // Nothing but a short takes more current than the limit from the tone of the self-test, or lets the voltage collapse under it.
        let collapses = found == Fault::SensorImplausible && stages.self_test.is_short(sensed, played.volts);
        let short = self.supervisor.mode() == Mode::SelfTest && (found == Fault::OverCurrent || collapses);
        Some(if short { Fault::LoadShorted } else { found })
    }

    /// What sensors beside voltage and current say, and limits of their own.
    #[inline(never)]
    fn watch(&mut self, stages: &Stages, measured: &Measured, volts: Option<f32>) -> Option<Fault> {
        let Measured { orders, sense, sensed, played, .. } = *measured;
        let mode = self.supervisor.mode();
        let (gate, amplitude) = stages.follow.ordered(self, orders);
        let (Amplitude::Volts(asked) | Amplitude::MotionalCurrent(asked)) = stages.follow.asked(amplitude);
        let now = self.generator.now(self.block);
        let driven = Driven {
            volts,
            stage: Stage::from(mode),
            requested: mode == Mode::Lock || mode == Mode::Run && self.generator.burst.is_requested(gate, now),
            full: played.is_full(),
            asked,
        };
        self.guard.watch(sense, sensed, &self.belt, &driven)
    }
}
