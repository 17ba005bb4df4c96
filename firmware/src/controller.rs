//! The controller: `Config -> build -> Controller`, and `process` once a block.
//!
//! Contract: the codes returned for sense block `k` play as block `k + 2` ([`LATENCY_BLOCKS`]). After `build` nothing can
//! fail: trouble is a numbered fault in the telemetry, and a muted drive.

mod acquire;
mod build;
mod edges;
mod follow;
mod friction;
mod guarded;
mod plan;
mod report;
mod trims;

use crate::amplitude::AmplitudeLoop;
use crate::belt::Belt;
use crate::block::{Amplitude, DriveBlock, Gate, LATENCY_BLOCKS, Orders, SenseBlock};
use crate::burst::Burst;
use crate::burst::boost::EdgeTimes;
use crate::calibrate::Calibrate;
use crate::clamped::PowerOn;
use crate::clamped::online::Online;
use crate::controller::edges::Edges;
use crate::controller::plan::Plan;
use crate::convert::Convert;
use crate::demod::demodulate;
use crate::friction::FrictionSwitch;
use crate::guard::Guard;
use crate::identify::{Resonance, Transducer};
use crate::nco::{Nco, Stretch};
use crate::phasing::Phasing;
use crate::restraint::Restraint;
use crate::scan::Scan;
use crate::self_test::SelfTest;
use crate::shape::Shape;
use crate::shaper::{Play, Shaper};
use crate::supervisor::{Acquisition, Mode, Supervisor};
use crate::sweep::Sweep;
use crate::telemetry::Telemetry;
use crate::tracker::Tracker;
use crate::tracker::identified::Learning;

/// A block on its way from `process` to the ear: what was played when the answer arrives.
#[derive(Clone, Copy, Debug, Default)]
struct Played {
    /// The tone, or the chord of what moves.
    tone: Stretch,
    /// Frequency relative to the nominal one, and as an offset from it, Hz.
    relative: f32,
    offset_hz: f32,
    /// How far beside the lock point that was on purpose, Hz.
    detune_hz: f32,
    volts: f32,
    /// What can be heard of the voltage: the gain of the lane that was listened to, times the fundamental of the shape. Nothing is known of a
    /// noise, nor of a lane that is being calibrated.
    audible: Option<f32>,
    /// Mean envelope; `flat` says whether it is that throughout.
    envelope: f32,
    flat: bool,
    /// It was a sine.
    pure: bool,
}

/// The controller. What every block reads stands first and in this order, within reach of one instruction.
#[derive(Clone)]
#[repr(C)]
pub struct Controller {
    block: u64,
    /// The block in which the transducer was learned.
    learned: u64,
    nco: Nco,
    samples: usize,
    supervisor: Supervisor,
    acquisition: Acquisition,
    played: [Played; LATENCY_BLOCKS],
    sweep: Sweep,
    amplitude: AmplitudeLoop,
    amplitude_asked: Amplitude,
    /// Time constant of the resonance in periods, as told.
    nominal_periods: f32,
    /// Motional inductance as told, H.
    nominal_lm_h: Option<f32>,
    scan_volts: f32,
    /// The drive that the present brake or boost is for, V.
    braked_volts: f32,
    /// How far beside the resonance to drive to measure the clamped capacitance, Hz.
    probe_hz: f32,
    transducer: Option<Transducer>,
    /// What is being learned of it anew.
    learning: Learning,
    tracker: Tracker,
    /// A resonance that comes back in the middle of the calibration looks like none, or like a broken one: it is made once more.
    calibrates_again: bool,
    online: Online,
    convert: Convert,
    guard: Guard,
    belt: Belt,
    shaper: Shaper,
    burst: Burst,
    edges: Edges,
    phasing: Phasing,
    shape: Shape,
    self_test: SelfTest,
    restraint: Option<Restraint>,
    friction: Option<FrictionSwitch>,
    power_on: PowerOn,
    calibrate: Calibrate,
    scan: Scan,
}

impl Controller {
    /// A block of silence: what plays until the first call has returned.
    pub fn silence(&self) -> DriveBlock {
        DriveBlock::silent(self.phasing.count(), self.samples, self.convert.drive.silence())
    }

