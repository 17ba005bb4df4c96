//! Friction logs: slip and force of each sample, the normal force, and the time of the vibration.

use num_complex::Complex64;

use super::quantity::{Columns, Quantity};
use super::smoothed::Smoothed;
use crate::error::ImportError;
use crate::rows::{bins, means};
use crate::units::Units;
use columns::Table;
use report::significant;

/// Options for properties that a file does not contain.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Options {
    /// Names of the columns, replacing the heading.
    pub columns: Option<String>,
    /// Normal force, N, if no column contains it.
    pub normal_n: Option<f64>,
    /// Intervals in which the vibration is ON, s, if no column contains it.
    pub on_s: Vec<(f64, f64)>,
    /// Units of columns and parts of file names that state none.
    pub units: Units,
    /// Frequency of the vibration, Hz, if no column contains it.
    pub frequency_hz: Option<f64>,
    /// Peak velocity of the vibration, m/s, if it was measured and no column contains it.
    pub tip_m_per_s: Option<f64>,
}

/// Friction log.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Log {
    /// Time of each sample, s; empty if the file has none.
    pub time_s: Vec<f64>,
    /// Slip since the preceding sample, m; zero for the first.
    pub slip_m: Vec<f64>,
    /// Slip velocity, m/s.
    pub velocity_m_per_s: Vec<f64>,
    /// Friction, N, positive if it opposes a positive slip.
    pub force_n: Vec<f64>,
    /// Mean normal force, N.
    pub normal_n: f64,
    /// Normal force of each sample, N; empty if it is constant.
    pub normals_n: Vec<f64>,
    /// Standard deviation of the noise of the displacement, m; zero without a displacement.
    pub noise_m: f64,
    /// `true` for samples with vibration.
    pub on: Vec<bool>,
    /// Inferred properties of the file, one sentence each.
    pub remarks: Vec<String>,
}

/// Minimum number of samples of the OFF part.
const MIN_OFF_SAMPLES: usize = 20;
/// Work on the contact above which the sign of the force is turned, relative to the sum of its
/// sizes.
const MIN_WORK_REL: f64 = 0.1;
/// Largest ratio of a measured velocity to the slope of the displacement, and its inverse.
const MAX_SLOPE_RATIO: f64 = 2.0;
/// Mean square of a slope that is more than noise, relative to that of its noise.
const SLOPE_OVER_NOISE: f64 = 4.0;
/// Largest range of a constant normal force, relative to its mean.
const MAX_CONSTANT_REL: f64 = 1e-3;
/// Smallest normal force of a sample, relative to the mean, so that no limit of a spring is zero.
const MIN_NORMAL_REL: f64 = 1e-6;

impl Log {
    /// Parses a log from the content of a file.
    ///
    /// # Errors
    /// Returns [`ImportError`], with the line or column that shows the reason.
    pub fn parse(bytes: impl AsRef<[u8]>, options: &Options) -> Result<Self, ImportError> {
        Self::from_columns(&Columns::parse(bytes.as_ref(), options.columns.as_deref())?, options)?.checked()
    }

