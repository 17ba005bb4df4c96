//! Conditions in the name of a file, such as `v0.1_ON.csv`, `speed=0.05mps_off.csv` or
//! `100mm_s_on_3.csv`.
//!
//! A number with the name of a quantity before it or a unit behind it is a condition. Other
//! numbers, such as that of a repeat, are not.

use super::super::quantity::{Quantity, state, unit_missing};
use crate::error::ImportError;
use crate::units::Units;
use columns::Unit;

/// Conditions of a whole file.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Named {
    /// `true` for ON.
    pub(super) on: Option<bool>,
    /// Quantities, numbers, and units as written.
    numbers: Vec<(Quantity, f64, String)>,
}

/// Quantity of a unit, if the name has none.
const BY_UNIT: [(&str, Quantity); 5] = [
    ("m/s", Quantity::Velocity),
    ("N", Quantity::Normal),
    ("m", Quantity::Level),
    ("V", Quantity::Level),
    ("Hz", Quantity::Frequency),
];

impl Named {
    /// Reads the name of a file without its extension.
    pub(super) fn parse(stem: &str) -> Self {
        let parts: Vec<&str> =
            stem.split(|c: char| !(c.is_alphanumeric() || ".+%".contains(c))).filter(|p| !p.is_empty()).collect();
        let mut named = Named::default();
        let mut at = 0;
        while let Some(part) = parts.get(at) {
            at += 1;
            if part.chars().all(char::is_alphabetic) {
                named.on = state(part).or(named.on);
                continue;
            }
            let digits = |c: char| c.is_ascii_digit();
            let (Some(from), Some(to)) = (part.find(digits), part.rfind(digits)) else { continue };
            let Ok(value) = part[from..=to].parse::<f64>() else { continue };
            let own = part[..from].trim_end_matches('.');
            let name = if own.is_empty() { at.checked_sub(2).map_or("", |before| parts[before]) } else { own };
            // The unit may contain the separator: `100mm_s`.
            let long = parts.get(at).map(|next| format!("{}_{next}", &part[to + 1..])).filter(|long| long.ends_with("m_s"));
            at += usize::from(long.is_some());
            let unit = long.unwrap_or_else(|| part[to + 1..].to_owned());
            let by_unit = || {
                let unit = Unit::parse(&unit)?;
                let of = |(base, _): &&(&str, Quantity)| Unit::parse(base).is_some_and(|base| base.measures_like(&unit));
                BY_UNIT.iter().find(of).map(|(_, quantity)| *quantity)
            };
            let known = Quantity::parse(name).filter(|quantity| *quantity != Quantity::Time);
            if let Some(quantity) = known.or_else(by_unit) {
                named.numbers.push((quantity, value, unit));
            }
        }
        named
    }

    /// Returns a quantity in its SI unit; `None` if the name does not contain it.
    pub(super) fn number(&self, wanted: Quantity, units: &Units) -> Result<Option<f64>, ImportError> {
        let Some((_, value, unit)) = self.numbers.iter().find(|(quantity, ..)| *quantity == wanted) else { return Ok(None) };
        let Some(base) = wanted.base() else { return Ok(Some(*value)) };
        let written = Unit::parse(base).and_then(|si| Unit::parse_like(unit, &si)?.factor_to(&si));
        let given = || units.factor_to(base).filter(|_| unit.is_empty());
        let factor =
            written.or_else(given).ok_or_else(|| unit_missing(format!("`{value}{unit}` in the name of the file"), base))?;
        Ok(Some(value * factor))
    }

    /// Returns the strength of the vibration and its unit as written.
    pub(super) fn level(&self) -> Option<(f64, &str)> {
        self.numbers.iter().find(|(quantity, ..)| *quantity == Quantity::Level).map(|(_, value, unit)| (*value, unit.as_str()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_files_contain_conditions() {
        let cases = [
            ("speed=0.05mps_off", Some(false), Some(0.05)),
            ("100mm_s_on_3", Some(true), Some(0.1)),
            ("ON-20mmps-run7", Some(true), Some(0.02)),
            ("2024_log_2", None, None),
        ];
        for (name, on, speed) in cases {
            let named = Named::parse(name);
            assert_eq!(named.on, on, "{name}");
            assert_eq!(named.number(Quantity::Velocity, &Units::default()).unwrap(), speed, "{name}");
        }
        let full = Named::parse("steel_10N_5um_40kHz_v0.1_ON");
        let units = Units::parse_friction(["m/s"]).unwrap();
        assert_eq!(full.number(Quantity::Velocity, &units).unwrap(), Some(0.1));
        assert_eq!(full.number(Quantity::Normal, &units).unwrap(), Some(10.0));
        assert_eq!((full.number(Quantity::Frequency, &units).unwrap(), full.level()), (Some(40e3), Some((5.0, "um"))));
        let error = full.number(Quantity::Velocity, &Units::default()).unwrap_err().to_string();
        assert!(error.contains("`0.1` in the name of the file has no unit") && error.contains("--unit m/s"), "{error}");
    }
}
