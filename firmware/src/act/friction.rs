//! Friction switch: converts the set point of a friction ratio or friction force to a tip velocity
//! or a burst duty.
//!
//! Vibration along the motion reduces the mean friction of a sliding contact. The [law](dahl) gives
//! the reduction, and its [inverse] gives the required drive. The amplitude loop holds the
//! corresponding motional current: tip velocity times the nominal force factor. The contact is
//! identified, not configured: a `survey` measures its friction without vibration and at three
//! amplitudes, and fits it. Where the law is steep, bursts replace the amplitude (`regime`).
//!
//! ```text
//! target ratio -> inverse law -> regime -> amplitude, gate, ON time of bursts -> amplitude loop and burst
//!                    ^  Dahl length, scale, friction without vibration, dead time
//!                 survey <- force, motional current, belt speed
//! ```
//!
//! For a knob with detents (`detents.rs`), the set point follows the position.
//!
//! The computation is spread over several blocks. An unreachable ratio is reported by a limit
//! number, and the nearest reachable one is driven.

mod average;
pub mod dahl;
pub(crate) mod detents;
pub(crate) mod fit;
pub mod inverse;
pub(crate) mod regime;
pub(crate) mod survey;
mod terms;
#[cfg(test)]
mod tests;

pub use terms::{Sensed, SetPoint};

use crate::act::friction::average::LowPass;
use crate::act::friction::dahl::Evaluation;
use crate::act::friction::detents::Detents;
use crate::act::friction::fit::Contact;
use crate::act::friction::inverse::{Inverse, Solution};
use crate::act::friction::regime::{Choice, MissReason, Regime};
use crate::act::friction::survey::{Found, Play, Progress, Reading, Survey};
use crate::seam::block::{Amplitude, Target};
use crate::seam::config::{Config, FrictionLaw, Schedule};
use crate::seam::error::Error;
use crate::seam::fault::Limit;
use crate::seam::features;
use crate::seam::telemetry::FrictionEstimate;

/// Smoothing time constant of the sliding speed and of the tip velocity, s.
const SMOOTH_S: f32 = 2e-3;
/// Smoothing time constant of the force, which contains bursts, s.
const FORCE_S: f32 = 20e-3;
/// Idle blocks after a solution.
const REST_BLOCKS: u32 = 32;
/// Settling time of amplitude and force sensor, s.
const SETTLE_S: f32 = 30e-3;

#[derive(Clone, Debug)]
enum Work {
    /// Idle for this number of blocks.
    Rest(u32),
    /// Solves for the drive of this ratio.
    Solve { target: f32, least_xi: f32, inverse: Inverse },
    /// Evaluates the ratio at the measured values.
    Estimate(Evaluation),
}

/// Friction switch: controls the friction ratio by amplitude or bursts.
#[derive(Clone, Debug)]
pub struct FrictionSwitch {
    _enabled: features::Friction,
    law: FrictionLaw,
    target: Target,
    detents: Option<Detents>,
    omega: f32,
    force_factor: f32,
    /// Maximum motional current, A.
    most_amperes: f32,
    /// Period of the bursts, samples; `None` without bursts.
    period: Option<f32>,
    settle_blocks: u32,
    average_blocks: u32,
    /// Averaging time as a whole number of bursts, blocks.
    burst_blocks: Option<u32>,
    nominal: Contact,
    survey: Option<Survey>,
    play: Play,
    found: Option<Found>,
    /// `true` if the readings of the force sensor were implausible.
    implausible: bool,
    speed: LowPass,
    tip: LowPass,
    force: LowPass,
    work: Work,
    solution: Solution,
    choice: Choice,
    ratio: f32,
    belief: Option<FrictionEstimate>,
    /// Ratio of the present or last solution.
    solved_ratio: f32,
    /// Present target of the friction ratio.
    target_ratio: f32,
    /// Set point of the drive.
    ordered: SetPoint,
}

