//! The shaper: phase, shape, lanes and envelope to codes.
//! `drive(n, lane) = mid + envelope(n) * volts * gain(lane) * shape(phase(n) + offset(lane))`.
//!
//! A plain sine is written as it is swung. Whatever else is played is put down as a wave first, sample by sample, and then written.
//!
//! Amplitudes are limited here to what the converter has, once a block, so that no code can run over. What a burst leaves in volt-seconds
//! (its sampling, its rounding, the shape of its edges) is counted in codes and paid back in the silence after it, an eighth of the
//! amplitude a sample at most: over burst and silence the codes of every lane add up to nothing.

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

/// The most that is paid back in a sample: codes, and a part of the amplitude.
const PAYBACK: (f32, f32) = (32.0, 0.125);
/// The most that is ever owed, codes times samples, or that many half cycles of the largest drive of an edge, if that is more: what rounding adds up
/// over hours of steady drive is no volt-second of a burst.
const MOST_OWED: (i32, f32) = (1 << 14, 2.0);

/// The shaper: it turns phase, envelope and amplitude into the codes of all lanes.
#[derive(Clone, Debug)]
pub struct Shaper {
    dither: Option<Dither>,
    /// What each lane has played too much since it was last even, codes times samples.
    owed: [i32; MAX_LANES],
    most_owed: i32,
    /// Amplitude of the last block that was driven, codes.
    driven: f32,
    /// What a block plays, where it is no plain sine.
    wave: Wave,
}

/// What a block is to play.
pub struct Play<'a> {
    /// Scale of the drive converters.
    pub scale: &'a DriveScale,
    /// The lanes, with their offsets and gains.
    pub lanes: &'a Vec<Lane, MAX_LANES>,
    /// The phase over the block.
    pub stretch: Stretch,
    /// Number of samples.
    pub samples: usize,
    /// Peak voltage before the envelope, V, and how many times louder the envelope may get.
    pub volts: f32,
    /// Largest ratio of the envelope to one; at least one.
    pub louder: f32,
    /// The envelope over the block.
    pub envelope: Envelope<'a>,
}

/// How large the waveform may be, codes.
#[derive(Clone, Copy)]
struct Size {
    target: f32,
    room: f32,
}

impl Size {
    fn of(play: &Play) -> Self {
        Size { target: play.volts * play.scale.lsb_per_volt(), room: play.scale.headroom() / play.louder }
    }

