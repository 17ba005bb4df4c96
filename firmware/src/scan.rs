//! Acquisition: where is the resonance, and what does the transducer look like? By sweeps in which nothing has to settle.
//!
//! | stage | what is driven | for |
//! |---|---|---|
//! | window | a sweep over the window and a tenth more, in 8 to 16 ms | its [spectrum](spectrum) |
//! | search | the middle of the window | [all resonances](crate::identify::mode_search), one line of the spectrum a block |
//! | fine | sweeps over three bandwidths about the [wanted](crate::identify::choice) one, as often as the deviations require | a spectrum, and a fit: the result |
//! | ring-down | the resonance | until what the sweep has left no longer turns the phase, so that whoever tracks from there hears one tone only |
//!
//! A window that is too wide for the lines of one spectrum is swept and searched part by part. The nominal Q may be wrong by a factor of
//! four.

pub mod baseband;
#[cfg(test)]
pub mod bench;
pub mod pass;
pub mod spectrum;

use heapless::Vec;

use crate::block::{LATENCY_BLOCKS, SenseBlock};
use crate::config::Config;
use crate::convert::Convert;
use crate::demod::Sensed;
use crate::error::{Error, in_range};
use crate::identify::choice::Choice;
use crate::identify::mode_search::{ModeSearch, Told};
use crate::identify::pole_fit::{Circuit, Pole};
use crate::identify::{Deviations, Listed, MOST_MODES, Resonance, Resonances, Transducer};
use crate::motional::Motional;
use crate::phasor::magnitude;
use crate::scan::baseband::Baseband;
use crate::scan::pass::Pass;
use crate::scan::spectrum::Spectrum;
use crate::supervisor::Fault;
use crate::sweep::hold::Hold;

/// How far the sweep goes over the ends of the window, as a part of it: what stands there is seen, and not taken for something inside.
const MARGIN: f32 = 0.1;
/// Shortest and longest sweep of the window, and of the fine pass, s.
const WINDOW_S: (f32, f32) = (8e-3, 16e-3);
const FINE_S: (f32, f32) = (4e-3, 20e-3);
/// Width of the fine pass in bandwidths of the resonance.
const FINE_BANDWIDTHS: f32 = 3.0;
/// The deviation of the resonance that is wanted, in bandwidths, or in parts of the frequency if that is more; and the longest fine pass, s.
const WANTED: (f32, f32) = (1e-4, 5e-7);
const LONGEST_S: f32 = 0.04;
/// Blocks that are heard before a sweep's own: the latency, and the rising half of the first triangle.
const BEFORE: u32 = LATENCY_BLOCKS as u32 + 1;
/// Time constants after which the sweep has certainly rung down.
const RING_DOWN: f32 = 4.0;
/// It has rung down once the motional phase is within so many radians for so many blocks.
const IN_PHASE: (f32, u32) = (0.01, 8);

/// What the scan wants next.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Step {
    /// Drive at this offset from the nominal frequency, Hz.
    Tune(f32),
    /// The transducer is identified.
    Found(Transducer, Motional),
    /// No resonance in the window, or not the one that is wanted.
    Failed(Fault),
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Stage {
    /// Of this part of the window.
    Window(u32),
    Search(u32),
    Fine,
    Fit,
    RingDown(Transducer, Motional),
}

/// The scan, in progress.
#[derive(Clone, Debug)]
pub struct Scan {
    told: Told,
    /// The clamped capacitance, as told.
    bare: Circuit,
    nominal_hz: f32,
    choice: Choice,
    window_hz: f32,
    parts: u32,
    block_s: f32,
    block_samples: u32,
    hold: Hold,
    stage: Stage,
    pass: Pass,
    /// Blocks of this stage, and since the last sweep ended.
    blocks: u32,
    still_blocks: u32,
    in_phase: u32,
    baseband: Baseband,
    spectrum: Spectrum,
    search: ModeSearch,
    /// At rising frequencies.
    found: Vec<(Pole, Deviations), MOST_MODES>,
    listed: Resonances,
    chosen: usize,
}