    /// Reads a log from the columns of a table.
    pub(super) fn from_columns(columns: &Columns, options: &Options) -> Result<Self, ImportError> {
        let column = |wanted: Quantity| columns.numbers(wanted, &options.units);
        let (table, seen) = (&columns.table, |what: &str| columns.missing(what));
        let (time, x, v) = (column(Quantity::Time)?, column(Quantity::Displacement)?, column(Quantity::Velocity)?);
        let (force_n, mu) = (column(Quantity::Force(None))?, column(Quantity::Mu(None))?);
        let count = force_n.as_ref().or(mu.as_ref()).ok_or_else(|| seen("no column is the friction force"))?.len();
        if let Some(at) = time
            .as_ref()
            .and_then(|time| time.windows(2).position(|pair| pair[0].partial_cmp(&pair[1]).is_none_or(|order| order.is_ge())))
        {
            let what = "the time does not increase here".to_owned();
            return Err(ImportError::bad_row(table, at + 1, what));
        }
        let mut remarks = vec![format!("A table with {}", table.found)];
        let smoothed = match (&x, &time) {
            (Some(x), Some(time)) if count > 1 => Some(Smoothed::new(time, x)),
            _ => None,
        };
        let noise_m = smoothed.as_ref().map_or(0.0, |smoothed| smoothed.noise_m);
        let steps = |x: &[f64]| std::iter::once(0.0).chain(x.windows(2).map(|pair| pair[1] - pair[0])).collect::<Vec<_>>();
        let slip_m = match (&smoothed, &x, &v, &time) {
            (Some(smoothed), ..) => steps(&smoothed.x_m),
            (None, Some(x), ..) => steps(x),
            (None, None, Some(v), Some(time)) => {
                let mean = |at: usize| 0.5 * (v[at] + v[at - 1]) * (time[at] - time[at - 1]);
                (0..count).map(|at| if at == 0 { 0.0 } else { mean(at) }).collect()
            }
            _ => return Err(seen("the slip needs a displacement, or time and velocity")),
        };
        let v = match (v, &smoothed) {
            (Some(v), Some(smoothed)) => velocity(v, smoothed, &mut remarks)?,
            (v, _) => v,
        };
        let velocity_m_per_s = match (v, smoothed) {
            (Some(v), _) => v,
            (None, Some(smoothed)) => {
                remarks.push(smoothed.remark());
                smoothed.velocity_m_per_s
            }
            (None, None) => return Err(seen("the velocity needs a column, or time and displacement")),
        };
        let normal = match options.normal_n {
            Some(_) => None,
            None => column(Quantity::Normal)?,
        };
        let (normal_n, normals_n) = match (options.normal_n, normal) {
            (None, Some(normals)) => normal_forces(normals, table, &mut remarks)?,
            (normal, _) => (normal.unwrap_or_default(), Vec::new()),
        };
        if normal_n == 0.0 && (options.normal_n.is_some() || columns.place(Quantity::Normal).is_some()) {
            return Err(ImportError::NoFit("the normal force is 0; give its mean with `--normal-n`".into()));
        }
        if normal_n <= 0.0 {
            let help = "give it with `--normal-n`, or as a column `N [N]`".to_owned();
            return Err(ImportError::UnitMissing { column: "the normal force".into(), help });
        }
        // A coefficient of friction is the force over the normal force.
        let normal_at = |at: usize| normals_n.get(at).copied().unwrap_or(normal_n);
        let of_mu = |mu: Vec<f64>| mu.into_iter().enumerate().map(|(at, mu)| mu * normal_at(at)).collect();
        let force_n = force_n.or_else(|| mu.map(of_mu)).unwrap_or_default();
        let on = match (columns.states()?, &time) {
            (Some(on), _) => on,
            (None, Some(time)) => time.iter().map(|t| options.on_s.iter().any(|(from, to)| (*from..*to).contains(t))).collect(),
            (None, None) => vec![false; count],
        };
        Ok(Log { time_s: time.unwrap_or_default(), slip_m, velocity_m_per_s, force_n, normal_n, normals_n, noise_m, on, remarks })
    }

