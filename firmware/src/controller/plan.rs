//! What each mode wants to play next.

use super::{Controller, Played};
use crate::block::{Gate, Orders, SenseBlock};
use crate::calibrate;
use crate::clamped;
use crate::demod::Sensed;
use crate::phasor::{Phasor, magnitude};
use crate::restraint::Restraint;
use crate::scan;
use crate::self_test;
use crate::supervisor::{Fault, Mode, Progress};
use crate::units::Turns;

/// What to play next, before the burst has its say.
#[derive(Clone, Copy)]
pub(super) struct Plan {
    pub(super) volts: f32,
    pub(super) gate: Gate,
    /// The lane to listen to.
    pub(super) listen: u8,
    /// Where the tracker is, as an offset from the nominal frequency, Hz; zero where nothing is tracked.
    pub(super) tracked_hz: f32,
    /// Phase that is driven to zero.
    pub(super) phase: Turns,
    /// The window has limited what the order asks for.
    pub(super) limited: bool,
    pub(super) progress: Progress,
}

impl Plan {
    const SILENT: Plan = Plan {
        volts: 0.0,
        gate: Gate::Off,
        listen: 0,
        tracked_hz: 0.0,
        phase: Turns(0.0),
        limited: false,
        progress: Progress::Busy,
    };

    fn tone(volts: f32) -> Self {
        Plan { volts, gate: Gate::On, ..Plan::SILENT }
    }

    pub(super) fn and(self, progress: Progress) -> Self {
        Plan { progress, ..self }
    }
}

impl Controller {
    /// Forgets what an earlier attempt has found.
    pub(super) fn begin(&mut self) {
        self.guard.begin();
        self.test_again();
        self.calibrates_again = false;
        self.calibrate.abandon(&mut self.phasing);
        self.scan.restart();
        self.transducer = None;
        self.learning.abandon();
        self.sweep.hold.retune(0.0);
        self.sweep.restart();
        self.tracker.restart();
        self.amplitude.restart();
        self.restart_friction();
        self.edges.restart();
        self.burst.restart();
        self.restraint.iter_mut().for_each(Restraint::restart);
    }

    /// Prepares the self-test and the measurement of the clamped branch that follows it.
    pub(super) fn test_again(&mut self) {
        self.convert.v.restore_zero();
        self.convert.i.restore_zero();
        self.self_test.restart();
        self.power_on.restart();
        self.probe_hz = 0.0;
    }

    /// What this mode wants to play next.
    pub(super) fn plan(
        &mut self,
        orders: &Orders,
        sense: &SenseBlock,
        sensed: &Sensed,
        heard: &Played,
        motional: Phasor,
    ) -> Plan {
        match self.supervisor.mode() {
            Mode::Idle | Mode::Fault => {
                self.calibrate.abandon(&mut self.phasing);
                Plan::SILENT
            }
            Mode::SelfTest => {
                match self.self_test.step(&mut self.convert, sense, sensed, heard.volts * heard.audible.unwrap_or(1.0)) {
                    self_test::Step::Silence => Plan::SILENT,
                    self_test::Step::Tone { offset_hz, volts } => {
                        self.sweep.hold.retune(offset_hz);
                        Plan::tone(volts)
                    }
                    self_test::Step::Passed => {
                        let (v, i) = self.noise();
                        self.power_on.set_noise(v, i);
                        self.sweep.hold.retune(0.0);
                        Plan::SILENT.and(Progress::Done)
                    }
                    self_test::Step::Failed(fault) => Plan::SILENT.and(Progress::Failed(fault)),
                }
            }
            Mode::Scan => match self.scan.step(&self.convert, sense, sensed) {
                scan::Step::Tune(offset_hz) => {
                    self.sweep.hold.retune(offset_hz);
                    Plan::tone(self.scan_volts)
                }
                scan::Step::Found(transducer, branch) => {
                    self.adopt(transducer, branch, magnitude(motional));
                    Plan::tone(self.scan_volts).and(Progress::Done)
                }
                scan::Step::Failed(fault) => Plan::SILENT.and(Progress::Failed(fault)),
            },
            Mode::Clamped => match self.power_on.step(sensed) {
                clamped::Step::Tone { offset_hz, volts } => {
                    self.sweep.hold.retune(offset_hz);
                    Plan::tone(volts)
                }
                clamped::Step::Silence => Plan::SILENT,
                clamped::Step::Found(clamped) => {
                    self.sweep.hold.retune(0.0);
                    self.observe(&clamped);
                    Plan::SILENT
                }
                clamped::Step::Over => Plan::tone(self.scan_volts).and(Progress::Done),
                clamped::Step::Failed(Fault::NoResonance | Fault::ResonanceDamaged) if self.calibrates_again => {
                    self.calibrates_again = false;
                    self.power_on.restart();
                    Plan::SILENT
                }
                clamped::Step::Failed(fault) => Plan::SILENT.and(Progress::Failed(fault)),
            },
            Mode::Calibrate => match self.calibrate.step(&mut self.phasing, sensed) {
                calibrate::Step::Listen { offset_hz, lane } => {
                    self.sweep.hold.retune(offset_hz);
                    Plan { listen: lane, ..Plan::tone(self.scan_volts) }
                }
                calibrate::Step::Done => {
                    self.sweep.hold.retune(0.0);
                    self.amplitude.set_loudest(self.phasing.loudest());
                    Plan::SILENT.and(Progress::Done)
                }
                calibrate::Step::Failed(fault) => Plan::SILENT.and(Progress::Failed(fault)),
            },
            // What has nothing to lock to waits.
            Mode::Lock if self.guard.is_muted() => Plan::SILENT,
            // Silent within the block, whatever the edge: a burst without a voltage ends at once, and begins anew.
            Mode::Run if self.guard.is_muted() => {
                let plan = self.follow(&Orders { gate: Gate::Off, ..*orders }, sensed, heard, motional);
                Plan { volts: 0.0, ..plan }
            }
            Mode::Lock => self.follow(&Orders { gate: Gate::On, ..*orders }, sensed, heard, motional),
            Mode::Run => {
                self.switch_friction(orders, sense, heard, motional);
                let switched = self.as_switched(orders);
                let plan = self.follow(switched.as_ref().unwrap_or(orders), sensed, heard, motional);
                self.trust_survey(plan)
            }
        }
    }
}
