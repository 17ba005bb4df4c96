//! Identification of the contact in place, while running: the friction without vibration, at three amplitudes, and, where
//! there are bursts, at half duty.
//!
//! ```text
//! silent -> maximum amplitude -> two smaller ones -> (fit) -> bursts -> over
//! ```
//!
//! Each place is left to settle, and then the force sensor is averaged; what counts is the ratio to the force in silence, so that its gain
//! does not matter, but its zero does: an offset of 1 % of the friction is 0.01 in a ratio near zero. The softer amplitudes lie where the inverse
//! law is used: the last at a velocity ratio of 0.85, the other half way in between.
//!
//! Bursts are described by how much their friction is lower than their ON time implies, as a time that is added to each: the **dead time**, of edges,
//! of the contact's own memory and of gates that wait for a passage through zero.

use heapless::Vec;

use super::fit::{AMPLITUDES, Contact, Fit, Observation};

/// Velocity ratio of the softest amplitude.
const SOFTEST_XI: f32 = 0.85;
/// What the bursts are measured at.
pub(crate) const TRIAL_DUTY: f32 = 0.5;
/// Friction ratios that can be.
const PLAUSIBLE: core::ops::Range<f32> = -0.05..1.05;

/// What one block shows.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Reading {
    /// Sliding speed, m/s.
    pub(crate) speed_m_per_s: f32,
    /// Tip velocity, by the nominal force factor, m/s.
    pub(crate) tip_m_per_s: f32,
    /// Friction, N; none without a sensor.
    pub(crate) force_n: Option<f32>,
}

/// What is to be played meanwhile.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Play {
    /// The drive is silent.
    Silence,
    /// This tip velocity, m/s.
    Tip(f32),
    /// Bursts of the maximum amplitude with [`TRIAL_DUTY`].
    Bursts,
    /// As before: it is being calculated.
    Same,
}

/// What was found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Found {
    /// The contact.
    pub(crate) contact: Contact,
    /// Friction without vibration, N.
    pub(crate) coulomb_n: f32,
    /// Dead time of bursts, as a part of their period; zero where there are none.
    pub(crate) dead: f32,
}

/// How a survey is getting on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Progress {
    /// The survey goes on, with this drive.
    Busy(Play),
    /// The survey is over, with this result.
    Found(Found),
    /// No force was measured: there is no sensor.
    NoForce,
    /// The measured force cannot be friction.
    Implausible,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Place {
    Silent,
    /// At so many amplitudes before.
    Loud(usize),
    Fit,
    Bursts,
}

/// Means over the blocks of a place that come after it has settled.
#[derive(Clone, Copy, Debug, Default)]
struct Means {
    blocks: u32,
    forces: u32,
    force: f32,
    tip: f32,
    speed: f32,
}

impl Means {
    fn take(&mut self, reading: &Reading) {
        self.blocks += 1;
        self.tip += reading.tip_m_per_s;
        self.speed += reading.speed_m_per_s;
        if let Some(force) = reading.force_n.filter(|force| force.is_finite()) {
            self.forces += 1;
            self.force += force;
        }
    }

    /// Mean force, N, if most blocks had one.
    fn force_n(&self) -> Option<f32> {
        (2 * self.forces > self.blocks).then(|| self.force / self.forces as f32)
    }

    fn of_blocks(&self, sum: f32) -> f32 {
        sum / self.blocks.max(1) as f32
    }
}

/// The survey.
#[derive(Clone, Debug)]
pub(crate) struct Survey {
    omega: f32,
    /// The largest tip velocity, m/s.
    loudest: f32,
    settle_blocks: u32,
    average_blocks: u32,
    /// The same of bursts, if there are any: whole ones.
    burst_blocks: Option<u32>,
    place: Place,
    /// Blocks at this place.
    blocks: u32,
    means: Means,
    coulomb_n: f32,
    /// Sliding speed in silence, m/s.
    speed: f32,
    observations: Vec<Observation, AMPLITUDES>,
    fit: Option<Fit>,
    contact: Option<Contact>,
}

