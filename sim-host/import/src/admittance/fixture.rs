//! Correction of a fixture: a series impedance `Zs`, a stray admittance `Yo` across the transducer,
//! and a resistance `R` in series with it.
//!
//! ```text
//! Zs = Z(short),   Yo = 1 / (Z(open) - Zs),   1 / Y + R = 1 / (1 / (Z - Zs) - Yo)
//! ```
//!
//! This is the open-short compensation of impedance analysers. Both measurements are interpolated
//! linearly in frequency, as impedance and as admittance. Curves show corrected values. The fit
//! compares the readings of the instrument, because the noise is that of the instrument.

use num_complex::Complex64;

use super::measured::Measured;
use super::options::Options;
use crate::error::ImportError;
use report::statistics::{ascending, quantile};

/// Network between transducer and instrument at one frequency.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fixture {
    /// Impedance in series with the whole, ohm.
    pub lead: Complex64,
    /// Admittance across the transducer and its series resistance, S.
    pub stray: Complex64,
    /// Resistance in series with the transducer alone, ohm.
    pub series_ohm: f64,
}

impl Fixture {
    /// Returns the admittance that the instrument measures, and its derivative by that of the
    /// transducer.
    pub(crate) fn seen(&self, admittance: Complex64) -> (Complex64, Complex64) {
        let behind = (1.0 + self.series_ohm * admittance).inv();
        let across = admittance * behind + self.stray;
        let before = (1.0 + self.lead * across).inv();
        (across * before, behind * behind * before * before)
    }

    /// Returns the admittance of the transducer from the measured one.
    fn corrected(&self, seen: Complex64) -> Complex64 {
        let across = (seen.inv() - self.lead).inv() - self.stray;
        (across.inv() - self.series_ohm).inv()
    }
}

/// Corrects the fixture that the options give.
pub(super) fn correct(measured: &mut Measured, options: &Options) -> Result<(), ImportError> {
    let read = |path: &Option<std::path::PathBuf>| path.as_deref().map(|path| Measured::read(path, options)).transpose();
    let (open, short) = (read(&options.open)?, read(&options.short)?);
    apply(measured, open.as_ref(), short.as_ref(), options.series_ohm)
}

/// Corrects a fixture by its measurements.
pub(crate) fn apply(
    measured: &mut Measured,
    open: Option<&Measured>,
    short: Option<&Measured>,
    series_ohm: f64,
) -> Result<(), ImportError> {
    if open.is_none() && short.is_none() && series_ohm == 0.0 {
        return Ok(());
    }
    check_order(measured, open, short)?;
    for at in 0..measured.hz.len() {
        let hz = measured.hz[at];
        let lead = short.map_or(Ok(Complex64::ZERO), |short| at_frequency(short, hz, "short", |y| y.inv()))?;
        let stray = match open {
            Some(open) => {
                let whole = at_frequency(open, hz, "open", |y| y)?;
                if whole == Complex64::ZERO { whole } else { (whole.inv() - lead).inv() }
            }
            None => Complex64::ZERO,
        };
        let fixture = Fixture { lead, stray, series_ohm };
        let corrected = fixture.corrected(measured.seen[at]);
        if !(corrected.re.is_finite() && corrected.im.is_finite()) {
            return Err(ImportError::Fixture(format!("the corrected admittance is not finite at {hz} Hz")));
        }
        measured.admittance[at] = corrected;
        measured.fixture.push(fixture);
    }
    let names =
        [open.map(|_| "open fixture"), short.map(|_| "shorted fixture"), (series_ohm != 0.0).then_some("series resistance")];
    let names: Vec<_> = names.into_iter().flatten().collect();
    measured.remarks.push(format!("Corrected for the {}", names.join(", ")));
    Ok(())
}

