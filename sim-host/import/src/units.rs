//! Units that a heading does not give: from an option, or inferred if only one makes sense.

use columns::{Table, Unit};

use crate::error::ImportError;
use crate::quantity::{Known, Part, Quantity, Subject};

/// Smallest series resonance that a scene can have, Hz. A frequency without a unit must be in the
/// same range.
const MIN_RESONANCE_HZ: f64 = 100.0;
/// Largest series resonance that a scene can have, Hz.
const MAX_RESONANCE_HZ: f64 = 450e3;
/// Units that a frequency can have.
const FREQUENCIES: [(&str, f64); 4] = [("Hz", 1.0), ("kHz", 1e3), ("MHz", 1e6), ("GHz", 1e9)];
/// Smallest maximum of angles in radians. The angle of a capacitor is close to a quarter turn.
const MIN_RADIANS: f64 = 1.0;
/// Largest maximum of angles that are taken as radians: half a turn.
const MAX_RADIANS: f64 = 3.15;
/// Maximum of angles above which they cannot be radians.
const IMPOSSIBLE_RADIANS: f64 = 6.3;
/// Largest angle in radians after unwrapping; larger ones are degrees.
const MAX_UNWRAPPED_RADIANS: f64 = 60.0;
/// Largest angle in degrees.
const MAX_DEGREES: f64 = 360.0;

/// Quantities that can have a unit, by their SI units.
const BASES: [&str; 4] = ["Hz", "ohm", "S", "rad"];
/// Quantities of a friction measurement that can have a unit, by their SI units.
const FRICTION_BASES: [&str; 7] = ["s", "m", "m/s", "N", "Hz", "V", "A"];

/// Units given by option, at most one per quantity.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Units(Vec<Unit>);

impl Units {
    /// Parses units by their names, such as `khz`, `ohm`, `mS`, `deg`.
    ///
    /// # Errors
    /// Returns an error for a name that is not a unit, or for the second unit of a quantity.
    pub fn parse<'a>(names: impl IntoIterator<Item = &'a str>) -> Result<Self, String> {
        Self::parse_among(&BASES, "Hz, ohm, S with a prefix, deg, rad", names)
    }

    /// Parses units of the quantities of a friction measurement, such as `mm/s`, `N`, `um`, `V`.
    ///
    /// # Errors
    /// Returns an error for a name that is not a unit, or for the second unit of a quantity.
    pub fn parse_friction<'a>(names: impl IntoIterator<Item = &'a str>) -> Result<Self, String> {
        Self::parse_among(&FRICTION_BASES, "s, m, m/s, N, Hz, V, A, also with a prefix", names)
    }

    fn parse_among<'a>(bases: &[&str], known: &str, names: impl IntoIterator<Item = &'a str>) -> Result<Self, String> {
        let mut units: Vec<Unit> = Vec::new();
        for name in names {
            let like = |base: &&str| {
                Unit::parse(base).and_then(|base| Unit::parse_like(name, &base).filter(|unit| unit.measures_like(&base)))
            };
            let unit = bases.iter().find_map(like);
            let unit = unit.ok_or_else(|| format!("`{name}` is not a unit; known are {known}"))?;
            if unit.is_ambiguous() {
                return Err(format!("`{name}` may be milli or mega; write mOhm or MOhm"));
            }
            if units.iter().any(|known| known.measures_like(&unit)) {
                return Err(format!("`{name}` is the second unit of its kind"));
            }
            units.push(unit);
        }
        Ok(Units(units))
    }

    /// Returns the factor from the given unit of a quantity to its SI unit; `None` without one.
    pub(crate) fn factor_to(&self, base: &str) -> Option<f64> {
        let si = Unit::parse(base)?;
        self.0.iter().find_map(|unit| unit.factor_to(&si))
    }
}

/// Returns the numbers of a column of a table.
pub(crate) fn numbers(table: &Table, at: usize) -> Result<Vec<f64>, ImportError> {
    table.columns[at].numbers().map(<[f64]>::to_vec).map_err(|cell| {
        let what = format!("the column `{}` is {}, but a number is needed in each row", table.headings()[at], cell.what);
        ImportError::bad_row(table, cell.row, what)
    })
}

/// Returns the factor from the unit of a heading to an SI unit; `None` without a unit.
pub(crate) fn factor(text: &str, unit: Option<&str>, base: &str) -> Result<Option<f64>, ImportError> {
    let (Some(written), Some(si)) = (unit, Unit::parse(base)) else { return Ok(None) };
    let refuse = |help: String| Err(ImportError::UnitUnknown { column: text.to_owned(), unit: written.to_owned(), help });
    match Unit::parse_like(written, &si) {
        None => refuse(format!("write {base}, also with a prefix, in the heading or in `--columns`")),
        Some(unit) if unit.is_ambiguous() => {
            refuse("it may be milli or mega; write the prefix in full, as in `megaohm`".to_owned())
        }
        Some(unit) => match unit.factor_to(&si) {
            Some(factor) => Ok(Some(factor)),
            None => refuse(format!("{base} is needed")),
        },
    }
}

