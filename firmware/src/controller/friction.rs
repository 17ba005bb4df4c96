//! The friction switch in the controller: it orders amplitude and gate, where nobody else does.

use super::follow::LEARN_BLOCKS;
use super::plan::Plan;
use super::{Controller, Played};
use crate::block::{Amplitude, Gate, Orders, SenseBlock};
use crate::friction::{FrictionSwitch, Sensed, Wanted};
use crate::phasor::{Phasor, magnitude};
use crate::supervisor::{Fault, Limit, Mode, Progress};

impl Controller {
    /// Lets the friction switch hear one block of a run.
    pub(super) fn switch_friction(&mut self, orders: &Orders, sense: &SenseBlock, heard: &Played, motional: Phasor) {
        if self.friction.is_none() || !is_free(orders) {
            return;
        }
        let boosts = self.burst.boosts();
        let told = self.told(boosts);
        let Some(friction) = &mut self.friction else { return };
        let on = heard.flat && heard.envelope == 1.0 && heard.volts > 0.0 && (!boosts || told.rung_up);
        let sensed = Sensed {
            belt_m_per_s: self.belt.speed_m_per_s(),
            force_n: sense.slow.force,
            motional_a: on.then(|| magnitude(motional)),
        };
        if let Wanted::Bursts { on_samples, .. } = friction.step(orders.friction, &sensed) {
            self.burst.set_on(on_samples);
        }
    }

    /// Lets the switch calculate, in a block that has time for it: nothing has been learned in it.
    pub(super) fn work_friction(&mut self) {
        let busy = self.learned == self.block || self.block.is_multiple_of(LEARN_BLOCKS);
        if let Some(friction) = &mut self.friction
            && !busy
            && self.supervisor.mode() == Mode::Run
        {
            friction.work();
        }
    }

    /// The orders as the friction switch has made them last; `None` where it has no part in them.
    pub(super) fn as_switched(&self, orders: &Orders) -> Option<Orders> {
        let friction = self.friction.as_ref().filter(|_| self.supervisor.mode() == Mode::Run && is_free(orders))?;
        // A schedule that repeats is the switch's own; windows are the user's, except while surveying.
        let on = if self.burst.repeats() || friction.is_surveying() { Gate::On } else { Gate::Scheduled };
        let (amplitude, gate) = match friction.wanted() {
            Wanted::Silence => (None, Gate::Off),
            Wanted::Current(amperes) => (Some(amperes), on),
            Wanted::Bursts { amperes, .. } => (Some(amperes), Gate::Scheduled),
        };
        Some(Orders { amplitude: amplitude.map(Amplitude::MotionalCurrent), gate, ..*orders })
    }

    /// A survey in which the force sensor has said what cannot be friction ends the run.
    pub(super) fn trust_survey(&self, plan: Plan) -> Plan {
        let refused = self.friction.as_ref().is_some_and(FrictionSwitch::is_implausible);
        if refused { plan.and(Progress::Failed(Fault::ForceSensorImplausible)) } else { plan }
    }

    /// Surveys the contact anew.
    pub(super) fn restart_friction(&mut self) {
        if let Some(friction) = &mut self.friction {
            friction.restart();
        }
    }

    /// Why the friction is not what is wanted.
    pub(super) fn friction_limit(&self, orders: &Orders) -> Option<Limit> {
        self.friction.as_ref().filter(|_| is_free(orders)).and_then(FrictionSwitch::limit)
    }
}

/// Whether an order leaves amplitude and gate to the switch.
fn is_free(orders: &Orders) -> bool {
    orders.amplitude.is_none() && orders.gate == Gate::Scheduled
}
