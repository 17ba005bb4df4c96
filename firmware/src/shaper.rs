//! The shaper: phase, shape, lanes and envelope to codes.
//! `drive(n, lane) = mid + envelope(n) * volts * gain(lane) * shape(phase(n) + offset(lane))`.
//!
//! Amplitudes are limited here to what the converter has, once a block, so that no code can run over. What a burst leaves in volt-seconds
//! (its sampling, its rounding, the shape of its edges) is counted in codes and paid back in the silence after it, an eighth of the
//! amplitude a sample at most: over burst and silence the codes of every lane add up to nothing.

use heapless::Vec;

use crate::block::{Codes, DriveBlock, MAX_BLOCK_SAMPLES, MAX_LANES};
use crate::burst::Envelope;
use crate::config::Config;
use crate::convert::DriveScale;
use crate::nco::Stretch;
use crate::phasing::Lane;
use crate::phasor::Phasor;
use crate::shape::Shape;
use crate::shape::bands::Blend;
use crate::shape::noise::Dither;
use crate::shape::sine::{self, Steady};

/// The most that is paid back in a sample: codes, and a part of the amplitude.
const PAYBACK: (f32, f32) = (32.0, 0.125);
/// The most that is ever owed, codes times samples, or that many half cycles of the loudest drive of an edge, if that is more: what rounding adds up
/// over hours of steady drive is no volt-second of a burst.
const MOST_OWED: (i32, f32) = (1 << 14, 2.0);

/// The shaper.
#[derive(Clone, Debug)]
pub struct Shaper {
    dither: Option<Dither>,
    /// What each lane has played too much since it was last even, codes times samples.
    owed: [i32; MAX_LANES],
    most_owed: i32,
    /// The most that is paid back in a sample, codes.
    payback: i32,
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
    /// Peak voltage before the envelope, V, and how many times louder the envelope may get.
    pub volts: f32,
    /// At least one.
    pub louder: f32,
    /// The envelope.
    pub envelope: Envelope<'a>,
}

/// How large the waveform may be, codes.
#[derive(Clone, Copy)]
struct Size {
    wanted: f32,
    room: f32,
}

impl Size {
    fn of(play: &Play) -> Self {
        Size { wanted: play.volts * play.scale.lsb_per_volt(), room: play.scale.headroom() / play.louder }
    }

    /// For a lane's gain of one; no more than the converter has room for at the lane's own gain.
    fn at(&self, gain: f32) -> f32 {
        if self.wanted * gain > self.room { self.room / gain } else { self.wanted }
    }
}

impl Shaper {
    /// The configured shaper.
    pub fn build(config: &Config) -> Self {
        Shaper {
            dither: config.drive.dither.then(|| Dither::new(config.drive.seed)),
            owed: [0; MAX_LANES],
            most_owed: MOST_OWED.0,
            payback: 0,
        }
    }

    /// Whether nothing is owed.
    pub fn is_even(&self) -> bool {
        self.owed.iter().all(|&owed| owed == 0)
    }

