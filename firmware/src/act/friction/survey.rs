//! Survey: identifies the contact in place during operation. It measures the friction without
//! vibration, at three amplitudes, and at half duty if bursts are configured.
//!
//! ```text
//! silent -> maximum amplitude -> two smaller ones -> (fit) -> bursts -> over
//! ```
//!
//! At each point the drive settles, then the force is averaged. Only the ratio to the force without
//! vibration is used. The gain of the force sensor therefore does not matter, but its zero does: an
//! offset of 1 % of the friction is 0.01 in a ratio near zero. The smaller amplitudes are in the
//! range where the inverse law is used: the last at a velocity ratio of 0.85, the other halfway.
//!
//! The friction of bursts is lower than their ON time implies. The difference is stated as a time
//! that is added to each burst, the **dead time**. It is caused by edges, by the memory of the
//! contact, and by gates that wait for a zero crossing.

use super::fit::{AMPLITUDES, Contact, Fit, Observation};

/// Velocity ratio of the smallest amplitude.
const SMALLEST_AMPLITUDE_XI: f32 = 0.85;
/// Duty at which bursts are measured.
pub(crate) const TRIAL_DUTY: f32 = 0.5;
/// Range of plausible friction ratios.
const PLAUSIBLE_RATIOS: core::ops::Range<f32> = -0.05..1.05;

/// Measurements of one block.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Reading {
    /// Sliding speed, m/s.
    pub(crate) speed_m_per_s: f32,
    /// Tip velocity, by the nominal force factor, m/s.
    pub(crate) tip_m_per_s: f32,
    /// Friction, N; `None` without a sensor.
    pub(crate) force_n: Option<f32>,
}

/// Drive during the survey.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Play {
    /// No drive.
    Silence,
    /// Constant tip velocity, m/s.
    Tip(f32),
    /// Bursts of the maximum amplitude with [`TRIAL_DUTY`].
    Bursts,
    /// As before, during a computation.
    Same,
}

/// Result of a survey.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Found {
    /// Identified contact.
    pub(crate) contact: Contact,
    /// Friction without vibration, N.
    pub(crate) coulomb_n: f32,
    /// Dead time of bursts, relative to their period; zero without bursts.
    pub(crate) dead: f32,
}

/// State of a survey after a block.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Progress {
    /// The survey continues with this drive.
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
    /// Drive after this number of amplitudes.
    Driven(usize),
    Fit,
    Bursts,
}

/// Sums over the settled blocks of a point.
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

    /// Returns the mean force, N, if most blocks had one.
    fn force_n(&self) -> Option<f32> {
        (2 * self.forces > self.blocks).then(|| self.force / self.forces as f32)
    }

    fn of_blocks(&self, sum: f32) -> f32 {
        sum / self.blocks.max(1) as f32
    }
}

/// Survey in progress.
#[derive(Clone, Debug)]
pub(crate) struct Survey {
    /// Maximum tip velocity, m/s.
    max_tip_m_per_s: f32,
    settle_blocks: u32,
    average_blocks: u32,
    /// Blocks to average for bursts, a whole number of bursts; `None` without bursts.
    burst_blocks: Option<u32>,
    place: Place,
    /// Blocks at this point.
    blocks: u32,
    means: Means,
    coulomb_n: f32,
    /// Sliding speed without vibration, m/s.
    speed: f32,
    fit: Fit,
    contact: Option<Contact>,
}

impl Survey {
    /// Creates a survey with a drive of `omega`, rad/s, up to the tip velocity `max_tip_m_per_s`,
    /// m/s. Each point takes `settle_blocks` and `average_blocks`; bursts are averaged over
    /// `burst_blocks`, if any.
    pub(crate) fn new(
        omega: f32,
        max_tip_m_per_s: f32,
        settle_blocks: u32,
        average_blocks: u32,
        burst_blocks: Option<u32>,
    ) -> Self {
        Survey {
            max_tip_m_per_s,
            settle_blocks,
            average_blocks: average_blocks.max(1),
            burst_blocks,
            place: Place::Silent,
            blocks: 0,
            means: Means::default(),
            coulomb_n: 0.0,
            speed: 0.0,
            fit: Fit::new(omega),
            contact: None,
        }
    }

    /// Processes one block.
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