    /// Returns two logs of this number of samples for the search of a long one: the means over
    /// bins, and the first samples without vibration. Means do not resolve a steady oscillation; a
    /// part does not have the range of a slow change.
    pub(super) fn shortened(&self, samples: usize) -> [Log; 2] {
        let largest = |values: &[f64]| values.iter().fold(f64::MIN_POSITIVE, |most, value| most.max(value.abs()));
        let (force, velocity) = (largest(&self.force_n), largest(&self.velocity_m_per_s));
        let course = self.force_n.iter().zip(&self.velocity_m_per_s).map(|(f, v)| Complex64::new(f / force, v / velocity));
        let bins = bins(&course.collect::<Vec<_>>(), samples);
        let first = self.on.iter().position(|on| !on).unwrap_or(0);
        let part = first..self.on.len().min(first + samples);
        let log = |slip_m: Vec<f64>, of: &dyn Fn(&[f64]) -> Vec<f64>, on: Vec<bool>| {
            let of = |values: &[f64]| if values.is_empty() { Vec::new() } else { of(values) };
            let (velocity_m_per_s, force_n) = (of(&self.velocity_m_per_s), of(&self.force_n));
            let (time_s, normals_n) = (of(&self.time_s), of(&self.normals_n));
            Log { time_s, slip_m, velocity_m_per_s, force_n, on, normal_n: self.normal_n, normals_n, ..Log::default() }
        };
        let mut x = self.slip_m.clone();
        (1..x.len()).for_each(|at| x[at] += x[at - 1]);
        let mut slip_m = means(&x, &bins);
        (1..slip_m.len()).rev().for_each(|at| slip_m[at] -= slip_m[at - 1]);
        let on = bins.iter().map(|bin| self.on[bin.clone()].contains(&true)).collect();
        [
            log(slip_m, &|values| means(values, &bins), on),
            log(self.slip_m[part.clone()].to_vec(), &|values| values[part.clone()].to_vec(), self.on[part.clone()].to_vec()),
        ]
    }

    /// Returns the middle between the mean forces of both directions of the part without vibration,
    /// N; zero if it slides in one direction.
    pub(super) fn offset_n(&self) -> f64 {
        let mean = |forward: bool| {
            let is_part = |at: &usize| !self.on[*at] && self.slip_m[*at] != 0.0 && (self.slip_m[*at] > 0.0) == forward;
            let forces: Vec<f64> = (0..self.on.len()).filter(is_part).map(|at| self.force_n[at]).collect();
            (!forces.is_empty()).then(|| forces.iter().sum::<f64>() / forces.len() as f64)
        };
        mean(true).zip(mean(false)).map_or(0.0, |(forward, back)| 0.5 * (forward + back))
    }

    /// Turns the sign of a force that does work on the contact, and returns `true` if it does.
    /// Friction always takes energy out of the motion.
    pub(super) fn turn(&mut self) -> bool {
        let offset = self.offset_n();
        let parts = self.force_n.iter().zip(&self.slip_m).zip(&self.on).filter(|(_, on)| !**on);
        let works = parts.map(|((force, slip), _)| (force - offset) * slip);
        let (work, size) = works.fold((0.0, 0.0), |(work, size), part| (work + part, size + part.abs()));
        let is_driven = work < -MIN_WORK_REL * size;
        if is_driven {
            self.force_n.iter_mut().for_each(|force| *force = -*force);
        }
        is_driven
    }

    pub(super) fn checked(self) -> Result<Self, ImportError> {
        let off = self.on.iter().filter(|on| !**on).count();
        if off < MIN_OFF_SAMPLES {
            return Err(ImportError::NoFit(format!("only {off} samples without vibration; a contact needs {MIN_OFF_SAMPLES}")));
        }
        if self.slip_m.iter().all(|slip| *slip == 0.0) {
            return Err(ImportError::NoFit("nothing slides: the displacement is constant".into()));
        }
        Ok(self)
    }
}

