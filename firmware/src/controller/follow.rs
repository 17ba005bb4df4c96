//! What is done in each block of a lock and of a run.

use super::plan::Plan;
use super::{Controller, Played};
use crate::block::{Amplitude, Orders};
use crate::clamped::online;
use crate::demod::Sensed;
use crate::guard::heat::Thermometers;
use crate::identify::Transducer;
use crate::phasor::{Phasor, magnitude};
use crate::shape::Shape;
use crate::supervisor::Mode;
use crate::tracker::compare::{larger, smaller};
use crate::tracker::{Heard, State};

/// How often what the observer knows of the transducer is taken, blocks.
pub(super) const LEARN_BLOCKS: u64 = 64;

impl Controller {
    /// Begins to take what the observer knows of the transducer, which is sure of it: what is followed by at once.
    fn begin_to_learn(&mut self) {
        self.tracker.learn(&mut self.learning);
        let transducer = self.learning.transducer();
        self.tracker.set_resonance(transducer);
        self.online.set_resonance(transducer.series_resonance_hz, transducer.q);
        self.learned = self.block;
    }

    /// Goes on with it.
    fn work_on_it(&mut self) {
        self.learning.advance();
        if self.learning.is_over() {
            self.transducer.get_or_insert_default().copy(self.learning.transducer());
        }
    }

    /// The transducer as it is known by now; while it is being learned, without deviations.
    pub(super) fn transducer_by_now(&self) -> Option<&Transducer> {
        if self.learning.is_over() { self.transducer.as_ref() } else { Some(self.learning.transducer()) }
    }

    /// Takes all of it at once.
    fn learn(&mut self) {
        self.begin_to_learn();
        while !self.learning.is_over() {
            self.work_on_it();
        }
    }

    /// The same again, now and then; in parts, in blocks in which nothing else is calculated.
    pub(super) fn learn_on(&mut self) {
        let following = matches!(self.supervisor.mode(), Mode::Lock | Mode::Run);
        if following && self.transducer.is_some() && self.block - self.learned >= LEARN_BLOCKS && self.tracker.is_sure() {
            // A friction switch has its own work in all other blocks.
            if self.friction.is_some() {
                self.learn();
            } else {
                self.begin_to_learn();
            }
        } else if !self.learning.is_over() && self.edges.are_idle() {
            self.work_on_it();
        }
        if following && self.block.is_multiple_of(LEARN_BLOCKS) && self.tracker.state() == State::Locked {
            let susceptance = self.online.motional().y0.im;
            self.guard.feel(&Thermometers { resonance_hz: self.tracker.estimate_hz(), susceptance });
        }
    }

    /// Measures the clamped capacitance anew, where it may drift, by small steps of a drive that is otherwise left alone.
    fn probe(&mut self, orders: &Orders, sensed: &Sensed, played: &Played) {
        if !self.tracker.observes() {
            return;
        }
        let alone = matches!(self.shape, Shape::Sine)
            && self.sweep.holds()
            && orders.detune.0 == 0.0
            && self.supervisor.mode() == Mode::Run;
        let whole = played.flat && played.envelope == 1.0 && !self.amplitude.limited() && !self.tracker.limited();
        let steady = alone && whole && self.tracker.state() == State::Locked;
        let heard = online::Heard { sensed, relative: played.relative, detune_hz: played.detune_hz, steady };
        let wanted = self.online.step(&heard);
        self.probe_hz = wanted.detune_hz;
        if let Some(update) = wanted.update {
            self.tracker.set_branch(update.motional, update.deviation);
        }
    }

    /// Follows frequency and amplitude for one block.
    pub(super) fn follow(&mut self, orders: &Orders, sensed: &Sensed, played: &Played, motional: Phasor) -> Plan {
        let on = played.flat && played.envelope == 1.0 && played.volts > 0.0;
        let driven = played.envelope != 0.0;
        let boosts = self.burst.boosts();
        let told = self.told(boosts);
        let heard = Heard {
            offset_hz: played.offset_hz,
            volts: played.volts,
            envelope: (played.flat && told.telling).then_some(played.envelope),
            pure: played.pure,
            on,
            driven,
            rung_up: told.rung_up,
        };
        let at_lock_point = self.tracker.at_lock_point(motional, played.detune_hz);
        let phase = self.tracker.follow(sensed, motional, at_lock_point, &heard);
        if self.transducer_by_now().is_none() && self.tracker.is_sure() {
            self.begin_to_learn();
            self.amplitude.seed(self.learning.transducer(), magnitude(motional));
        }
        if self.online.drifts() {
            self.probe(orders, sensed, played);
        }
        let tracked_hz = if self.tracker.tracks() { self.tracker.offset_hz() } else { 0.0 };
        let (offset_hz, limited) = self.detune(orders, tracked_hz);
        self.sweep.hold.retune(offset_hz);
        // An edge is never quite one, whatever its mean rounds to.
        let envelope = if played.flat || played.envelope > 1.0 { played.envelope } else { played.envelope.min(0.999) };
        // Before the order's own amplitude: what rings was driven by the one before.
        if boosts {
            self.prepare_boost(orders, sensed, played, motional);
        } else {
            self.prepare_brake(orders.gate);
        }
        let known = self.transducer_by_now().is_some() || !self.tracker.observes();
        if known {
            if on && told.rung_up {
                self.amplitude.has_rung_up();
            }
            self.amplitude.update(self.asked(orders).0, envelope, at_lock_point);
        }
        let volts = match () {
            () if !known => self.scan_volts,
            () if self.burst.is_under_way(orders.gate) => self.braked_volts,
            () => self.amplitude.volts(),
        };
        if boosts {
            self.burst.set_drive(volts);
        }
        Plan { volts, gate: orders.gate, listen: 0, tracked_hz, phase, limited, progress: self.lock_progress() }
    }

    /// The amplitude asked for, as far as it is not derated; and as a number, before that.
    pub(super) fn asked(&self, orders: &Orders) -> (Amplitude, f32) {
        let left = self.guard.derating();
        match orders.amplitude.unwrap_or(self.amplitude_asked) {
            Amplitude::Volts(volts) => (Amplitude::Volts(left * volts), volts),
            Amplitude::MotionalCurrent(amperes) => (Amplitude::MotionalCurrent(left * amperes), amperes),
        }
    }

    /// Where to drive, as an offset from the nominal frequency, Hz, and whether the order had to be limited. Only what runs is moved
    /// away from the resonance.
    fn detune(&self, orders: &Orders, tracked_hz: f32) -> (f32, bool) {
        let window = self.tracker.window_hz();
        let asked = if self.supervisor.mode() == Mode::Run && orders.detune.0.is_finite() { orders.detune.0 } else { 0.0 };
        let wanted = tracked_hz + asked + self.probe_hz;
        // `clamp` could panic, for all that the compiler knows.
        (smaller(larger(wanted, -window), window), wanted.abs() > window)
    }
}
