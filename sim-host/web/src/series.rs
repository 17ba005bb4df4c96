//! A time series that the reader opens: measured curves over the figures of the last run.
//!
//! A column belongs to the curve of its name. If no curve has its name, it belongs to a curve in
//! the same quantity, provided that no other column has this quantity. Each curve takes one column.

use columns::heading::{Heading, axis_unit, factor, is_time_name};
use columns::{Table, Unit};
use report::{Figure, Series};
use scene::figures::{MEASURED, axis_units};
use scene::load::Loaded;
use scene::schema::unit_of;
use serde_json::{Value, json};

/// Largest number of points of a curve. More would only fill the text of the scene.
const MAX_POINTS: usize = 2000;

/// The last run of the page.
pub(crate) struct Shown {
    /// Its scene.
    pub(crate) loaded: Loaded,
    /// Its figures.
    pub(crate) figures: Vec<Figure>,
}

/// A column of a measured table: its heading, and the name and the unit in it.
struct Measured<'a> {
    heading: &'a str,
    name: &'a str,
    unit: Option<String>,
    negative: bool,
    place: usize,
}

impl<'a> Measured<'a> {
    fn new(heading: &'a str, place: usize) -> Self {
        let Heading { name, unit, negative } = Heading::new(heading, |_| false);
        let suffixed = columns::unit::split(heading);
        match suffixed {
            (name, Some(unit)) => Measured { heading, name, unit: Some(unit.symbol), negative, place },
            (_, None) => Measured { heading, name, unit: unit.map(str::to_owned), negative, place },
        }
    }

    /// Returns the factor to the unit of a curve. One that is not a power of ten converts to
    /// another quantity, as from revolutions per minute to hertz.
    fn factor_to(&self, curve: &str) -> Option<f64> {
        let factor = factor(self.unit.as_deref(), unit_of(curve).as_deref())?;
        let decades = factor.log10();
        ((decades - decades.round()).abs() < 1e-9).then_some(factor)
    }

    /// Returns the finite points of the column, in the unit of a curve.
    fn points(&self, times_s: &[f64], values: &[f64], curve: &str) -> Vec<(f64, f64)> {
        let factor = self.factor_to(curve).map_or(f64::NAN, |factor| if self.negative { -factor } else { factor });
        let points = times_s.iter().copied().zip(values.iter().map(|value| factor * value));
        points.filter(|(x, y)| x.is_finite() && y.is_finite()).collect()
    }

    /// Returns `true` if the heading has the name of a curve, with or without its unit.
    fn is_called(&self, curve: &str) -> bool {
        self.heading == curve || self.name == curve || self.name == columns::unit::split(curve).0
    }
}

/// Returns the column of the time, and the factor to seconds.
fn time<'a>(columns: &'a [Measured<'a>]) -> Option<(&'a Measured<'a>, f64)> {
    columns.iter().filter(|column| is_time_name(column.name)).find_map(|column| {
        let unit = Unit::parse(column.unit.as_deref().unwrap_or("s"))?;
        Some((column, unit.factor_to(&Unit::parse("s")?)?))
    })
}

/// Returns `true` if a table has a column of the time.
pub(crate) fn is_over_time(table: &Table) -> bool {
    let headings = table.headings();
    time(&measured(&headings)).is_some()
}

fn measured(headings: &[String]) -> Vec<Measured<'_>> {
    headings.iter().enumerate().map(|(place, heading)| Measured::new(heading, place)).collect()
}