impl Scan {
    /// A scan of the configured window.
    pub fn build(config: &Config) -> Result<Self, Error> {
        let tracking = &config.tracking;
        in_range("tracking.span", tracking.span.into(), 1e-4, 0.2)?;
        in_range("tracking.nominal_q", tracking.nominal_q.into(), 2.0, 1e5)?;
        in_range("tracking.nominal_c0_f", tracking.nominal_c0_f.into(), 1e-12, 1e-3)?;
        if let Some(lm_h) = tracking.nominal_lm_h {
            in_range("tracking.nominal_lm_h", lm_h.into(), 1e-9, 1e6)?;
        }
        let nominal_hz = config.drive.frequency_hz;
        let told = Told { steps: (config.front_end.volt_per_lsb, config.front_end.ampere_per_lsb), q: tracking.nominal_q };
        let bare = Circuit::bare(nominal_hz, tracking.nominal_c0_f);
        let block_s = f32::from(config.block_samples) / config.sample_hz;
        let window_hz = tracking.span * nominal_hz;
        let reach_hz = window_hz * (1.0 + MARGIN);
        let whole = Pass::between(-reach_hz, reach_hz, WINDOW_S, block_s);
        let parts = if whole.width_hz < 1.99 * reach_hz {
            // Neighbours overlap by as much as the sweep goes over the ends.
            (2.0 * reach_hz * (1.0 + MARGIN) / whole.width_hz) as u32 + 1
        } else {
            1
        };
        let spectrum = whole.spectrum(block_s);
        let mut scan = Scan {
            told,
            search: ModeSearch::new(&told, bare.clone(), 1, 1),
            bare,
            nominal_hz,
            choice: Choice { window_hz: (nominal_hz, window_hz), nominal_lm_h: tracking.nominal_lm_h },
            window_hz,
            parts,
            block_s,
            block_samples: config.block_samples.into(),
            hold: Hold::build(nominal_hz, config.sample_hz)?,
            stage: Stage::Window(0),
            pass: whole,
            blocks: 0,
            still_blocks: 0,
            in_phase: 0,
            baseband: Baseband::default(),
            spectrum,
            found: Vec::new(),
            listed: Resonances::new(),
            chosen: 0,
        };
        scan.restart();
        Ok(scan)
    }

    /// Begins again from the window.
    pub fn restart(&mut self) {
        self.found.clear();
        self.listed.clear();
        self.begin_part(0);
    }

    /// The resonances found by the last scan, at rising frequencies.
    pub fn resonances(&self) -> &[Resonance] {
        &self.listed
    }

    /// One of them, each in the turn of a block.
    pub fn listed(&self, block: usize) -> Option<Listed> {
        let place = block % MOST_MODES % self.listed.len().max(1);
        let resonance = *self.listed.get(place)?;
        Some(Listed { place: place as u8, of: self.listed.len() as u8, resonance })
    }

    /// Takes the block just heard and says what to do next.
    pub fn step(&mut self, convert: &Convert, sense: &SenseBlock, sensed: &Sensed) -> Step {
        self.blocks += 1;
        self.still_blocks += 1;
        match self.stage {
            Stage::Window(part) => {
                if self.sweep(convert, sense) {
                    let (blocks, samples) = self.heard();
                    self.search = ModeSearch::new(&self.told, self.bare.clone(), blocks, samples);
                    self.begin(Stage::Search(part));
                }
                self.tune()
            }
            Stage::Search(part) => {
                if !self.search.step(&self.spectrum) {
                    return self.tune();
                }
                self.take_part(part);
                if part + 1 < self.parts {
                    self.begin_part(part + 1);
                    return self.tune();
                }
                self.choose()
            }
            Stage::Fine => {
                if self.sweep(convert, sense) {
                    self.begin_fit();
                }
                self.tune()
            }
            Stage::Fit => {
                if self.search.step(&self.spectrum) {
                    return self.take_fit();
                }
                self.tune()
            }
            Stage::RingDown(transducer, motional) => self.ring_down(sensed, transducer, motional),
        }
    }

    fn begin(&mut self, stage: Stage) {
        self.stage = stage;
        self.blocks = 0;
    }