    /// For a lane's gain of one; no more than the converter has room for at the lane's own gain.
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
            most_owed: MOST_OWED.0,
            driven: 0.0,
            wave: Wave::default(),
        }
    }

    /// Whether nothing is owed.
    pub(crate) fn is_even(&self) -> bool {
        self.owed.iter().all(|&owed| owed == 0)
    }

    /// A block of mid-code, whatever is owed: for a drive that must be silent, or is listened to in silence.
    pub(crate) fn mute(&mut self, play: &Play, drive: &mut DriveBlock) {
        self.owed = [0; MAX_LANES];
        fit(play, drive);
        self.silence(play, drive);
    }

    /// Writes one block of codes. Returns the amplitude of its fundamental, of a peak of one; a noise has none, and of silence it is one.
    pub fn shape(&mut self, shape: &mut Shape, play: &Play, drive: &mut DriveBlock) -> Option<f32> {
        fit(play, drive);
        if play.volts == 0.0 || play.envelope == Envelope::Flat(0.0) {
            self.silence(play, drive);
            return shape.has_fundamental().then_some(1.0);
        }
        let size = Size::of(play);
        self.driven = size.target;
        if play.louder > 1.0 && !play.envelope.is_flat() {
            self.let_owe(size.target * play.louder, play.stretch.frequency());
        }
        match shape {
            Shape::Sine if play.stretch.step == 0 => self.steady(size, play, drive),
            // A sine whose frequency moves.
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

    /// Lets as much be owed as an edge of this amplitude, codes, may leave.
    #[inline(never)]
    fn let_owe(&mut self, amplitude: f32, frequency: f32) {
        let half_cycle = amplitude / (core::f32::consts::PI * frequency);
        self.most_owed = ((MOST_OWED.1 * half_cycle).min(1e8) as i32).max(MOST_OWED.0);
    }

    /// A sine of constant frequency. Most blocks are one of the first two, which are separate so that neither costs the other time.
    fn steady(&mut self, size: Size, play: &Play, drive: &mut DriveBlock) {
        match (&self.dither, play.envelope) {
            _ if play.stretch.word > Steps::HIGHEST => self.swung(size, play, drive),
            (None, Envelope::Flat(1.0)) => self.even(size, play, drive),
            (None, Envelope::Edge(levels)) => self.edge(size, play, drive, levels),
            _ => self.swung(size, play, drive),
        }
    }

    /// Under an envelope of one, without a dither.
    #[inline(never)]
    fn even(&mut self, size: Size, play: &Play, drive: &mut DriveBlock) {
        self.swing(size, play, drive, rows::even);
    }

    /// Under an envelope that differs from sample to sample, without a dither.
    #[inline(never)]
    fn edge(&mut self, size: Size, play: &Play, drive: &mut DriveBlock, levels: Levels) {
        // As loud as it may get, of which the levels are parts.
        let size = Size { target: size.target * levels.loudest, room: size.room * levels.loudest };
        self.swing(size, play, drive, |steps, base, codes| rows::edge(steps, base, levels.parts, codes));
    }

    /// Writes each lane's swing, or that of the lane that it is the opposite of, about mid-code.
    #[inline(always)]
    fn swing(&mut self, size: Size, play: &Play, drive: &mut DriveBlock, row: impl Fn(Steps, f32, &mut [u16]) -> i32) {
        let steady = Steady::new(&play.stretch);
        let (mid, base) = (play.scale.silence(), play.scale.rounding_base());
        let silent = i32::from(mid) * play.samples as i32;
        // Of the last two lanes.
        let mut beside = [0; 2];
        for (n, lane) in play.lanes.iter().enumerate() {
            let Some((before, [codes, ..])) = drive.lanes.split_at_mut_checked(n) else { break };
            let this = match before.iter().nth_back(1).filter(|_| lane.mirrors) {
                Some(other) => {
                    rows::opposite(mid, other, codes);
                    -beside[0]
                }
                None => row(steady.swing(lane.row * size.at(lane.gain)).steps().0, base, codes) - silent,
            };
            beside = [beside[1], this];
            self.owe(n, this);
        }
    }

    /// A sine under any other envelope, or with a dither.
    #[inline(never)]
    fn swung(&mut self, size: Size, play: &Play, drive: &mut DriveBlock) {
        // As loud as it may get, so that no level is more than one.
        let size = Size { target: size.target * play.louder, room: size.room * play.louder };
        let steady = Steady::new(&play.stretch);
        for (n, (lane, codes)) in play.lanes.iter().zip(&mut drive.lanes).enumerate() {
            self.wave.swing(&steady.swing(lane.row * size.at(lane.gain)), play.samples);
            self.write(play, Wave::OF_STEPS / play.louder, n, codes);
        }
    }

    /// What tables hold.
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

    /// Rounds the waveform, of this peak in codes, to the codes of a lane. Amplitudes are limited where they are made, so that every sum is a code.
    #[inline(never)]
    fn write(&mut self, play: &Play, peak: f32, lane: usize, codes: &mut Codes) {
        let sum = self.wave.write(peak, play.scale.rounding_base(), &play.envelope, self.dither.as_mut(), codes);
        self.owe(lane, sum - i32::from(play.scale.silence()) * play.samples as i32);
    }

    /// Adds what a lane has played beside mid-code to what it owes.
    #[inline(always)]
    fn owe(&mut self, lane: usize, beside: i32) {
        // `clamp` could panic, for all that the compiler knows.
        if let Some(owed) = self.owed.get_mut(lane) {
            *owed = (*owed + beside).min(self.most_owed).max(-self.most_owed);
        }
    }

    /// Mid-code, but for what is owed.
    #[inline(never)]
    fn silence(&mut self, play: &Play, drive: &mut DriveBlock) {
        let (mid, (codes, part)) = (play.scale.silence(), PAYBACK);
        let most = (self.driven * part).clamp(1.0, codes) as i32;
        for (codes, owed) in drive.lanes.iter_mut().zip(&mut self.owed) {
            let (fours, rest) = codes.as_chunks_mut::<4>();
            // Written out: a compiler that saves code calls a copy of four here.
            for [first, second, third, fourth] in fours {
                (*first, *second, *third, *fourth) = (mid, mid, mid, mid);
            }
            rest.fill(mid);
            if *owed == 0 {
                continue;
            }
            // By the most, as often as that goes, and then what is left.
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

/// Gives the block its lanes and samples.
fn fit(play: &Play, drive: &mut DriveBlock) {
    // There are never more of either than there is room for: the configuration was checked.
    if drive.lanes.len() != play.lanes.len() {
        let _ = drive.lanes.resize_default(play.lanes.len());
    }
    for lane in drive.lanes.iter_mut().filter(|lane| lane.len() != play.samples) {
        let _ = lane.resize_default(play.samples);
    }
}
