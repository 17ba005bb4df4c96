//! The signal generator: the codes of one block from a plan.

use crate::generate::amplitude::AmplitudeLoop;
use crate::generate::burst::Burst;
use crate::generate::drive_scale::DriveScale;
use crate::generate::nco::{Nco, Stretch};
use crate::generate::phasing::Phasing;
use crate::generate::shape::Shape;
use crate::generate::shaper::{Play, Shaper};
use crate::generate::step::Plan;
use crate::generate::sweep::Sweep;
use crate::generate::sweep::hold::Hold;
use crate::seam::block::{DriveBlock, Gate, LATENCY_BLOCKS, Orders};
use crate::seam::mode::Mode;

/// Record of a written block, for the time when the sense codes of that block arrive.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Played {
    /// Tone, or the chord of a chirp.
    pub(crate) tone: Stretch,
    /// Frequency relative to the nominal one.
    pub(crate) relative: f32,
    /// Frequency as an offset from the nominal one, Hz.
    pub(crate) offset_hz: f32,
    /// Intended offset of the drive from the lock point, Hz.
    pub(crate) detune_hz: f32,
    /// Peak voltage before the envelope, V.
    pub(crate) volts: f32,
    /// Amplitude at the sense channels relative to the voltage: the gain of the connected lane
    /// times the fundamental of the shape. `None` for noise, and for a lane that is being
    /// calibrated.
    pub(crate) audible: Option<f32>,
    /// Mean envelope.
    pub(crate) envelope: f32,
    /// `true` if the envelope was constant.
    pub(crate) flat: bool,
    /// `true` if the drive was a sine.
    pub(crate) pure: bool,
    /// Lane that the sense channels were connected to.
    pub(crate) lane: u8,
}

impl Played {
    /// Creates the record of a block before the first: silence at the held frequency.
    pub(crate) fn at_rest(hold: &Hold) -> Self {
        let tone = Stretch { word: hold.word(), ..Stretch::default() };
        Played { tone, relative: 1.0, flat: true, pure: true, ..Played::default() }
    }

    /// Marks the block as dropped while it played, or before. Only the board knows how much of it
    /// has played.
    #[cold]
    #[inline(never)]
    pub(crate) fn drop_rest(&mut self) {
        self.audible = None;
        self.flat = false;
    }

    /// Returns `true` if the drive was fully ON throughout the block.
    #[inline]
    pub(crate) fn is_full(&self) -> bool {
        self.flat && self.envelope == 1.0 && self.volts > 0.0
    }
}

/// Generator: everything between a plan and the codes. Small parts that every block reads come
/// first.
#[derive(Clone, Debug)]
#[repr(C)]
pub(crate) struct SignalGenerator {
    pub(crate) nco: Nco,
    /// Samples in a block.
    pub(crate) samples: usize,
    pub(crate) sweep: Sweep,
    pub(crate) amplitude: AmplitudeLoop,
    pub(crate) scale: DriveScale,
    pub(crate) shaper: Shaper,
    pub(crate) burst: Burst,
    pub(crate) phasing: Phasing,
    pub(crate) shape: Shape,
    /// `true` if the last block had the configured shape, and not that of a plain sine.
    pub(crate) shaped: bool,
    /// `true` if the drive fades in the next block, because another stage begins with silence.
    pub(crate) fades: bool,
}

impl SignalGenerator {
    /// Returns a block of silence.
    pub(crate) fn silence(&self) -> DriveBlock {
        DriveBlock::silent(self.phasing.count(), self.samples, self.scale.silence())
    }

    /// Returns to the nominal frequency and amplitude.
    pub(crate) fn restart(&mut self) {
        self.fade();
        self.sweep.hold.retune(0.0);
        self.sweep.restart();
        self.amplitude.restart();
        if !self.fades {
            self.burst.restart();
        }
    }

    /// Lets a drive fade in the next block instead of ending at once.
    pub(crate) fn fade(&mut self) {
        self.fades = self.burst.is_open();
    }

    /// Starts the burst schedule at a block.
    pub(crate) fn begin_schedule(&mut self, block: u64) {
        self.burst.begin_schedule(block * self.samples as u64);
    }

    /// Returns the number of the first sample of the block to be written.
    pub(crate) fn now(&self, block: u64) -> u64 {
        (block + LATENCY_BLOCKS as u64) * self.samples as u64
    }

    /// Applies the present trims to the voltage limit, which the lane with the largest gain
    /// determines. Returns the limit, V.
    pub(crate) fn set_loudest(&mut self) -> f32 {
        self.amplitude.set_loudest(self.phasing.loudest())
    }