    fn begin_part(&mut self, part: u32) {
        let reach_hz = self.window_hz * (1.0 + MARGIN);
        let width_hz = 2.0 * reach_hz / self.parts as f32;
        let low_hz = part as f32 * width_hz - reach_hz;
        let over_hz = if self.parts > 1 { MARGIN * width_hz * 0.5 } else { 0.0 };
        self.begin_pass(
            Pass::between(low_hz - over_hz, low_hz + width_hz + over_hz, WINDOW_S, self.block_s),
            Stage::Window(part),
        );
    }

    fn begin_pass(&mut self, pass: Pass, stage: Stage) {
        self.pass = pass;
        self.hold.retune(pass.centre_hz);
        self.baseband.restart(self.hold.word());
        self.spectrum = pass.spectrum(self.block_s);
        self.begin(stage);
    }

    /// What is to be driven next.
    fn tune(&self) -> Step {
        Step::Tune(match self.stage {
            Stage::Window(_) | Stage::Fine => self.pass.offset_hz(self.blocks),
            Stage::Search(_) => self.pass.centre_hz,
            Stage::Fit | Stage::RingDown(..) => self.resonance_hz(),
        })
    }

    /// Offset of the wanted resonance, as far as it is known, Hz.
    fn resonance_hz(&self) -> f32 {
        self.found.get(self.chosen).map_or(0.0, |(pole, _)| pole.offset_hz)
    }

    /// Takes a block of a sweep. Returns whether it was the last.
    fn sweep(&mut self, convert: &Convert, sense: &SenseBlock) -> bool {
        if self.blocks >= BEFORE {
            let heard = self.baseband.take(convert, sense);
            if self.blocks > BEFORE {
                self.spectrum.add(&heard);
            }
        }
        self.still_blocks = 0;
        self.blocks == BEFORE + self.pass.blocks()
    }

    /// Lists what a part of the window shows, at rising frequencies; the weakest are left out.
    fn take_part(&mut self, part: u32) {
        let width_hz = 2.0 * self.window_hz * (1.0 + MARGIN) / self.parts as f32;
        let low_hz = part as f32 * width_hz - self.window_hz * (1.0 + MARGIN);
        let own = |hz: f32| self.parts == 1 || (hz >= low_hz && hz < low_hz + width_hz);
        let (circuit, deviations) = self.search.found();
        for (pole, deviations) in circuit.poles.iter().zip(deviations).filter(|(pole, _)| own(pole.offset_hz)) {
            let weakest =
                (0..self.found.len()).min_by(|&a, &b| strength(&self.found[a].0).total_cmp(&strength(&self.found[b].0)));
            if let (true, Some(weakest)) = (self.found.is_full(), weakest) {
                if strength(&self.found[weakest].0) > strength(pole) {
                    continue;
                }
                self.found.remove(weakest);
            }
            // There is room.
            let _ = self.found.push((*pole, *deviations));
        }
        self.found.sort_unstable_by(|a, b| a.0.offset_hz.total_cmp(&b.0.offset_hz));
        self.list();
    }

    fn list(&mut self) {
        self.listed = self.found.iter().map(|(pole, _)| resonance(pole, self.nominal_hz)).collect();
    }

    /// Chooses the wanted resonance, and decides whether it is known well enough.
    fn choose(&mut self) -> Step {
        match self.choice.of(&self.listed) {
            Err(fault) => return Step::Failed(fault),
            Ok(chosen) => self.chosen = chosen,
        }
        let (pole, deviations) = self.found[self.chosen];
        let bandwidth_hz = (self.nominal_hz + pole.offset_hz) / pole.q;
        let excess = deviations.series_resonance_hz / (WANTED.0 * bandwidth_hz).max(WANTED.1 * self.nominal_hz);
        if excess <= 1.0 && self.parts == 1 {
            let wanted = |other: &Pole| other.offset_hz == pole.offset_hz;
            return self.take(self.search.found().0.poles.iter().position(wanted).unwrap_or(0));
        }
        // A resonance near the edge of the window is looked at from one side.
        let reach_hz = self.window_hz * (1.0 + MARGIN);
        let inside = |hz: f32| hz.clamp(-reach_hz, reach_hz);
        let half_hz = 0.5 * FINE_BANDWIDTHS * bandwidth_hz;
        let (low_hz, high_hz) = (inside(pole.offset_hz - half_hz), inside(pole.offset_hz + half_hz));
        let fine = Pass::between(low_hz, high_hz, FINE_S, self.block_s);
        // The time that the first pass has spent there, for a deviation that falls with the root of it.
        let there_s = self.pass.blocks() as f32 * self.block_s * (fine.width_hz / self.pass.width_hz).min(1.0);
        let wanted_s = (there_s * excess * excess).min(LONGEST_S);
        let repeats = (wanted_s / (fine.period_blocks as f32 * self.block_s)) as u32 + 1;
        self.begin_pass(Pass { repeats, ..fine }, Stage::Fine);
        self.tune()
    }