    /// One block: what the converters saw, what to play two blocks later, and a report.
    pub fn process(&mut self, orders: &Orders, sense: &SenseBlock, drive: &mut DriveBlock) -> Telemetry {
        let slot = (self.block % LATENCY_BLOCKS as u64) as usize;
        let heard = self.played[slot];
        let (sensed, suspect) = demodulate(&self.convert, sense, &heard.tone);
        let motional_current = self.tracker.motional_current(&sensed, heard.relative);

        self.belt.hear(sense.slow.belt);
        let restrained = self.restrained(orders, sense);
        let orders = restrained.as_ref().unwrap_or(orders);
        let driven = self.driven(orders, sense, &heard, suspect);
        let found = self
            .guard
            .inspect(&self.convert, sense, &sensed, &self.belt, &driven)
            .map(|fault| self.named(fault, &sensed, heard.volts));
        if self.supervisor.judge(orders, found) {
            self.begin();
        }
        let plan = self.plan(orders, sense, &sensed, &heard, motional_current);
        self.supervisor.advance(orders, plan.progress, self.acquisition);

        self.played[slot] = self.play(orders, &plan, drive);
        // An edge takes all the time that there is.
        if self.played[slot].flat {
            self.learn_on();
            self.work_friction();
        }
        self.block += 1;
        self.report(orders, &plan, slot, sensed, motional_current)
    }

    /// How long the edges of a boosted burst take, as they are planned now; `None` where they are not boosted.
    pub fn edge_times(&self) -> Option<EdgeTimes> {
        self.burst.edge_times()
    }

    /// The resonances that the last scan has found, at rising frequencies.
    pub fn resonances(&self) -> &[Resonance] {
        self.scan.roster().listed()
    }

    /// The orders with the gate where a crash, or none, wants it; `None` where no belt is served.
    fn restrained(&mut self, orders: &Orders, sense: &SenseBlock) -> Option<Orders> {
        let restraint = self.restraint.as_mut()?;
        let fresh = self.belt.is_expected().then(|| self.belt.fresh_counts());
        Some(restraint.decide(orders, sense.slow.force, fresh, self.supervisor.mode()))
    }

    /// Writes the codes of a plan, and remembers what they are.
    fn play(&mut self, orders: &Orders, plan: &Plan, drive: &mut DriveBlock) -> Played {
        let mode = self.supervisor.mode();
        let running = mode == Mode::Run;
        let stretch = self.nco.advance(self.sweep.next(running), self.samples);
        let tone = stretch.chord(self.samples);
        let offset_hz = self.sweep.hold.offset_of(tone.word);
        let hz = self.sweep.hold.nominal_hz() + offset_hz;

        let now = (self.block + LATENCY_BLOCKS as u64) * self.samples as u64;
        let louder = self.burst.loudest();
        let envelope = match mode {
            Mode::Idle | Mode::Fault => self.burst.snap(false, &stretch, self.samples),
            Mode::SelfTest | Mode::Scan | Mode::Calibrate | Mode::Clamped => {
                self.burst.snap(plan.gate == Gate::On, &stretch, self.samples)
            }
            // Without a voltage there is no burst: the next one begins at zero.
            Mode::Lock | Mode::Run if plan.volts == 0.0 => self.burst.snap(false, &stretch, self.samples),
            Mode::Lock | Mode::Run => self.burst.envelope(plan.gate, now, &stretch, self.samples, plan.volts),
        };
        let (level, flat) = (envelope.mean(), envelope.is_flat());
        // A brake may be louder than the drive, but not than the limit, whatever has become of the drive since it began.
        let volts = self.amplitude.within(plan.volts, louder);
        let (quadrature, _) = self.phasing.quadrature(orders.quadrature.filter(|_| mode != Mode::Calibrate));
        let lanes = self.phasing.lanes(hz, quadrature);
        let gain = lanes.first().map_or(1.0, |lane| lane.gain);
        let play = Play { scale: &self.convert.drive, lanes, stretch, samples: self.samples, volts, louder, envelope };
        let mut plain = Shape::Sine;
        // An observer locks by a sine, whatever the shape.
        let shaped = mode == Mode::Run || mode == Mode::Lock && !self.tracker.observes();
        let pure = !shaped || matches!(self.shape, Shape::Sine);
        let shape = if shaped { &mut self.shape } else { &mut plain };
        match mode {
            Mode::Idle | Mode::Fault => self.shaper.mute(&play, drive),
            Mode::SelfTest | Mode::Clamped if plan.volts == 0.0 => self.shaper.mute(&play, drive),
            _ => self.shaper.shape(shape, &play, drive),
        }
        let fundamental = shape.fundamental(tone.frequency()).filter(|_| plan.listen == 0);
        drive.listen = plan.listen;
        if self.burst.boosts() {
            self.note(plan.volts, level);
        }
        Played {
            tone,
            relative: hz / self.sweep.hold.nominal_hz(),
            offset_hz,
            detune_hz: if running && self.tracker.tracks() { offset_hz - plan.tracked_hz } else { 0.0 },
            volts,
            audible: fundamental.map(|part| part * gain),
            envelope: level,
            flat,
            pure,
        }
    }
}
