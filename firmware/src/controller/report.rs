//! The telemetry of a block.

use super::Controller;
use super::chain::Chain;
use crate::act::friction::FrictionSwitch;
use crate::act::restraint::{Class, Restraint};
use crate::generate::step::Plan;
use crate::seam::block::Orders;
use crate::seam::fault::Limit;
use crate::seam::mode::Mode;
use crate::seam::phasor::Phasor;
use crate::seam::telemetry::Telemetry;
use crate::seam::units::{Hertz, Volts};
use crate::sense::demod::Sensed;
use crate::track::tracker::State;

impl Controller {
    /// Returns the limit for which the friction of a contact or a D-ring misses its set point.
    #[inline(never)]
    fn service_limit(&self, orders: &Orders) -> Option<Limit> {
        let unknown = |restraint: &Restraint| restraint.class(orders.torso_kg) == Class::Unknown;
        let unclassified = self.chain.restraint.as_ref().is_some_and(unknown).then_some(Limit::RestraintUnclassified);
        self.stages.follow.friction_limit(orders).or(unclassified)
    }

    /// Writes the report of the block that is over.
    pub(super) fn report(
        &self,
        orders: &Orders,
        plan: &Plan,
        slot: usize,
        (sensed, motional_current): (&Sensed, Phasor),
        report: &mut Telemetry,
    ) {
        let played = &self.played[slot];
        let Chain { supervisor, track, generator, guard, .. } = &self.chain;
        let mode = supervisor.mode();
        let following = matches!(mode, Mode::Lock | Mode::Run);
        let state = track.tracker.state();
        let serves = self.stages.follow.friction.is_some() || self.chain.restraint.is_some();
        let limit = match following {
            true if guard.mutes_request() => Some(Limit::BeltMuted),
            // Before those that last: it explains the frequency of some blocks.
            true if track.online.probes() => Some(Limit::Probing),
            true if guard.derating() < 1.0 => Some(Limit::Derated),
            true if generator.amplitude.limited() => Some(generator.amplitude.limit()),
            true if track.tracker.limited() || plan.limited => Some(Limit::FrequencyWindow),
            true if generator.phasing.quadrature(orders.quadrature).1 => Some(Limit::QuadratureRequest),
            true => serves.then(|| self.service_limit(orders)).flatten().or_else(|| match track.limit(state) {
                None if generator.burst.limited() && mode == Mode::Run => Some(Limit::BoostLimited),
                limit => limit,
            }),
            false => None,
        };
        // Field by field: a struct literal would be built elsewhere and copied.
        report.block = (self.chain.block - 1) as u32;
        report.orders_sequence = orders.sequence;
        report.mode = mode;
        report.fault = supervisor.fault();
        report.limit = limit;
        report.locked = following && state == State::Locked;
        report.tuning_word = played.tone.word;
        report.frequency = Hertz(generator.sweep.hold.nominal_hz() + played.offset_hz);
        report.resonance = Hertz(generator.sweep.hold.nominal_hz() + track.tracker.estimate_hz());
        report.drive = Volts(played.volts);
        report.envelope = played.envelope;
        report.v = sensed.v;
        report.i = sensed.i;
        report.motional_current = motional_current;
        report.phase = plan.phase;
        report.listed = self.stages.scan.modes().in_turn(self.chain.block as usize);
        report.friction = self.stages.follow.friction.as_ref().and_then(FrictionSwitch::belief);
        match track.transducer() {
            Some(transducer) => report.transducer.get_or_insert_default().copy(transducer),
            None => report.transducer = None,
        }
    }
}