    /// Blocks and samples of the spectrum.
    fn heard(&self) -> (u32, u32) {
        (self.pass.blocks(), self.pass.blocks() * self.block_samples)
    }

    /// Fits the wanted resonance, and with it what else is in the fine pass.
    fn begin_fit(&mut self) {
        let mut circuit = Circuit { poles: Vec::new(), ..self.search.found().0.clone() };
        let wanted = self.found[self.chosen].0;
        let (centre_hz, half_hz) = (self.pass.centre_hz, 0.5 * self.pass.width_hz);
        // There is room: no more are found than fit in.
        let _ = circuit.poles.push(wanted);
        for (_, (pole, _)) in self.found.iter().enumerate().filter(|(n, _)| *n != self.chosen) {
            let inside = (pole.offset_hz - centre_hz).abs() < half_hz;
            let _ = if inside { circuit.poles.push(*pole) } else { circuit.known.push(*pole) };
        }
        let (blocks, samples) = self.heard();
        self.search = ModeSearch::again(&self.told, circuit, blocks, samples);
        self.begin(Stage::Fit);
    }

    /// Takes the fit of the fine pass.
    fn take_fit(&mut self) -> Step {
        let (circuit, deviations) = self.search.found();
        match (circuit.poles.first(), deviations.first()) {
            (Some(pole), Some(deviations)) if pole.offset_hz.abs() <= self.window_hz => {
                self.found[self.chosen] = (*pole, *deviations);
                self.list();
                self.take(0)
            }
            _ => Step::Failed(Fault::NoResonance),
        }
    }

    /// Takes this resonance of the latest fit as the result.
    fn take(&mut self, place: usize) -> Step {
        let (circuit, deviations) = self.search.found();
        let transducer = Transducer {
            deviations: deviations.get(place).copied().unwrap_or_default(),
            modes: self.found.len() as u8,
            chosen: self.chosen as u8,
            ..circuit.transducer(place)
        };
        let motional = circuit.motional(place);
        self.in_phase = 0;
        self.begin(Stage::RingDown(transducer, motional));
        self.tune()
    }

    fn ring_down(&mut self, sensed: &Sensed, transducer: Transducer, motional: Motional) -> Step {
        let current = motional.current(sensed, 1.0 + self.resonance_hz() / self.nominal_hz);
        let phase = motional.phase_of(current, sensed.v);
        let heard = self.blocks > LATENCY_BLOCKS as u32;
        self.in_phase = if heard && phase.re > 0.0 && phase.im.abs() < IN_PHASE.0 * phase.re { self.in_phase + 1 } else { 0 };
        let longest = (RING_DOWN * transducer.time_constant_s() / self.block_s) as u32 + LATENCY_BLOCKS as u32;
        if self.in_phase >= IN_PHASE.1 || self.still_blocks > longest { Step::Found(transducer, motional) } else { self.tune() }
    }
}

/// `G / Q`, which is how much of the drive's energy a resonance takes up.
fn strength(pole: &Pole) -> f32 {
    magnitude(pole.conductance) / pole.q
}

fn resonance(pole: &Pole, nominal_hz: f32) -> Resonance {
    let hz = nominal_hz + pole.offset_hz;
    let conductance_s = magnitude(pole.conductance);
    Resonance { hz, q: pole.q, lm_h: pole.q / (core::f32::consts::TAU * hz * conductance_s), conductance_s }
}

#[cfg(test)]
mod tests;
