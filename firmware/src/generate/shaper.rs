//! The shaper: codes from phase, shape, lanes and envelope.
//! `drive(n, lane) = mid + envelope(n) * volts * gain(lane) * shape(phase(n) + offset(lane))`.
//!
//! A plain sine is written directly as codes. Every other waveform is first computed as a wave,
//! sample by sample, and then written.
//!
//! Amplitudes are limited to the range of the converter once a block, so that no code can overflow.
//! The volt-seconds that a burst leaves (from its sampling, its rounding, and the shape of its
//! edges) are counted in codes, and compensated in the silence after it by at most an eighth of the
//! amplitude a sample. Over burst and silence the codes of each lane, relative to mid-code, add up
//! to zero.

mod rows;
mod wave;

use heapless::Vec;

use crate::generate::burst::envelope::{Envelope, Levels};
use crate::generate::drive_scale::DriveScale;
use crate::generate::nco::Stretch;
use crate::generate::phasing::Lane;
use crate::generate::shape::Shape;
use crate::generate::shape::bands::Blend;
use crate::generate::shape::noise::{Dither, Noise};
use crate::generate::shape::sine::{Steady, Steps};
use crate::generate::shape::square;
use crate::generate::shaper::wave::Wave;
use crate::seam::block::{Codes, DriveBlock, MAX_LANES};
use crate::seam::config::Config;

/// Largest compensation of volt-seconds in a sample, codes.
const MAX_PAYBACK_CODES: f32 = 32.0;
/// Largest compensation of volt-seconds in a sample, relative to the amplitude.
const MAX_PAYBACK_REL: f32 = 0.125;
/// Largest amount that is compensated, codes times samples. The sum of rounding over hours of
/// steady drive is not due to a burst.
const MAX_OWED_CODE_SAMPLES: i32 = 1 << 14;
/// Largest amount that is compensated after an edge, half cycles of its largest drive.
const MAX_OWED_HALF_CYCLES: f32 = 2.0;

/// Shaper, which turns phase, envelope and amplitude into the codes of all lanes.
#[derive(Clone, Debug)]
pub struct Shaper {
    dither: Option<Dither>,
    /// Sum of each lane's codes that is still to be compensated, codes times samples.
    owed: [i32; MAX_LANES],
    owed_limit: i32,
    /// Amplitude of the last driven block, codes.
    driven: f32,
    /// Waveform of a block, if it is not a plain sine.
    wave: Wave,
}

/// Input of the shaper for one block.
pub struct Play<'a> {
    /// Scale of the drive converters.
    pub scale: &'a DriveScale,
    /// Lanes, with their offsets and gains.
    pub lanes: &'a Vec<Lane, MAX_LANES>,
    /// Phase over the block.
    pub stretch: Stretch,
    /// Number of samples.
    pub samples: usize,
    /// Peak voltage before the envelope, V.
    pub volts: f32,
    /// Largest value that the envelope may reach; at least one.
    pub louder: f32,
    /// Envelope over the block.
    pub envelope: Envelope<'a>,
}

/// Intended amplitude of the waveform, and the room for it, codes.
#[derive(Clone, Copy)]
struct Size {
    target: f32,
    room: f32,
}

impl Size {
    fn new(play: &Play) -> Self {
        Size { target: play.volts * play.scale.lsb_per_volt(), room: play.scale.headroom() / play.louder }
    }

    /// Returns the amplitude for a gain of one, such that the converter has room for it at the gain
    /// of the lane.
    fn at(&self, gain: f32) -> f32 {
        if self.target * gain > self.room { self.room / gain } else { self.target }
    }
}

impl Shaper {
    /// Builds the configured shaper.
    pub fn build(config: &Config) -> Self {
        Shaper {
            dither: config.drive.dither.then(|| Dither::new(config.drive.seed)),
            owed: [0; MAX_LANES],
            owed_limit: MAX_OWED_CODE_SAMPLES,
            driven: 0.0,
            wave: Wave::default(),
        }
    }

    /// Returns `true` if nothing is left to be compensated.
    pub(crate) fn is_even(&self) -> bool {
        self.owed.iter().all(|&owed| owed == 0)
    }

    /// Returns the amplitude of the last driven block, codes.
    pub(crate) fn driven(&self) -> f32 {
        self.driven
    }

    /// Writes a block of mid-code without compensation, for a drive that must be silent, or is
    /// measured in silence.
    pub(crate) fn mute(&mut self, play: &Play, drive: &mut DriveBlock) {
        self.owed = [0; MAX_LANES];
        fit(play, drive);
        self.silence(play, drive);
        self.driven = 0.0;
    }

