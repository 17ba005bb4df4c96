//! Rules of the excitation of a contact study: keys of the waveform, and reference of the velocity
//! ratio.

use super::Rules;
use crate::diagnostic::Problem;
use crate::nearest::shown;
use crate::problem::resonates;
use crate::schema::join;

const EXCITATION: &str = "excitation";
const FORCE: &str = "excitation.force_n";
const FREQUENCY: &str = "excitation.frequency_hz";
const HOLD: &str = "excitation.hold_time_s";
const RATIO: &str = "excitation.velocity_ratio";
const WAVEFORM: &str = "excitation.waveform";
const VIBRATION: &str = "rig.kinematic.vibration_m_per_s";
const AMPLITUDE: &str = "rig.kinematic.vibration_amplitude_m";
/// Largest peak velocity of a vibration, m/s.
const MAX_VELOCITY_M_PER_S: f64 = 1e4;
/// Largest number of values of a random waveform.
const MAX_RANDOM_VALUES: f64 = 1e8;

impl Rules<'_> {
    pub(super) fn excited(&mut self) {
        self.force();
        self.amplitude();
        self.waveform();
        self.hertz();
        self.compliant();
        self.expression();
        self.velocity_ratio();
        self.window();
    }

    fn force(&mut self) {
        if self.given("rig.kinematic") && self.value(FORCE).is_some() {
            let message = "a force has no effect on [rig.kinematic], whose motion is prescribed";
            let problem = Problem::new(self.key(FORCE), message, "not with [rig.kinematic]");
            self.add(FORCE, problem.help(format!("the velocity of the vibration is `{VIBRATION}`")));
        }
        let moves = self.text(WAVEFORM).is_some_and(|waveform| waveform != "still");
        if self.given("rig.sdof") && moves && self.lacks(FORCE) {
            let problem =
                Problem::new(self.place(EXCITATION), "`force_n` is missing in [excitation]", "needs `force_n`, a number in N");
            self.add(FORCE, problem.help("the peak force on the mass of [rig.sdof]"));
        }
    }

    /// Checks a vibration given by its displacement: that of a sine, of a possible velocity.
    fn amplitude(&mut self) {
        let Some(amplitude_m) = self.number(AMPLITUDE) else { return };
        if self.text(WAVEFORM).is_some_and(|waveform| waveform != "sine") {
            let message = "only the displacement of a sine gives its velocity";
            let problem = Problem::new(self.place(self.newer(AMPLITUDE, WAVEFORM)), message, "only with the waveform `sine`");
            self.add(AMPLITUDE, problem.help(format!("give `{VIBRATION}` instead")));
        }
        let velocity = std::f64::consts::TAU * amplitude_m * self.number(FREQUENCY).unwrap_or(0.0);
        if velocity > MAX_VELOCITY_M_PER_S {
            let message = format!("a peak velocity of {} m/s", shown(velocity));
            let label = format!("`w` times this amplitude must be at most {} m/s", shown(MAX_VELOCITY_M_PER_S));
            let problem = Problem::new(self.place(self.newer(AMPLITUDE, FREQUENCY)), message, label);
            self.add(AMPLITUDE, problem);
        }
    }

    fn waveform(&mut self) {
        let Some(waveform) = self.text(WAVEFORM) else { return };
        let needed: &[(&str, &str)] = match waveform {
            "random" => &[("hold_time_s", "the time for which each random value is held determines the effect on friction")],
            "chirp" => &[
                ("start_hz", "a chirp runs from `start_hz` to `stop_hz`"),
                ("stop_hz", "a chirp runs from `start_hz` to `stop_hz`"),
            ],
            _ => &[],
        };
        for (key, why) in needed {
            let path = join(EXCITATION, key);
            if self.lacks(&path) {
                let message = format!("a {waveform} excitation without `{key}`");
                let problem = Problem::new(self.place(WAVEFORM), message, format!("needs `{key}` as well"));
                self.add(&path, problem.help(*why));
            }
        }
        let (hold, duration) = (self.number(HOLD), self.number("duration_s"));
        if let (Some(hold), Some(duration)) = (hold, duration)
            && waveform == "random"
            && duration / hold > MAX_RANDOM_VALUES
        {
            let message = format!("a random excitation of {} values", shown((duration / hold).ceil()));
            let label = format!("must be at least {} s", shown(duration / MAX_RANDOM_VALUES));
            let problem = Problem::new(self.place(HOLD), message, label);
            self.add(HOLD, problem.help(format!("at most {} values are possible", shown(MAX_RANDOM_VALUES))));
        }
    }

    /// Checks a Hertzian contact: it supports a prescribed sine, or a mass that is excited by a
    /// sine.
    fn hertz(&mut self) {
        const HERTZ: &str = "contact.hertz";
        if !self.given(HERTZ) {
            return;
        }
        if self.given("rig.sdof") && self.value(RATIO).is_some() {
            let message = "the velocity of a mass on a Hertzian contact is not known in advance";
            let problem = Problem::new(self.place(RATIO), message, "`velocity_ratio` has no reference");
            self.add(
                RATIO,
                problem.help("give `sliding_m_per_s` instead: the vibration is across the surface, and is not part of the slip"),
            );
        }
        if self.text(WAVEFORM).is_some_and(|waveform| waveform != "sine") {
            let message = "a Hertzian contact supports only a sine";
            let problem = Problem::new(self.place(WAVEFORM), message, "must be `sine` with [contact.hertz]");
            self.add(WAVEFORM, problem);
        }
        for path in self.tables("disturbance") {
            let message = "a Hertzian contact supports only a constant load";
            let problem = Problem::new(self.place(&path), message, "not with [contact.hertz]");
            self.add(&path, problem);
        }
    }

    /// Checks that the velocity ratio has a reference: a vibration of finite amplitude.
    fn velocity_ratio(&mut self) {
        if self.value(RATIO).is_none() || self.text("excitation.velocity_ratio_of") != Some("steady") {
            return;
        }
        let peak = match self.given("rig.kinematic") {
            true if self.value(AMPLITUDE).is_some() => AMPLITUDE,
            true => VIBRATION,
            false => FORCE,
        };
        let nothing = self.number(peak) == Some(0.0) || (self.given("rig.sdof") && self.lacks(FORCE));
        let oscillator = ["mass_kg", "stiffness_n_per_m", "damping_ratio"].map(|key| self.number(&join("rig.sdof", key)));
        let (message, label, help) = match (oscillator, self.number(FREQUENCY)) {
            _ if nothing => (
                "the velocity ratio needs a vibration, but there is none".to_owned(),
                "`velocity_ratio` refers to zero velocity",
                "give `sliding_m_per_s` instead",
            ),
            ([Some(mass), Some(stiffness), Some(damping)], Some(hz)) if resonates(mass, stiffness, damping, hz) => (
                format!("at {} Hz, the resonance of a mass without damping, the vibration grows without bound", shown(hz)),
                "`velocity_ratio` refers to an infinite velocity",
                "give `rig.sdof.damping_ratio`, or `sliding_m_per_s` instead of the ratio",
            ),
            _ => return,
        };
        let at = if nothing { self.newer(RATIO, peak) } else { self.newer(RATIO, FREQUENCY) };
        let problem = Problem::new(self.place(at), message, label);
        self.add(RATIO, problem.help(help));
    }
}
