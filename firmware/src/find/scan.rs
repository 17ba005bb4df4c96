//! Scan: finds the resonance and identifies the transducer, by sweeps that need no settling time.
//!
//! | stage | drive | result |
//! |---|---|---|
//! | wait | silence, only after a drive | the vibration has decayed |
//! | window | a sweep over the window plus a tenth of it, in 8 to 16 ms | [spectrum] of the sweep |
//! | search | centre of the window | [all resonances](crate::find::identify::mode_search); one line of the spectrum per block |
//! | fine | slow sweeps over two bandwidths around the [chosen](crate::find::identify::choice) one, as often as needed | final spectrum and fit |
//! | ring-down | the resonance | the remaining vibration no longer turns the phase; a tracker then measures a single tone |
//!
//! A window too wide for the lines of one spectrum is swept and searched in parts. The nominal Q
//! may be wrong by a factor of four.

pub(crate) mod baseband;
#[cfg(test)]
pub(crate) mod bench;
mod conclude;
pub(crate) mod modes;
pub(crate) mod pass;
pub(crate) mod ring_down;
pub(crate) mod spectrum;

use crate::find::identify::choice::Choice;
use crate::find::identify::mode_search::{ModeSearch, Nominal};
use crate::find::identify::pole_fit::Circuit;
use crate::find::scan::baseband::Baseband;
use crate::find::scan::modes::Modes;
use crate::find::scan::pass::Pass;
use crate::find::scan::ring_down::RingDown;
use crate::find::scan::spectrum::Spectrum;
use crate::generate::step::Step;
use crate::generate::sweep::hold::Hold;
use crate::seam::block::{LATENCY_BLOCKS, SenseBlock};
use crate::seam::config::{Config, TrackingMode};
use crate::seam::fault::Fault;
use crate::seam::phasor::magnitude;
use crate::seam::transducer::MOST_MODES;
use crate::sense::convert::Convert;
use crate::sense::demod::Sensed;

/// Extension of the sweep beyond each end of the window, relative to its half-width. A resonance in
/// this margin is identified as such and is not mistaken for one inside.
const MARGIN_REL: f32 = 0.1;
/// Minimum and maximum duration of the sweep of the window, s.
const WINDOW_S: (f32, f32) = (8e-3, 16e-3);
/// Maximum number of resonances in each part of a window; the fine pass, which follows in any case,
/// shows more.
const MOST_OF_A_PART: usize = 2;
/// Blocks measured before the first block of a sweep: the latency and the rising half of the first
/// triangle.
const LEAD_BLOCKS: u32 = LATENCY_BLOCKS as u32 + 1;
/// Current of a vibration that leaves room for the first tone, relative to the limit: at a figure
/// of merit of 0.5 the clamped current of a drive is up to three quarters of the limit.
const CALM_REL: f32 = 0.2;
/// Longest wait for that, s; a current that remains is none of a vibration.
const MAX_WAIT_S: f32 = 0.5;
/// Current above which the scan continues at a lower voltage, relative to the limit. The fit does
/// not require a constant voltage.
const LOUD_REL: f32 = 0.9;
/// The lower voltage, relative to the one before.
const QUIETER_REL: f32 = 0.7;

#[derive(Clone, Copy, Debug, PartialEq)]
enum Stage {
    /// Sweep of this part of the window.
    Window(u32),
    Search(u32),
    Fine,
    Fit,
    RingDown(RingDown),
    /// Silence before this fault.
    Failed(Fault),
}