/// Returns the measured velocity, or `None` for a speed without a sign, so that the slope of the
/// displacement is used. Refuses one that is not that slope.
fn velocity(v: Vec<f64>, smoothed: &Smoothed, remarks: &mut Vec<String>) -> Result<Option<Vec<f64>>, ImportError> {
    let slope = &smoothed.velocity_m_per_s;
    let is_speed = v.iter().all(|v| *v >= 0.0) && slope.iter().any(|slope| *slope < 0.0);
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| if is_speed { (a * b).abs() } else { a * b }).sum::<f64>();
    let (own, both, square) = (dot(&v, &v), dot(&v, slope), dot(slope, slope));
    let noise = v.len() as f64 * smoothed.velocity_noise_m_per_s.powi(2);
    let ratio = both / (square - noise);
    // A slope that is mostly noise proves nothing.
    if square < SLOPE_OVER_NOISE * noise || own == 0.0 {
        return Ok(Some(v));
    }
    if !(1.0 / MAX_SLOPE_RATIO..MAX_SLOPE_RATIO).contains(&ratio) {
        return Err(ImportError::NoFit(format!(
            "the velocity is not the slope of the displacement: their ratio is {}. Correct the unit or the sign of one of them, \
             or leave one out",
            significant(ratio)
        )));
    }
    if is_speed {
        remarks.push("The speed has no sign: the slope of the displacement is the velocity".into());
    }
    Ok((!is_speed).then_some(v))
}