    /// Ends a point with this mean force.
    fn conclude(&mut self, means: &Means, force: f32) -> Progress {
        if self.place == Place::Silent {
            // The force may be negative.
            (self.coulomb_n, self.speed) = (force, means.of_blocks(means.speed));
            self.place = Place::Driven(0);
            let some = force != 0.0 && self.speed > 0.0 && self.max_tip_m_per_s > 0.0;
            return if some { Progress::Busy(self.play()) } else { Progress::Implausible };
        }
        let ratio = force / self.coulomb_n;
        if !PLAUSIBLE_RATIOS.contains(&ratio) {
            return Progress::Implausible;
        }
        if let (Place::Bursts, Some(contact), Some(largest)) = (self.place, self.contact, self.fit.observations().first()) {
            let part = (1.0 - ratio) / (1.0 - largest.ratio);
            // If the maximum amplitude has no effect, bursts have none either.
            let dead = if part.is_finite() { (part - TRIAL_DUTY).clamp(-TRIAL_DUTY, TRIAL_DUTY) } else { 0.0 };
            return Progress::Found(Found { contact, coulomb_n: self.coulomb_n.abs(), dead });
        }
        let tip_m_per_s = means.of_blocks(means.tip);
        let observation = Observation { speed_m_per_s: means.of_blocks(means.speed), tip_m_per_s, ratio };
        self.fit.observe(observation);
        self.place = match self.fit.observations().len() {
            AMPLITUDES => Place::Fit,
            next => Place::Driven(next),
        };
        Progress::Busy(self.play())
    }

    /// Advances the fit during its stage, for blocks with spare time.
    pub(crate) fn work(&mut self) {
        if let Some(contact) = self.fit.step() {
            self.contact = Some(contact);
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
            Place::Driven(n) => Play::Tip(self.tip(n)),
            Place::Fit => Play::Same,
            Place::Bursts => Play::Bursts,
        }
    }

    /// Returns the tip velocity of an amplitude, m/s: the largest, the geometric mean, and the
    /// smallest.
    fn tip(&self, n: usize) -> f32 {
        let smallest = (self.speed / SMALLEST_AMPLITUDE_XI).min(self.max_tip_m_per_s);
        match n {
            0 => self.max_tip_m_per_s,
            1 => fpu::sqrtf(self.max_tip_m_per_s * smallest),
            _ => smallest,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::dahl::friction_ratio;
    use super::*;

    const OMEGA: f32 = 2.0 * core::f32::consts::PI * 40e3;

    /// Surveys a contact of 0.5 um. The measured force is a function of the drive and of the true
    /// friction.
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
            // The dead time is 0.03 of the period.
            let ratio = if play == Play::Bursts { 1.0 - (TRIAL_DUTY + 0.03) * (1.0 - ratio) } else { ratio };
            let reading = Reading { speed_m_per_s: 0.038, tip_m_per_s: tip, force_n: force(play, 0.144 * ratio) };
            survey.work();
            match survey.step(&reading) {
                Progress::Busy(Play::Same) => {}
                Progress::Busy(next) => play = next,
                over => return (over, n),
            }
        }
        panic!("the survey does not end");
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

    /// A sensor with reversed sign or another gain gives the same result.
    #[test]
    fn sign_and_gain_of_the_sensor_do_not_matter() {
        for gain in [-1.0, 3.0] {
            let (progress, _) = survey(true, |_, force| Some(gain * force));
            assert!(matches!(progress, Progress::Found(found) if (found.dead - 0.03).abs() < 1e-3), "{gain}: {progress:?}");
        }
    }

    #[test]
    fn implausible_forces_are_refused() {
        assert_eq!(survey(false, |_, _| None).0, Progress::NoForce);
        assert_eq!(survey(false, |_, _| Some(f32::NAN)).0, Progress::NoForce);
        assert_eq!(survey(false, |_, _| Some(0.0)).0, Progress::Implausible);
        let too_large = |play, force: f32| Some(if matches!(play, Play::Tip(_)) { 2.0 } else { force });
        assert_eq!(survey(false, too_large).0, Progress::Implausible);
        let turned = |play, force: f32| Some(if matches!(play, Play::Tip(_)) { -force } else { force });
        assert_eq!(survey(false, turned).0, Progress::Implausible);
        // A stuck sensor shows no effect of vibration; the result is extreme but finite.
        let stuck = survey(false, |_, _| Some(0.144)).0;
        assert!(matches!(stuck, Progress::Found(found) if found.contact.dahl_length_m > 0.0), "{stuck:?}");
    }
}