impl FrictionSwitch {
    /// Checks the settings of a friction switch; returns `None` if none is configured.
    pub(crate) fn build(config: &Config, block_s: f32) -> Result<Option<Self>, Error> {
        let Some(friction) = &config.friction else { return Ok(None) };
        let enabled = features::friction()?;
        friction.check_all()?;
        let Amplitude::MotionalCurrent(most_amperes) = config.drive.amplitude else {
            return Err(Error::FrictionWithoutCurrent);
        };
        let period = match config.burst.schedule {
            Schedule::Periodic { period_s, .. } => Some((period_s * f64::from(config.sample_hz)) as f32),
            _ => None,
        };
        let whole_bursts = |samples: f32| {
            let bursts = libm::roundf(friction.average_s * config.sample_hz / samples).max(1.0);
            libm::roundf(bursts * samples / f32::from(config.block_samples)) as u32
        };
        let mut switch = FrictionSwitch {
            _enabled: enabled,
            law: friction.law,
            target: friction.target,
            detents: Detents::build(config, friction, block_s)?,
            omega: core::f32::consts::TAU * config.drive.frequency_hz,
            force_factor: friction.force_factor_n_per_v,
            most_amperes,
            period,
            settle_blocks: (SETTLE_S / block_s) as u32,
            average_blocks: (friction.average_s / block_s) as u32,
            burst_blocks: period.map(whole_bursts),
            nominal: Contact::nominal(friction.dahl_length_m),
            survey: None,
            play: Play::Silence,
            found: None,
            implausible: false,
            speed: LowPass::new(block_s / SMOOTH_S, friction.speed_m_per_s),
            tip: LowPass::new(block_s / SMOOTH_S, 0.0),
            force: LowPass::new(block_s / FORCE_S, 0.0),
            work: Work::Rest(0),
            solution: Solution { xi: 1.0, ratio: 1.0, floor: 1.0 },
            choice: Choice::new(friction.prefer),
            ratio: 1.0,
            belief: None,
            solved_ratio: 1.0,
            target_ratio: 1.0,
            ordered: SetPoint::Silence,
        };
        switch.restart();
        Ok(Some(switch))
    }

    /// Discards the identified contact and restarts the survey.
    // Not inlined: it has two callers.
    #[inline(never)]
    pub(crate) fn restart(&mut self) {
        let max_tip_m_per_s = self.most_amperes / self.force_factor;
        let (settle, average) = (self.settle_blocks, self.average_blocks);
        self.survey = Some(Survey::new(self.omega, max_tip_m_per_s, settle, average, self.burst_blocks));
        (self.play, self.found, self.implausible, self.belief) = (Play::Silence, None, false, None);
        (self.work, self.ordered) = (Work::Rest(0), SetPoint::Silence);
        self.solution = Solution { xi: 1.0, ratio: 1.0, floor: 1.0 };
    }

    /// Processes one block of a run and returns the set point of the drive. `ordered` replaces the
    /// configured target.
    #[inline(never)]
    pub fn step(&mut self, ordered: Option<Target>, sensed: &Sensed) -> SetPoint {
        if let Some(speed) = sensed.belt_m_per_s.filter(|speed| speed.is_finite()) {
            self.speed.take(speed.abs());
        }
        if let Some(amperes) = sensed.motional_a {
            self.tip.take(amperes / self.force_factor);
        }
        if let Some(force) = sensed.force_n.filter(|force| force.is_finite()) {
            self.force.take(force.abs());
        }
        if self.survey.is_some() {
            self.step_survey(sensed);
            self.ordered = self.surveyed();
            return self.ordered;
        }
        let between = self.ratio_of(ordered.unwrap_or(self.target));
        self.target_ratio = match (&self.detents, sensed.counts) {
            (Some(detents), Some(counts)) => detents.ratio(counts, sensed.belt_m_per_s.unwrap_or(0.0), between),
            _ => between,
        };
        self.ordered = match self.choice.regime() {
            Regime::Silent => SetPoint::Silence,
            Regime::Amplitude(xi) => self.current(self.contact().scale * self.speed.value / xi),
            Regime::Bursts(on) => SetPoint::Bursts { amperes: self.most_amperes, on_samples: on * self.period.unwrap_or(0.0) },
        };
        self.ordered
    }

    /// Returns the set point of the drive from the last step.
    pub fn set_point(&self) -> SetPoint {
        self.ordered
    }

    /// Returns `true` if the set point moves with a knob.
    pub(crate) fn moves(&self) -> bool {
        self.detents.is_some()
    }

    /// Returns the reason why the friction misses its set point, if it does.
    pub(crate) fn limit(&self) -> Option<Limit> {
        match self.choice.miss() {
            _ if self.survey.is_some() => None,
            Some(MissReason::NoAuthority) => Some(Limit::NoAuthority),
            Some(MissReason::Unreachable) => Some(Limit::RatioUnreachable),
            None => None,
        }
    }

    /// Returns `true` during the survey.
    pub(crate) fn is_surveying(&self) -> bool {
        self.survey.is_some()
    }

    /// Returns `true` if the force measured in the survey was implausible.
    pub(crate) fn is_implausible(&self) -> bool {
        self.implausible
    }

    /// Returns the latest estimate of the contact; `None` until the survey has ended.
    pub(crate) fn belief(&self) -> Option<FrictionEstimate> {
        self.belief
    }

