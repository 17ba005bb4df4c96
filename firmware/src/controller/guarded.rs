//! What the guard has to know of a block, and what its faults are called.

use crate::controller::chain::{Chain, Measured};
use crate::controller::stages::Stages;
use crate::guard::continuity::{Load, Steady};
use crate::guard::{Driven, Stage};
use crate::seam::block::{Amplitude, SenseBlock};
use crate::seam::fault::Fault;
use crate::seam::mode::Mode;
use crate::sense::demod::{Sensed, Suspect};

impl Chain {
    /// What the guard says is wrong with this block, if anything.
    pub(super) fn inspect(&mut self, stages: &Stages, measured: &Measured, suspect: Suspect) -> Option<Fault> {
        let Measured { sense, sensed, played, .. } = *measured;
        let volts = played.audible.filter(|_| played.flat).map(|part| part * played.volts * played.envelope.abs());
        let electrical = self.guard.inspect(&self.convert, sense, sensed, volts, suspect);
        let electrical = electrical.or_else(|| match volts {
            Some(volts) => self.breaks(measured, volts, suspect),
            // An edge or a noise.
            None => {
                self.continuity.rest(false);
                None
            }
        });
        let watches = self.guard.watches(sense, &self.belt);
        let found = if watches { electrical.or(self.watch(stages, measured, volts)) } else { electrical };
        found.map(|found| self.name(stages, measured, found))
    }

    /// Nothing but a short takes more current than the limit from the tone of the self-test, or lets the voltage collapse under it.
    // Not inlined: the fast memory of a board has no room for it.
    #[cold]
    #[inline(never)]
    fn name(&self, stages: &Stages, measured: &Measured, found: Fault) -> Fault {
        let collapses = found == Fault::SensorImplausible && stages.self_test.is_short(measured.sensed, measured.played.volts);
        let short = self.supervisor.mode() == Mode::SelfTest && (found == Fault::OverCurrent || collapses);
        if short { Fault::LoadShorted } else { found }
    }

    /// Whether voltage and current of a steady drive have changed as they cannot.
    // Not inlined: the fast memory of a board has no room for it.
    #[inline(never)]
    fn breaks(&mut self, measured: &Measured, volts: f32, suspect: Suspect) -> Option<Fault> {
        // A block of several lanes that is a multiple of something has no time for it.
        if self.lanes.are_several() && self.block & 1 == 0 {
            return None;
        }
        let Measured { sense, sensed, motional, played, .. } = *measured;
        let follows = matches!(self.supervisor.mode(), Mode::Lock | Mode::Run);
        let (silent, judged) = (volts == 0.0, self.guard.judges(volts));
        if silent || !follows {
            let known = silent || judged;
            let distorted = known && suspect.distorted && (!silent || self.is_loud_in_silence(sense));
            let misplayed = self.continuity.is_misplayed(sensed.v, distorted, silent);
            return (known && misplayed).then_some(Fault::SensorImplausible);
        }
        // Of another lane there are no phasors, but the last ones of lane 0.
        let here = self.lanes.are_at_home() && self.generator.sweep.holds();
        if !(here && judged && played.pure && played.is_full()) {
            self.continuity.rings();
            return None;
        }
        let Sensed { v, i } = *sensed;
        let tracked = self.track.tracker.tracks();
        if !tracked {
            self.continuity.follow_order(played.offset_hz);
        }
        let hard = self.supervisor.mode() == Mode::Run && self.generator.burst.is_hard();
        let block =
            Steady { volts, offset_hz: played.offset_hz, v, i, motional, tracked, hard, unexplained: suspect.unexplained };
        let track = &self.track;
        let load = || Load { periods: track.periods(), susceptance: track.online.motional().y0.im, noise: track.noise.1 };
        // What is implausible by itself has a name of its own, and some blocks to go.
        let broken = if self.guard.doubts() {
            self.continuity.doubt(&block);
            false
        } else {
            self.continuity.is_broken(&block, load)
        };
        // So has a lane that has failed.
        (broken && !self.lanes.postpone(self.supervisor.mode() != Mode::Run)).then_some(Fault::SensorImplausible)
    }

    /// Whether samples of a block of silence are beyond what a voltage may be at most: a bit of the drive's converter stands, or its amplifier.
    #[cold]
    #[inline(never)]
    fn is_loud_in_silence(&self, sense: &SenseBlock) -> bool {
        self.convert.v.beyond(&sense.v, self.continuity.most_volts()) > 1
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
