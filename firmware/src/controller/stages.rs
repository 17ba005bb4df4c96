//! The stages of the controller, one for each [mode](Mode) that drives. Each processes the block
//! just measured and returns the next drive.
//!
//! | stage | modes | result |
//! |---|---|---|
//! | [`SelfTest`] | `SelfTest` | zeros and noise of the sense channels; a transducer is connected |
//! | [`Scan`] | `Scan` | the resonances in the window, and the chosen one |
//! | [`PowerOn`] | `Clamped` | the clamped branch, measured off resonance |
//! | [`Calibrate`] | `Calibrate` | the trims of the lanes |
//! | [`Follow`] | `Lock`, `Run` | none: it drives the resonance |

mod calibrate;
mod clamped;
pub(crate) mod follow;
mod scan;
mod self_test;

use crate::controller::chain::{Chain, Measured};
use crate::controller::stages::follow::Follow;
use crate::find::calibrate::Calibrate;
use crate::find::clamped::PowerOn;
use crate::find::scan::Scan;
use crate::find::self_test::SelfTest;
use crate::generate::step::Progress;
use crate::generate::step::Step;
use crate::seam::mode::Mode;

/// Stage on the way to a run, or the run itself.
pub(crate) trait Stage {
    /// Resets the stage for a new attempt.
    fn begin(&mut self, chain: &mut Chain);

    /// Processes one block, updates the chain with the result, and returns the next drive.
    fn step(&mut self, chain: &mut Chain, measured: &Measured) -> Step;
}

/// All stages: the one with the least time first, the largest last.
#[derive(Clone, Debug)]
#[repr(C)]
pub(crate) struct Stages {
    pub(crate) follow: Follow,
    pub(crate) self_test: SelfTest,
    pub(crate) clamped: PowerOn,
    pub(crate) calibrate: Calibrate,
    pub(crate) scan: Scan,
}

impl Stages {
    /// Resets all stages for a new attempt.
    #[inline(never)]
    pub(crate) fn begin(&mut self, chain: &mut Chain) {
        self.follow.begin(chain);
        self.self_test.begin(chain);
        self.clamped.begin(chain);
        self.calibrate.begin(chain);
        self.scan.begin(chain);
    }

    /// Runs the stage of the present mode on one block, and returns the next drive.
    #[inline]
    pub(crate) fn step(&mut self, chain: &mut Chain, measured: &Measured) -> Step {
        match chain.supervisor.mode() {
            Mode::Idle | Mode::Fault => {
                self.calibrate.begin(chain);
                Step::Silence
            }
            Mode::SelfTest => self.run_self_test(chain, measured),
            Mode::Scan => self.scan.step(chain, measured),
            Mode::Clamped => {
                let step = self.clamped.step(chain, measured);
                if let Step::Instead(mode) = step {
                    self.go_back(chain, mode);
                }
                step
            }
            Mode::Calibrate => self.calibrate.step(chain, measured),
            Mode::Lock | Mode::Run => {
                let step = self.follow.step(chain, measured);
                if let Step::Follow(plan) = &step
                    && let Progress::Back(mode) = plan.progress
                {
                    self.go_back(chain, mode);
                }
                step
            }
        }
    }

    /// Runs the self-test, and passes its result to the stages after it.
    #[inline(never)]
    fn run_self_test(&mut self, chain: &mut Chain, measured: &Measured) -> Step {
        let step = self.self_test.step(chain, measured);
        if matches!(step, Step::Done { .. }) {
            let c0_f = self.self_test.capacitance_f();
            self.clamped.prepare(chain.track.noise, c0_f);
            if let Some(c0_f) = c0_f {
                self.scan.reckon_with(c0_f);
                chain.track.tracker.set_clamped_capacitance(c0_f);
            }
        }
        step
    }

    /// Prepares the stage to which a lost lock goes back, or that replaces another one.
    #[inline(never)]
    fn go_back(&mut self, chain: &mut Chain, mode: Mode) {
        match mode {
            Mode::SelfTest => {
                chain.generator.fade();
                self.self_test.begin(chain);
                self.clamped.begin_twice(chain.track.transducer().map(|transducer| transducer.q));
            }
            Mode::Scan => {
                chain.generator.fade();
                self.scan.restart_after_drive(self.clamped.shown_c0_f);
            }
            _ => {}
        }
    }
}