/// Scan in progress. Small parts that every block reads come first.
#[derive(Clone, Debug)]
#[repr(C)]
pub(crate) struct Scan {
    stage: Stage,
    /// Blocks in this stage.
    blocks: u32,
    /// Blocks since the last sweep ended.
    still_blocks: u32,
    pass: Pass,
    /// Peak voltage of the drive, V.
    volts: f32,
    /// Limit of the current, A.
    limit_a: f32,
    /// Current above which the voltage falls, A.
    loud_a: f32,
    nominal_hz: f32,
    block_s: f32,
    block_samples: u32,
    /// `true` while the vibration of a drive decays before the first sweep.
    waits: bool,
    baseband: Baseband,
    spectrum: Spectrum,
    hold: Hold,
    modes: Modes,
    search: ModeSearch,
    /// Circuit with only the nominal clamped capacitance.
    bare: Circuit,
    /// Peak voltage at the start of a scan, V.
    scan_volts: f32,
    choice: Choice,
    /// Nominal Q for the damage check; set only for an observer with a nominal clamped capacitance.
    judged_q: Option<f32>,
    window_hz: f32,
    parts: u32,
    /// `true` if the window is swept a second time when nothing is found. An observer does not
    /// repeat the scan.
    repeats: bool,
    /// `true` if the window has been swept a second time.
    repeated: bool,
    /// `true` if the chosen resonance is fitted alone: it is, or the fit of several has failed.
    alone: bool,
    /// Clamped capacitance from tones off resonance, F, to compare with that of the scan.
    off_resonance_c0_f: Option<f32>,
}

impl Scan {
    /// Creates a scan of the configured window; it [starts](Self::restart) on command.
    // Not inlined, so that it is built directly in the memory of the controller.
    #[inline(never)]
    pub(crate) fn build(config: &Config, hold: &Hold) -> Self {
        let tracking = &config.tracking;
        let nominal_hz = config.drive.frequency_hz;
        let nominal = Nominal { steps: (config.front_end.volt_per_lsb, config.front_end.ampere_per_lsb), q: tracking.nominal_q };
        let bare = Circuit::bare(nominal_hz, tracking.c0_f());
        let block_s = f32::from(config.block_samples) / config.sample_hz;
        let window_hz = tracking.span * nominal_hz;
        let reach_hz = window_hz * (1.0 + MARGIN_REL);
        let whole = Pass::between(-reach_hz, reach_hz, WINDOW_S, block_s);
        let parts = if whole.width_hz < 1.99 * reach_hz {
            // Neighbouring parts overlap by the same margin as at the ends.
            (2.0 * reach_hz * (1.0 + MARGIN_REL) / whole.width_hz) as u32 + 1
        } else {
            1
        };
        let spectrum = whole.spectrum(block_s);
        Scan {
            search: ModeSearch::new(&nominal, bare.clone()),
            bare,
            nominal_hz,
            scan_volts: config.drive.scan_volts,
            volts: config.drive.scan_volts,
            limit_a: config.limits.current_a,
            loud_a: LOUD_REL * config.limits.current_a,
            choice: Choice { window_hz: (nominal_hz, window_hz), nominal_lm_h: tracking.nominal_lm_h },
            judged_q: tracking.nominal_c0_f.filter(|_| tracking.mode == TrackingMode::Observer).map(|_| tracking.nominal_q),
            window_hz,
            parts,
            block_s,
            block_samples: config.block_samples.into(),
            hold: hold.clone(),
            stage: Stage::Window(0),
            pass: whole,
            blocks: 0,
            still_blocks: 0,
            baseband: Baseband::default(),
            spectrum,
            modes: Modes::new(nominal_hz),
            repeats: tracking.mode != TrackingMode::Observer,
            repeated: false,
            alone: false,
            off_resonance_c0_f: None,
            waits: false,
        }
    }

    /// Restarts the scan with a sweep of the window.
    pub(crate) fn restart(&mut self) {
        (self.repeated, self.off_resonance_c0_f, self.waits) = (false, None, false);
        self.volts = self.scan_volts;
        self.begin_window();
    }