    /// Writes one block of codes. Returns the amplitude of its fundamental at a peak of one: `None`
    /// for noise, and one for silence.
    pub fn shape(&mut self, shape: &mut Shape, play: &Play, drive: &mut DriveBlock) -> Option<f32> {
        fit(play, drive);
        if play.volts == 0.0 || play.envelope == Envelope::Flat(0.0) {
            self.silence(play, drive);
            return shape.has_fundamental().then_some(1.0);
        }
        let size = Size::new(play);
        self.driven = size.target;
        if play.louder > 1.0 && !play.envelope.is_flat() {
            self.raise_owed_limit(size.target * play.louder, play.stretch.frequency());
        }
        match shape {
            Shape::Sine if play.stretch.step == 0 => self.steady(size, play, drive),
            // A sine whose frequency changes.
            Shape::Sine => self.read(&square::SINE, size, play, drive),
            Shape::Harmonics(_, bands) => {
                let blend = bands.at(play.stretch.frequency());
                self.read(&blend, size, play, drive);
                return Some(blend.fundamental());
            }
            Shape::Noise(_, noise) => {
                self.noise(noise, size, play, drive);
                return None;
            }
        }
        Some(1.0)
    }

    /// Writes a block in which a drive ends. A second call of `shape` would keep that function out
    /// of the fast memory of a board, where its only caller is.
    pub(crate) fn fade(&mut self, shape: &mut Shape, play: &Play, drive: &mut DriveBlock) {
        fit(play, drive);
        let size = Size::new(play);
        match shape {
            Shape::Sine if play.stretch.step == 0 => self.steady(size, play, drive),
            Shape::Sine => self.swung(size, play, drive),
            Shape::Harmonics(_, bands) => self.read(&bands.at(play.stretch.frequency()), size, play, drive),
            Shape::Noise(_, noise) => self.noise(noise, size, play, drive),
        }
    }

    /// Raises the largest compensation to that of an edge of this amplitude, codes.
    #[inline(never)]
    fn raise_owed_limit(&mut self, amplitude: f32, frequency: f32) {
        let half_cycle = amplitude / (core::f32::consts::PI * frequency);
        self.owed_limit = ((MAX_OWED_HALF_CYCLES * half_cycle).min(1e8) as i32).max(MAX_OWED_CODE_SAMPLES);
    }

    /// Writes a sine of constant frequency. Most blocks are `even` or `edge`, which are separate so
    /// that neither slows the other.
    #[inline(always)]
    fn steady(&mut self, size: Size, play: &Play, drive: &mut DriveBlock) {
        match (&self.dither, play.envelope) {
            _ if play.stretch.word > Steps::MAX_SMALL_WORD => self.swung(size, play, drive),
            (None, Envelope::Flat(1.0)) => self.even(size, play, drive),
            (None, Envelope::Edge(levels)) => self.edge(size, play, drive, levels),
            _ => self.swung(size, play, drive),
        }
    }

    /// Writes a sine under an envelope of one, without dither.
    #[inline(never)]
    fn even(&mut self, size: Size, play: &Play, drive: &mut DriveBlock) {
        self.swing(size, play, drive, rows::even);
    }

    /// Writes a sine under an envelope that varies from sample to sample, without dither.
    #[inline(never)]
    fn edge(&mut self, size: Size, play: &Play, drive: &mut DriveBlock, levels: Levels) {
        // At the largest level, of which the levels are parts.
        let size = Size { target: size.target * levels.loudest, room: size.room * levels.loudest };
        self.swing(size, play, drive, |steps, base, codes| rows::edge(steps, base, levels.parts, codes));
    }

    /// Writes each lane: its own sine, or the opposite of another lane about mid-code.
    #[inline(always)]
    fn swing(&mut self, size: Size, play: &Play, drive: &mut DriveBlock, row: impl Fn(Steps, f32, &mut [u16]) -> i32) {
        let steady = Steady::new(&play.stretch);
        let (mid, base) = (play.scale.silence(), play.scale.rounding_base());
        let silent = i32::from(mid) * play.samples as i32;
        // Sums of the last two lanes, relative to mid-code.
        let mut sums = [0; 2];
        for (n, lane) in play.lanes.iter().enumerate() {
            let Some((before, [codes, ..])) = drive.lanes.split_at_mut_checked(n) else { break };
            let this = match before.iter().nth_back(1).filter(|_| lane.mirrors) {
                Some(other) => {
                    rows::opposite(mid, other, codes);
                    -sums[0]
                }
                None => row(steady.swing(lane.row * size.at(lane.gain)).steps().0, base, codes) - silent,
            };
            sums = [sums[1], this];
            self.owe(n, this);
        }
    }