    /// A block of mid-code, whatever is owed: for a drive that must be silent, or is listened to in silence.
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
        let (size, (codes, part)) = (Size::of(play), PAYBACK);
        self.payback = (size.wanted * part).clamp(1.0, codes) as i32;
        let stretch = &play.stretch;
        if play.louder > 1.0 && !play.envelope.is_flat() {
            let half_cycle = size.wanted * play.louder / (core::f32::consts::PI * stretch.frequency());
            self.most_owed = ((MOST_OWED.1 * half_cycle).min(1e8) as i32).max(MOST_OWED.0);
        }
        let each = play.lanes.iter().zip(&mut drive.lanes).enumerate();
        match shape {
            Shape::Sine if stretch.step == 0 => {
                let steady = Steady::new(stretch);
                each.for_each(|(n, (lane, codes))| {
                    let mut swing = steady.swing(lane.row * size.at(lane.gain));
                    self.write(n, play, codes, || swing.take());
                });
            }
            Shape::Sine => {
                // One pair a sample, for all lanes.
                let (mut pairs, mut phases) = ([Phasor::default(); MAX_BLOCK_SAMPLES], stretch.phases(0));
                pairs.iter_mut().take(play.samples).for_each(|z| *z = sine::rotation(u64::from(phases.take()) << 32));
                each.for_each(|(n, (lane, codes))| {
                    let (row, mut pairs) = (lane.row * size.at(lane.gain), pairs.iter());
                    self.write(n, play, codes, || pairs.next().map_or(0.0, |z| z.im * row.re + z.re * row.im));
                });
            }
            Shape::Harmonics(_, bands) => {
                let Blend { lower, upper, weight } = bands.at(stretch.frequency());
                each.for_each(|(n, (lane, codes))| {
                    let (peak, mut phases) = (size.at(lane.gain) * lane.gain, stretch.phases(lane.offset));
                    if weight == 1.0 {
                        return self.write(n, play, codes, || peak * upper.at(phases.take()));
                    }
                    self.write(n, play, codes, || {
                        let phase = phases.take();
                        let (low, high) = (lower.at(phase), upper.at(phase));
                        peak * (low + weight * (high - low))
                    });
                });
            }
            Shape::Noise(_, noise) => {
                let mut wave = [0.0; MAX_BLOCK_SAMPLES];
                wave.iter_mut().take(play.samples).for_each(|value| *value = noise.take());
                each.for_each(|(n, (lane, codes))| {
                    let (peak, mut values) = (size.at(lane.gain) * lane.gain, wave.iter());
                    self.write(n, play, codes, || peak * values.next().copied().unwrap_or(0.0));
                });
            }
        }
    }

    /// Rounds a waveform to the codes of a lane. Amplitudes are limited where they are made, so that every sum is a code.
    #[inline(always)]
    fn write(&mut self, lane: usize, play: &Play, codes: &mut Codes, mut next: impl FnMut() -> f32) {
        let base = play.scale.rounding_base();
        let mut sum = 0;
        let mut put = |place: &mut u16, value: f32| {
            let code = (base + value) as i32;
            sum += code;
            *place = code as u16;
        };
        match (&mut self.dither, play.envelope) {
            (None, Envelope::Flat(1.0)) => {
                // Two by two: most of the time is spent here.
                let (pairs, rest) = codes.as_chunks_mut::<2>();
                for [first, second] in pairs {
                    put(first, next());
                    put(second, next());
                }
                rest.iter_mut().for_each(|place| put(place, next()));
            }
            (None, Envelope::Flat(level)) => codes.iter_mut().for_each(|place| put(place, level * next())),
            (None, Envelope::Edge(levels)) => codes.iter_mut().zip(levels).for_each(|(place, level)| put(place, level * next())),
            (Some(dither), Envelope::Flat(level)) => {
                codes.iter_mut().for_each(|place| put(place, level * next() + dither.take()));
            }
            (Some(dither), Envelope::Edge(levels)) => codes.iter_mut().zip(levels).for_each(|(place, level)| {
                // Silence is silent.
                let dithered = if *level == 0.0 { 0.0 } else { dither.take() };
                put(place, level * next() + dithered);
            }),
        }
        let silent = i32::from(play.scale.silence()) * play.samples as i32;
        // `clamp` could panic, for all that the compiler knows.
        self.owed[lane] = (self.owed[lane] + (sum - silent)).min(self.most_owed).max(-self.most_owed);
    }

    /// Mid-code, but for what is owed.
    fn silence(&mut self, play: &Play, drive: &mut DriveBlock) {
        let (mid, most) = (play.scale.silence(), self.payback);
        for (codes, owed) in drive.lanes.iter_mut().zip(&mut self.owed) {
            codes.fill(mid);
            for code in codes {
                if *owed == 0 {
                    break;
                }
                let back = (*owed).clamp(-most, most);
                *owed -= back;
                *code = (i32::from(mid) - back) as u16;
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