    fn estimated(&self) -> FrictionEstimate {
        let contact = self.contact();
        let ratio = match self.choice.regime() {
            Regime::Silent => 1.0,
            Regime::Amplitude(_) => self.ratio,
            Regime::Bursts(on) => 1.0 - (1.0 - self.ratio) * (on + self.dead().unwrap_or(0.0)),
        };
        FrictionEstimate {
            identified: self.found.is_some(),
            ratio,
            force_ratio: self.found.map(|found| self.force.value / found.coulomb_n),
            kappa: self.most_amperes / (self.force_factor * self.omega * contact.dahl_length_m),
            kappa_deviation: contact.length_deviation,
            floor: self.solution.floor,
        }
    }

    fn contact(&self) -> Contact {
        self.found.map_or(self.nominal, |found| found.contact)
    }

    /// Returns the dead time of bursts relative to their period; `None` without bursts.
    fn dead(&self) -> Option<f32> {
        self.period.map(|_| self.found.map_or(0.0, |found| found.dead))
    }

    /// Returns the set point for a tip velocity, limited to the maximum current.
    fn current(&self, tip_m_per_s: f32) -> SetPoint {
        let amperes = tip_m_per_s * self.force_factor;
        SetPoint::Current(if amperes < self.most_amperes { amperes } else { self.most_amperes })
    }

    fn step_survey(&mut self, sensed: &Sensed) {
        let Some(survey) = &mut self.survey else { return };
        let reading = Reading { speed_m_per_s: self.speed.value, tip_m_per_s: self.tip.value, force_n: sensed.force_n };
        match survey.step(&reading) {
            Progress::Busy(Play::Same) => {}
            Progress::Busy(play) => self.play = play,
            Progress::Found(found) => (self.survey, self.found) = (None, Some(found)),
            Progress::NoForce => self.survey = None,
            Progress::Implausible => (self.survey, self.implausible) = (None, true),
        }
    }

    fn surveyed(&self) -> SetPoint {
        match self.play {
            Play::Tip(tip) => self.current(tip),
            Play::Bursts => {
                SetPoint::Bursts { amperes: self.most_amperes, on_samples: survey::TRIAL_DUTY * self.period.unwrap_or(0.0) }
            }
            Play::Silence | Play::Same => SetPoint::Silence,
        }
    }

    /// Returns the target as a friction ratio; NaN for a force while the friction without vibration
    /// is unknown.
    fn ratio_of(&self, target: Target) -> f32 {
        match (target, self.found) {
            (Target::Ratio(ratio), _) => ratio,
            (Target::Force(newtons), Some(found)) => newtons / found.coulomb_n,
            (Target::Force(_), None) => f32::NAN,
        }
    }

    /// Continues the present computation or starts the next: a few hundred instructions, for blocks
    /// with spare time.
    #[inline(never)]
    pub(crate) fn work(&mut self) {
        if let Some(survey) = &mut self.survey {
            return survey.work();
        }
        let target = self.target_ratio;
        let new = target.to_bits() != self.solved_ratio.to_bits();
        match &mut self.work {
            Work::Rest(left) if *left > 0 && !new => *left -= 1,
            Work::Rest(_) => {
                // Started solutions are completed, even if the target moves continuously.
                self.solved_ratio = target;
                self.work = self.solve(target);
            }
            Work::Solve { target, least_xi, inverse } => {
                let Some(solution) = inverse.step() else { return };
                let (target, least_xi) = (*target, *least_xi);
                self.solution = solution;
                self.choice.choose(target, least_xi, &solution, self.dead());
                let tip = self.tip.value;
                let xi = self.contact().scale * self.speed.value / tip;
                self.work = Work::Estimate(Evaluation::new(xi, tip / (self.omega * self.contact().dahl_length_m)));
            }
            Work::Estimate(evaluation) => {
                let Some(ratio) = evaluation.step() else { return };
                self.ratio = ratio;
                self.belief = Some(self.estimated());
                self.work = Work::Rest(REST_BLOCKS);
            }
        }
    }

    fn solve(&self, target: f32) -> Work {
        let contact = self.contact();
        let speed = contact.scale * self.speed.value;
        let least_xi = speed * self.force_factor / self.most_amperes;
        let lambda = match self.law {
            FrictionLaw::Dahl => speed / (self.omega * contact.dahl_length_m),
            FrictionLaw::Coulomb => f32::INFINITY,
        };
        Work::Solve { target, least_xi, inverse: Inverse::new(target, lambda, least_xi) }
    }
}
