//! The shaper: phase, shape, lanes and envelope to codes.
//! `drive(n, lane) = mid + envelope(n) * volts * gain(lane) * shape(phase(n) + offset(lane))`.
//!
//! Amplitudes are limited here to what the converter has, once a block, so that no code can run over. What a burst leaves in volt-seconds
//! (its sampling, its rounding, the shape of its edges) is counted in codes and paid back in the silence after it, a small part of the
//! amplitude a sample: over burst and silence the codes of every lane add up to nothing.

use heapless::Vec;

use crate::block::{Codes, DriveBlock, MAX_BLOCK_SAMPLES, MAX_LANES};
use crate::burst::Envelope;
use crate::config::Config;
use crate::convert::DriveScale;
use crate::nco::{Stretch, cycles_per_sample};
use crate::phasing::Lane;
use crate::phasor::Phasor;
use crate::shape::Shape;
use crate::shape::bands::{Bands, Blend};
use crate::shape::noise::Dither;
use crate::shape::sine::Rotor;

/// The most that is paid back in a sample, codes; no more than the converter has.
const PAYBACK: f32 = 32.0;

/// A block of a waveform, in codes about zero.
type Wave = [f32; MAX_BLOCK_SAMPLES];

/// The shaper.
#[derive(Clone, Debug)]
pub struct Shaper {
    dither: Option<Dither>,
    /// What each lane has played too much since it was last even, codes times samples.
    owed: [i32; MAX_LANES],
}

/// What is to be played.
pub struct Play<'a> {
    /// The converter.
    pub scale: &'a DriveScale,
    /// The lanes.
    pub lanes: &'a Vec<Lane, MAX_LANES>,
    /// The phase.
    pub stretch: Stretch,
    /// Samples.
    pub samples: usize,
    /// Peak voltage before the envelope, V.
    pub volts: f32,
    /// The envelope.
    pub envelope: Envelope<'a>,
}

impl Play<'_> {
    /// Peak of a lane of this gain before its gain, codes: no more than the converter has.
    fn peak(&self, gain: f32) -> f32 {
        let (codes, room) = (self.volts * self.scale.lsb_per_volt(), self.scale.headroom());
        if codes * gain > room { room / gain } else { codes }
    }

    /// A block of a waveform, times the envelope.
    fn wave(&self, mut at: impl FnMut(usize) -> f32) -> Wave {
        let mut wave = [0.0; MAX_BLOCK_SAMPLES];
        let level = |n: usize| match self.envelope {
            Envelope::Flat(level) => level,
            Envelope::Edge(levels) => levels.get(n).copied().unwrap_or(0.0),
        };
        wave.iter_mut().take(self.samples).enumerate().for_each(|(n, value)| *value = at(n) * level(n));
        wave
    }
}

impl Shaper {
    /// The configured shaper.
    pub fn build(config: &Config) -> Self {
        Shaper { dither: config.drive.dither.then(|| Dither::new(config.drive.seed)), owed: [0; MAX_LANES] }
    }

    /// A block of mid-code, whatever is owed: for a drive that must be silent.
    pub fn mute(&mut self, play: &Play, drive: &mut DriveBlock) {
        self.owed = [0; MAX_LANES];
        fit(play, drive);
        self.silence(play, drive);
    }

    /// Writes one block of codes.
    pub fn shape(&mut self, shape: &mut Shape, play: &Play, drive: &mut DriveBlock) {
        fit(play, drive);
        if play.volts == 0.0 || play.envelope == Envelope::Flat(0.0) {
            return self.silence(play, drive);
        }
        match shape {
            Shape::Sine => match (&mut *drive.lanes, play.envelope, &self.dither) {
                ([one], Envelope::Flat(1.0), None) => self.sines(play, [one]),
                ([one, two], Envelope::Flat(1.0), None) => self.sines(play, [one, two]),
                ([one, two, three], Envelope::Flat(1.0), None) => self.sines(play, [one, two, three]),
                ([one, two, three, four], Envelope::Flat(1.0), None) => self.sines(play, [one, two, three, four]),
                (lanes, ..) => self.sine_by_sine(play, lanes),
            },
            Shape::Harmonics(bands) => self.harmonics(bands, play, &mut drive.lanes),
            Shape::Noise(noise) => {
                let wave = play.wave(|_| noise.next());
                for (n, lane) in play.lanes.iter().enumerate() {
                    let peak = play.peak(lane.gain) * lane.gain;
                    self.write(n, &wave.map(|value| peak * value), play, &mut drive.lanes[n]);
                }
            }
        }
    }

