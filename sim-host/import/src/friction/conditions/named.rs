//! Conditions in the name of a file, such as `v0.1_ON.csv`, `speed=0.05mps_off.csv` or
//! `100mm_s_on_3.csv`.
//!
//! A condition is `name=number unit`, a number with the unit of a speed, a force, a frequency or a
//! voltage, or a number directly behind the name of a quantity. Other numbers, such as that of a
//! repeat or a version, are not.

use super::super::quantity::{Quantity, unit_missing};
use crate::error::ImportError;
use crate::units::Units;
use columns::Unit;

/// Conditions of a whole file.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Named {
    /// `true` for ON.
    pub(super) on: Option<bool>,
    numbers: Vec<Number>,
}

/// Number in a name.
#[derive(Clone, Debug, PartialEq)]
struct Number {
    quantity: Quantity,
    value: f64,
    /// Unit as written; empty without one.
    unit: String,
    /// `true` for `name=number`.
    is_explicit: bool,
}

/// Quantity of a unit, if the name has none. A length may be any size of the rig.
const BY_UNIT: [(&str, Quantity); 4] =
    [("m/s", Quantity::Velocity), ("N", Quantity::Normal), ("V", Quantity::Level), ("Hz", Quantity::Frequency)];
/// Single letters that name a quantity before a number; others are versions, grades and samples.
const LETTERS: [&str; 1] = ["v"];

impl Named {
    /// Reads the name of a file without its extension.
    ///
    /// # Errors
    /// If it states a condition in two ways.
    pub(super) fn parse(stem: &str) -> Result<Self, ImportError> {
        let parts = parts(stem);
        let mut named = Named::default();
        let mut states = Vec::new();
        let mut at = 0;
        while let Some(part) = parts.get(at) {
            at += 1;
            let (key, rest) = part.split_once('=').map_or((None, part.as_str()), |(key, rest)| (Some(key), rest));
            if let Some(on) = on_or_off(rest).filter(|_| key.is_none_or(|key| Quantity::parse(key) == Some(Quantity::State))) {
                states.push((key.is_some(), on));
                continue;
            }
            let digits = |c: char| c.is_ascii_digit();
            let (Some(from), Some(to)) = (rest.find(digits), rest.rfind(digits)) else { continue };
            let (own, number) = (rest[..from].trim_end_matches('.'), &rest[from..=to]);
            let Ok(value) = number.parse::<f64>() else { continue };
            // The unit may contain the separator: `100mm_s`.
            let long = parts.get(at).map(|next| format!("{}_{next}", &rest[to + 1..])).filter(|long| long.ends_with("m_s"));
            at += usize::from(long.is_some());
            let unit = long.unwrap_or_else(|| rest[to + 1..].to_owned());
            let by_unit = || {
                let unit = Unit::parse(&unit)?;
                let of = |(base, _): &&(&str, Quantity)| Unit::parse(base).is_some_and(|base| base.measures_like(&unit));
                BY_UNIT.iter().find(of).map(|(_, quantity)| *quantity)
            };
            let name = key.unwrap_or(own);
            let is_name = key.is_some() || name.len() > 1 || LETTERS.contains(&name.to_lowercase().as_str());
            let known = Quantity::parse(name).filter(|quantity| is_name && *quantity != Quantity::Time);
            let Some(quantity) = known.or_else(by_unit) else { continue };
            if number.len() > 1 && number.starts_with('0') && digits(number.as_bytes()[1].into()) {
                return Err(ImportError::NoFit(format!(
                    "`{part}` in the name of the file may have lost its decimal point; write `0.5` or `0,5`"
                )));
            }
            named.numbers.push(Number { quantity, value, unit, is_explicit: key.is_some() });
        }
        // `state=on` is clearer than a word.
        let explicit = states.iter().any(|(explicit, _)| *explicit);
        states.retain(|(own, _)| *own == explicit);
        if states.windows(2).any(|pair| pair[0].1 != pair[1].1) {
            let why = "the name of the file says ON and OFF; write `state=on` or `state=off` in it, or add a column `state`";
            return Err(ImportError::NoFit(why.to_owned()));
        }
        named.on = states.first().map(|(_, on)| *on);
        Ok(named)
    }

    /// Returns the number of a quantity: that of `name=number`, then one with a unit.
    fn of(&self, wanted: Quantity) -> Result<Option<&Number>, ImportError> {
        let all = || self.numbers.iter().filter(|number| number.quantity == wanted);
        let rank = |number: &Number| (number.is_explicit, !number.unit.is_empty());
        let Some(best) = all().max_by_key(|number| rank(number)) else { return Ok(None) };
        match all().find(|other| rank(other) == rank(best) && (other.value, &other.unit) != (best.value, &best.unit)) {
            None => Ok(Some(best)),
            Some(other) => Err(ImportError::NoFit(format!(
                "the name of the file says both {}{} and {}{}; write the condition as `speed=…`, `normal=…` or `amplitude=…`",
                other.value, other.unit, best.value, best.unit
            ))),
        }
    }