impl Shown {
    /// Returns the scene with the columns of a table as measured curves, and a note for each.
    /// Without any curve it returns `None`.
    pub(crate) fn with_series(&self, file: &str, table: &Table) -> Option<Value> {
        let headings = table.headings();
        let columns = measured(&headings);
        let (axis, to_s) = time(&columns)?;
        let times_s: Vec<f64> = table.columns[axis.place].values.iter().map(|time| to_s * time).collect();
        let others = || columns.iter().filter(|column| column.place != axis.place);
        let curves = self.curves_at(&times_s);
        let taken = assigned(&others().collect::<Vec<_>>(), &curves);
        let (mut tables, mut notes) = (String::new(), Vec::new());
        if axis.unit.is_none() {
            notes.push(format!("assumed: `{}` is in seconds", axis.heading));
        }
        for column in others() {
            let curve = taken.iter().find(|(place, _)| *place == column.place).map(|(_, curve)| *curve);
            let points =
                curve.map(|curve| column.points(&times_s, &table.columns[column.place].values, curve)).unwrap_or_default();
            let Some(curve) = curve.filter(|_| !points.is_empty()) else {
                notes.push(format!("note: `{}` is compared with nothing", column.heading));
                continue;
            };
            let every = points.len().div_ceil(MAX_POINTS);
            let (x, values): (Vec<f64>, Vec<f64>) = points.into_iter().step_by(every).unzip();
            tables += &overlay(&format!("{file}: {}", column.heading), curve, &x, &values);
            let thinned = if every > 1 { format!(", one point of {every}") } else { String::new() };
            notes.push(format!("note: `{}` is compared with `{curve}`{thinned}", column.heading));
        }
        if tables.is_empty() {
            return None;
        }
        let Loaded { name: own, origin, input, sets, .. } = &self.loaded;
        let scene = if scene::builtin::text(origin).is_some() { format!("base = \"{own}\"\n") } else { input.clone() };
        Some(json!({
            "text": format!("{}\n{tables}", scene.trim_end()),
            "sets": sets,
            "fit": { "title": format!("{file} and the scene {own}"), "tables": [], "notes": notes, "why": null, "is_friction": false },
        }))
    }

    /// Returns the names of the curves over time, those first that exist at one of these times.
    pub(crate) fn curves_at(&self, times_s: &[f64]) -> Vec<&str> {
        let is_time = |figure: &&Figure| axis_units(&figure.x.label).iter().any(|axis| factor(Some("s"), *axis).is_some());
        let over_time = self.figures.iter().filter(|figure| figure.map.is_none()).filter(is_time);
        let curves = over_time.flat_map(|figure| figure.series.iter().map(|series| (self.scale(figure), series)));
        let curves = curves.filter(|(_, series)| !series.csv_column.starts_with(MEASURED));
        let meets = |scale: f64, series: &Series| {
            let (least, most) = series.x.iter().fold((f64::INFINITY, -f64::INFINITY), |ends, x| (ends.0.min(*x), ends.1.max(*x)));
            times_s.iter().any(|time| (least..=most).contains(&(scale * time)))
        };
        let (mut met, other): (Vec<_>, Vec<_>) = curves.partition(|(scale, series)| meets(*scale, series));
        met.extend(other);
        met.into_iter().map(|(_, series)| series.csv_column.as_str()).collect()
    }

    /// Returns the factor from seconds to the axis of a figure.
    fn scale(&self, figure: &Figure) -> f64 {
        let hz = self.loaded.scene.excitation.as_ref().map(|excitation| excitation.frequency_hz);
        factor(Some("s"), axis_unit(&figure.x.label)).or(hz).unwrap_or(1.0)
    }
}

/// Returns the curve of each column that has one, with the place of the column.
fn assigned<'a>(columns: &[&Measured], curves: &[&'a str]) -> Vec<(usize, &'a str)> {
    let converts = |column: &Measured, curve: &str| column.factor_to(curve).is_some();
    let is_alone = |column: &Measured| {
        let first = curves.iter().find(|curve| converts(column, curve));
        first.is_some_and(|curve| columns.iter().filter(|other| converts(other, curve)).count() == 1)
    };
    let mut taken: Vec<(usize, &str)> = Vec::new();
    for named in [true, false] {
        for column in columns.iter().filter(|column| named || is_alone(column)) {
            let fits = |curve: &&str| converts(column, curve) && (!named || column.is_called(curve));
            let free = |curve: &&str| taken.iter().all(|(place, other)| *place != column.place && other != curve);
            let curve = curves.iter().copied().find(|curve| free(curve) && fits(curve));
            taken.extend(curve.map(|curve| (column.place, curve)));
        }
    }
    taken
}

/// Returns the table of a measured curve. Its times are in seconds.
fn overlay(name: &str, quantity: &str, x: &[f64], values: &[f64]) -> String {
    let list = |numbers: &[f64]| numbers.iter().map(|number| format!("{number:e}")).collect::<Vec<_>>().join(", ");
    let name: String = name.chars().filter(|letter| !letter.is_control()).collect();
    let (name, x, values) = (json!(name), list(x), list(values));
    format!("\n[[overlay]]\nname = {name}\nquantity = \"{quantity}\"\nx_unit = \"s\"\nx = [{x}]\nvalues = [{values}]\n")
}