impl Survey {
    /// A survey with a drive of `omega` rad/s up to a tip velocity of `loudest` m/s, so many blocks a place to settle and to average; and bursts,
    /// where there are any, over so many blocks.
    pub(crate) fn new(omega: f32, loudest: f32, settle_blocks: u32, average_blocks: u32, burst_blocks: Option<u32>) -> Self {
        Survey {
            omega,
            loudest,
            settle_blocks,
            average_blocks: average_blocks.max(1),
            burst_blocks,
            place: Place::Silent,
            blocks: 0,
            means: Means::default(),
            coulomb_n: 0.0,
            speed: 0.0,
            observations: Vec::new(),
            fit: None,
            contact: None,
        }
    }

    /// Takes one block.
    pub(crate) fn step(&mut self, reading: &Reading) -> Progress {
        if self.place == Place::Fit {
            return self.fitted();
        }
        self.blocks += 1;
        if self.blocks > self.settle_blocks {
            self.means.take(reading);
        }
        let average_blocks = self.burst_blocks.filter(|_| self.place == Place::Bursts).unwrap_or(self.average_blocks);
        if self.blocks < self.settle_blocks + average_blocks {
            return Progress::Busy(self.play());
        }
        let means = core::mem::take(&mut self.means);
        self.blocks = 0;
        match means.force_n() {
            Some(force) => self.conclude(&means, force),
            None => Progress::NoForce,
        }
    }

    /// A place is over, with this mean force.
    fn conclude(&mut self, means: &Means, force: f32) -> Progress {
        if self.place == Place::Silent {
            // Backwards is friction, too.
            (self.coulomb_n, self.speed) = (force, means.of_blocks(means.speed));
            self.place = Place::Loud(0);
            let some = force != 0.0 && self.speed > 0.0 && self.loudest > 0.0;
            return if some { Progress::Busy(self.play()) } else { Progress::Implausible };
        }
        let ratio = force / self.coulomb_n;
        if !PLAUSIBLE.contains(&ratio) {
            return Progress::Implausible;
        }
        if let (Place::Bursts, Some(contact), Some(loudest)) = (self.place, self.contact, self.observations.first()) {
            let part = (1.0 - ratio) / (1.0 - loudest.ratio);
            // Without an effect of the maximum amplitude, bursts have none either.
            let dead = if part.is_finite() { (part - TRIAL_DUTY).clamp(-TRIAL_DUTY, TRIAL_DUTY) } else { 0.0 };
            return Progress::Found(Found { contact, coulomb_n: self.coulomb_n.abs(), dead });
        }
        let tip_m_per_s = means.of_blocks(means.tip);
        let observation = Observation { speed_m_per_s: means.of_blocks(means.speed), tip_m_per_s, ratio };
        // There is room for as many as there are places.
        let _ = self.observations.push(observation);
        self.place = match self.observations.len() {
            AMPLITUDES => {
                self.fit = Some(Fit::new(self.omega, self.observations.clone()));
                Place::Fit
            }
            next => Place::Loud(next),
        };
        Progress::Busy(self.play())
    }

    /// Goes on with the fit, if it is its time: for blocks that have time.
    pub(crate) fn work(&mut self) {
        if let Some(contact) = self.fit.as_mut().and_then(Fit::step) {
            (self.fit, self.contact) = (None, Some(contact));
        }
    }

    fn fitted(&mut self) -> Progress {
        let Some(contact) = self.contact else { return Progress::Busy(Play::Same) };
        if self.burst_blocks.is_none() {
            return Progress::Found(Found { contact, coulomb_n: self.coulomb_n.abs(), dead: 0.0 });
        }
        self.place = Place::Bursts;
        Progress::Busy(Play::Bursts)
    }

