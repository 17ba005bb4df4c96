//! A grid: one metric over two keys.

use std::sync::atomic::AtomicBool;

use rayon::prelude::*;

use super::StudyError;
use super::plan::{Cell, Plan};
use super::points::{BESIDE, Measured, Points};
use scene::Grid;
use scene::load::Loaded;

/// A metric over two keys.
#[derive(Clone, Debug, PartialEq)]
pub struct GridResult {
    /// The grid asked for.
    pub grid: Grid,
    /// For each row, the metric in each column.
    pub cells: Vec<Vec<Option<f64>>>,
}

/// Runs every cell of a grid of a scene, in parallel; nothing if it is stopped. The grid need not be the scene's own, and may have any size.
///
/// # Errors
/// If a cell is no valid scene, or has no result.
pub fn run(loaded: &Loaded, grid: &Grid, stop: &AtomicBool) -> Result<Option<GridResult>, StudyError> {
    let plan = Plan::new(loaded, stop)?;
    let places = places(grid);
    let Some(&first) = places.first() else { return Ok(None) };
    // Cells that the firmware drives take long enough to be shared out one by one.
    let beside = if loaded.scene.controller.is_some() {
        1
    } else {
        places.len().div_ceil(4 * rayon::current_num_threads()).clamp(8, BESIDE)
    };
    let metric = [grid.metric.as_str()];
    let points = Points::new(&plan, cell(grid, first), &[&grid.row_key, &grid.column_key], &metric);
    let of = |places: &[(f64, f64)]| points.metrics(places, |&(row, column)| [row, column], |&place| cell(grid, place));
    let metrics: Vec<_> = places.par_chunks(beside).map(of).collect();
    let Some(metrics) = metrics.into_iter().collect::<Option<Vec<_>>>() else { return Ok(None) };
    let metric = |measured: Measured| measured.map(|metrics| metrics.into_iter().next().flatten());
    let metrics = metrics.into_iter().flatten().map(metric).collect::<Result<Vec<Option<f64>>, StudyError>>()?;
    if plan.is_stopped() {
        return Ok(None);
    }
    Ok(Some(GridResult { grid: grid.clone(), cells: metrics.chunks(grid.columns.len()).map(<[_]>::to_vec).collect() }))
}

/// Row and column of every cell, row by row.
fn places(grid: &Grid) -> Vec<(f64, f64)> {
    grid.rows.iter().flat_map(|&row| grid.columns.iter().map(move |&column| (row, column))).collect()
}

