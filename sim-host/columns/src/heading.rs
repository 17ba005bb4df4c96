//! Headings of a measured table: sign, name and unit in the usual notations.

use crate::unit::{self, Unit};

/// Names of a time column.
const TIME_NAMES: [&str; 8] = ["t", "time", "zeit", "elapsed time", "time since start", "timestamp", "seconds", "x-axis"];

/// Heading of a column, split in its parts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Heading<'a> {
    /// Name without sign and unit.
    pub name: &'a str,
    /// Unit as written; it may be unknown.
    pub unit: Option<&'a str>,
    /// `true` if the column has the quantity with the other sign, as `-Im(Z)`.
    pub negative: bool,
}

impl<'a> Heading<'a> {
    /// Splits a heading: `v [mm/s]`, `Force (N)`, `x/mm`, `Phase, degrees`, `speed_mm_per_s`,
    /// `-Im(Z)/Ohm`, `t`. `is_known` returns `true` for the name of a quantity; `Re(Z)` is one with
    /// its brackets.
    pub fn new(text: &'a str, is_known: impl Fn(&str) -> bool) -> Self {
        let text = text.trim().trim_matches('"').trim();
        let bare = text.strip_prefix(['-', '−', '–']).map(str::trim);
        let negative = bare.is_some_and(|bare| !bare.is_empty());
        let text = bare.filter(|_| negative).unwrap_or(text);
        let whole = |name, unit| Heading { name, unit, negative };
        let bracketed = [('[', ']'), ('(', ')'), ('{', '}')].into_iter().find_map(|(open, close)| {
            let (name, rest) = text.rsplit_once(open)?;
            let (inside, after) = rest.split_once(close)?;
            after.trim().is_empty().then(|| (name.trim(), inside.trim()))
        });
        let is_unit = |unit: &str| Unit::parse(unit).is_some();
        if let Some((name, unit)) = bracketed.filter(|(_, unit)| is_unit(unit)) {
            return whole(name, Some(unit));
        }
        // `speed mm/s` and `speed_mm/s`, before the slash of the unit cuts.
        let spaced = text.match_indices([' ', ',', '_']).map(|(at, _)| (text[..at].trim(), text[at + 1..].trim()));
        if let Some((name, unit)) = spaced.into_iter().find(|(name, unit)| {
            !name.is_empty() && !name.contains('/') && unit.find('/').is_some_and(|at| at > 0) && is_unit(unit)
        }) {
            let name = name.trim_end_matches([',', '_']).trim_end_matches(" in");
            return whole(name.trim(), Some(unit));
        }
        if let Some((name, unit)) = text.rsplit_once('/').filter(|(name, unit)| !name.trim().is_empty() && is_unit(unit)) {
            // The whole unit, before a part of it: `v/mm/s`.
            let (name, unit) = text.split_once('/').filter(|(_, unit)| is_unit(unit)).unwrap_or((name, unit));
            return whole(name.trim(), Some(unit.trim()));
        }
        if is_known(text) {
            return whole(text, None);
        }
        // The whole unit, before its last part: `speed_mm_s`.
        let long = text.match_indices('_').map(|(at, _)| (&text[..at], &text[at + 1..]));
        if let Some((name, unit)) =
            long.into_iter().find(|(name, unit)| !name.is_empty() && unit.ends_with("m_s") && is_unit(unit))
        {
            return whole(name, Some(unit));
        }
        if let (name, Some(_)) = unit::split(&text.to_lowercase())
            && let Some((name, unit)) = text.split_at_checked(name.len())
        {
            return whole(name, Some(unit.trim_start_matches('_')));
        }
        let cuts = || text.match_indices(['/', ',', ' ', '-', '_']).filter(|(at, _)| *at > 0);
        let cut = |(at, sign): (usize, &str)| (text[..at].trim(), text[at + sign.len()..].trim());
        if let Some((name, unit)) = bracketed {
            return whole(name, Some(unit));
        }
        let suffix = cuts().map(cut).find(|(_, unit)| is_unit(unit));
        // After a slash or an underscore there is a unit, also an unknown one.
        let is_word = |unit: &str| !unit.is_empty() && (!unit.contains('_') || unit.contains("_per_"));
        let unknown =
            || cuts().filter(|(_, sign)| "/_".contains(sign)).map(cut).find(|(name, unit)| is_known(name) && is_word(unit));
        match suffix.or_else(unknown) {
            Some((name, unit)) => whole(name, Some(unit)),
            None => whole(text, None),
        }
    }

    /// Returns `true` if the heading is that of a time column.
    pub fn is_time(&self) -> bool {
        is_time_name(self.name)
    }
}

/// Returns `true` for the name of a time.
pub fn is_time_name(name: &str) -> bool {
    TIME_NAMES.contains(&name.trim().to_lowercase().as_str())
}

/// Returns the unit in the label of an axis, such as `time [ms]`, or `None` if it has none.
pub fn axis_unit(label: &str) -> Option<&str> {
    let (_, rest) = label.rsplit_once('[')?;
    Some(rest.split(']').next()?.trim())
}

