//! The friction switch: from a wanted friction ratio, or a wanted force, to tip velocity or burst duty.
//!
//! Vibration along the motion lowers the mean friction of a sliding contact. By how much is told by the [law](dahl), and the drive that does it
//! by its [inverse]; the amplitude loop holds the motional current that belongs to it: tip velocity times force factor, which is told
//! as nominal. What the contact is, nobody tells: a `survey` measures its friction in silence and at three amplitudes and
//! fits it. Where the law is steep, bursts take the place of the amplitude (`regime`).
//!
//! ```text
//! wanted ratio -> inverse law -> regime -> amplitude, gate, ON time of bursts -> amplitude loop and burst
//!                    ^  Dahl length, scale, friction in silence, dead time
//!                 survey <- force, motional current, belt speed
//! ```
//!
//! What is calculated is spread over blocks. A ratio that is not to be had is refused by number, and the nearest that can be is driven.

mod average;
pub mod dahl;
pub(crate) mod fit;
pub mod inverse;
pub(crate) mod regime;
pub(crate) mod survey;
mod terms;
#[cfg(test)]
mod tests;

pub use terms::{Sensed, Wanted};

use crate::act::friction::average::LowPass;
use crate::act::friction::dahl::Evaluation;
use crate::act::friction::fit::Contact;
use crate::act::friction::inverse::{Inverse, Solution};
use crate::act::friction::regime::{Choice, Regime, Short};
use crate::act::friction::survey::{Found, Heard, Play, Progress, Survey};
use crate::seam::block::{Amplitude, Target};
use crate::seam::config::{Config, FrictionLaw, Schedule};
use crate::seam::error::Error;
use crate::seam::fault::Limit;
use crate::seam::features;
use crate::seam::telemetry::Belief;

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
    Solve { wanted: f32, least_xi: f32, inverse: Inverse },
    /// Evaluates the ratio at what is measured.
    Believe(Evaluation),
}

/// The switch.
#[derive(Clone, Debug)]
pub struct FrictionSwitch {
    _carried: features::Friction,
    law: FrictionLaw,
    target: Target,
    omega: f32,
    force_factor: f32,
    /// Loudest motional current, A.
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
    belief: Option<Belief>,
    /// The ratio that is being solved for, or was last.
    last: f32,
    /// The ratio that is wanted now.
    asked: f32,
    /// What is to be played.
    ordered: Wanted,
}

