//! The friction switch in the controller: it orders amplitude and gate, where nobody else does.

use super::{Controller, Played};
use crate::block::{Amplitude, Gate, Orders, SenseBlock};
use crate::friction::{Sensed, Wanted};
use crate::phasor::{Phasor, magnitude};
use crate::supervisor::Limit;

impl Controller {
    /// The orders as the friction switch makes them, once a block of a run.
    pub(super) fn switch_friction(&mut self, orders: &Orders, sense: &SenseBlock, heard: &Played, motional: Phasor) -> Orders {
        let Some(friction) = self.friction.as_mut().filter(|_| is_free(orders)) else { return *orders };
        let on = heard.flat && heard.envelope == 1.0 && heard.volts > 0.0;
        let sensed = Sensed {
            belt_m_per_s: self.belt.speed_m_per_s(),
            force_n: sense.slow.force,
            motional_a: on.then(|| magnitude(motional)),
        };
        let wanted = friction.step(orders.friction, &sensed);
        // A schedule that repeats is the switch's own; windows are the user's, except while surveying.
        let on = if self.burst.repeats() || friction.is_surveying() { Gate::On } else { Gate::Scheduled };
        let (amplitude, gate) = match wanted {
            Wanted::Silence => (None, Gate::Off),
            Wanted::Current(amperes) => (Some(amperes), on),
            Wanted::Bursts { amperes, on_samples } => {
                self.burst.set_on(on_samples);
                (Some(amperes), Gate::Scheduled)
            }
        };
        Orders { amplitude: amplitude.map(Amplitude::MotionalCurrent), gate, ..*orders }
    }

    /// Surveys the contact anew.
    pub(super) fn restart_friction(&mut self) {
        if let Some(friction) = &mut self.friction {
            friction.restart();
        }
    }

    /// Why the friction is not what is wanted.
    pub(super) fn friction_limit(&self, orders: &Orders) -> Option<Limit> {
        self.friction.as_ref().filter(|_| is_free(orders)).and_then(|friction| friction.limit())
    }
}

/// Whether an order leaves amplitude and gate to the switch.
fn is_free(orders: &Orders) -> bool {
    orders.amplitude.is_none() && orders.gate == Gate::Scheduled
}