    /// Writes a sine under any other envelope, or with dither.
    #[inline(never)]
    fn swung(&mut self, size: Size, play: &Play, drive: &mut DriveBlock) {
        // At the largest level, so that no level is above one.
        let size = Size { target: size.target * play.louder, room: size.room * play.louder };
        let steady = Steady::new(&play.stretch);
        for (n, (lane, codes)) in play.lanes.iter().zip(&mut drive.lanes).enumerate() {
            self.wave.swing(&steady.swing(lane.row * size.at(lane.gain)), play.samples);
            self.write(play, Wave::STEPS_PEAK_CODES / play.louder, n, codes);
        }
    }

    /// Writes a waveform from tables.
    #[inline(never)]
    fn read(&mut self, blend: &Blend, size: Size, play: &Play, drive: &mut DriveBlock) {
        for (n, (lane, codes)) in play.lanes.iter().zip(&mut drive.lanes).enumerate() {
            self.wave.read(blend, play.stretch.phases(lane.offset), play.samples);
            self.write(play, size.at(lane.gain) * lane.gain, n, codes);
        }
    }

    #[inline(never)]
    fn noise(&mut self, noise: &mut Noise, size: Size, play: &Play, drive: &mut DriveBlock) {
        self.wave.fill(noise, play.samples);
        for (n, (lane, codes)) in play.lanes.iter().zip(&mut drive.lanes).enumerate() {
            self.write(play, size.at(lane.gain) * lane.gain, n, codes);
        }
    }

    /// Rounds the waveform, with this peak in codes, to the codes of a lane. Amplitudes were
    /// limited before, so that every sum is a code.
    #[inline(never)]
    fn write(&mut self, play: &Play, peak: f32, lane: usize, codes: &mut Codes) {
        let sum = self.wave.write(peak, play.scale.rounding_base(), &play.envelope, self.dither.as_mut(), codes);
        self.owe(lane, sum - i32::from(play.scale.silence()) * play.samples as i32);
    }

    /// Adds the sum of a lane's codes, relative to mid-code, to the amount to be compensated.
    #[inline(always)]
    fn owe(&mut self, lane: usize, sum: i32) {
        // `clamp` could panic, as far as the compiler knows.
        if let Some(owed) = self.owed.get_mut(lane) {
            *owed = (*owed + sum).min(self.owed_limit).max(-self.owed_limit);
        }
    }

    /// Writes mid-code, shifted by at most 32 codes until the DC offset of the preceding drive is
    /// compensated.
    #[inline(never)]
    fn silence(&mut self, play: &Play, drive: &mut DriveBlock) {
        let mid = play.scale.silence();
        let most = (self.driven * MAX_PAYBACK_REL).clamp(1.0, MAX_PAYBACK_CODES) as i32;
        for (codes, owed) in drive.lanes.iter_mut().zip(&mut self.owed) {
            let (fours, rest) = codes.as_chunks_mut::<4>();
            // Written out: a compiler that optimizes for size calls a copy of four here.
            for [first, second, third, fourth] in fours {
                (*first, *second, *third, *fourth) = (mid, mid, mid, mid);
            }
            rest.fill(mid);
            if *owed == 0 {
                continue;
            }
            // The largest compensation as often as it fits, and then the rest.
            let (whole, most) = (owed.unsigned_abs() / most as u32, most * owed.signum());
            let whole = codes.len().min(whole as usize);
            let (all, left) = codes.split_at_mut(whole);
            all.fill((i32::from(mid) - most) as u16);
            *owed -= whole as i32 * most;
            if let Some(code) = left.first_mut() {
                *code = (i32::from(mid) - *owed) as u16;
                *owed = 0;
            }
        }
    }
}

/// Resizes the block to its lanes and samples.
fn fit(play: &Play, drive: &mut DriveBlock) {
    // Neither exceeds the capacity, because the configuration was checked.
    if drive.lanes.len() != play.lanes.len() {
        let _ = drive.lanes.resize_default(play.lanes.len());
    }
    for lane in drive.lanes.iter_mut().filter(|lane| lane.len() != play.samples) {
        let _ = lane.resize_default(play.samples);
    }
}