    /// Returns a quantity in its SI unit; `None` if the name does not contain it.
    pub(super) fn number(&self, wanted: Quantity, units: &Units) -> Result<Option<f64>, ImportError> {
        let Some(Number { value, unit, .. }) = self.of(wanted)? else { return Ok(None) };
        let Some(base) = wanted.base() else { return Ok(Some(*value)) };
        let written = Unit::parse(base).and_then(|si| Unit::parse_like(unit, &si)?.factor_to(&si));
        let given = || units.factor_to(base).filter(|_| unit.is_empty());
        match written.or_else(given) {
            Some(factor) => Ok(Some(value * factor)),
            None if unit.is_empty() => Err(unit_missing(format!("`{value}` in the name of the file"), base)),
            None => {
                let column = format!("{value}{unit} in the name of the file");
                Err(ImportError::UnitUnknown { column, unit: unit.clone(), help: format!("write {base}, also with a prefix") })
            }
        }
    }

    /// Returns the strength of the vibration and its unit as written.
    pub(super) fn level(&self) -> Result<Option<(f64, &str)>, ImportError> {
        Ok(self.of(Quantity::Level)?.map(|number| (number.value, number.unit.as_str())))
    }

    /// Returns the conditions that the name contains, for a reader; `None` if there are none.
    pub(super) fn in_words(&self) -> Option<String> {
        let numbers = self.numbers.iter().map(|number| format!("{}{}", number.value, number.unit));
        let state = self.on.map(|on| if on { "ON" } else { "OFF" }.to_owned());
        let words: Vec<String> = numbers.chain(state).collect();
        (!words.is_empty()).then(|| words.join(", "))
    }
}

fn on_or_off(word: &str) -> Option<bool> {
    match word.to_lowercase().as_str() {
        "on" => Some(true),
        "off" => Some(false),
        _ => None,
    }
}

/// Splits a name into parts. A comma between digits is a decimal comma, and `5e-2` is one number.
fn parts(stem: &str) -> Vec<String> {
    let letters: Vec<char> = stem.chars().collect();
    let is_digit = |at: Option<usize>| at.and_then(|at| letters.get(at)).is_some_and(char::is_ascii_digit);
    let mut parts = vec![String::new()];
    for (at, &letter) in letters.iter().enumerate() {
        let exponent = at >= 2 && matches!(letters[at - 1], 'e' | 'E') && is_digit(Some(at - 2)) && is_digit(Some(at + 1));
        let within = is_digit(at.checked_sub(1)) && is_digit(Some(at + 1));
        match letter {
            ',' if within => parts.last_mut().map(|part| part.push('.')),
            '-' if exponent => parts.last_mut().map(|part| part.push(letter)),
            _ if letter.is_alphanumeric() || ".+%=".contains(letter) => parts.last_mut().map(|part| part.push(letter)),
            _ => {
                parts.push(String::new());
                None
            }
        };
    }
    parts.retain(|part| !part.is_empty());
    parts
}

#[cfg(test)]
mod tests {
    use super::*;

    fn speed(name: &str) -> Result<Option<f64>, String> {
        let named = Named::parse(name).map_err(|error| error.to_string())?;
        named.number(Quantity::Velocity, &Units::default()).map_err(|error| error.to_string())
    }

    #[test]
    fn names_of_files_contain_conditions() {
        let cases = [
            ("speed=0.05mps_off", Some(false), Some(0.05)),
            ("100mm_s_on_3", Some(true), Some(0.1)),
            ("ON-20mmps-run7", Some(true), Some(0.02)),
            ("2024_log_2", None, None),
            ("0,02mps_off_r0", Some(false), Some(0.02)),
            ("5e-2mps_on", Some(true), Some(0.05)),
            ("v2_100mmps_off_no12", Some(false), Some(0.1)),
            ("d10mm_20mmps_on_no_lube", Some(true), Some(0.02)),
            ("off_pin_on_disc_state=off_20mmps", Some(false), Some(0.02)),
        ];
        for (name, on, value) in cases {
            assert_eq!((Named::parse(name).unwrap().on, speed(name)), (on, Ok(value)), "{name}");
        }
        assert_eq!(Named::parse("A36_amp_a0_d10mm_sample3").unwrap(), Named::default());
        let full = Named::parse("steel_10N_amplitude=5um_40kHz_v0.1_ON").unwrap();
        let units = Units::parse_friction(["m/s"]).unwrap();
        assert_eq!(full.number(Quantity::Velocity, &units).unwrap(), Some(0.1));
        assert_eq!(full.number(Quantity::Normal, &units).unwrap(), Some(10.0));
        assert_eq!((full.number(Quantity::Frequency, &units).unwrap(), full.level().unwrap()), (Some(40e3), Some((5.0, "um"))));
        for (name, why) in [
            ("v0.1_on", "`0.1` in the name of the file has no unit"),
            ("v2furlongs_off", "the unit `furlongs` of the column `2furlongs in the name of the file`"),
            ("off_pin_on_disc", "says ON and OFF"),
            ("10mmps_20mmps_on", "says both"),
            ("v0_05mps_off", "may have lost its decimal point"),
        ] {
            assert!(speed(name).is_err_and(|error| error.contains(why)), "{name}: {:?}", speed(name));
        }
    }
}
