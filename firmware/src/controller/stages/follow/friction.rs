//! The friction switch in a run: it sets amplitude and gate, unless the host does.

use super::Follow;
use crate::act::friction::{FrictionSwitch, Sensed, SetPoint};
use crate::controller::chain::{Chain, Measured};
use crate::seam::block::{Amplitude, Gate, Orders};
use crate::seam::fault::Limit;
use crate::seam::mode::Mode;
use crate::seam::phasor::magnitude;

impl Follow {
    /// Passes one measured block of a run to the friction switch.
    #[inline]
    pub(crate) fn switch_friction(&mut self, chain: &mut Chain, measured: &Measured) {
        let Measured { orders, sense, motional, played, .. } = *measured;
        let Some(friction) = &mut self.friction else { return };
        if !leaves_to_switch(orders) {
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

    /// Returns gate and amplitude: those of the orders, or in a run those of the friction switch.
    #[inline]
    pub(crate) fn ordered(&self, chain: &Chain, orders: &Orders) -> (Gate, Option<Amplitude>) {
        let running = chain.supervisor.mode() == Mode::Run;
        let Some(friction) = &self.friction else { return (orders.gate, orders.amplitude) };
        if !running || !leaves_to_switch(orders) {
            return (orders.gate, orders.amplitude);
        }
        // A periodic schedule belongs to the switch; a schedule of windows belongs to the user,
        // except during a survey.
        let on = if chain.generator.burst.repeats() || friction.is_surveying() { Gate::On } else { Gate::Scheduled };
        let (amplitude, gate) = match friction.set_point() {
            SetPoint::Silence => (None, Gate::Off),
            SetPoint::Current(amperes) => (Some(amperes), on),
            SetPoint::Bursts { amperes, .. } => (Some(amperes), Gate::Scheduled),
        };
        (gate, amplitude.map(Amplitude::MotionalCurrent))
    }

    /// Returns the limit for which the friction misses its set point.
    pub(crate) fn friction_limit(&self, orders: &Orders) -> Option<Limit> {
        self.friction.as_ref().filter(|_| leaves_to_switch(orders)).and_then(FrictionSwitch::limit)
    }
}

/// Returns `true` if the orders leave amplitude and gate to the friction switch.
fn leaves_to_switch(orders: &Orders) -> bool {
    orders.amplitude.is_none() && orders.gate == Gate::Scheduled
}
