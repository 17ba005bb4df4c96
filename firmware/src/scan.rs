//! Acquisition by admittance scan: where is the resonance, and what does the transducer look like?
//!
//! Three passes, each a row of frequencies on which the drive dwells, settles and averages:
//!
//! | pass | span | dwell | takes |
//! |---|---|---|---|
//! | coarse | the whole window, one nominal bandwidth a step | 1.5 nominal time constants | the highest motional conductance |
//! | middle | two nominal bandwidths about it | 5 nominal time constants | a circle fit |
//! | fine | 1.5 identified bandwidths about that | 6 identified time constants | a circle fit: the result |
//!
//! Then it stays on the resonance until the last tone has rung down, so that whoever tracks from there hears one tone only.
//! The nominal Q may be wrong by a factor of two.

use crate::block::LATENCY_BLOCKS;
use crate::config::Config;
use crate::demod::Sensed;
use crate::error::{Error, in_range};
use crate::identify::{CircleFit, Guess, Transducer};
use crate::motional::Motional;
use crate::phasor::Phasor;

/// Points of a pass that is fitted.
const FIT_POINTS: u16 = 15;
/// Fewest and most points of the coarse pass.
const COARSE_POINTS: (f32, f32) = (25.0, 400.0);
/// Blocks averaged at each point of the coarse pass, and of a pass that is fitted. Four times as many halve the noise of the fit.
const COARSE_AVERAGE: u32 = 8;
const FIT_AVERAGE: u32 = 32;
/// Time constants for which the last tone rings down.
const RING_DOWN: f32 = 4.0;
/// The first point of a pass also has to ring up from rest.
const FIRST_POINT_SETTLES: u32 = 3;

/// What the scan wants next.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Step {
    /// Drive at this offset from the nominal frequency, Hz.
    Tune(f32),
    /// The transducer is identified.
    Found(Transducer, Motional),
    /// No resonance in the window.
    NotFound,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Stage {
    Coarse,
    Middle,
    Fine,
    RingDown(Transducer, Motional),
}

/// The scan, in progress.
#[derive(Clone, Debug)]
pub struct Scan {
    nominal_hz: f32,
    nominal: Guess,
    window_hz: f32,
    block_s: f32,
    stage: Stage,
    guess: Guess,
    /// First and last frequency of this pass, as offsets from the nominal one, Hz.
    span_hz: (f32, f32),
    points: u16,
    settle_blocks: u32,
    point: u16,
    blocks: u32,
    sum: Sensed,
    fit: CircleFit,
    best: (f32, f32),
}

impl Scan {
    /// A scan of the configured window.
    pub fn build(config: &Config) -> Result<Self, Error> {
        let tracking = &config.tracking;
        in_range("tracking.span", tracking.span.into(), 1e-4, 0.2)?;
        in_range("tracking.nominal_q", tracking.nominal_q.into(), 2.0, 1e5)?;
        in_range("tracking.nominal_c0_f", tracking.nominal_c0_f.into(), 1e-12, 1e-3)?;
        let nominal_hz = config.drive.frequency_hz;
        let nominal = Guess { hz: nominal_hz, q: tracking.nominal_q, c0_f: tracking.nominal_c0_f };
        let mut scan = Scan {
            nominal_hz,
            nominal,
            window_hz: tracking.span * nominal_hz,
            block_s: f32::from(config.block_samples) / config.sample_hz,
            stage: Stage::Coarse,
            guess: nominal,
            span_hz: (0.0, 0.0),
            points: 0,
            settle_blocks: 0,
            point: 0,
            blocks: 0,
            sum: Sensed::default(),
            fit: CircleFit::new(nominal, 1.0),
            best: (0.0, f32::MIN),
        };
        scan.restart();
        Ok(scan)
    }

