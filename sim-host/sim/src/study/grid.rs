//! Grid of a scene: a small sweep, held in memory, that is run in addition to the scene itself.

use std::sync::atomic::AtomicBool;

use super::StudyError;
use super::sweep::design::Design;
use super::sweep::{Rows, Sweep, SweepError};
use scene::Grid;
use scene::load::Loaded;

/// Metrics over the values of some keys.
#[derive(Clone, Debug, PartialEq)]
pub struct GridResult {
    /// Grid as defined in the scene.
    pub grid: Grid,
    /// Points of the grid.
    pub design: Design,
    /// Requested metrics; if none were named, those that a point has.
    pub metrics: Vec<String>,
    /// Values and metrics of each point, or the reason that it has none.
    pub rows: Rows,
}

/// Runs every point of a grid of a scene, in parallel; `None` if it is stopped. The grid need not
/// be the scene's own, and may have any size.
///
/// # Errors
/// If the common part of all points is not a valid scene, if a key or metric is unknown, or if
/// neither the first nor the last point is a valid scene.
pub fn run(loaded: &Loaded, grid: &Grid, stop: &AtomicBool) -> Result<Option<GridResult>, StudyError> {
    let changed = loaded.changed(&grid.set).map_err(|error| StudyError::Grid(SweepError::Scene(error)))?;
    let design = Design::product(grid.over.iter().map(Into::into).collect()).map_err(StudyError::Grid)?;
    let sweep = Sweep::new(&changed, design, &grid.metrics).map_err(StudyError::Grid)?;
    let Some(mut rows) = sweep.rows(0..sweep.design.count(), stop, &|| ())? else { return Ok(None) };
    let has = |place: &usize| !sweep.all || rows.metrics[*place].iter().any(Option::is_some);
    let present: Vec<usize> = (0..sweep.metrics.len()).filter(has).collect();
    rows.metrics = present.iter().map(|&place| std::mem::take(&mut rows.metrics[place])).collect();
    let metrics = present.into_iter().map(|place| sweep.metrics[place].to_owned()).collect();
    Ok(Some(GridResult { grid: grid.clone(), design: sweep.design, metrics, rows }))
}

impl GridResult {
    /// Returns the paths of the keys that change.
    pub fn keys(&self) -> Vec<String> {
        self.grid.over.iter().map(|over| over.key.clone()).collect()
    }

