//! Rules of measured profiles: samples in order of time, long enough for the run, and in the range
//! of the quantity.

use super::{Rules, shown};
use crate::diagnostic::Problem;
use crate::profile::resolve::{first_not_rising, paths};
use crate::schema::{Schema, join};
use crate::wording::range;

const WAVEFORM: &str = "excitation.waveform";
const PROFILE: &str = "excitation.profile";
const PULSE: &str = "rig.dring.pulse";
/// Largest deceleration of a measured pulse, 200 g, m/s^2.
const MAX_PULSE_M_PER_S2: f64 = 200.0 * 9.81;
/// Round-off, relative to the duration of the run.
const ROUND_OFF_REL: f64 = 1e-9;

impl Rules<'_> {
    pub(super) fn profiles(&mut self) {
        for path in paths(self.root) {
            if self.clean(&path) {
                self.samples(&path);
            }
        }
        self.measured_waveform();
        self.check_only_disturbance();
    }

    /// Checks that a measured waveform and its profile occur together.
    fn measured_waveform(&mut self) {
        let measured = self.text(WAVEFORM) == Some("measured");
        if measured && self.lacks(PROFILE) {
            let message = "a measured excitation without `profile`";
            let problem = Problem::new(self.place(WAVEFORM), message, "needs [excitation.profile]");
            self.add(PROFILE, problem.help("`profile.file` names a table of numbers with a time column"));
        }
        if !measured && self.given(PROFILE) && self.clean(WAVEFORM) {
            let message = "[excitation.profile] is only for a measured waveform";
            let problem = Problem::new(self.key(PROFILE), message, "needs `waveform = \"measured\"`");
            self.add(PROFILE, problem);
        }
        let rms = "excitation.match";
        if measured && self.text(rms) == Some("rms") {
            let message = "a measured waveform is played without scaling";
            self.add(rms, Problem::new(self.place(rms), message, "not with `measured`"));
        }
    }

    /// Checks that a key with a measured profile has no other disturbance.
    fn check_only_disturbance(&mut self) {
        let tables = self.tables("disturbance");
        let keys: Vec<_> = tables.iter().map(|path| self.text(&join(path, "key")).map(str::to_owned)).collect();
        for (index, path) in tables.iter().enumerate() {
            let others = keys.iter().enumerate().any(|(other, key)| other != index && key.is_some() && *key == keys[index]);
            let profile = join(path, "profile");
            if others && self.given(&profile) {
                let key = keys[index].clone().unwrap_or_default();
                let message = format!("`{key}` follows a measured profile, but another disturbance changes it as well");
                let problem = Problem::new(self.key(&profile), message, "must be the only disturbance of this key");
                self.add(&profile, problem);
            }
        }
    }

    fn samples(&mut self, path: &str) {
        let (times, values) = (join(path, "time_s"), join(path, "values"));
        let samples = |key: &str| self.root.at(key).and_then(|node| node.samples()).cloned();
        let (Some(time_s), Some(value)) = (samples(&times), samples(&values)) else { return };
        let at = |key: &str| self.place(key);
        if time_s.len() != value.len() || time_s.len() < 2 {
            let message = format!("the profile has {} times and {} values", time_s.len(), value.len());
            let problem = Problem::new(at(&values), message, "needs equal numbers of both, at least two");
            return self.add(path, problem);
        }
        if let Some(later) = first_not_rising(&time_s) {
            let message =
                format!("the time does not increase: {} s follows {} s", shown(time_s[later]), shown(time_s[later - 1]));
            let problem = Problem::new(at(&times), message, "must be in ascending order");
            return self.add(path, problem);
        }
        let (first, last) = (time_s[0], time_s[time_s.len() - 1]);
        let from = join(path, "from_s");
        let (Some(from_s), Some(duration)) = (self.number(&from), self.number("duration_s")) else { return };
        let slack = ROUND_OFF_REL * duration;
        if from_s < first - slack || from_s >= last {
            let place = if self.given(&from) { self.place(&from) } else { at(&times) };
            let message = format!("the profile has no sample at {} s, where playback begins", shown(from_s));
            let label = format!("it has samples from {} to {} s", shown(first), shown(last));
            let help = format!("with `from_s = {}`, playback begins at the first sample", shown(first));
            return self.add(path, Problem::new(place, message, label).help(help));
        }
        let begins = match path {
            PULSE => None,
            PROFILE => Some(0.0),
            _ => self.number(&path.replace(".profile", ".at_s")),
        };
        let needed = begins.map(|begins| duration - begins).filter(|needed| last - from_s < needed - slack);
        if let Some(needed) = needed {
            let message = format!(
                "the profile is too short for the run: {} s are needed, but it has only {} s",
                shown(needed),
                shown(last - from_s)
            );
            let label = format!("ends at {} s", shown(last));
            let most = shown(duration - needed + last - from_s);
            return self.add(
                path,
                Problem::new(self.place(self.newer(&times, &from)), message, label)
                    .help(format!("`duration_s` can be at most {most}")),
            );
        }
        self.within_range(path, &time_s, &value);
    }

    fn within_range(&mut self, path: &str, time_s: &[f64], values: &[f64]) {
        let target = match path.strip_suffix(".profile") {
            _ if path == PULSE => "rig.dring.pulse".to_owned(),
            Some("excitation") => {
                if self.given("rig.kinematic") { "rig.kinematic.vibration_m_per_s" } else { "excitation.force_n" }.to_owned()
            }
            Some(disturbance) => {
                let Some(key) = self.text(&join(disturbance, "key")) else { return };
                self.changed(key)
            }
            None => return,
        };
        let limits = match path {
            PULSE => (Some(-MAX_PULSE_M_PER_S2), Some(MAX_PULSE_M_PER_S2)),
            _ => {
                let Some(schema) = Schema::root().at(&target) else { return };
                let (least, most) = schema.range();
                // A vibration has both signs.
                if path == PROFILE { (most.map(|most| -most), most) } else { (least, most) }
            }
        };
        if path == PULSE {
            let area = |(time, value): (&[f64], &[f64])| 0.5 * (value[0] + value[1]) * (time[1] - time[0]);
            let change_m_per_s: f64 = time_s.windows(2).zip(values.windows(2)).map(area).sum();
            if change_m_per_s <= 0.0 {
                let message = format!("the pulse does not slow the vehicle: its speed falls by {} m/s", shown(change_m_per_s));
                let problem = Problem::new(self.place(&join(path, "values")), message, "a deceleration must be positive");
                return self.add(path, problem.help("turn the sign of the file's column if it is an acceleration"));
            }
        }
        let outside = |value: f64| limits.0.is_some_and(|least| value < least) || limits.1.is_some_and(|most| value > most);
        let Some(at) = values.iter().position(|&value| outside(value)) else { return };
        let message =
            format!("the profile leaves the range of `{target}`: it is {} at {} s", shown(values[at]), shown(time_s[at]));
        let what = if path == PULSE {
            format!("from {} to {} m/s^2", shown(-MAX_PULSE_M_PER_S2), shown(MAX_PULSE_M_PER_S2))
        } else {
            range(limits, &target)
        };
        let problem = Problem::new(self.place(&join(path, "values")), message, format!("must stay {what}"));
        self.add(path, problem);
    }
}