    /// Begins again from the coarse pass.
    pub fn restart(&mut self) {
        let bandwidths = 2.0 * self.window_hz * self.nominal.q / self.nominal_hz;
        self.best = (0.0, f32::MIN);
        self.guess = self.nominal;
        self.begin(Stage::Coarse, self.window_hz, (bandwidths + 1.0).clamp(COARSE_POINTS.0, COARSE_POINTS.1) as u16, 1.5);
    }

    /// Takes the phasors of the block just heard and says what to do next.
    pub fn step(&mut self, sensed: &Sensed) -> Step {
        self.blocks += 1;
        if let Stage::RingDown(transducer, motional) = self.stage {
            let over = self.blocks > self.settle_blocks;
            return if over { Step::Found(transducer, motional) } else { Step::Tune(self.offset_hz()) };
        }
        let settle = self.settle_blocks * if self.point == 0 { FIRST_POINT_SETTLES } else { 1 } + LATENCY_BLOCKS as u32;
        if self.blocks > settle {
            self.sum.v += sensed.v;
            self.sum.i += sensed.i;
        }
        let averaged = if self.stage == Stage::Coarse { COARSE_AVERAGE } else { FIT_AVERAGE };
        if self.blocks < settle + averaged {
            return Step::Tune(self.offset_hz());
        }
        self.take_point();
        if self.point < self.points { Step::Tune(self.offset_hz()) } else { self.finish_pass() }
    }

    fn begin(&mut self, stage: Stage, half_span_hz: f32, points: u16, settle_time_constants: f32) {
        let tau_s = self.guess.q / (core::f32::consts::PI * self.guess.hz);
        // A resonance near the edge of the window is looked at from one side.
        let centre_hz = self.guess.hz - self.nominal_hz;
        let inside = |offset_hz: f32| offset_hz.clamp(-self.window_hz, self.window_hz);
        self.span_hz = (inside(centre_hz - half_span_hz), inside(centre_hz + half_span_hz));
        self.stage = stage;
        self.points = points;
        self.settle_blocks = (settle_time_constants * tau_s / self.block_s) as u32 + 1;
        self.point = 0;
        self.blocks = 0;
        self.sum = Sensed::default();
        self.fit = CircleFit::new(self.guess, half_span_hz);
    }

    /// Offset of the present point from the nominal frequency.
    fn offset_hz(&self) -> f32 {
        let part = f32::from(self.point) / f32::from(self.points - 1);
        self.span_hz.0 + part * (self.span_hz.1 - self.span_hz.0)
    }

    fn take_point(&mut self) {
        let offset = self.offset_hz();
        let hz = self.nominal_hz + offset;
        if self.sum.v.norm_sqr() > 0.0 {
            let y: Phasor = self.sum.i / self.sum.v;
            if y.re > self.best.1 {
                self.best = (hz, y.re);
            }
            if self.stage != Stage::Coarse {
                self.fit.add(hz, y);
            }
        }
        self.point += 1;
        self.blocks = 0;
        self.sum = Sensed::default();
    }

    fn finish_pass(&mut self) -> Step {
        if self.stage == Stage::Coarse {
            self.guess.hz = self.best.0;
            self.begin(Stage::Middle, 2.0 * self.guess.hz / self.guess.q, FIT_POINTS, 5.0);
            return Step::Tune(self.offset_hz());
        }
        let found = self.fit.solve(self.nominal_hz);
        let in_window = |t: &Transducer| (t.series_resonance_hz - self.nominal_hz).abs() <= self.window_hz;
        match found.filter(|(transducer, _)| in_window(transducer)) {
            None => Step::NotFound,
            Some((transducer, motional)) => {
                self.guess = Guess { hz: transducer.series_resonance_hz, q: transducer.q, c0_f: transducer.c0_f };
                if self.stage == Stage::Fine {
                    self.begin(Stage::RingDown(transducer, motional), 0.0, FIT_POINTS, RING_DOWN);
                } else {
                    self.begin(Stage::Fine, 1.5 * self.guess.hz / self.guess.q, FIT_POINTS, 6.0);
                }
                Step::Tune(self.offset_hz())
            }
        }
    }
}