/// Converts a column to the SI unit, in place. Adds a remark if the unit was inferred.
pub(crate) fn to_si(heading: &Known, values: &mut [f64], units: &Units, remarks: &mut Vec<String>) -> Result<(), ImportError> {
    let sign = if heading.negative { -1.0 } else { 1.0 };
    let factor = match heading.quantity.base() {
        // A ratio in percent, or without a unit.
        None => factor(&heading.text, heading.unit.as_deref(), "%")?.map_or(1.0, |percent| 0.01 * percent),
        Some("dB") => 1.0,
        Some(base) => match factor(&heading.text, heading.unit.as_deref(), base)?.or_else(|| units.factor_to(base)) {
            Some(factor) => factor,
            None => found(heading, values, remarks)?,
        },
    };
    values.iter_mut().for_each(|value| *value *= sign * factor);
    let largest = values.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
    if heading.quantity.base() == Some("rad") && factor == 1.0 && largest > MAX_UNWRAPPED_RADIANS {
        let (column, unit) = (heading.text.clone(), "rad".to_owned());
        return Err(ImportError::UnitUnknown { column, unit, help: format!("angles up to {largest} are not in radians") });
    }
    Ok(())
}

/// Infers the factor of a column without a unit.
fn found(heading: &Known, values: &[f64], remarks: &mut Vec<String>) -> Result<f64, ImportError> {
    let column = format!("the column `{}`", heading.text);
    match heading.quantity {
        Quantity::Frequency => {
            let (least, most) = values.iter().fold((f64::INFINITY, 0.0_f64), |(least, most), &f| (least.min(f), most.max(f)));
            let fits = |factor: &f64| most * factor >= MIN_RESONANCE_HZ && least * factor <= MAX_RESONANCE_HZ;
            let fitting: Vec<_> = FREQUENCIES.iter().filter(|(_, factor)| fits(factor)).collect();
            match fitting[..] {
                [&(name, factor)] => {
                    remarks.push(format!("{column} has no unit: only {name} gives plausible frequencies of a transducer"));
                    Ok(factor)
                }
                _ => {
                    let names: Vec<_> = fitting.iter().map(|(name, _)| *name).collect();
                    let meant = if names.is_empty() { "none of Hz to GHz gives frequencies from 100 Hz to 450 kHz" } else { "" };
                    let meant = if meant.is_empty() { format!("it may be {}", names.join(" or ")) } else { meant.to_owned() };
                    Err(ImportError::UnitMissing {
                        column,
                        help: format!("{meant}; give it with `--unit`, such as `--unit khz`"),
                    })
                }
            }
        }
        Quantity::Of(_, Part::Angle) => {
            let largest = values.iter().fold(0.0_f64, |most, angle| most.max(angle.abs()));
            if largest > IMPOSSIBLE_RADIANS && largest <= MAX_DEGREES {
                remarks.push(format!("{column} has no unit: angles up to {largest} are degrees"));
                Ok(std::f64::consts::PI / 180.0)
            } else if (MIN_RADIANS..=MAX_RADIANS).contains(&largest) {
                remarks
                    .push(format!("{column} has no unit: angles up to {largest} are radians; a capacitance has a quarter turn"));
                Ok(1.0)
            } else {
                Err(ImportError::AngleDoubtful { column, largest })
            }
        }
        Quantity::Of(Some(Subject::Admittance), _) => {
            Err(ImportError::UnitMissing { column, help: "give it with `--unit`, such as `--unit S` or `--unit mS`".into() })
        }
        _ => {
            Err(ImportError::UnitMissing { column, help: "give it with `--unit`, such as `--unit ohm` or `--unit kohm`".into() })
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn converted(name: &str, values: &[f64], units: &[&str]) -> Result<Vec<f64>, String> {
        let units = Units::parse(units.iter().copied())?;
        let mut values = values.to_vec();
        let heading = Known::parse(name).ok_or("unknown")?;
        to_si(&heading, &mut values, &units, &mut Vec::new()).map_err(|error| error.to_string())?;
        Ok(values)
    }

    #[test]
    fn the_only_plausible_frequency_unit_is_inferred() {
        assert_eq!(converted("f", &[39e3, 41e3], &[]), Ok(vec![39e3, 41e3]));
        assert_eq!(converted("f", &[39.0, 41.0], &[]), Ok(vec![39e3, 41e3]));
        assert!(converted("f", &[150.0, 300.0], &[]).is_err_and(|error| error.contains("Hz or kHz")));
        assert_eq!(converted("f", &[150.0, 300.0], &["khz"]), Ok(vec![150e3, 300e3]));
    }

    #[test]
    fn degrees_and_radians_are_distinguished_or_refused() {
        let quarter = std::f64::consts::FRAC_PI_2;
        assert_eq!(converted("theta", &[-90.0, 80.0], &[]).map(|values| (values[0] + quarter).abs() < 1e-12), Ok(true));
        assert_eq!(converted("theta", &[-1.55, 1.2], &[]), Ok(vec![-1.55, 1.2]));
        assert!([[-0.4, 0.4], [-4.0, 2.0]].iter().all(|angles| converted("theta", angles, &[]).is_err()));
        assert_eq!(converted("theta", &[-0.4, 0.4], &["rad"]), Ok(vec![-0.4, 0.4]));
    }

    #[test]
    fn an_impedance_without_a_unit_is_refused() {
        assert!(converted("|Z|", &[1.0], &[]).is_err_and(|error| error.starts_with("unit missing: the column `|Z|`")));
    }
}
