//! What the guard is told of a block, and what its faults are called.

use super::{Controller, Played};
use crate::block::{LATENCY_BLOCKS, Orders, SenseBlock};
use crate::demod::{Sensed, Suspect};
use crate::guard::{Driven, Stage};
use crate::supervisor::{Fault, Mode};

impl Controller {
    /// Nothing but a short takes more current than the limit from the tone of the self-test, or lets the voltage collapse under it.
    pub(super) fn named(&self, fault: Fault, sensed: &Sensed, volts: f32) -> Fault {
        let collapses = fault == Fault::SensorImplausible && self.self_test.is_short(sensed, volts);
        let short = self.supervisor.mode() == Mode::SelfTest && (fault == Fault::OverCurrent || collapses);
        if short { Fault::LoadShorted } else { fault }
    }

    /// What the guard has to know of the block just heard.
    pub(super) fn driven(&mut self, orders: &Orders, sense: &SenseBlock, heard: &Played, suspect: Suspect) -> Driven {
        let volts = heard.audible.filter(|_| heard.flat).map(|part| part * heard.volts * heard.envelope.abs());
        let known = Driven { volts, suspect, ..Driven::default() };
        if self.guard.watches(sense, &self.belt) { self.watched(orders, heard, known) } else { known }
    }

    /// The same for what looks at more than voltage and current.
    #[inline(never)]
    fn watched(&mut self, orders: &Orders, heard: &Played, known: Driven) -> Driven {
        let mode = self.supervisor.mode();
        let now = (self.block + LATENCY_BLOCKS as u64) * self.samples as u64;
        let switched = self.as_switched(orders);
        let orders = switched.as_ref().unwrap_or(orders);
        Driven {
            stage: Stage::from(mode),
            wanted: mode == Mode::Lock || mode == Mode::Run && self.burst.is_wanted(orders.gate, now),
            full: heard.flat && heard.envelope == 1.0 && heard.volts > 0.0,
            asked: self.asked(orders).1,
            ..known
        }
    }
}