/// Checks that the open fixture has a larger impedance than the shorted one and the transducer, and
/// the shorted one a smaller impedance than both.
fn check_order(measured: &Measured, open: Option<&Measured>, short: Option<&Measured>) -> Result<(), ImportError> {
    let sizes = |sweep: &Measured| ascending(sweep.seen.iter().map(|y| y.norm_sqr().sqrt().recip()));
    let middle = |sweep: &Measured| quantile(&sizes(sweep), 0.5).unwrap_or(f64::NAN);
    let (open, short, own) = (open.map(middle), short.map(middle), sizes(measured));
    let (least, most) = (own.first().copied().unwrap_or(0.0), own.last().copied().unwrap_or(f64::INFINITY));
    let why = match (open, short) {
        (Some(open), Some(short)) if open < short => {
            format!("the open fixture has {open:.3e} ohm, the shorted one {short:.3e} ohm; exchange `--open` and `--short`")
        }
        (Some(open), _) if open < least => {
            format!("the open fixture has {open:.3e} ohm, less than the transducer ({least:.3e} ohm); is it the shorted one?")
        }
        (_, Some(short)) if short > most => {
            format!("the shorted fixture has {short:.3e} ohm, more than the transducer ({most:.3e} ohm); is it the open one?")
        }
        _ => return Ok(()),
    };
    Err(ImportError::Fixture(why))
}

/// Returns a value of a fixture at a frequency, interpolated between its points.
fn at_frequency(fixture: &Measured, hz: f64, name: &str, of: impl Fn(Complex64) -> Complex64) -> Result<Complex64, ImportError> {
    let points = &fixture.hz;
    let behind = points.partition_point(|point| *point < hz);
    // Frequencies that differ only in the last printed digits are equal.
    let slack = 1e-6 * hz;
    let value = |at: usize| of(fixture.admittance[at]);
    match (behind.checked_sub(1), points.get(behind)) {
        (Some(before), Some(next)) => {
            let part = (hz - points[before]) / (next - points[before]);
            Ok(value(before) * (1.0 - part) + value(behind) * part)
        }
        (None, Some(first)) if first - hz <= slack => Ok(value(0)),
        (Some(last), None) if hz - points[last] <= slack => Ok(value(last)),
        _ => {
            let (from, to) = (points.first().copied().unwrap_or(0.0), points.last().copied().unwrap_or(0.0));
            Err(ImportError::Fixture(format!(
                "the measurement of the {name} goes from {from} to {to} Hz, but the sweep has {hz} Hz"
            )))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::coordinate::Coordinate;
    use super::*;

    #[test]
    fn open_short_and_series_resistance_are_corrected() {
        let hz = vec![40e3, 41e3];
        let sweep = |of: &dyn Fn(f64) -> Complex64| Measured {
            hz: hz.clone(),
            admittance: hz.iter().map(|&hz| of(hz)).collect(),
            seen: hz.iter().map(|&hz| of(hz)).collect(),
            fixture: Vec::new(),
            coordinate: Coordinate::Immittance,
            remarks: Vec::new(),
        };
        let (lead, stray, own) = (Complex64::new(0.3, 0.2), Complex64::new(0.0, 1e-6), Complex64::new(2e-3, 1e-3));
        let within = |y: Complex64| (lead + (stray + y).inv()).inv();
        let mut measured = sweep(&|_| within((own.inv() + 10.0).inv()));
        let open = sweep(&|_| within(Complex64::ZERO));
        let short = sweep(&|_| lead.inv());
        apply(&mut measured, Some(&open), Some(&short), 10.0).unwrap();
        assert!(measured.admittance.iter().all(|y| (y - own).norm_sqr() < 1e-24), "{measured:?}");
        assert!((measured.reading(1, own).0 - Coordinate::Immittance.of(measured.seen[1])).norm_sqr() < 1e-24);
        let mut exchanged = |open, short| apply(&mut measured, open, short, 0.0).unwrap_err().to_string();
        assert!(exchanged(Some(&short), Some(&open)).contains("exchange `--open` and `--short`"));
        assert!(exchanged(Some(&short), None).contains("is it the shorted one?"));
        assert!(exchanged(None, Some(&open)).contains("is it the open one?"));
        let narrow = Measured { hz: vec![40.5e3, 40.6e3], ..open };
        let error = apply(&mut measured, Some(&narrow), None, 0.0).unwrap_err().to_string();
        assert!(error.contains("open goes from 40500 to 40600 Hz, but the sweep has 40000 Hz"), "{error}");
    }
}
