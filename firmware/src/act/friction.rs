//! The friction switch: from the set point of a friction ratio, or of a friction force, to tip velocity or burst duty.
//!
//! Vibration along the motion lowers the mean friction of a sliding contact. By how much follows from the [law](dahl), and the drive that does it
//! from its [inverse]; the amplitude loop holds the motional current that belongs to it: tip velocity times the nominal
//! force factor. The contact is not configured but identified: a `survey` measures its friction in silence and at three amplitudes and
//! fits it. Where the law is steep, bursts take the place of the amplitude (`regime`).
//!
//! ```text
//! target ratio -> inverse law -> regime -> amplitude, gate, ON time of bursts -> amplitude loop and burst
//!                    ^  Dahl length, scale, friction in silence, dead time
//!                 survey <- force, motional current, belt speed
//! ```
//!
//! A knob has detents (`detents.rs`): its set point follows its position.
//!
//! What is calculated is spread over blocks. A ratio that is not to be had is refused by number, and the nearest that can be is driven.

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
use crate::act::friction::regime::{Choice, Regime, Short};
use crate::act::friction::survey::{Found, Play, Progress, Reading, Survey};
use crate::seam::block::{Amplitude, Target};
use crate::seam::config::{Config, FrictionLaw, Schedule};
use crate::seam::error::Error;
use crate::seam::fault::Limit;
use crate::seam::features;
use crate::seam::telemetry::FrictionEstimate;

/// Time constant by which the sliding speed and the tip velocity are smoothed, s.
const SMOOTH_S: f32 = 2e-3;
/// The same for the force, which has bursts in it.
const FORCE_S: f32 = 20e-3;
/// Blocks of rest after a solution.
const REST_BLOCKS: u32 = 32;
/// Amplitude and force sensor settle in this time, s.
const SETTLE_S: f32 = 30e-3;

#[derive(Clone, Debug)]
enum Work {
    /// Nothing, for so many blocks more.
    Rest(u32),
    /// Seeks the drive for this ratio.
    Solve { target: f32, least_xi: f32, inverse: Inverse },
    /// Evaluates the ratio at what is measured.
    Estimate(Evaluation),
}

/// The friction switch: a controller of the friction ratio by amplitude or bursts.
#[derive(Clone, Debug)]
pub struct FrictionSwitch {
    _enabled: features::Friction,
    law: FrictionLaw,
    target: Target,
    detents: Option<Detents>,
    omega: f32,
    force_factor: f32,
    /// Largest motional current, A.
    most_amperes: f32,
    /// Period of the bursts, samples, if there are any.
    period: Option<f32>,
    settle_blocks: u32,
    average_blocks: u32,
    /// Whole bursts, in about that time.
    burst_blocks: Option<u32>,
    nominal: Contact,
    survey: Option<Survey>,
    play: Play,
    found: Option<Found>,
    /// The force sensor says what cannot be.
    implausible: bool,
    speed: LowPass,
    tip: LowPass,
    force: LowPass,
    work: Work,
    solution: Solution,
    choice: Choice,
    ratio: f32,
    belief: Option<FrictionEstimate>,
    /// The ratio that is being solved for, or was last.
    last: f32,
    /// The target of the friction ratio now.
    asked: f32,
    /// Set point of the drive.
    ordered: SetPoint,
}

impl FrictionSwitch {
    /// Checks the settings of a friction switch; `None` if none is configured.
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
            last: 1.0,
            asked: 1.0,
            ordered: SetPoint::Silence,
        };
        switch.restart();
        Ok(Some(switch))
    }

    /// Forgets the contact, and surveys it again.
    pub(crate) fn restart(&mut self) {
        let loudest = self.most_amperes / self.force_factor;
        let (settle, average) = (self.settle_blocks, self.average_blocks);
        self.survey = Some(Survey::new(self.omega, loudest, settle, average, self.burst_blocks));
        (self.play, self.found, self.implausible, self.belief) = (Play::Silence, None, false, None);
        (self.work, self.ordered) = (Work::Rest(0), SetPoint::Silence);
        self.solution = Solution { xi: 1.0, ratio: 1.0, floor: 1.0 };
    }

    /// Takes one block of a run, and says what to play. `ordered` takes the place of the configured target.
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
        self.asked = match (&self.detents, sensed.counts) {
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

    /// Set point of the drive, from the last step.
    pub fn set_point(&self) -> SetPoint {
        self.ordered
    }

    /// Whether its set point moves with a knob, and with it the drive.
    pub(crate) fn moves(&self) -> bool {
        self.detents.is_some()
    }

    /// Why the friction misses its set point, if it does.
    pub(crate) fn limit(&self) -> Option<Limit> {
        match self.choice.short() {
            _ if self.survey.is_some() => None,
            Some(Short::NoAuthority) => Some(Limit::NoAuthority),
            Some(Short::Unreachable) => Some(Limit::RatioUnreachable),
            None => None,
        }
    }

    /// Whether the contact is being surveyed.
    pub(crate) fn is_surveying(&self) -> bool {
        self.survey.is_some()
    }

    /// Whether the force sensor has said in the survey what cannot be friction.
    pub(crate) fn is_implausible(&self) -> bool {
        self.implausible
    }

    /// Estimate of the contact by the last calculation; `None` before the survey is over.
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

    /// Dead time of bursts as a part of their period, if there are any.
    fn dead(&self) -> Option<f32> {
        self.period.map(|_| self.found.map_or(0.0, |found| found.dead))
    }

    /// So much, or as much as there is.
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

    /// Target of the friction ratio. It is not a number for a force while the friction without vibration is unknown.
    fn ratio_of(&self, target: Target) -> f32 {
        match (target, self.found) {
            (Target::Ratio(ratio), _) => ratio,
            (Target::Force(newtons), Some(found)) => newtons / found.coulomb_n,
            (Target::Force(_), None) => f32::NAN,
        }
    }

    /// Goes on with what is being calculated, or begins with what is next: a few hundred instructions, for blocks that have time for them.
    #[inline(never)]
    pub(crate) fn work(&mut self) {
        if let Some(survey) = &mut self.survey {
            return survey.work();
        }
        let target = self.asked;
        let new = target.to_bits() != self.last.to_bits();
        match &mut self.work {
            Work::Rest(left) if *left > 0 && !new => *left -= 1,
            Work::Rest(_) => {
                // A solution that was begun is completed: a target that moves all the time must not prevent that.
                self.last = target;
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
