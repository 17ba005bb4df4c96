//! Lock and run as a stage: the drive follows the resonance in frequency and amplitude, block by
//! block.

pub(crate) mod edges;
mod friction;

use crate::act::friction::FrictionSwitch;
use crate::controller::chain::{Chain, Measured};
use crate::controller::stages::Stage;
use crate::controller::stages::follow::edges::Edges;
use crate::find::clamped::online;
use crate::generate::shape::Shape;
use crate::generate::signal_generator::Played;
use crate::generate::step::Progress;
use crate::generate::step::{Plan, Step};
use crate::guard::heat::Thermometers;
use crate::seam::block::{Amplitude, Gate, Orders};
use crate::seam::compare::{smaller, within};
use crate::seam::config::Config;
use crate::seam::fault::Fault;
use crate::seam::mode::Mode;
use crate::seam::phasor::magnitude;
use crate::seam::units::Turns;
use crate::track::tracked_transducer::LEARN_BLOCKS;
use crate::track::tracker::{PlayedBlock, State};

/// Stage of lock and run.
#[derive(Clone, Debug)]
#[repr(C)]
pub(crate) struct Follow {
    /// Configured amplitude.
    amplitude: Amplitude,
    /// Offset from the resonance for measuring the clamped capacitance, Hz.
    probe_hz: f32,
    pub(crate) edges: Edges,
    pub(crate) friction: Option<FrictionSwitch>,
}

impl Stage for Follow {
    fn begin(&mut self, _: &mut Chain) {
        self.probe_hz = 0.0;
        self.edges.restart();
        self.friction.iter_mut().for_each(FrictionSwitch::restart);
    }

    // Not inlined: the fast memory of a board has no room for it.
    #[inline(never)]
    fn step(&mut self, chain: &mut Chain, measured: &Measured) -> Step {
        let orders = measured.orders;
        let (gate, amplitude) = match (chain.supervisor.mode(), chain.guard.is_muted()) {
            (Mode::Run, false) => {
                self.switch_friction(chain, measured);
                self.ordered(chain, orders)
            }
            (Mode::Run, true) => (Gate::Off, orders.amplitude),
            (_, false) => (Gate::On, orders.amplitude),
            // The guard has muted the drive while locking: play silence until it releases the
            // drive.
            (_, true) => return Step::Silence,
        };
        if chain.lanes.are_heard() || chain.continuity.is_out_of_sequence() {
            return Step::Follow(self.hold(chain, orders, gate));
        }
        Step::Follow(self.follow(chain, measured, gate, amplitude))
    }
}

impl Follow {
    /// Builds the stage with the configured amplitude.
    pub(crate) fn build(config: &Config, friction: Option<FrictionSwitch>) -> Self {
        Follow { amplitude: config.drive.amplitude, probe_hz: 0.0, edges: Edges::build(config), friction }
    }

    /// Follows frequency and amplitude for one block, with the given gate and amplitude set point.
    #[inline(always)]
    fn follow(&mut self, chain: &mut Chain, measured: &Measured, gate: Gate, amplitude: Option<Amplitude>) -> Plan {
        let Measured { orders, sensed, motional, played, .. } = *measured;
        let on = played.is_full();
        let boosts = chain.generator.burst.boosts();
        let info = self.edges.block_info(chain.block, boosts);
        let block = PlayedBlock {
            offset_hz: played.offset_hz,
            volts: played.volts,
            envelope: (played.flat && info.informative).then_some(played.envelope),
            pure: played.pure,
            on,
            driven: played.envelope != 0.0,
            rung_up: info.rung_up,
        };
        let track = &mut chain.track;
        let at_lock_point = track.tracker.at_lock_point(motional, played.detune_hz);
        let phase = track.tracker.follow(sensed, motional, at_lock_point, &block);
        if track.latest_transducer().is_none() && track.tracker.has_converged() {
            let transducer = track.begin_to_learn(chain.block);
            let amplitude = &mut chain.generator.amplitude;
            amplitude.seed(transducer, magnitude(motional), amplitude.start_volts());
        }
        if chain.track.tracker.observes() && (played.pure || chain.track.online.probes()) {
            self.probe(chain, measured);
        } else {
            chain.track.online.rest();
        }
        let tracked_hz = chain.track.tracker.tracks().then(|| chain.track.lock_point_hz());
        let (offset_hz, limited) = self.detune(chain, orders, tracked_hz.unwrap_or(0.0));
        chain.generator.sweep.hold.retune(offset_hz);
        // A block with an edge must never count as full, even if its mean rounds to one.
        let envelope = if played.flat || played.envelope > 1.0 { played.envelope } else { smaller(played.envelope, 0.999) };
        // Before the new amplitude is set: the residual vibration was driven by the one before.
        if boosts {
            self.edges.prepare_boost(chain, measured, gate);
        } else if chain.generator.burst.brakes(gate) || chain.generator.burst.brake().is_some() {
            self.edges.prepare_brake(chain, gate);
        }
        let known = chain.track.latest_transducer().is_some() || !chain.track.tracker.observes();
        let generator = &mut chain.generator;
        if known {
            if on && info.rung_up {
                generator.amplitude.has_rung_up();
            }
            let susceptance = chain.track.online.motional().y0.im;
            generator.amplitude.watch_current((on && played.pure).then_some(played.volts), motional, susceptance);
            let asked = self.asked(amplitude).derated(chain.guard.derating());
            generator.amplitude.update(asked, envelope, at_lock_point);
        }
        let volts = if !known {
            generator.amplitude.start_volts()
        } else if generator.burst.is_under_way(gate) {
            self.edges.volts()
        } else {
            generator.amplitude.volts()
        };
        if boosts {
            generator.burst.set_drive(volts);
        }
        let progress = chain.track.progress(chain.supervisor.mode(), &chain.generator.amplitude, &mut chain.lanes);
        let plan = Plan { volts, gate, listen: chain.lanes.ordered(), tracked_hz, phase, limited, progress };
        if chain.guard.is_muted() {
            // Silent within the block at any edge: a burst of 0 V ends at once and starts again
            // later.
            return Plan { volts: 0.0, ..plan };
        }
        if chain.supervisor.mode() == Mode::Run
            && let Some(friction) = &self.friction
            && friction.is_implausible()
        {
            // A survey in which the force sensor reads a force that friction cannot have ends the
            // run.
            return Plan { progress: Progress::Failed(Fault::ForceSensorImplausible), ..plan };
        }
        plan
    }