    fn play(&self) -> Play {
        match self.place {
            Place::Silent => Play::Silence,
            Place::Loud(n) => Play::Tip(self.tip(n)),
            Place::Fit => Play::Same,
            Place::Bursts => Play::Bursts,
        }
    }

    /// The tip velocity of an amplitude, m/s: the largest, the smallest, and their geometric mean.
    fn tip(&self, n: usize) -> f32 {
        let softest = (self.speed / SOFTEST_XI).min(self.loudest);
        match n {
            0 => self.loudest,
            1 => libm::sqrtf(self.loudest * softest),
            _ => softest,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::dahl::friction_ratio;
    use super::*;

    const OMEGA: f32 = 2.0 * core::f32::consts::PI * 40e3;

    /// A survey of a contact of 0.5 um whose measured force is a function of what is played and of the true friction.
    fn survey(bursts: bool, force: impl Fn(Play, f32) -> Option<f32>) -> (Progress, u32) {
        let mut survey = Survey::new(OMEGA, 0.175, 20, 100, bursts.then_some(120));
        let mut play = Play::Silence;
        for n in 1..5000 {
            let tip = match play {
                Play::Tip(tip) => tip,
                Play::Bursts => 0.175,
                _ => 0.0,
            };
            let ratio = if tip > 0.0 { friction_ratio(0.038 / tip, tip / (OMEGA * 0.5e-6)) } else { 1.0 };
            // A dead time of 0.03 of the period.
            let ratio = if play == Play::Bursts { 1.0 - (TRIAL_DUTY + 0.03) * (1.0 - ratio) } else { ratio };
            let reading = Reading { speed_m_per_s: 0.038, tip_m_per_s: tip, force_n: force(play, 0.144 * ratio) };
            survey.work();
            match survey.step(&reading) {
                Progress::Busy(Play::Same) => {}
                Progress::Busy(next) => play = next,
                over => return (over, n),
            }
        }
        panic!("it does not end");
    }

    #[test]
    fn finds_the_contact_and_the_dead_time() {
        let (progress, blocks) = survey(true, |_, force| Some(force));
        let Progress::Found(found) = progress else { panic!("{progress:?}") };
        assert!(
            (found.contact.dahl_length_m / 0.5e-6 - 1.0).abs() < 0.01 && (found.contact.scale - 1.0).abs() < 2e-3,
            "{found:?}"
        );
        assert!((found.coulomb_n - 0.144).abs() < 1e-5 && (found.dead - 0.03).abs() < 1e-3, "{found:?}");
        assert!(blocks < 5 * 120 + 620, "{blocks}");
    }

    /// A sensor that is mounted the other way round, or of another gain, says the same.
    #[test]
    fn sign_and_gain_of_the_sensor_do_not_matter() {
        for gain in [-1.0, 3.0] {
            let (progress, _) = survey(true, |_, force| Some(gain * force));
            assert!(matches!(progress, Progress::Found(found) if (found.dead - 0.03).abs() < 1e-3), "{gain}: {progress:?}");
        }
    }

    #[test]
    fn what_is_no_friction_is_refused() {
        assert_eq!(survey(false, |_, _| None).0, Progress::NoForce);
        assert_eq!(survey(false, |_, _| Some(f32::NAN)).0, Progress::NoForce);
        assert_eq!(survey(false, |_, _| Some(0.0)).0, Progress::Implausible);
        let louder = |play, force: f32| Some(if matches!(play, Play::Tip(_)) { 2.0 } else { force });
        assert_eq!(survey(false, louder).0, Progress::Implausible);
        let turned = |play, force: f32| Some(if matches!(play, Play::Tip(_)) { -force } else { force });
        assert_eq!(survey(false, turned).0, Progress::Implausible);
        // One that sticks at what it was shows no effect of any amplitude: a contact that cannot be.
        let stuck = survey(false, |_, _| Some(0.144)).0;
        assert!(matches!(stuck, Progress::Found(found) if found.contact.dahl_length_m > 0.0), "{stuck:?}");
    }
}