impl FrictionSwitch {
    /// Checks the settings of a switch; none, if none is wanted.
    pub(crate) fn build(config: &Config, block_s: f32) -> Result<Option<Self>, Error> {
        let Some(friction) = &config.friction else { return Ok(None) };
        let carried = features::friction()?;
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
            _carried: carried,
            law: friction.law,
            target: friction.target,
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
            ordered: Wanted::Silence,
        };
        switch.restart();
        Ok(Some(switch))
    }

    /// Forgets the contact, and surveys it anew.
    pub(crate) fn restart(&mut self) {
        let loudest = self.most_amperes / self.force_factor;
        let (settle, average) = (self.settle_blocks, self.average_blocks);
        self.survey = Some(Survey::new(self.omega, loudest, settle, average, self.burst_blocks));
        (self.play, self.found, self.implausible, self.belief) = (Play::Silence, None, false, None);
        (self.work, self.ordered) = (Work::Rest(0), Wanted::Silence);
        self.solution = Solution { xi: 1.0, ratio: 1.0, floor: 1.0 };
    }

    /// Takes one block of a run, and says what to play. `ordered` takes the place of the configured target.
    pub fn step(&mut self, ordered: Option<Target>, sensed: &Sensed) -> Wanted {
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
        self.asked = self.ratio_of(ordered.unwrap_or(self.target));
        self.ordered = match self.choice.regime() {
            Regime::Silent => Wanted::Silence,
            Regime::Amplitude(xi) => self.current(self.contact().scale * self.speed.value / xi),
            Regime::Bursts(on) => Wanted::Bursts { amperes: self.most_amperes, on_samples: on * self.period.unwrap_or(0.0) },
        };
        self.ordered
    }

    /// What is to be played, as the last step has said.
    pub fn wanted(&self) -> Wanted {
        self.ordered
    }

    /// Why the friction is not what is wanted, if it is not.
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

    /// What is believed of the contact, since the last calculation; nothing before the survey is over.
    pub(crate) fn belief(&self) -> Option<Belief> {
        self.belief
    }

    fn believe(&self) -> Belief {
        let contact = self.contact();
        let ratio = match self.choice.regime() {
            Regime::Silent => 1.0,
            Regime::Amplitude(_) => self.ratio,
            Regime::Bursts(on) => 1.0 - (1.0 - self.ratio) * (on + self.dead().unwrap_or(0.0)),
        };
        Belief {
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
    fn current(&self, tip_m_per_s: f32) -> Wanted {
        let amperes = tip_m_per_s * self.force_factor;
        Wanted::Current(if amperes < self.most_amperes { amperes } else { self.most_amperes })
    }

    fn step_survey(&mut self, sensed: &Sensed) {
        let Some(survey) = &mut self.survey else { return };
        let heard = Heard { speed_m_per_s: self.speed.value, tip_m_per_s: self.tip.value, force_n: sensed.force_n };
        match survey.step(&heard) {
            Progress::Busy(Play::Same) => {}
            Progress::Busy(play) => self.play = play,
            Progress::Found(found) => (self.survey, self.found) = (None, Some(found)),
            Progress::Unheard => self.survey = None,
            Progress::Implausible => (self.survey, self.implausible) = (None, true),
        }
    }

    fn surveyed(&self) -> Wanted {
        match self.play {
            Play::Tip(tip) => self.current(tip),
            Play::Bursts => {
                Wanted::Bursts { amperes: self.most_amperes, on_samples: survey::TRIAL_DUTY * self.period.unwrap_or(0.0) }
            }
            Play::Silence | Play::Same => Wanted::Silence,
        }
    }

    /// The ratio that is wanted. A force of which nobody knows what part it is, is not a number.
    fn ratio_of(&self, target: Target) -> f32 {
        match (target, self.found) {
            (Target::Ratio(ratio), _) => ratio,
            (Target::Force(newtons), Some(found)) => newtons / found.coulomb_n,
            (Target::Force(_), None) => f32::NAN,
        }
    }

    /// Goes on with what is being calculated, or begins with what is next: a few hundred instructions, for blocks that have time for them.
    pub(crate) fn work(&mut self) {
        if let Some(survey) = &mut self.survey {
            return survey.work();
        }
        let wanted = self.asked;
        let new = wanted.to_bits() != self.last.to_bits();
        match &mut self.work {
            Work::Rest(left) if *left > 0 && !new => *left -= 1,
            Work::Rest(_) => {
                // What is begun is ended: a wanted ratio that moves all the time must not keep it from that.
                self.last = wanted;
                self.work = self.solve(wanted);
            }
            Work::Solve { wanted, least_xi, inverse } => {
                let Some(solution) = inverse.step() else { return };
                let (wanted, least_xi) = (*wanted, *least_xi);
                self.solution = solution;
                self.choice.choose(wanted, least_xi, &solution, self.dead());
                let tip = self.tip.value;
                let xi = self.contact().scale * self.speed.value / tip;
                self.work = Work::Believe(Evaluation::new(xi, tip / (self.omega * self.contact().dahl_length_m)));
            }
            Work::Believe(evaluation) => {
                let Some(ratio) = evaluation.step() else { return };
                self.ratio = ratio;
                self.belief = Some(self.believe());
                self.work = Work::Rest(REST_BLOCKS);
            }
        }
    }

    fn solve(&self, wanted: f32) -> Work {
        let contact = self.contact();
        let speed = contact.scale * self.speed.value;
        let least_xi = speed * self.force_factor / self.most_amperes;
        let lambda = match self.law {
            FrictionLaw::Dahl => speed / (self.omega * contact.dahl_length_m),
            FrictionLaw::Coulomb => f32::INFINITY,
        };
        Work::Solve { wanted, least_xi, inverse: Inverse::new(wanted, lambda, least_xi) }
    }
}