fn cell(grid: &Grid, (row, column): (f64, f64)) -> Cell {
    let keys = [format!("{}={row}", grid.row_key), format!("{}={column}", grid.column_key)];
    Cell { label: keys.join(", "), sets: [grid.set.as_slice(), &keys].concat() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::abreast::{self, Mean};
    use crate::study::plan::Made;
    use scene::load::load;

    fn grid(scene: &str, sets: &[&str], grid: &Grid) -> (Loaded, GridResult) {
        let sets: Vec<String> = sets.iter().map(|&set| set.to_owned()).collect();
        let loaded = load(scene, &sets).unwrap_or_else(|error| panic!("{error}"));
        let result = run(&loaded, grid, &AtomicBool::new(false)).expect("a result").expect("not stopped");
        (loaded, result)
    }

    fn over(metric: &str, (row_key, rows): (&str, &[f64]), (column_key, columns): (&str, &[f64])) -> Grid {
        Grid {
            title: String::new(),
            metric: metric.to_owned(),
            row_key: row_key.to_owned(),
            rows: rows.to_vec(),
            column_key: column_key.to_owned(),
            columns: columns.to_vec(),
            set: vec!["integrator.window_periods=[100, 200]".to_owned()],
        }
    }

    /// Each cell of a grid as a run of its own, without lanes.
    fn one_by_one(loaded: &Loaded, grid: &Grid) -> Vec<Option<f64>> {
        read(loaded, grid, |made| Ok(made.metrics()?.find(&grid.metric)))
    }

    fn read<T: Send>(loaded: &Loaded, grid: &Grid, of: impl Fn(&Made) -> Result<T, StudyError> + Sync) -> Vec<T> {
        let stop = AtomicBool::new(false);
        let plan = Plan::new(loaded, &stop).expect("a template");
        let read = plan.run(places(grid), |place| cell(grid, *place), |_, made| of(made)).expect("valid cells");
        read.into_iter().flatten().collect()
    }

    /// For each cell, whether its steady state alone gives the metric.
    fn steady(loaded: &Loaded, grid: &Grid) -> Vec<bool> {
        let is_mean = Mean::named(&grid.metric).is_some();
        read(loaded, grid, |made| Ok(is_mean && made.scene.excited().is_some_and(|scene| abreast::steady(&scene).is_some())))
    }

    /// Means in lanes are those of the scalar closed form: 5e-16 apart at most here, with and without reversals, and of Coulomb friction.
    #[test]
    fn lanes_agree_with_runs() {
        let speeds = ("excitation.sliding_m_per_s", &[0.001, 0.01, 0.02, 0.03, 0.04, 0.053, 0.06][..]);
        let mu = |law: &str| format!("contact.{law}.mu");
        let coulomb = ["contact.coulomb.mu=0.1", "contact.coulomb.normal_n=0.2", "grid.row_key=contact.coulomb.mu"];
        let mut worst = 0.0f64;
        for (law, sets) in [("dahl", &[][..]), ("coulomb", &coulomb)] {
            for metric in ["friction_ratio", "reduction_percent", "friction_on_n", "power_ratio"] {
                let asked = over(metric, (&mu(law), &[0.01, 0.1, 0.3, 0.5]), speeds);
                let (loaded, result) = grid("contact-kinematic", sets, &asked);
                assert!(steady(&loaded, &asked).into_iter().all(|steady| steady), "{law}");
                for (lane, alone) in result.cells.concat().into_iter().zip(one_by_one(&loaded, &asked)) {
                    let (lane, alone) = (lane.expect("a metric"), alone.expect("a metric"));
                    let off = (lane - alone).abs() / alone.abs().max(1.0);
                    assert!(off < 1e-13, "{law}, {metric}: {lane}, {alone}");
                    worst = worst.max(off);
                }
            }
        }
        println!("{worst:e}");
    }

    /// What has no steady sine, or is asked for something else, is run cell by cell.
    #[test]
    fn other_cells_are_run() {
        let few = ("excitation.velocity_ratio", &[0.3, 0.6][..]);
        for (metric, set) in [
            ("friction_ratio", "excitation.waveform=square"),
            ("friction_ratio", "integrator.method=linexp"),
            ("input_ratio", "excitation.waveform=sine"),
        ] {
            let asked = over(metric, ("contact.dahl.mu", &[0.1]), few);
            let (loaded, result) = grid("contact-kinematic", &[set], &asked);
            assert!(!steady(&loaded, &asked).into_iter().any(|steady| steady), "{metric}, {set}");
            assert_eq!(result.cells.concat(), one_by_one(&loaded, &asked));
        }
    }

    /// A thousand points of a map of contacts with a mass: what is solved abreast has the metric of a run of its own, bit for bit, as have the cells that
    /// the rules judge (a velocity ratio of zero) among them.
    #[test]
    fn a_map_of_contacts_is_its_runs() {
        let stiffness: Vec<f64> = (0..25).map(|row| 1e4 * 1e3f64.powf(f64::from(row) / 24.0)).collect();
        let ratios: Vec<f64> = (0..40).map(|column| 0.03 * f64::from(column)).collect();
        let mut asked =
            over("friction_ratio", ("contact.dahl.stiffness_n_per_m", &stiffness), ("excitation.velocity_ratio", &ratios));
        asked.set = vec!["integrator.window_periods=[40, 80]".to_owned(), "duration_s=0.001334".to_owned()];
        let (loaded, result) = grid("contact", &["integrator.tolerance=1e-6"], &asked);
        assert_eq!(result.cells.concat(), one_by_one_for(&loaded, &asked));
        for metric in ["power_ratio", "kappa", "error_estimate", "input_ratio", "peak_velocity_m_per_s"] {
            let asked = Grid { metric: metric.to_owned(), rows: stiffness[..2].to_vec(), ..asked.clone() };
            let result = run(&loaded, &asked, &AtomicBool::new(false)).expect("a result").expect("not stopped");
            assert_eq!(result.cells.concat(), one_by_one_for(&loaded, &asked), "{metric}");
        }
    }

    /// Each cell as a run of its own that is asked for the metric only.
    fn one_by_one_for(loaded: &Loaded, grid: &Grid) -> Vec<Option<f64>> {
        read(loaded, grid, |made| Ok(made.metrics_for(Some(&[&grid.metric]))?.find(&grid.metric)))
    }

    /// A cell without an answer is named, and a grid that is to end has no result.
    #[test]
    fn a_cell_that_is_wrong_is_named_and_a_stop_is_heeded() {
        let asked = over("friction_ratio", ("contact.dahl.mu", &[0.1, 0.0]), ("excitation.velocity_ratio", &[0.3, 0.5]));
        let loaded = load("contact", &[]).expect("built in");
        let error = run(&loaded, &asked, &AtomicBool::new(false)).expect_err("no friction");
        assert!(matches!(&error, StudyError::Cell(label, _) if label.starts_with("contact.dahl.mu=0,")), "{error}");
        let stopped = run(&loaded, &Grid { rows: vec![0.1], ..asked }, &AtomicBool::new(true));
        assert!(stopped.expect("no error").is_none());
    }

    /// A cell is the scene with its keys set, as if it were read from its file.
    #[test]
    fn a_cell_is_a_scene_of_its_own() {
        for scene in ["contact-kinematic", "experiment-1", "experiment-2", "experiment-2-heavy", "usm-miscalibrated"] {
            let loaded = load(scene, &[]).expect("built in");
            let grid = loaded.scene.grid.as_ref().expect("a grid");
            let made = read(&loaded, grid, |made| Ok(made.scene.clone()));
            for (made, place) in made.into_iter().zip(places(grid)) {
                assert_eq!(made, loaded.cell(&cell(grid, place).sets).expect("valid").scene, "{scene}");
            }
        }
    }
}
