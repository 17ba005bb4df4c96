//! Units that a heading does not give: by option, or found where only one makes sense.

use crate::error::ImportError;
use crate::heading::{Dimension, Heading, Quantity, Unit, unit};

/// Series resonances that a scene can have, Hz: where a frequency without a unit must lie.
const RESONANCES_HZ: (f64, f64) = (100.0, 450e3);
/// Units that a frequency may be in.
const FREQUENCIES: [(&str, f64); 4] = [("Hz", 1.0), ("kHz", 1e3), ("MHz", 1e6), ("GHz", 1e9)];
/// A capacitor's angle comes near a quarter turn: angles that reach this much may be radians.
const LEAST_RADIANS: f64 = 1.0;
/// Angles to this are within half a turn in radians; beyond the second, they are none.
const MOST_RADIANS: (f64, f64) = (3.15, 6.3);
/// Largest angle in degrees.
const MOST_DEGREES: f64 = 360.0;

/// Units given by option: one for each dimension at most.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Units(Vec<Unit>);

impl Units {
    /// Units by their names, as `khz`, `ohm`, `mS`, `deg`.
    ///
    /// # Errors
    /// The name that is no unit, or the second of a dimension.
    pub fn parse<'a>(names: impl IntoIterator<Item = &'a str>) -> Result<Self, String> {
        let mut units: Vec<Unit> = Vec::new();
        for name in names {
            let unit = unit(name).ok_or_else(|| format!("`{name}` is no unit; known are Hz, ohm, S with a prefix, deg, rad"))?;
            if units.iter().any(|known| known.dimension == unit.dimension) {
                return Err(format!("`{name}` is the second unit of its kind"));
            }
            units.push(unit);
        }
        Ok(Units(units))
    }

    fn of(&self, dimension: Dimension) -> Option<Unit> {
        self.0.iter().find(|unit| unit.dimension == dimension).copied()
    }
}

/// Brings a column to the SI's unit, in place; what was found rather than given is added to `remarks`.
pub(crate) fn to_si(heading: &Heading, values: &mut [f64], units: &Units, remarks: &mut Vec<String>) -> Result<(), ImportError> {
    let dimension = heading.quantity.dimension();
    let factor = match heading.unit.or(units.of(dimension)) {
        Some(unit) => unit.factor,
        None => found(heading, values, remarks)?,
    };
    values.iter_mut().for_each(|value| *value *= factor);
    Ok(())
}

/// The factor of a column without a unit.
fn found(heading: &Heading, values: &[f64], remarks: &mut Vec<String>) -> Result<f64, ImportError> {
    let column = format!("the column `{}`", heading.text);
    match heading.quantity {
        Quantity::Frequency => {
            let (least, most) = values.iter().fold((f64::INFINITY, 0.0_f64), |(least, most), &f| (least.min(f), most.max(f)));
            let fits = |factor: &f64| most * factor >= RESONANCES_HZ.0 && least * factor <= RESONANCES_HZ.1;
            let fitting: Vec<_> = FREQUENCIES.iter().filter(|(_, factor)| fits(factor)).collect();
            match fitting[..] {
                [&(name, factor)] => {
                    remarks.push(format!("{column} has no unit: only {name} gives frequencies of a transducer"));
                    Ok(factor)
                }
                _ => {
                    let names: Vec<_> = fitting.iter().map(|(name, _)| *name).collect();
                    let meant = if names.is_empty() { "none of Hz to GHz gives frequencies from 100 Hz to 450 kHz" } else { "" };
                    let meant = if meant.is_empty() { format!("it may be {}", names.join(" or ")) } else { meant.to_owned() };
                    Err(ImportError::UnitMissing { column, help: format!("{meant}; say so with `--unit`, as `--unit khz`") })
                }
            }
        }
        Quantity::Angle => {
            let largest = values.iter().fold(0.0_f64, |most, angle| most.max(angle.abs()));
            if largest > MOST_RADIANS.1 && largest <= MOST_DEGREES {
                remarks.push(format!("{column} has no unit: angles to {largest} are degrees"));
                Ok(std::f64::consts::PI / 180.0)
            } else if (LEAST_RADIANS..=MOST_RADIANS.0).contains(&largest) {
                remarks
                    .push(format!("{column} has no unit: angles to {largest} are radians, as a capacitance has a quarter turn"));
                Ok(1.0)
            } else {
                Err(ImportError::AngleDoubtful { column, largest })
            }
        }
        _ if heading.quantity.dimension() == Dimension::None => Ok(1.0),
        Quantity::Conductance | Quantity::Susceptance | Quantity::Admittance => {
            Err(ImportError::UnitMissing { column, help: "say so with `--unit`, as `--unit s` or `--unit ms`".into() })
        }
        _ => Err(ImportError::UnitMissing { column, help: "say so with `--unit`, as `--unit ohm` or `--unit kohm`".into() }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::heading::heading;

    fn converted(name: &str, values: &[f64], units: &[&str]) -> Result<Vec<f64>, String> {
        let units = Units::parse(units.iter().copied())?;
        let mut values = values.to_vec();
        let heading = heading(name).ok_or("unknown")?;
        to_si(&heading, &mut values, &units, &mut Vec::new()).map_err(|error| error.to_string())?;
        Ok(values)
    }

    #[test]
    fn a_frequency_without_a_unit_is_found_where_one_unit_makes_sense() {
        assert_eq!(converted("f", &[39e3, 41e3], &[]), Ok(vec![39e3, 41e3]));
        assert_eq!(converted("f", &[39.0, 41.0], &[]), Ok(vec![39e3, 41e3]));
        assert!(converted("f", &[150.0, 300.0], &[]).is_err_and(|error| error.contains("Hz or kHz")));
        assert_eq!(converted("f", &[150.0, 300.0], &["khz"]), Ok(vec![150e3, 300e3]));
    }

    #[test]
    fn degrees_and_radians_are_told_apart_or_refused() {
        let quarter = std::f64::consts::FRAC_PI_2;
        assert_eq!(converted("theta", &[-90.0, 80.0], &[]).map(|values| (values[0] + quarter).abs() < 1e-12), Ok(true));
        assert_eq!(converted("theta", &[-1.55, 1.2], &[]), Ok(vec![-1.55, 1.2]));
        assert!([[-0.4, 0.4], [-4.0, 2.0]].iter().all(|angles| converted("theta", angles, &[]).is_err()));
        assert_eq!(converted("theta", &[-0.4, 0.4], &["rad"]), Ok(vec![-0.4, 0.4]));
    }

    #[test]
    fn an_impedance_without_a_unit_is_refused_by_name() {
        assert!(converted("|Z|", &[1.0], &[]).is_err_and(|error| error.starts_with("unit missing: the column `|Z|`")));
    }
}
