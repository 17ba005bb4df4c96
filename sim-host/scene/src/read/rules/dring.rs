//! Rules of a D-ring: it has its own contact, and its restraint measures the belt's force.

use std::f64::consts::TAU;

use super::{Rules, shown};
use crate::diagnostic::Problem;
use crate::wording::header;

const DRING: &str = "rig.dring";
const RESTRAINT: &str = "controller.restraint";
const FORCE: &str = "sensors.force_hz";
const ACTUATOR: &str = "rig.dring.actuator";
const ANGLE: &str = "rig.dring.ring_angle_deg";
const NORMAL: &str = "rig.dring.ring_normal_part";
/// Keys that need a direction of vibration.
const DIRECTION_KEYS: [&str; 2] = ["rig.dring.ring_axis_deg", NORMAL];
/// Keys that need the fitted law.
const FIT_KEYS: [&str; 2] = ["rig.dring.ring_hz", "rig.dring.ring_radius_m"];

impl Rules<'_> {
    pub(super) fn dring(&mut self) {
        self.restraint();
        if !self.given(DRING) {
            return;
        }
        if self.given("contact") {
            let problem =
                Problem::new(self.key("contact"), "[contact] cannot be combined with [rig.dring]", "the D-ring is the contact");
            self.add("contact", problem.help("its friction is given by `rig.dring.mu_high`, `mu_low` and `actuator`"));
        }
        let (low, high) = ("rig.dring.mu_low", "rig.dring.mu_high");
        if let (Some(mu_low), Some(mu_high)) = (self.number(low), self.number(high))
            && mu_low > mu_high
        {
            let at = self.newer(low, high);
            let message = format!("low friction of {} is more than high friction of {}", shown(mu_low), shown(mu_high));
            let problem = Problem::new(self.place(at), message, "`mu_low` must be at most `mu_high`");
            self.add(at, problem);
        }
        self.ring();
        let at_s = "rig.dring.at_s";
        if let Some(time) = self.number(at_s) {
            self.within_the_run(at_s, time);
        }
    }

    /// Checks the direction in which the whole ring vibrates, and its keys.
    fn ring(&mut self) {
        let Some(actuator) = self.text(ACTUATOR) else { return };
        if self.given(ANGLE) && !["ring", "stack"].contains(&actuator) {
            let message = format!("`ring_angle_deg` with the actuator `{actuator}`");
            let problem = Problem::new(self.key(ANGLE), message, "only for `ring` and `stack`");
            self.add(
                ANGLE,
                problem.help(
                    "the other actuators act equally along the whole wrap; omit `ring_angle_deg`, or use `actuator = \"ring\"`",
                ),
            );
        }
        if actuator == "ring" && self.lacks(ANGLE) {
            let problem =
                Problem::new(self.place(ACTUATOR), "the direction of the ring's vibration is missing", "needs `ring_angle_deg`");
            self.add(
                ANGLE,
                problem.help(
                    "0 is radial at the middle of the wrap, 90 along the webbing there; `ring_axis_deg = 90` is along the \
                     ring's axis",
                ),
            );
        }
        self.check_effect(&DIRECTION_KEYS, ANGLE, self.lacks(ANGLE) && actuator != "ring");
        let fitted = self.text(NORMAL) == Some("fitted");
        self.check_effect(&FIT_KEYS, "ring_normal_part = \"fitted\"", !fitted && self.clean(NORMAL));
        if fitted && actuator == "stack" {
            let problem = Problem::new(self.place(NORMAL), "the fitted normal part with the actuator `stack`", "for `ring`");
            self.add(
                NORMAL,
                problem.help("the law is fitted to amplitudes of at least 42 um, but a 40 kHz stack reaches less than 1 um"),
            );
        }
        if fitted && actuator == "ring" {
            self.fitted_amplitude();
        }
    }

    /// Reports keys that have no effect without another key.
    fn check_effect(&mut self, keys: &[&'static str], other: &str, no_effect: bool) {
        let given: Vec<_> = keys.iter().copied().filter(|key| no_effect && self.given(key)).collect();
        for key in given {
            let short = |path: &str| path.rsplit_once("dring.").map_or(path.to_owned(), |(_, key)| key.to_owned());
            let problem =
                Problem::new(self.key(key), format!("`{}` has no effect without `{}`", short(key), short(other)), "omit it");
            self.add(key, problem);
        }
    }

    /// Checks that the amplitude is within the fitted law, which ends at the full amplitude of its
    /// horn.
    fn fitted_amplitude(&mut self) {
        const TIP: &str = "rig.dring.tip_m_per_s";
        const HZ: &str = "rig.dring.ring_hz";
        let hz = if self.given(HZ) { self.number(HZ) } else { Some(crate::dring::RING_HZ) };
        let (Some(tip), Some(hz)) = (self.number(TIP), hz) else { return };
        let amplitude_um = 1e6 * tip / (TAU * hz);
        let full_um = 1e6 * contact::wrap::normal::FULL_M;
        if amplitude_um > full_um {
            let at = self.newer(TIP, HZ);
            let message =
                format!("{} m/s at {} Hz are an amplitude of {} um", shown(tip), shown(hz), shown(amplitude_um.round()));
            let problem = Problem::new(self.place(at), message, format!("at most {} um", shown(full_um)));
            self.add(
                at,
                problem.help(
                    "the law of the normal part is fitted up to the full amplitude of its experiment; `ring_normal_part = \
                     \"none\"` has no such limit",
                ),
            );
        }
    }

    fn restraint(&mut self) {
        if !self.given(RESTRAINT) {
            return;
        }
        let missing =
            [(DRING, "a restraint controls the friction of a D-ring"), (FORCE, "it detects the crash by the force in the belt")];
        for (path, why) in missing {
            if self.lacks(path) {
                let called = if path == DRING { header(path) } else { format!("`{path}`") };
                let message = format!("{} without {called}", header(RESTRAINT));
                let problem = Problem::new(self.key(RESTRAINT), message, format!("needs {called}"));
                self.add(path, problem.help(why));
            }
        }
        if self.given("controller.burst") {
            let message = "[controller.burst] and [controller.restraint] exclude each other";
            let problem = Problem::new(self.key("controller.burst"), message, "the restraint switches the drive");
            self.add("controller.burst", problem);
        }
    }
}
