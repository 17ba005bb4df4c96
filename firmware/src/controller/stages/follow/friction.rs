//! The friction switch: it orders amplitude and gate of a run, where the host does not.

use super::Follow;
use crate::act::friction::{FrictionSwitch, Sensed, SetPoint};
use crate::controller::chain::{Chain, Measured};
use crate::seam::block::{Amplitude, Gate, Orders};
use crate::seam::fault::Limit;
use crate::seam::mode::Mode;
use crate::seam::phasor::magnitude;

impl Follow {
    /// Gives the friction switch one measured block of a run.
    #[inline]
    pub(crate) fn switch_friction(&mut self, chain: &mut Chain, measured: &Measured) {
        let Measured { orders, sense, motional, played, .. } = *measured;
        let Some(friction) = &mut self.friction else { return };
        if !is_free(orders) {
            return;
        }
        let boosts = chain.generator.burst.boosts();
        let on = played.is_full() && (!boosts || self.edges.block_info(chain.block, boosts).rung_up);
        let sensed = Sensed {
            belt_m_per_s: chain.belt.speed_m_per_s(),
            counts: chain.belt.counts(),
            force_n: sense.slow.force,
            motional_a: on.then(|| magnitude(motional)),
        };
        if let SetPoint::Bursts { on_samples, .. } = friction.step(orders.friction, &sensed) {
            chain.generator.burst.set_on(on_samples);
        }
    }

    /// Gate and amplitude of the orders, or in a run what the friction switch has made of them last.
    #[inline]
    pub(crate) fn ordered(&self, chain: &Chain, orders: &Orders) -> (Gate, Option<Amplitude>) {
        let running = chain.supervisor.mode() == Mode::Run;
        let Some(friction) = &self.friction else { return (orders.gate, orders.amplitude) };
        if !running || !is_free(orders) {
            return (orders.gate, orders.amplitude);
        }
        // A schedule that repeats is the switch's own; windows are the user's, except while surveying.
        let on = if chain.generator.burst.repeats() || friction.is_surveying() { Gate::On } else { Gate::Scheduled };
        let (amplitude, gate) = match friction.set_point() {
            SetPoint::Silence => (None, Gate::Off),
            SetPoint::Current(amperes) => (Some(amperes), on),
            SetPoint::Bursts { amperes, .. } => (Some(amperes), Gate::Scheduled),
        };
        (gate, amplitude.map(Amplitude::MotionalCurrent))
    }

    /// Why the friction misses its set point.
    pub(crate) fn friction_limit(&self, orders: &Orders) -> Option<Limit> {
        self.friction.as_ref().filter(|_| is_free(orders)).and_then(FrictionSwitch::limit)
    }
}

/// Whether an order leaves amplitude and gate to the switch.
fn is_free(orders: &Orders) -> bool {
    orders.amplitude.is_none() && orders.gate == Gate::Scheduled
}