    /// Returns the values of a key or a metric at all points, NaN if a point has none; `None` if
    /// the grid does not have it.
    pub fn column(&self, name: &str) -> Option<Vec<f64>> {
        if let Some(place) = self.grid.over.iter().position(|over| over.key == name) {
            return Some(self.rows.keys[place].clone());
        }
        let place = self.metrics.iter().position(|metric| metric == name)?;
        Some(self.rows.metrics[place].iter().map(|value| value.unwrap_or(f64::NAN)).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use scene::Over;
    use scene::load::load;

    fn loaded(scene: &str, sets: &[&str]) -> Loaded {
        let sets: Vec<String> = sets.iter().map(|&set| set.to_owned()).collect();
        load(scene, &sets).unwrap_or_else(|error| panic!("{error}"))
    }

    fn over(key: &str, values: &[f64]) -> Over {
        Over { key: key.to_owned(), values: values.to_vec(), from: None, to: None, points: None, log: false }
    }

    fn grid(metrics: &[&str], over: Vec<Over>, set: &[&str]) -> Grid {
        let owned = |texts: &[&str]| texts.iter().map(|&text| text.to_owned()).collect();
        Grid { title: String::new(), metrics: owned(metrics), contours: Vec::new(), over, set: owned(set) }
    }

    fn result(loaded: &Loaded, grid: &Grid) -> GridResult {
        run(loaded, grid, &AtomicBool::new(false)).expect("a result").expect("not stopped")
    }

    /// Computes the metrics of each point as a separate scene, requesting only these metrics.
    fn one_by_one(loaded: &Loaded, grid: &Grid, result: &GridResult) -> Vec<Vec<Option<f64>>> {
        let names: Vec<&str> = result.metrics.iter().map(String::as_str).collect();
        let point = |point: u64| {
            let keys = result.keys().into_iter().zip(result.design.values(point));
            let sets = keys.map(|(key, value)| format!("{key}={value:?}"));
            let cell = loaded.cell(&grid.set.iter().cloned().chain(sets).collect::<Vec<_>>()).expect("a scene");
            let scene = cell.scene.excited().expect("a contact study");
            let metrics = crate::study::contact::cell(&scene, Some(&names), &AtomicBool::new(false)).expect("an answer");
            names.iter().map(|name| metrics.find(name)).collect::<Vec<_>>()
        };
        let rows: Vec<_> = (0..result.design.count()).map(point).collect();
        (0..names.len()).map(|metric| rows.iter().map(|row| row[metric]).collect()).collect()
    }

    /// Tests closed forms with and without reversals and for Coulomb friction, and waveforms and
    /// methods without a closed form.
    #[test]
    fn points_of_given_vibrations_equal_separate_runs() {
        let speeds = [0.001, 0.01, 0.02, 0.03, 0.04, 0.053, 0.06];
        let means = ["friction_ratio", "reduction_percent", "friction_on_n", "power_ratio"];
        for (law, metrics, sets) in [
            ("dahl", &means[..], &[][..]),
            (
                "coulomb",
                &means,
                &["contact.coulomb.mu=0.1", "contact.coulomb.normal_n=0.2", "grid.over.0.key=contact.coulomb.mu"],
            ),
            ("dahl", &means[..1], &["excitation.waveform=square"]),
            ("dahl", &means[..1], &["integrator.method=linexp"]),
            ("dahl", &["input_ratio", "friction_ratio"], &[]),
        ] {
            let loaded = loaded("contact-kinematic", sets);
            let axes = vec![over(&format!("contact.{law}.mu"), &[0.01, 0.1, 0.5]), over("excitation.sliding_m_per_s", &speeds)];
            let asked = grid(metrics, axes, &["integrator.window_periods=[100, 200]"]);
            let result = result(&loaded, &asked);
            assert!(result.rows.metrics.iter().flatten().all(Option::is_some), "{law}, {sets:?}");
            assert_eq!(result.rows.metrics, one_by_one(&loaded, &asked, &result), "{law}, {sets:?}");
        }
    }

    /// At a thousand points of a map of contacts with a mass, batched solutions equal separate runs
    /// bit for bit. Points that the rules treat separately (a velocity ratio of zero) are among
    /// them.
    #[test]
    fn map_of_contacts_equals_separate_runs() {
        let loaded = loaded("contact", &["integrator.tolerance=1e-6"]);
        let ratios: Vec<f64> = (0..40).map(|column| 0.03 * f64::from(column)).collect();
        let stiffness = over("contact.dahl.stiffness_n_per_m", &[]);
        let range = |points| Over { from: Some(1e4), to: Some(1e7), points: Some(points), log: true, ..stiffness.clone() };
        let set = ["integrator.window_periods=[40, 80]", "duration_s=0.001334"];
        for (metrics, points) in [
            (&["friction_ratio"][..], 25),
            (&["power_ratio", "kappa", "error_estimate"], 2),
            (&["input_ratio", "peak_velocity_m_per_s"], 2),
        ] {
            let asked = grid(metrics, vec![range(points), over("excitation.velocity_ratio", &ratios)], &set);
            let result = result(&loaded, &asked);
            assert_eq!(result.rows.metrics, one_by_one(&loaded, &asked, &result), "{metrics:?}");
        }
    }

    /// An invalid point of a grid with three keys and all metrics states its reason, and a stopped
    /// grid has no result.
    #[test]
    fn invalid_points_have_reasons_and_a_stop_ends_the_grid() {
        let loaded = loaded("contact", &[]);
        let axes = [
            over("contact.dahl.mu", &[0.1, 0.0]),
            over("excitation.velocity_ratio", &[0.3, 0.5]),
            over("rig.sdof.mass_kg", &[1e-3, 2e-3]),
        ];
        let asked = grid(&[], axes.to_vec(), &[]);
        let result = result(&loaded, &asked);
        assert!(result.metrics.iter().any(|name| name == "friction_ratio") && result.metrics.len() > 8, "{:?}", result.metrics);
        assert!(result.rows.failures[..4].iter().all(Option::is_none));
        assert!(result.rows.failures[4..].iter().all(|why| why.as_ref().is_some_and(|why| why.contains("friction"))));
        assert_eq!(result.column("contact.dahl.mu").map(|column| column[3..5].to_vec()), Some(vec![0.1, 0.0]));
        assert!(run(&loaded, &asked, &AtomicBool::new(true)).expect("no error").is_none());
    }

    /// Each point of a scene of several runs has the statistics of its runs.
    #[test]
    fn a_point_of_several_runs_has_their_statistics() {
        let loaded = loaded("lock-cold", &["runs=3"]);
        let asked = grid(&["lock_time_20hz_ms_max", "runs_locked"], vec![over("controller.drive.amplitude_v", &[3.0, 4.0])], &[]);
        let result = result(&loaded, &asked);
        let alone = loaded.changed(&["controller.drive.amplitude_v=4".to_owned()]).expect("a scene");
        let (_, metrics) = super::super::monte_carlo::run(&alone, Default::default(), &AtomicBool::new(false)).expect("runs");
        let last = |metric: usize| result.rows.metrics[metric][1];
        assert!(last(0).is_some() && last(0) == metrics.find("lock_time_20hz_ms_max"));
        assert_eq!((last(1), metrics.find("runs_locked")), (Some(3.0), Some(3.0)));
    }
}
