//! Rules of disturbances: the key that changes must exist, and its value must stay in range until
//! the end of the run.

use super::kind::Kind;
use super::{Rules, shown};
use crate::diagnostic::Problem;
use crate::schema::{Schema, join};
use crate::walk::wrong_number;
use crate::wording::{bound, range};

const NORMAL: &str = "contact.normal_n";

/// Change of a key's value by a disturbance.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Change {
    /// A step to a value.
    To(f64),
    /// A ramp with this slope per second.
    Ramp(f64),
    /// A sine of this amplitude.
    Sine(f64),
}

/// Smallest and largest value of a key.
type Range = (Option<f64>, Option<f64>);

impl Rules<'_> {
    pub(super) fn disturbances(&mut self) {
        for path in self.tables("disturbance") {
            let (at_s, key, to) = (join(&path, "at_s"), join(&path, "key"), join(&path, "to"));
            if let Some(time) = self.number(&at_s) {
                self.within_the_run(&at_s, time);
            }
            let Some(target) = self.text(&key) else { continue };
            // A missing table is only reported if the table that would contain it exists.
            let tables = target.match_indices('.').map(|(at, _)| &target[..at]);
            if let Some(table) = tables.into_iter().find(|table| self.lacks(table)) {
                let message = format!("`{target}` cannot change: the scene has no [{table}]");
                let problem = Problem::new(self.place(&key), message, format!("needs [{table}]"));
                self.add(&key, problem);
            }
            if target == NORMAL {
                self.normal_force(&path);
            }
            let changed = self.changed(target);
            if let (Some(value), Some(schema)) = (self.value(&to), Schema::root().at(&changed))
                && let Some(problem) = wrong_number(value, schema, &changed)
            {
                self.add(&to, problem);
            }
        }
        for target in Schema::root().at("disturbance.0.key").map(Schema::choices).unwrap_or_default() {
            self.check_course(target);
        }
    }

    /// Checks a disturbance of the normal force: only in a contact study, and only in steps.
    fn normal_force(&mut self, path: &str) {
        if self.kind == Some(Kind::Driven) {
            let key = join(path, "key");
            let message = format!("`{NORMAL}` cannot be used in a scene with [controller]");
            let problem = Problem::new(self.place(&key), message, "belongs to [excitation]");
            self.add(&key, problem.help("the load of a slider is `rig.slider.load_n`"));
        }
        for key in ["rate_per_s", "sine_amplitude"].map(|key| join(path, key)) {
            if self.value(&key).is_some() {
                let message = format!("`{NORMAL}` changes only in steps");
                let problem = Problem::new(self.key(&key), message, "give `to` or `profile` instead");
                self.add(&key, problem);
            }
        }
    }

    /// Returns the path of the key that a disturbance changes; the normal force is a key of the
    /// contact's model.
    pub(super) fn changed(&self, target: &str) -> String {
        match self.model() {
            Some(model) if target == NORMAL => join(&model, "normal_n"),
            _ => target.to_owned(),
        }
    }

    /// Checks the range of a key over the run.
    fn check_course(&mut self, target: &str) {
        let of_target = |path: &String| self.text(&join(path, "key")) == Some(target);
        let paths: Vec<_> = self.tables("disturbance").into_iter().filter(of_target).collect();
        let changes: Option<Vec<_>> = paths.iter().map(|path| self.change(path)).collect();
        let (Some(duration), Some(mut changes)) = (self.number("duration_s"), changes) else { return };
        let (Some(start), Some(schema)) = (self.present(target), Schema::root().at(target)) else { return };
        changes.sort_by(|a, b| a.0.total_cmp(&b.0));
        let timed: Vec<_> = changes.iter().map(|&(at_s, change, _)| (at_s, change)).collect();
        let Some((number, time)) = leaves_range(start, &timed, schema.range(), duration) else { return };
        let Some((at_s, change, path)) = changes.get(number) else { return };
        let message = format!("`{target}` may leave its range at {} s", shown(time));
        let label = format!("must stay {}", range(schema.range(), target));
        let key = join(path, if matches!(change, Change::Sine(_)) { "sine_amplitude" } else { "rate_per_s" });
        let help = match (changes.len(), largest_allowed(start, *change, schema.range(), duration - at_s)) {
            (1, Some(allowed)) => allowed,
            _ => "the disturbances of a key add up, sines with their full amplitude".to_owned(),
        };
        let problem = Problem::new(self.place(&key), message, label);
        self.add(&key, problem.help(help));
    }

    /// Returns beginning, change and path of a disturbance, if it has no problem.
    fn change(&self, path: &str) -> Option<(f64, Change, String)> {
        let at = |key: &str| join(path, key);
        let keys = ["to", "rate_per_s", "sine_amplitude", "sine_hz"].map(at);
        let [to, rate, sine, hz] = keys.each_ref().map(|key| self.number(key));
        let change = match (to, rate, sine) {
            _ if !keys.iter().all(|key| self.clean(key)) => None,
            (Some(to), ..) => Some(Change::To(to)),
            (_, Some(rate), _) => Some(Change::Ramp(rate)),
            // A sine of frequency zero adds nothing.
            (.., Some(amplitude)) => Some(Change::Sine(if hz == Some(0.0) { 0.0 } else { amplitude.abs() })),
            _ => None,
        };
        Some((self.number(&at("at_s"))?, change?, path.to_owned()))
    }

    /// Returns the initial value of a key. The stack may be given by its elements instead.
    fn present(&self, target: &str) -> Option<f64> {
        if let Some(number) = self.number(target) {
            return Some(number);
        }
        let [cm_f, lm_h, rm_ohm] = ["cm_f", "lm_h", "rm_ohm"].map(|key| self.number(&join("stack.bvd", key)));
        let omega = 1.0 / (lm_h? * cm_f?).sqrt();
        match target {
            "stack.bvd.series_resonance_hz" => Some(omega / std::f64::consts::TAU),
            "stack.bvd.q" => Some(omega * lm_h? / rm_ohm?),
            _ => None,
        }
    }
}

