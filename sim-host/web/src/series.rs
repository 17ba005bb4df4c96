//! A time series that the reader opens: a measured curve over a figure of the scene on the page.

use columns::heading::{Heading, factor};
use columns::{Column, Table};
use report::Figure;
use scene::Overlay;
use scene::figures::axis_units;
use scene::load::Loaded;
use scene::schema::unit_of;
use serde_json::{Value, json};

/// Largest number of points of a curve: more are not visible, and are in the way in the text.
const MAX_POINTS: usize = 2000;

/// The last run of the page.
pub(crate) struct Shown {
    /// Its scene.
    pub(crate) loaded: Loaded,
    /// Its figures.
    pub(crate) figures: Vec<Figure>,
}

/// Criterion for the curve that a column is drawn over.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Match {
    /// The heading is the name of the curve.
    Name,
    /// The unit is convertible to that of the curve; the first curve of the figures counts.
    Unit,
}

impl Shown {
    /// Returns the scene with each column of a table over the first curve that matches, and a note
    /// for each; `None` if no column matches any.
    pub(crate) fn with_series(&self, name: &str, table: &Table, by: Match) -> Option<Value> {
        let headings = table.headings();
        let time = headings.iter().position(|heading| Heading::new(heading, |_| false).is_time())?;
        let drawn = |place: usize| {
            let points = [time, place].map(|place| &table.columns[place]);
            self.over(name, points, [&headings[time], &headings[place]], by)
        };
        let (tables, notes): (Vec<_>, Vec<_>) = (0..headings.len()).filter(|&place| place != time).filter_map(drawn).unzip();
        if tables.is_empty() {
            return None;
        }
        let Loaded { name: own, origin, input, sets, .. } = &self.loaded;
        let text = if scene::builtin::text(origin).is_some() { format!("base = \"{own}\"\n") } else { input.clone() };
        let title = format!("{name} over the scene {own}");
        Some(json!({
            "text": format!("{}\n{}", text.trim_end(), tables.concat()),
            "sets": sets,
            "fit": { "title": title, "tables": [], "notes": notes, "why": null, "is_friction": false },
        }))
    }

    /// Returns the names of the curves over time of the last run.
    pub(crate) fn curves(&self) -> Vec<&str> {
        let mut names: Vec<&str> = self.over_time("s").flat_map(curves).map(|(_, curve)| curve).collect();
        names.sort_unstable();
        names.dedup();
        names
    }

    /// Returns the figures over a time that this unit converts to.
    fn over_time(&self, unit: &str) -> impl Iterator<Item = &Figure> {
        let is_time = |figure: &&Figure| axis_units(&figure.x.label).iter().any(|axis| factor(Some(unit), *axis).is_some());
        self.figures.iter().filter(|figure| figure.map.is_none()).filter(is_time)
    }

    /// Returns the `[[overlay]]` of a column, and a note.
    fn over(&self, file: &str, points: [&Column; 2], [axis, own]: [&str; 2], by: Match) -> Option<(String, String)> {
        let [axis, heading] = [axis, own].map(|text| Heading::new(text, |_| false));
        let every = points[0].values.len().div_ceil(MAX_POINTS).max(1);
        let rows = points[0].values.iter().zip(&points[1].values).step_by(every);
        let (x, values): (Vec<f64>, Vec<f64>) = rows.filter(|(x, y)| x.is_finite() && y.is_finite()).unzip();
        let sign = if heading.negative { -1.0 } else { 1.0 };
        let time = axis.unit.unwrap_or("s");
        self.over_time(time).flat_map(curves).find_map(|(id, quantity)| {
            let of_curve = unit_of(quantity);
            let factor = match by {
                Match::Name => (own == quantity).then_some(1.0)?,
                Match::Unit => factor(Some(heading.unit?), Some(of_curve.as_deref()?))?,
            };
            let overlay = Overlay {
                quantity: quantity.to_owned(),
                figure: Some(id.to_owned()),
                name: Some(format!("{file}: {own}")),
                x_unit: Some(time.to_owned()),
                x: x.clone().into(),
                values: values.iter().map(|value| sign * factor * value).collect(),
                ..Overlay::default()
            };
            let thinned = if every > 1 { format!("; one point of {every} is shown") } else { String::new() };
            let note = format!("note: `{own}` is drawn over `{quantity}` of the figure `{id}`{thinned}");
            Some((table(&overlay), note))
        })
    }
}

/// Returns the curves of a figure, each with the name of the figure.
fn curves(figure: &Figure) -> impl Iterator<Item = (&str, &str)> {
    figure.series.iter().map(|series| (figure.id.as_str(), series.csv_column.as_str()))
}

/// Returns the table of a scene.
fn table(overlay: &Overlay) -> String {
    let text = |text: &Option<String>| json!(text.as_deref().unwrap_or_default()).to_string();
    let list = |numbers: &[f64]| numbers.iter().map(|number| format!("{number:e}")).collect::<Vec<_>>().join(", ");
    let Overlay { quantity, figure, name, x_unit, x, values, .. } = overlay;
    format!(
        "\n[[overlay]]\nname = {}\nquantity = \"{quantity}\"\nfigure = {}\nx_unit = {}\nx = [{}]\nvalues = [{}]\n",
        text(name),
        text(figure),
        text(x_unit),
        list(x),
        list(values)
    )
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
        let opened = file.read(table.as_bytes().to_vec(), session.shown().as_ref())?;
        assert!(opened["text"].is_string(), "{opened}");
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
                "`w [mm/s]` is drawn over",
            ),
            ("contact", &[], "t [us],F [mN]\n3320,1\n3325,2\n3330,3\n", "overlay_rms_n", "`F [mN]` is drawn over"),
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
        assert!(opened["fit"]["notes"][0].as_str().is_some_and(|said| said.ends_with("one point of 3 is shown")), "{opened}");
        let error = dropped("contact", &[], "t [s],T [degC]\n0,1\n1e-3,2\n").expect_err("no temperature");
        assert!(error.contains("friction_n") && error.contains("`sim-host spectrum log.csv`"), "{error}");
    }
}