/// Returns the mean normal force and that of each sample, N. The size of a negative force is used.
fn normal_forces(mut normals: Vec<f64>, table: &Table, remarks: &mut Vec<String>) -> Result<(f64, Vec<f64>), ImportError> {
    let sign = normals.iter().find(|normal| **normal != 0.0).map_or(1.0, |normal| normal.signum());
    if let Some(at) = normals.iter().position(|normal| normal * sign < 0.0) {
        let what = "the normal force changes its sign here; subtract its offset, or give a mean with `--normal-n`".to_owned();
        return Err(ImportError::bad_row(table, at, what));
    }
    normals.iter_mut().for_each(|normal| *normal *= sign);
    if sign < 0.0 {
        remarks.push("The normal force is negative throughout: its size was used".into());
    }
    let mean = normals.iter().sum::<f64>() / normals.len().max(1) as f64;
    let (least, most) = normals.iter().fold((mean, mean), |(least, most), normal| (least.min(*normal), most.max(*normal)));
    if most - least <= MAX_CONSTANT_REL * mean {
        return Ok((mean, Vec::new()));
    }
    remarks.push(format!("The friction is proportional to the normal force of each sample, {least:.3} to {most:.3} N"));
    normals.iter_mut().for_each(|normal| *normal = normal.max(MIN_NORMAL_REL * mean));
    Ok((mean, normals))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_and_columns_of_a_log_are_recognised() {
        let lines: String = (0..30).map(|n| format!("{n};{},5;2;{}\n", n, n / 20)).collect();
        let log = Log::parse(format!("t [ms];x [um];F [mN];on\n{lines}"), &Options { normal_n: Some(2.0), ..Options::default() })
            .unwrap();
        assert!((log.slip_m[1] - 1e-6).abs() < 1e-18 && (log.velocity_m_per_s[3] - 1e-3).abs() < 1e-12);
        assert_eq!((log.on[19], log.on[20], log.force_n[0]), (false, true, 2e-3));
    }

    #[test]
    fn a_log_without_unit_or_normal_force_is_refused() {
        let lines: String = (0..30).map(|n| format!("{n},{n},2\n")).collect();
        let error = |head: &str| Log::parse(format!("{head}\n{lines}"), &Options::default()).unwrap_err().to_string();
        assert!(error("t [s],x,F [N]").starts_with("unit missing: the column `x` has no unit"));
        assert!(error("t [s],x [m],F [N]").starts_with("unit missing: the normal force"));
        assert!(error("t [s],x [m],u [V]").contains("no column is the friction force"));
    }

    #[test]
    fn columns_that_contradict_each_other_are_refused() {
        let error = |head: &str, row: fn(i32) -> String| {
            let lines: String = (0..40).map(|n| row(n) + "\n").collect();
            Log::parse(format!("{head}\n{lines}"), &Options { normal_n: Some(2.0), ..Options::default() })
                .err()
                .map(|e| e.to_string())
        };
        let twice = error("t [s],position [m],x [m],F [N]", |n| format!("{n},{n},{n},2"));
        assert!(twice.is_some_and(|error| error.contains("`position [m]` and `x [m]` have the same quantity")));
        let slope = error("t [s],x [m],v [m/s],F [N]", |n| format!("{n},{n},1000,2"));
        assert!(slope.is_some_and(|error| error.contains("not the slope of the displacement: their ratio is 1000")));
        assert_eq!(error("t [s],x [m],v [m/s],F [N]", |n| format!("{n},{n},1,2")), None);
        // A speed has no sign.
        let turned = |n: i32| format!("{n},{},1,2", if n < 20 { n } else { 40 - n });
        assert_eq!(error("t [s],x [m],speed [m/s],F [N]", turned), None);
        // A note in brackets is not a unit.
        assert_eq!(error("t [s],x [m],F [N],on [0/1]", |n| format!("{n},{n},2,0")), None);
        // `drive [V]` is not a state, `a [g]` not an amplitude, and `T` not a time next to `t`.
        assert_eq!(error("T [°C],t [s],x [m],F [N],drive [V],a [g]", |n| format!("25,{n},{n},2,2,0.1")), None);
        let zero = Log::parse("t [s],x [m],F [N],N [N]\n0,0,1,0\n1,1,1,0\n2,2,1,0\n", &Options::default()).unwrap_err();
        assert!(zero.to_string().contains("the normal force is 0"), "{zero}");
    }

    #[test]
    fn a_coefficient_of_friction_replaces_the_force() {
        let lines: String = (0..40).map(|n| format!("{n},{n},0.3\n")).collect();
        let log = Log::parse(format!("t [s],x [m],mu\n{lines}"), &Options { normal_n: Some(2.0), ..Options::default() }).unwrap();
        assert!((log.force_n[3] - 0.6).abs() < 1e-12 && log.force_n.len() == 40);
    }

    #[test]
    fn a_coefficient_of_friction_may_be_in_percent_only() {
        let mu = |head: &str| {
            let columns = Columns::parse(format!("{head}\n29.9,1\n30.1,1\n").as_bytes(), None)?;
            Ok::<_, ImportError>(columns.numbers(Quantity::Mu(None), &Units::default())?.unwrap_or_default()[0])
        };
        assert!(
            (mu("mu [%],k").unwrap() - 0.299).abs() < 1e-12 && mu("mu [1],k").unwrap() == 29.9 && mu("mu,k").unwrap() == 29.9
        );
        assert!(mu("mu [furlong],k").unwrap_err().to_string().contains("the unit `furlong`"));
    }

    #[test]
    fn a_normal_force_has_one_sign() {
        let log = |normal: fn(i32) -> i32| {
            let lines: String = (0..30).map(|n| format!("{n},{n},2,{}\n", normal(n))).collect();
            Log::parse(format!("t [s],x [m],F [N],N [N]\n{lines}"), &Options::default())
        };
        let negative = log(|n| -10 - n % 2).unwrap();
        assert_eq!((negative.normal_n, negative.normals_n[1]), (10.5, 11.0));
        assert!(negative.remarks.iter().any(|remark| remark.contains("negative throughout")), "{:?}", negative.remarks);
        assert!(log(|n| n - 20).unwrap_err().to_string().starts_with("line 23: the normal force changes its sign"));
        // A binary file has rows without lines.
        let header = "{'descr': [('t_s', '<f8'), ('x_m', '<f8'), ('force_n', '<f8'), ('load_n', '<f8')], 'fortran_order': False, 'shape': (30,), }";
        let rows = (0..30).flat_map(|n| [f64::from(n), f64::from(n), 2.0, f64::from(n - 20)]).flat_map(f64::to_le_bytes);
        let npy = [b"\x93NUMPY\x01\x00", &(header.len() as u16).to_le_bytes()[..], header.as_bytes(), &rows.collect::<Vec<u8>>()]
            .concat();
        let error = Log::parse(&npy, &Options::default()).unwrap_err().to_string();
        assert!(error.contains("row 22: the normal force changes its sign"), "{error}");
    }
}
