//! How a run comes to its frequency, and comes back to it.

use super::Controller;
use crate::clamped::Clamped;
use crate::identify::Transducer;
use crate::motional::Motional;
use crate::supervisor::{Fault, Mode, Progress};
use crate::tracker::State;
use crate::tracker::identified::Known;
use crate::tracker::observed::Seek;
use crate::tracker::observer::Prior;

/// A resonance whose motional inductance is this many times smaller or larger than was told is another one.
const SAME_MODE: f32 = 2.0;

impl Controller {
    /// Takes the clamped branch, and lets the observer begin anywhere in the window.
    pub(super) fn observe(&mut self, clamped: &Clamped) {
        let window_hz = self.tracker.window_hz();
        let prior = Prior {
            offset_hz: (0.0, window_hz),
            q: core::f32::consts::PI * self.nominal_periods,
            // Measured to a part in five hundred; what was told is what it is held against once it has locked.
            lm_h: (clamped.lm_h.value, clamped.lm_h.deviation),
            axis: clamped.motional.axis,
            noise_a: self.noise_a(&clamped.motional),
        };
        let modes = 1 + u8::from(clamped.company.is_some());
        let known = Known { c0_f: (clamped.c0_f.value, clamped.c0_f.deviation), modes: (modes, 0) };
        self.tracker.observe(clamped.motional, known, &prior);
        let (c0, hz, q) = (clamped.c0_f, clamped.resonance_hz.value, clamped.q.value);
        self.online.seed(clamped.motional, c0.deviation / c0.value, hz, q);
    }

    /// Variances of a block's voltage and current by noise, both components, V² and A².
    pub(super) fn noise(&self) -> (f32, f32) {
        let (v, i) = self.self_test.noise();
        (self.convert.v.phasor_variance(v, self.samples), self.convert.i.phasor_variance(i, self.samples))
    }

    /// Rms noise of a block's motional current, A.
    fn noise_a(&self, branch: &Motional) -> f32 {
        let (v, i) = self.noise();
        libm::sqrtf(i + branch.y0.norm_sqr() * v)
    }

    /// Takes the transducer that the scan has found, and starts both loops on it.
    pub(super) fn adopt(&mut self, transducer: Transducer, branch: Motional, motional_current: f32) {
        self.tracker.seed(&transducer, branch, self.noise_a(&branch));
        let deviation = transducer.deviations.c0_f / transducer.c0_f;
        self.online.seed(branch, deviation, transducer.series_resonance_hz, transducer.q);
        self.sweep.hold.retune(self.tracker.offset_hz());
        self.amplitude.seed(&transducer, motional_current);
        self.transducer = Some(transducer);
        self.learning.abandon();
    }

    pub(super) fn lock_progress(&mut self) -> Progress {
        let locking = self.supervisor.mode() == Mode::Lock;
        match self.tracker.state() {
            _ if !self.tracker.tracks() => Progress::Busy,
            State::Disagree => Progress::Failed(Fault::TrackersDisagree),
            State::Locked if self.is_another_mode() => Progress::Failed(Fault::WrongMode),
            State::Locked if self.amplitude.settled() => Progress::Done,
            State::Lost if !locking => self.seek_on(Fault::LossOfLock),
            State::TimedOut | State::Lost if locking => self.seek_on(Fault::NoLock),
            _ => Progress::Busy,
        }
    }

    /// Seeks the lock where there is more hope, if there is any left.
    fn seek_on(&mut self, fault: Fault) -> Progress {
        match self.tracker.seek_on(fault == Fault::LossOfLock) {
            Some(Seek::Nearby | Seek::Window) => Progress::Back(Mode::Lock),
            Some(Seek::Anew) => {
                self.test_again();
                self.calibrates_again = true;
                Progress::Back(Mode::SelfTest)
            }
            Some(Seek::Scan) => {
                self.scan.restart();
                Progress::Back(Mode::Scan)
            }
            None => Progress::Failed(fault),
        }
    }

    /// Whether what it has locked to is not the resonance it was told of, by its inductance.
    fn is_another_mode(&self) -> bool {
        let strength = |told: f32| self.transducer_by_now().map_or(1.0, |transducer| told / transducer.lm_h);
        self.nominal_lm_h.is_some_and(|told| !(1.0 / SAME_MODE..SAME_MODE).contains(&strength(told)))
    }
}
