//! Headings of a measured table: name and unit, in the usual notations.

use crate::units::{self, Unit};

/// Names of a time column.
const TIME_NAMES: [&str; 6] = ["t", "time", "zeit", "elapsed time", "time since start", "timestamp"];
/// Acceleration of gravity as in the scenes, m/s^2.
const G_M_PER_S2: f64 = 9.81;

/// Splits a heading into name and unit: `v [mm/s]`, `Force (N)`, `speed_mm_per_s`, `t`.
pub(crate) fn split(heading: &str) -> (&str, Option<&str>) {
    let heading = heading.trim();
    for (open, close) in [('[', ']'), ('(', ')')] {
        if let Some((name, rest)) = heading.rsplit_once(open)
            && let Some((inside, _)) = rest.split_once(close)
        {
            return (name.trim(), Some(inside.trim()));
        }
    }
    let (name, unit) = units::split(heading);
    let given = unit.map(|_| heading[name.len()..].trim_start_matches('_'));
    (name, given)
}

/// Returns `true` if the heading is that of a time column.
pub(crate) fn is_time(heading: &str) -> bool {
    let name = split(heading).0.to_lowercase();
    TIME_NAMES.contains(&name.as_str())
}

/// Returns the unit with this name, such as `mm/s`, `kN`, `m/s²` or `g`, or in the notation of
/// keys: `mm_per_s`. Upper and lower case are distinguished only if the prefix would differ: `MN`
/// is unknown.
pub(crate) fn unit(name: &str) -> Option<Unit> {
    let name = name.trim();
    let square = |scale: f64| Unit::new("m/s^2", scale, "m/s^2");
    match name {
        "m/s^2" | "m/s2" | "m/s²" | "m_per_s2" => return Some(square(1.0)),
        "mm/s^2" | "mm/s2" | "mm/s²" => return Some(square(1e-3)),
        "g" | "g0" | "G" => return Some(square(G_M_PER_S2)),
        "°C" | "degC" => return None,
        _ => {}
    }
    let mega = name.starts_with('M') && name.len() > 1 && !name.starts_with("MHz");
    if mega {
        return None;
    }
    let plain = name.to_lowercase().replace(['µ', 'μ'], "u").replace('ω', "ohm").replace('°', "deg");
    let plain = plain.replace("n*m", "nm").replace("n m", "nm").replace('/', "_per_").replace(' ', "");
    units::named(&plain)
}

/// Returns the unit in the label of an axis, such as `time [ms]`, or `None` if it has none.
pub(crate) fn axis_unit(label: &str) -> Option<&str> {
    let (_, rest) = label.rsplit_once('[')?;
    Some(rest.split(']').next()?.trim())
}

/// Returns the factor that converts `from` to `to`, or `None` if they measure different quantities.
/// Both may be without a unit.
pub(crate) fn factor(from: Option<&str>, to: Option<&str>) -> Option<f64> {
    let meant = |unit: Option<&str>| unit.map(str::trim).filter(|unit| !unit.is_empty() && *unit != "1").map(str::to_owned);
    match (meant(from), meant(to)) {
        (from, to) if from == to => Some(1.0),
        (Some(from), Some(to)) => unit(&from)?.factor_to(&unit(&to)?),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn headings_have_a_name_and_a_unit() {
        assert_eq!(split("v [mm/s]"), ("v", Some("mm/s")));
        assert_eq!(split(" Belt speed (m/s) "), ("Belt speed", Some("m/s")));
        assert_eq!(split("speed_mm_per_s"), ("speed", Some("mm_per_s")));
        assert_eq!((split("time_s"), split("load")), (("time", Some("s")), ("load", None)));
        assert!(is_time("t [ms]") && is_time("Time (s)") && is_time("time_ms") && !is_time("torque [Nm]"));
    }

    #[test]
    fn common_unit_notations_are_read() {
        let factor = |name: &str, to: &str| unit(name).and_then(|from| from.factor_to(&unit(to).unwrap()));
        let cases = [
            ("mm/s", "m/s", 1e-3),
            ("kN", "N", 1e3),
            ("mN", "N", 1e-3),
            ("ms", "s", 1e-3),
            ("µs", "s", 1e-6),
            ("g", "m/s^2", 9.81),
        ];
        for (from, to, expected) in cases {
            let found = factor(from, to).unwrap_or_else(|| panic!("{from}"));
            assert!((found / expected - 1.0).abs() < 1e-12, "{from}: {found}");
        }
        assert!(["MN", "furlong", ""].iter().all(|name| unit(name).is_none()));
        assert_eq!(factor("mm", "m/s"), None);
    }
}