    /// Steady sines, all lanes at once: two products a lane and sample.
    #[inline]
    fn sines<const LANES: usize>(&mut self, play: &Play, lanes: [&mut Codes; LANES]) {
        let rows: [Phasor; LANES] = core::array::from_fn(|n| play.lanes[n].row * play.peak(play.lanes[n].gain));
        let mut sums = [0; LANES];
        let mut codes = lanes.map(|lane| lane.iter_mut());
        let base = play.scale.rounding_base();
        Rotor::new(&play.stretch).each(play.samples, |z| {
            for lane in 0..LANES {
                // The amplitude leaves room at both ends, so that the code is one.
                let code = (base + z.im * rows[lane].re + z.re * rows[lane].im) as i32;
                sums[lane] += code;
                if let Some(place) = codes[lane].next() {
                    *place = code as u16;
                }
            }
        });
        let silent = i32::from(play.scale.silence()) * play.samples as i32;
        for (owed, sum) in self.owed.iter_mut().zip(sums) {
            *owed = owed.wrapping_add(sum - silent);
        }
    }

    /// Sines at an edge, or with dither.
    fn sine_by_sine(&mut self, play: &Play, drive: &mut [Codes]) {
        let mut pairs = [Phasor::default(); MAX_BLOCK_SAMPLES];
        let mut places = pairs.iter_mut();
        Rotor::new(&play.stretch).each(play.samples, |z| {
            if let Some(place) = places.next() {
                *place = z;
            }
        });
        for (n, lane) in play.lanes.iter().enumerate() {
            let row = lane.row * play.peak(lane.gain);
            self.write(n, &play.wave(|n| pairs[n].im * row.re + pairs[n].re * row.im), play, &mut drive[n]);
        }
    }

    fn harmonics(&mut self, bands: &Bands, play: &Play, drive: &mut [Codes]) {
        let Blend { lower, upper, weight } = bands.at(cycles_per_sample(play.stretch.word) as f32);
        for (n, lane) in play.lanes.iter().enumerate() {
            let peak = play.peak(lane.gain) * lane.gain;
            let phase = |n: usize| ((play.stretch.phase_at(n) >> 32) as u32).wrapping_add(lane.offset);
            let wave = match weight {
                1.0 => play.wave(|n| peak * upper.at(phase(n))),
                _ => play.wave(|n| {
                    let (low, high) = (lower.at(phase(n)), upper.at(phase(n)));
                    peak * (low + weight * (high - low))
                }),
            };
            self.write(n, &wave, play, &mut drive[n]);
        }
    }

    /// Rounds a waveform to the codes of a lane.
    fn write(&mut self, lane: usize, wave: &Wave, play: &Play, codes: &mut Codes) {
        let silent = i32::from(play.scale.silence());
        let mut sum = 0;
        for (code, value) in codes.iter_mut().zip(wave) {
            let dither = self.dither.as_mut().map_or(0.0, Dither::next);
            *code = play.scale.code(value + dither);
            sum += i32::from(*code) - silent;
        }
        self.owed[lane] = self.owed[lane].wrapping_add(sum);
    }

    /// Mid-code, but for what is owed.
    fn silence(&mut self, play: &Play, drive: &mut DriveBlock) {
        let (mid, most) = (i32::from(play.scale.silence()), play.scale.headroom().min(PAYBACK) as i32);
        for (codes, owed) in drive.lanes.iter_mut().zip(&mut self.owed) {
            for code in codes {
                let back = (*owed).clamp(-most, most);
                *owed -= back;
                *code = (mid - back) as u16;
            }
        }
    }
}

/// Gives the block its lanes and samples.
fn fit(play: &Play, drive: &mut DriveBlock) {
    // There are never more of either than there is room for: the configuration was checked.
    let _ = drive.lanes.resize_default(play.lanes.len());
    for lane in &mut drive.lanes {
        let _ = lane.resize_default(play.samples);
    }
}
