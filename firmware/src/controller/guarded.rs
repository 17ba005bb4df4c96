//! The inputs of the guard for one block, and the name of the fault it finds.

use crate::controller::chain::{Chain, Measured};
use crate::controller::stages::Stages;
use crate::guard::continuity::{Load, Steady};
use crate::guard::{Driven, Stage};
use crate::seam::block::{Amplitude, SenseBlock};
use crate::seam::fault::Fault;
use crate::seam::mode::Mode;
use crate::sense::demod::{Sensed, Suspect};

impl Chain {
    /// Runs the guard on one block, and returns the fault found.
    pub(super) fn inspect(&mut self, stages: &Stages, measured: &Measured, suspect: Suspect) -> Option<Fault> {
        let Measured { sense, sensed, played, .. } = *measured;
        let volts = played.audible.filter(|_| played.flat).map(|part| part * played.volts * played.envelope.abs());
        let electrical = self.guard.inspect(&self.convert, sense, sensed, volts, suspect);
        let electrical = electrical.or_else(|| match volts {
            Some(volts) => self.check_continuity(measured, volts, suspect),
            // An edge or a noise.
            None => {
                self.continuity.rest(false);
                None
            }
        });
        let watches = self.guard.watches(sense, &self.belt);
        let found = if watches { electrical.or(self.watch(stages, measured, volts)) } else { electrical };
        found.map(|found| self.fault_to_report(stages, measured, found))
    }

    /// Returns the fault to report for `found`. In the self-test only a short takes more current
    /// than the limit, or lets the voltage collapse under a high current.
    // Not inlined: the fast memory of a board has no room for it.
    #[cold]
    #[inline(never)]
    fn fault_to_report(&self, stages: &Stages, measured: &Measured, found: Fault) -> Fault {
        let collapses = found == Fault::SensorImplausible && stages.self_test.is_short(measured.sensed, measured.played.volts);
        let short = self.supervisor.mode() == Mode::SelfTest && (found == Fault::OverCurrent || collapses);
        if short { Fault::LoadShorted } else { found }
    }

    /// Returns a fault if voltage or current of a steady drive have changed in an impossible way.
    // Not inlined: the fast memory of a board has no room for it.
    #[inline(never)]
    fn check_continuity(&mut self, measured: &Measured, volts: f32, suspect: Suspect) -> Option<Fault> {
        // With several lanes, only odd blocks have time for this.
        if self.lanes.are_several() && self.block & 1 == 0 {
            return None;
        }
        let Measured { sense, sensed, motional, played, .. } = *measured;
        let follows = matches!(self.supervisor.mode(), Mode::Lock | Mode::Run);
        let (silent, judged) = (volts == 0.0, self.guard.is_judged(volts));
        if silent || !follows {
            let known = silent || judged;
            let distorted = known && suspect.distorted && (!silent || self.exceeds_limit_in_silence(sense));
            let misplayed = self.continuity.check_measuring_block(sensed.v, distorted, silent);
            return (known && misplayed).then_some(Fault::SensorImplausible);
        }
        // In a block of another lane, `sensed` holds the last phasors of lane 0.
        let here = self.lanes.are_at_home() && self.generator.sweep.holds();
        if !(here && played.pure && played.is_full()) {
            self.continuity.mark_ringing();
            return None;
        }
        let tracked = self.track.tracker.tracks();
        if !judged {
            let failed = self.continuity.check_small_block(tracked && suspect.unexplained, self.track.periods());
            return failed.then_some(Fault::SensorImplausible);
        }
        let Sensed { v, i } = *sensed;
        if !tracked {
            self.continuity.follow_order(played.offset_hz);
        }
        let hard = self.supervisor.mode() == Mode::Run && self.generator.burst.is_hard();
        let block =
            Steady { volts, offset_hz: played.offset_hz, v, i, motional, tracked, hard, unexplained: suspect.unexplained };
        let track = &self.track;
        let load = || {
            let y0 = track.online.motional().y0;
            // The motional current contains the noise of both channels.
            let noise = track.noise.1 + y0.norm_sqr() * track.noise.0;
            Load { periods: track.periods(), susceptance: y0.im, noise }
        };
        // A block that is implausible by itself is judged by `electrical`, which needs some more
        // blocks.
        let broken = if self.guard.is_implausible() {
            self.continuity.mark_implausible(&block);
            false
        } else {
            self.continuity.check_steady_block(&block, load)
        };
        // A failed lane has its own fault, and is judged first.
        (broken && !self.lanes.postpone(self.supervisor.mode() != Mode::Run)).then_some(Fault::SensorImplausible)
    }

    /// Returns `true` if samples of a silent block exceed the largest accepted voltage: a bit of
    /// the drive converter or the amplifier is stuck.
    #[cold]
    #[inline(never)]
    fn exceeds_limit_in_silence(&self, sense: &SenseBlock) -> bool {
        self.convert.v.beyond(&sense.v, self.continuity.most_volts()) > 1
    }

    /// Runs the checks of sensors other than voltage and current, and of limits.
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
        self.guard.watch(&self.convert, sense, sensed, &self.belt, &driven)
    }
}
