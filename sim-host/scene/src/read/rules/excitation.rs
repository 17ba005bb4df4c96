//! The excitation of a contact study: what its waveform needs, and what a velocity ratio is of.

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
/// Most values of a random waveform.
const MOST_HOLDS: f64 = 1e8;

impl Rules<'_> {
    pub(super) fn excited(&mut self) {
        self.force();
        self.waveform();
        self.hertz();
        self.compliant();
        self.velocity_ratio();
        self.window();
    }

    fn force(&mut self) {
        if self.given("rig.kinematic") && self.value(FORCE).is_some() {
            let message = "a force cannot shake [rig.kinematic], whose motion is given";
            let problem = Problem::new(self.key(FORCE), message, "not with [rig.kinematic]");
            self.add(FORCE, problem.help(format!("how fast it vibrates is `{VIBRATION}`")));
        }
        let moves = self.text(WAVEFORM).is_some_and(|waveform| waveform != "still");
        if self.given("rig.sdof") && moves && self.lacks(FORCE) {
            let problem =
                Problem::new(self.place(EXCITATION), "`force_n` is missing in [excitation]", "needs `force_n`, a number in N");
            self.add(FORCE, problem.help("the peak force that shakes the mass of [rig.sdof]"));
        }
    }

    fn waveform(&mut self) {
        let Some(waveform) = self.text(WAVEFORM) else { return };
        let needed: &[(&str, &str)] = match waveform {
            "random" => &[("hold_time_s", "how long each random value is held decides what it does to friction")],
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
                let problem = Problem::new(self.place(WAVEFORM), message, format!("needs `{key}` beside it"));
                self.add(&path, problem.help(*why));
            }
        }
        let (hold, duration) = (self.number(HOLD), self.number("duration_s"));
        if let (Some(hold), Some(duration)) = (hold, duration)
            && waveform == "random"
            && duration / hold > MOST_HOLDS
        {
            let message = format!("a random excitation of {} values", shown((duration / hold).ceil()));
            let label = format!("must be at least {} s", shown(duration / MOST_HOLDS));
            let problem = Problem::new(self.place(HOLD), message, label);
            self.add(HOLD, problem.help(format!("it may have {} values at most", shown(MOST_HOLDS))));
        }
    }

    /// A Hertzian contact has a solution for a given sine, and for a mass that a sine shakes.
    fn hertz(&mut self) {
        const HERTZ: &str = "contact.hertz";
        if !self.given(HERTZ) {
            return;
        }
        if self.given("rig.sdof") && self.value(RATIO).is_some() {
            let message = "the velocity of a mass on a Hertzian contact is not known beforehand";
            let problem = Problem::new(self.place(RATIO), message, "`velocity_ratio` is of nothing");
            self.add(
                RATIO,
                problem
                    .help("give `sliding_m_per_s` instead: the vibration is across the surface, and does not count in the slip"),
            );
        }
        if self.text(WAVEFORM).is_some_and(|waveform| waveform != "sine") {
            let message = "a Hertzian contact is studied under a sine only";
            let problem = Problem::new(self.place(WAVEFORM), message, "must be `sine` with [contact.hertz]");
            self.add(WAVEFORM, problem);
        }
        for path in self.tables("disturbance") {
            let message = "a Hertzian contact is studied under one load only";
            let problem = Problem::new(self.place(&path), message, "not with [contact.hertz]");
            self.add(&path, problem);
        }
    }

    /// A velocity ratio needs a vibration, and one with an end.
    fn velocity_ratio(&mut self) {
        if self.value(RATIO).is_none() || self.text("excitation.velocity_ratio_of") != Some("steady") {
            return;
        }
        let peak = if self.given("rig.kinematic") { VIBRATION } else { FORCE };
        let nothing = self.number(peak) == Some(0.0) || (self.given("rig.sdof") && self.lacks(FORCE));
        let oscillator = ["mass_kg", "stiffness_n_per_m", "damping_ratio"].map(|key| self.number(&join("rig.sdof", key)));
        let (message, label, help) = match (oscillator, self.number(FREQUENCY)) {
            _ if nothing => (
                "there is no vibration that the velocity ratio could be of".to_owned(),
                "`velocity_ratio` is of zero velocity",
                "give `sliding_m_per_s` instead",
            ),
            ([Some(mass), Some(stiffness), Some(damping)], Some(hz)) if resonates(mass, stiffness, damping, hz) => (
                format!("at {} Hz, the resonance of a mass without damping, the vibration grows without bound", shown(hz)),
                "`velocity_ratio` is of no finite velocity",
                "give `rig.sdof.damping_ratio`, or `sliding_m_per_s` instead of the ratio",
            ),
            _ => return,
        };
        let at = if nothing { self.newer(RATIO, peak) } else { self.newer(RATIO, FREQUENCY) };
        let problem = Problem::new(self.place(at), message, label);
        self.add(RATIO, problem.help(help));
    }
}