#[cfg(test)]
mod tests {
    use serde_json::Value;

    use crate::measurement::OpenedFile;
    use crate::{Request, Session};

    /// Runs a scene, drops a file, and runs the scene that it becomes.
    fn dropped(scene: &str, sets: &[&str], table: &str) -> Result<(Value, Value), String> {
        let mut session = Session::default();
        let sets = sets.iter().map(|&set| set.to_owned()).collect();
        session.run(&Request { name: scene.into(), sets, ..Request::default() }, None)?;
        let file = OpenedFile { name: "log.csv".into(), ..OpenedFile::default() };
        let opened = session.read(&file, table.as_bytes().to_vec())?;
        assert!(opened["text"].is_string(), "{}", opened["fit"]);
        let sets = opened["sets"].as_array().into_iter().flatten().filter_map(|set| set.as_str().map(str::to_owned)).collect();
        let text = opened["text"].as_str().map(str::to_owned);
        let result = session.run(&Request { name: "log.toml".into(), text, sets, ..Request::default() }, None)?;
        Ok((opened, result))
    }

    #[test]
    fn a_time_series_is_compared_with_the_curve_of_its_name_or_unit() {
        let short = ["duration_s=0.02", "controller.burst.on_s=[0.01]", "controller.burst.off_s=[0.02]"];
        for (scene, sets, table, metric, note) in [
            ("experiment-1", &short[..], "t [ms],friction_true_n\n5,0\n6,0\n", "overlay_rms_n", "`friction_true_n`"),
            (
                "experiment-1",
                &short,
                "time (s);w [mm/s]\n0,015;39,9\n0,016;40\n",
                "overlay_rms_m_per_s",
                "`w [mm/s]` is compared with",
            ),
            ("contact", &[], "t [us],F [mN]\n3320,1\n3325,2\n3330,3\n", "overlay_rms_n", "`F [mN]` is compared with"),
        ] {
            let (opened, result) = dropped(scene, sets, table).unwrap_or_else(|error| panic!("{scene}: {error}"));
            assert!(opened["fit"]["notes"][0].as_str().is_some_and(|said| said.contains(note)), "{scene}: {}", opened["fit"]);
            assert!(result["metrics"][metric].as_f64().is_some_and(f64::is_finite), "{scene}: {}", result["metrics"]);
        }
    }

    #[test]
    fn long_series_are_thinned_and_others_are_refused_with_the_curves_that_exist() {
        let rows: String = (0..5000).map(|row| format!("{},{}\n", f64::from(row) * 1e-6, row)).collect();
        let (opened, _) = dropped("contact", &[], &format!("t [s],P [mW]\n{rows}")).expect("drawn");
        assert!(opened["fit"]["notes"][0].as_str().is_some_and(|said| said.ends_with(", one point of 3")), "{}", opened["fit"]);
        for (table, notes) in [
            (
                "t [s];Fn [N];Fs [N];x [um]\n1e-6;1;2;0,1\n2e-6;2;3;0,2\n",
                ["`Fn [N]` is compared with nothing", "`displacement_um`"],
            ),
            (
                "T [degC],t [us],friction_n,F2 [mN]\n20,1,0.1,1\n20,2,0.2,2\n",
                ["`T [degC]` is compared with nothing", "`friction_n` is"],
            ),
            ("t,P [mW],n [rpm]\n1e-6,,3\n2e-6,1,4\n", ["assumed: `t` is in seconds", "`n [rpm]` is compared with nothing"]),
        ] {
            let (opened, _) = dropped("contact", &[], table).unwrap_or_else(|error| panic!("{table}: {error}"));
            let said = opened["fit"]["notes"].to_string();
            assert!(notes.iter().all(|note| said.contains(note)), "{table}: {said}");
        }
        let error = dropped("contact", &[], "t [s],T [degC]\n0,1\n1e-3,2\n").expect_err("no temperature");
        assert!(error.contains("friction_n") && error.contains("`sim-host spectrum log.csv`"), "{error}");
    }
}