    /// Restarts the scan after a drive, with a silence in which the vibration decays: its current
    /// and that of the first tone together may exceed the limit. `off_resonance_c0_f` is the
    /// clamped capacitance from the tones off resonance, F.
    pub(crate) fn restart_after_drive(&mut self, off_resonance_c0_f: Option<f32>) {
        self.restart();
        (self.off_resonance_c0_f, self.waits) = (off_resonance_c0_f, true);
    }

    fn begin_window(&mut self) {
        self.modes = Modes::new(self.nominal_hz);
        self.alone = false;
        self.begin_part(0);
    }

    /// Restarts once if there was no resonance or if it moved during the scan. Returns `None` if
    /// the scan was repeated before.
    #[cold]
    pub(crate) fn repeat(&mut self) -> Option<Step> {
        if !self.repeats || core::mem::replace(&mut self.repeated, true) {
            return None;
        }
        self.begin_window();
        Some(self.tune())
    }

    /// Sets the initial clamped capacitance, F, when no nominal value is configured.
    pub(crate) fn reckon_with(&mut self, c0_f: f32) {
        self.bare = Circuit::bare(self.nominal_hz, c0_f);
    }

    /// Returns the resonances of the last scan.
    pub(crate) fn modes(&self) -> &Modes {
        &self.modes
    }

    /// Returns the result; `None` while the scan is running.
    pub(crate) fn found(&self) -> Option<&RingDown> {
        match &self.stage {
            Stage::RingDown(result) => Some(result),
            _ => None,
        }
    }

