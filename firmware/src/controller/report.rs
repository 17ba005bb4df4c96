//! What a block reports.

use super::Controller;
use super::plan::Plan;
use crate::block::Orders;
use crate::demod::Sensed;
use crate::friction::FrictionSwitch;
use crate::phasor::Phasor;
use crate::restraint::{Class, Restraint};
use crate::supervisor::{Limit, Mode};
use crate::telemetry::Telemetry;
use crate::tracker::State;
use crate::units::{Hertz, Volts};

impl Controller {
    /// Why the friction of a contact, or of a D-ring, is not what is wanted.
    #[inline(never)]
    fn service_limit(&self, orders: &Orders) -> Option<Limit> {
        let unknown = |restraint: &Restraint| restraint.class(orders.torso_kg) == Class::Unknown;
        let unclassified = self.restraint.as_ref().is_some_and(unknown).then_some(Limit::RestraintUnclassified);
        self.friction_limit(orders).or(unclassified)
    }

    /// The report of the block that is over.
    pub(super) fn report(
        &self,
        orders: &Orders,
        plan: &Plan,
        slot: usize,
        sensed: Sensed,
        motional_current: Phasor,
    ) -> Telemetry {
        let played = &self.played[slot];
        let mode = self.supervisor.mode();
        let following = matches!(mode, Mode::Lock | Mode::Run);
        let state = self.tracker.state();
        let serves = self.friction.is_some() || self.restraint.is_some();
        let limit = match following {
            true if self.guard.mutes() => Some(Limit::BeltMuted),
            true if self.guard.derating() < 1.0 => Some(Limit::Derated),
            true if self.amplitude.limited() => Some(Limit::OverVoltageRequest),
            true if self.tracker.limited() || plan.limited => Some(Limit::FrequencyWindow),
            true if self.phasing.quadrature(orders.quadrature).1 => Some(Limit::QuadratureRequest),
            true => serves.then(|| self.service_limit(orders)).flatten().or_else(|| match state {
                State::Unheard => Some(Limit::NotTracking),
                _ if self.burst.limited() && mode == Mode::Run => Some(Limit::BoostLimited),
                _ => None,
            }),
            false => None,
        };
        let mut report = Telemetry {
            block: (self.block - 1) as u32,
            orders_sequence: orders.sequence,
            mode,
            fault: self.supervisor.fault(),
            limit,
            locked: following && state == State::Locked,
            tuning_word: played.tone.word,
            frequency: Hertz(self.sweep.hold.nominal_hz() + played.offset_hz),
            resonance: Hertz(self.sweep.hold.nominal_hz() + self.tracker.estimate_hz()),
            drive: Volts(played.volts),
            envelope: played.envelope,
            v: sensed.v,
            i: sensed.i,
            motional_current,
            phase: plan.phase,
            transducer: None,
            listed: self.scan.roster().in_turn(self.block as usize),
            friction: self.friction.as_ref().and_then(FrictionSwitch::belief),
        };
        if let Some(transducer) = &self.transducer {
            report.transducer.get_or_insert_default().copy(transducer);
        }
        report
    }
}