/// Returns the factor that converts `from` to `to`, or `None` if they measure different quantities.
/// Both may be without a unit.
pub fn factor(from: Option<&str>, to: Option<&str>) -> Option<f64> {
    let meant = |unit: Option<&str>| unit.map(str::trim).filter(|unit| !unit.is_empty() && *unit != "1").map(str::to_owned);
    match (meant(from), meant(to)) {
        (from, to) if from == to => Some(1.0),
        (Some(from), Some(to)) => Unit::parse(&from)?.factor_to(&Unit::parse(&to)?),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn headings_have_a_sign_a_name_and_a_unit() {
        let cases = [
            ("v [mm/s]", "v", Some("mm/s")),
            (" Belt speed (m/s) ", "Belt speed", Some("m/s")),
            ("speed_mm_per_s", "speed", Some("mm_per_s")),
            ("speed_mm_s", "speed", Some("mm_s")),
            ("time_s", "time", Some("s")),
            ("load", "load", None),
            ("Re(Z)", "Re(Z)", None),
            ("Re(Z)/Ohm", "Re(Z)", Some("Ohm")),
            ("Frequency, Hz", "Frequency", Some("Hz")),
            ("v/mm/s", "v", Some("mm/s")),
            ("speed mm/s", "speed", Some("mm/s")),
            ("speed in mm/s", "speed", Some("mm/s")),
            ("speed, mm/s", "speed", Some("mm/s")),
            ("speed_mm/s", "speed", Some("mm/s")),
            ("x [furlong]", "x", Some("furlong")),
            ("x/furlong", "x", Some("furlong")),
            ("friction_force_n", "friction_force", Some("n")),
            ("F [uN]", "F", Some("uN")),
            ("Theta deg", "Theta", Some("deg")),
            ("Time (msec)", "Time", Some("msec")),
        ];
        let is_known = |name: &str| ["Re(Z)", "x"].contains(&name);
        for (text, name, unit) in cases {
            assert_eq!(Heading::new(text, is_known), Heading { name, unit, negative: false }, "{text}");
        }
        let negative = Heading::new("-Im(Z)/Ohm", |_| false);
        assert_eq!((negative.name, negative.unit, negative.negative), ("Im(Z)", Some("Ohm"), true));
        for (text, expected) in [("t [ms]", true), ("Time (s)", true), ("time_ms", true), ("torque [Nm]", false)] {
            assert_eq!(Heading::new(text, |_| false).is_time(), expected, "{text}");
        }
    }

    #[test]
    fn written_units_are_read_or_unknown() {
        let factor = |name: &str, to: &str| Unit::parse(name).and_then(|from| from.factor_to(&Unit::parse(to).unwrap()));
        let cases = [
            ("mm/s", "m/s", 1e-3),
            ("mm/sec", "m/s", 1e-3),
            ("mm_s", "m/s", 1e-3),
            ("mmps", "m/s", 1e-3),
            ("in/s", "m/s", 0.0254),
            ("km/h", "m/s", 1.0 / 3.6),
            ("kN", "N", 1e3),
            ("mN", "N", 1e-3),
            ("uN", "N", 1e-6),
            ("kgf", "N", 9.80665),
            ("ms", "s", 1e-3),
            ("msec", "s", 1e-3),
            ("usec", "s", 1e-6),
            ("microseconds", "s", 1e-6),
            ("minutes", "s", 60.0),
            ("µs", "s", 1e-6),
            ("nm", "m", 1e-9),
            ("g", "m/s^2", 9.81),
            ("mS", "S", 1e-3),
            ("µS", "S", 1e-6),
            ("MHz", "Hz", 1e6),
            ("mhz", "Hz", 1e6),
            ("kΩ", "ohm", 1e3),
            ("KOHM", "ohm", 1e3),
            ("MOhm", "ohm", 1e6),
            ("mΩ", "ohm", 1e-3),
            ("Megohm", "ohm", 1e6),
            ("milliohm", "ohm", 1e-3),
            ("meganewton", "N", 1e6),
            ("deg", "rad", std::f64::consts::PI / 180.0),
            ("mrad", "rad", 1e-3),
            ("Grad", "rad", std::f64::consts::PI / 180.0),
            ("mm·s⁻¹", "m/s", 1e-3),
            ("mm s^-1", "m/s", 1e-3),
            ("m s^-2", "m/s^2", 1.0),
        ];
        for (from, to, expected) in cases {
            let found = factor(from, to).unwrap_or_else(|| panic!("{from}"));
            assert!((found / expected - 1.0).abs() < 1e-12, "{from}: {found}");
        }
        assert!(["furlong", "grad", "", "REAL", "Z", "1e3"].iter().all(|name| Unit::parse(name).is_none()));
        assert!(["MN", "mohm", "MOHM"].iter().all(|name| Unit::parse(name).is_some_and(|unit| unit.is_ambiguous())));
        assert_eq!((factor("mm", "m/s"), factor("S", "s")), (None, None));
        let like =
            |text: &str, base: &str| Unit::parse_like(text, &Unit::parse(base).unwrap())?.factor_to(&Unit::parse(base).unwrap());
        assert_eq!((like("MS", "s"), like("ms", "S"), like("S", "s")), (Some(1e-3), Some(1e-3), Some(1.0)));
    }
}