    /// Continues unchanged if the measured block is of another lane or out of sequence: tracker and
    /// loops hold their values.
    // Not inlined: the fast memory of a board has no room for it.
    #[cold]
    #[inline(never)]
    fn hold(&mut self, chain: &mut Chain, orders: &Orders, gate: Gate) -> Plan {
        let tracked_hz = chain.track.tracker.tracks().then(|| chain.track.lock_point_hz());
        let (offset_hz, limited) = self.detune(chain, orders, tracked_hz.unwrap_or(0.0));
        chain.generator.sweep.hold.retune(offset_hz);
        let under_way = chain.generator.burst.is_under_way(gate);
        let volts = match (chain.guard.is_muted(), under_way) {
            (true, _) => 0.0,
            (false, true) => self.edges.volts(),
            (false, false) => chain.generator.amplitude.volts(),
        };
        let progress = chain.lanes.found().map_or(Progress::Busy, Progress::Failed);
        Plan { volts, gate, listen: chain.lanes.ordered(), tracked_hz, phase: Turns(0.0), limited, progress }
    }

    /// Records the written block, and does background work if the block has time: an edge takes all
    /// of it.
    #[inline]
    pub(crate) fn work(&mut self, chain: &mut Chain, plan: &Plan, written: &Played) {
        if chain.generator.burst.boosts() {
            self.edges.record(chain.block, &chain.generator, plan.volts, written.envelope);
        }
        if written.flat {
            self.calculate(chain);
        }
    }

    /// Does the background work.
    #[inline]
    fn calculate(&mut self, chain: &mut Chain) {
        let (block, mode) = (chain.block, chain.supervisor.mode());
        let following = matches!(mode, Mode::Lock | Mode::Run);
        // A friction switch uses all other blocks for its own work.
        chain.track.learn_periodically(block, following, self.friction.is_some(), self.edges.are_idle());
        if following && block.is_multiple_of(LEARN_BLOCKS) && chain.track.tracker.state() == State::Locked {
            let susceptance = chain.track.online.motional().y0.im;
            chain.guard.update_temperature(&Thermometers { resonance_hz: chain.track.tracker.estimate_hz(), susceptance });
        }
        let busy = chain.track.since_learned(block) == 0 || block.is_multiple_of(LEARN_BLOCKS);
        if let Some(friction) = &mut self.friction
            && mode == Mode::Run
            && !busy
        {
            friction.work();
        }
    }

    /// Measures the clamped branch at the lock point by small frequency steps of an otherwise
    /// steady drive.
    #[inline(never)]
    fn probe(&mut self, chain: &mut Chain, measured: &Measured) {
        let Measured { orders, sensed, played, .. } = *measured;
        let (track, generator) = (&mut chain.track, &chain.generator);
        let alone = chain.supervisor.mode() == Mode::Run
            && matches!(generator.shape, Shape::Sine)
            && generator.sweep.holds()
            && orders.detune.0 == 0.0
            && !self.friction.as_ref().is_some_and(FrictionSwitch::moves);
        let level = alone && played.flat && played.envelope == 1.0;
        if !track.online.listens(level, track.tracker.has_gate_opened()) {
            return;
        }
        let amplitude = &generator.amplitude;
        let steady = level && !amplitude.limited() && !amplitude.is_stepped() && track.tracker.state() == State::Locked;
        let sample =
            online::Sample { sensed, relative: played.relative, detune_hz: played.detune_hz, volts: played.volts, steady };
        let output = track.online.step(&sample);
        self.probe_hz = output.detune_hz;
        if let Some(update) = output.update {
            track.apply_update(&update);
            // A new clamped branch changes the motional current: the comparison starts again.
            chain.continuity.rest(false);
        }
    }

    /// Returns the amplitude set point before derating: the given one, or the configured one.
    pub(crate) fn asked(&self, amplitude: Option<Amplitude>) -> Amplitude {
        amplitude.unwrap_or(self.amplitude)
    }

    /// Returns the frequency to drive, as an offset from the nominal frequency, Hz, and `true` if
    /// the window limits the order. Only a run can be detuned from the resonance.
    #[inline(always)]
    fn detune(&self, chain: &Chain, orders: &Orders, tracked_hz: f32) -> (f32, bool) {
        let window = chain.track.tracker.window_hz();
        let running = chain.supervisor.mode() == Mode::Run;
        let asked = if running && orders.detune.0.is_finite() { orders.detune.0 } else { 0.0 };
        let ordered_hz = tracked_hz + asked + self.probe_hz;
        (within(ordered_hz, -window, window), ordered_hz.abs() > window)
    }
}