    /// Processes the measured block and returns the next step.
    pub(crate) fn listen(&mut self, convert: &Convert, sense: &SenseBlock, sensed: &Sensed) -> Step {
        if self.waits {
            self.blocks += 1;
            // The first blocks measured are those of the drive, and of its fade.
            let rings = magnitude(sensed.i) > CALM_REL * self.limit_a && (self.blocks as f32) * self.block_s < MAX_WAIT_S;
            self.waits = self.blocks <= LEAD_BLOCKS || rings;
            self.blocks *= u32::from(self.waits);
            return Step::Silence;
        }
        self.blocks += 1;
        self.still_blocks += 1;
        match self.stage {
            Stage::Window(part) => {
                // Restarted here, as nothing is measured yet; the last block has no spare time, and
                // the first one prepares the reference.
                if self.blocks == 2 {
                    let (blocks, samples) = self.measured();
                    let most = if self.parts > 1 { MOST_OF_A_PART } else { MOST_MODES };
                    self.search.restart(&self.bare, most, blocks, samples);
                }
                if let Some(tone) = self.sweep(convert, sense, sensed) {
                    return tone;
                }
                self.begin(Stage::Search(part));
                self.tune()
            }
            Stage::Search(part) => {
                self.reduce_voltage(sensed);
                // The result is processed in a block of its own.
                if !self.search.is_over() {
                    self.search.step(&self.spectrum);
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
                if let Some(tone) = self.sweep(convert, sense, sensed) {
                    return tone;
                }
                self.begin(Stage::Fit);
                self.tune()
            }
            Stage::Fit => {
                self.reduce_voltage(sensed);
                // The last block of the sweep had no spare time.
                if self.blocks == 1 {
                    self.begin_fit();
                } else if self.search.is_over() {
                    return self.take_fit();
                } else {
                    self.search.step(&self.spectrum);
                }
                self.tune()
            }
            Stage::RingDown(_) => {
                self.reduce_voltage(sensed);
                let relative = 1.0 + self.resonance_hz() / self.nominal_hz;
                if let Stage::RingDown(result) = &mut self.stage {
                    if self.blocks == 1 {
                        result.state(self.modes.is_crowded(), self.off_resonance_c0_f);
                    }
                    if result.check_block(sensed, relative) {
                        return Step::Done { volts: self.volts };
                    }
                }
                self.tune()
            }
            Stage::Failed(fault) if self.blocks > LATENCY_BLOCKS as u32 => Step::Failed(fault),
            Stage::Failed(_) => Step::Silence,
        }
    }

    /// Fails after a silence in which the queued blocks of the drive have been played, the last of
    /// which fades: a fault ends the drive at once, with a peak of current into the clamped
    /// capacitance.
    #[cold]
    pub(crate) fn fail(&mut self, fault: Fault) -> Step {
        self.begin(Stage::Failed(fault));
        Step::Silence
    }

    /// Returns `true` if the scan drives.
    pub(crate) fn drives(&self) -> bool {
        !matches!(self.stage, Stage::Failed(_))
    }

    fn begin(&mut self, stage: Stage) {
        self.stage = stage;
        self.blocks = 0;
    }

    fn begin_part(&mut self, part: u32) {
        let reach_hz = self.window_hz * (1.0 + MARGIN_REL);
        let width_hz = 2.0 * reach_hz / self.parts as f32;
        let low_hz = part as f32 * width_hz - reach_hz;
        let over_hz = if self.parts > 1 { MARGIN_REL * width_hz * 0.5 } else { 0.0 };
        self.begin_pass(
            Pass::between(low_hz - over_hz, low_hz + width_hz + over_hz, WINDOW_S, self.block_s),
            Stage::Window(part),
        );
    }

    fn begin_pass(&mut self, pass: Pass, stage: Stage) {
        self.pass = pass;
        self.loud_a = LOUD_REL * self.limit_a;
        self.hold.retune(pass.centre_hz);
        self.baseband.restart(self.hold.word());
        self.spectrum = pass.spectrum(self.block_s);
        self.begin(stage);
    }

    /// Returns the next tone to drive.
    fn tune(&self) -> Step {
        let offset_hz = match self.stage {
            Stage::Window(_) | Stage::Fine => self.pass.offset_hz(self.blocks),
            Stage::Search(_) => self.pass.centre_hz,
            Stage::Fit | Stage::RingDown(_) | Stage::Failed(_) => self.resonance_hz(),
        };
        Step::Tone { offset_hz, volts: self.volts, lane: 0 }
    }

    /// Returns the latest offset of the chosen resonance, Hz.
    fn resonance_hz(&self) -> f32 {
        self.modes.chosen().map_or(0.0, |(pole, _)| pole.offset_hz)
    }

    /// Lowers the voltage if the current comes near its limit.
    #[inline(always)]
    fn reduce_voltage(&mut self, sensed: &Sensed) {
        // Squares are compared, because a square root takes a hundred instructions.
        if sensed.i.norm_sqr() > self.loud_a * self.loud_a {
            self.volts *= QUIETER_REL;
            self.loud_a = 0.5 * (self.loud_a + self.limit_a);
        }
    }

    /// Processes a block of a sweep. Returns the next tone, or `None` after the last block.
    fn sweep(&mut self, convert: &Convert, sense: &SenseBlock, sensed: &Sensed) -> Option<Step> {
        self.reduce_voltage(sensed);
        const { assert!(LEAD_BLOCKS >= 3, "the reference is prepared in two blocks before the first measured one") };
        match self.blocks {
            1 => self.baseband.prepare(),
            2 => self.baseband.weigh(self.block_samples as usize, convert.v.max_code()),
            _ => {
                let sensed = self.baseband.process(convert, sense);
                if self.blocks > LEAD_BLOCKS {
                    self.spectrum.add(&sensed);
                }
            }
        }
        self.still_blocks = 0;
        if self.blocks == LEAD_BLOCKS + self.pass.blocks() {
            return None;
        }
        // Not by `tune`, which is not in the fast memory of a board.
        Some(Step::Tone { offset_hz: self.pass.offset_hz(self.blocks), volts: self.volts, lane: 0 })
    }

    /// Returns the numbers of blocks and samples in the spectrum.
    fn measured(&self) -> (u32, u32) {
        (self.pass.blocks(), self.pass.blocks() * self.block_samples)
    }
}

#[cfg(test)]
mod tests;