/// Returns the index of the change that takes a value out of its range, and the time. The changes
/// are sorted by time and add up.
fn leaves_range(start: f64, changes: &[(f64, Change)], (least, most): Range, duration: f64) -> Option<(usize, f64)> {
    /// Round-off, relative to the numbers that are added.
    const ROUND_OFF_REL: f64 = 1e-9;
    let (mut now, mut value, mut slope, mut sines, mut swing) = (0.0, start, 0.0, 0.0, 0.0);
    for number in 0..=changes.len() {
        let next = changes.get(number).map_or(duration, |(at_s, _)| *at_s);
        let rise = slope * (next - now);
        for (end, way) in [(least, -1.0), (most, 1.0)] {
            let Some(end) = end else { continue };
            let slack = ROUND_OFF_REL * (value.abs() + rise.abs() + swing);
            // Distance outside the range at the beginning and at the end of this part of the run.
            let (first, last) = (way * (value - end) + swing, way * (value + rise - end) + swing);
            let outward = |(_, change): &(f64, Change)| match change {
                Change::To(_) => false,
                Change::Ramp(rate) => rate * way > 0.0,
                Change::Sine(amplitude) => *amplitude > 0.0,
            };
            if let (true, Some(cause)) = (first.max(last) > slack, changes[..number].iter().rposition(outward)) {
                let inside = if first >= 0.0 { 0.0 } else { first / (first - last) };
                return Some((cause, now + inside * (next - now)));
            }
        }
        (now, value) = (next, value + rise);
        match changes.get(number).map(|(_, change)| *change) {
            // A sine continues from the new value, which may have been set at the other extreme.
            Some(Change::To(to)) => (value, swing) = (to, 2.0 * sines),
            Some(Change::Ramp(rate)) => slope += rate,
            Some(Change::Sine(amplitude)) => (sines, swing) = (sines + amplitude, swing + amplitude),
            None => {}
        }
    }
    None
}

/// Returns the help text with the largest change that stays in range.
fn largest_allowed(start: f64, change: Change, (least, most): Range, seconds: f64) -> Option<String> {
    let (below, above) = (least.map_or(f64::MAX, |least| start - least), most.map_or(f64::MAX, |most| most - start));
    let within = |end: f64| shown(bound(end, -end.signum(), |x| x.abs() <= end.abs()));
    match change {
        Change::Ramp(rate) if rate < 0.0 => {
            Some(format!("a slope of at least {} per second would stay in range", within(-below / seconds)))
        }
        Change::Ramp(_) => Some(format!("a slope of at most {} per second would stay in range", within(above / seconds))),
        Change::Sine(_) => Some(format!("an amplitude of at most {} would stay in range", within(below.min(above)))),
        Change::To(_) => None,
    }
}

#[cfg(test)]
mod tests {
    use super::Change::{Ramp, Sine, To};
    use super::leaves_range;

    const POSITIVE: super::Range = (Some(0.0), Some(10.0));

    #[test]
    fn the_time_and_the_cause_are_reported() {
        assert_eq!(leaves_range(4.0, &[(1.0, Ramp(-2.0))], POSITIVE, 5.0), Some((0, 3.0)));
        assert_eq!(leaves_range(4.0, &[(1.0, Ramp(-2.0))], POSITIVE, 2.9), None);
        assert_eq!(leaves_range(4.0, &[(1.0, Sine(4.5))], POSITIVE, 5.0), Some((0, 1.0)));
        assert_eq!(leaves_range(4.0, &[(1.0, Ramp(2.0)), (2.0, Ramp(-1.0))], POSITIVE, 9.0), Some((0, 6.0)));
    }

    #[test]
    fn ends_of_the_range_are_inside() {
        assert_eq!(leaves_range(10.0, &[(1.0, Ramp(-2.0))], POSITIVE, 6.0), None);
        assert_eq!(leaves_range(0.3, &[(0.1, Ramp(-1.0))], POSITIVE, 0.4), None);
        assert_eq!(leaves_range(5.0, &[(1.0, Sine(5.0))], POSITIVE, 6.0), None);
    }

    #[test]
    fn changes_of_one_key_add_up() {
        assert_eq!(leaves_range(5.0, &[(1.0, Sine(3.0)), (2.0, Sine(3.0))], POSITIVE, 6.0), Some((1, 2.0)));
        assert_eq!(leaves_range(5.0, &[(0.0, Ramp(-1.0)), (2.0, Sine(2.0))], POSITIVE, 6.0), Some((1, 3.0)));
        // A step sets a new value; an earlier ramp continues.
        assert_eq!(leaves_range(5.0, &[(0.0, Ramp(-1.0)), (4.0, To(3.0))], POSITIVE, 6.5), None);
        assert_eq!(leaves_range(5.0, &[(0.0, Ramp(-1.0)), (4.0, To(1.0))], POSITIVE, 6.5), Some((0, 5.0)));
        assert_eq!(leaves_range(5.0, &[(0.0, Sine(4.0)), (4.0, To(5.0))], POSITIVE, 6.0), Some((0, 4.0)));
    }
}