    /// Writes the codes of a plan, and their record. `observed`: the observer locks, which needs a
    /// sine for any shape.
    #[inline]
    pub(crate) fn play(
        &mut self,
        orders: &Orders,
        plan: &Plan,
        (mode, observed): (Mode, bool),
        block: u64,
        drive: &mut DriveBlock,
        played: &mut Played,
    ) {
        if self.fades || matches!(mode, Mode::Idle | Mode::Fault) {
            return self.rest(orders, plan, mode, drive, played);
        }
        let running = mode == Mode::Run;
        let stretch = self.nco.advance(self.sweep.next(running), self.samples);
        let tone = stretch.chord(self.samples);
        let offset_hz = self.sweep.hold.offset_of(tone.word);
        let hz = self.sweep.hold.nominal_hz() + offset_hz;

        let now = self.now(block);
        let louder = self.burst.loudest();
        let envelope = match mode {
            Mode::SelfTest | Mode::Scan | Mode::Calibrate | Mode::Clamped => {
                let open = plan.gate == Gate::On;
                if mode == Mode::Scan && !open {
                    // A scan begins at full voltage, and therefore at the beginning of a cycle: a
                    // jump would draw a peak of current into the clamped capacitance.
                    self.nco.rewind();
                }
                self.burst.set_envelope_now(open, &stretch, self.samples)
            }
            // Without a voltage there is no burst: the next one begins at zero.
            Mode::Lock | Mode::Run if plan.volts == 0.0 => self.burst.set_envelope_now(false, &stretch, self.samples),
            _ => self.burst.envelope(plan.gate, now, &stretch, self.samples, plan.volts),
        };
        let (level, flat) = (envelope.mean(), envelope.is_flat());
        // A brake may exceed the drive but not the limit, even if the drive has changed since.
        let volts = self.amplitude.limit_volts(plan.volts, louder);
        let (quadrature, _) = self.phasing.quadrature(orders.quadrature.filter(|_| mode != Mode::Calibrate));
        let lanes = self.phasing.lanes(hz, quadrature);
        let gain = lanes.first().map_or(1.0, |lane| lane.gain);
        let play = Play { scale: &self.scale, lanes, stretch, samples: self.samples, volts, louder, envelope };
        let mut plain = Shape::Sine;
        self.shaped = running || mode == Mode::Lock && !observed;
        let pure = !self.shaped || matches!(self.shape, Shape::Sine);
        let shape = if self.shaped { &mut self.shape } else { &mut plain };
        let muted = matches!(mode, Mode::SelfTest | Mode::Clamped) && plan.volts == 0.0;
        let fundamental = if muted {
            self.shaper.mute(&play, drive);
            Some(1.0)
        } else {
            self.shaper.shape(shape, &play, drive)
        };
        drive.listen = plan.listen;
        *played = Played {
            tone,
            relative: hz / self.sweep.hold.nominal_hz(),
            offset_hz,
            detune_hz: plan.tracked_hz.filter(|_| running).map_or(0.0, |tracked_hz| offset_hz - tracked_hz),
            volts,
            audible: fundamental.filter(|_| plan.listen == 0).map(|part| part * gain),
            envelope: level,
            flat,
            pure,
            lane: plan.listen,
        };
    }

    /// Writes silence, after the block in which a stopped drive fades, and the record.
    #[inline(never)]
    fn rest(&mut self, orders: &Orders, plan: &Plan, mode: Mode, drive: &mut DriveBlock, played: &mut Played) {
        let stretch = self.nco.advance(self.sweep.next(false), self.samples);
        let tone = stretch.chord(self.samples);
        let offset_hz = self.sweep.hold.offset_of(tone.word);
        let hz = self.sweep.hold.nominal_hz() + offset_hz;
        let louder = self.burst.loudest();
        let (quadrature, _) = self.phasing.quadrature(orders.quadrature);
        let lanes = self.phasing.lanes(hz, quadrature);
        let gain = lanes.first().map_or(1.0, |lane| lane.gain);
        let begins = core::mem::take(&mut self.fades);
        let fades = (begins || mode == Mode::Idle) && mode != Mode::Fault && self.burst.is_open();
        let volts = if fades { self.shaper.driven() / self.scale.lsb_per_volt() } else { 0.0 };
        let envelope = self.burst.fade_out(fades, &stretch, self.samples);
        let level = envelope.mean();
        let play = Play { scale: &self.scale, lanes, stretch, samples: self.samples, volts, louder, envelope };
        if fades {
            let mut plain = Shape::Sine;
            self.shaper.fade(if self.shaped { &mut self.shape } else { &mut plain }, &play, drive);
        } else {
            self.shaper.mute(&play, drive);
        }
        drive.listen = plan.listen;
        *played = Played {
            tone,
            relative: hz / self.sweep.hold.nominal_hz(),
            offset_hz,
            volts,
            // The block that fades is not measured.
            audible: (!fades && plan.listen == 0).then_some(gain),
            envelope: level,
            flat: !fades,
            pure: !fades,
            lane: plan.listen,
            ..Played::default()
        };
        if begins {
            self.burst.restart();
        }
    }
}
