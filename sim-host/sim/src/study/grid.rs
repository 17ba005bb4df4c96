//! A grid: one metric over two keys.

use std::sync::atomic::{AtomicBool, Ordering};

use rayon::prelude::*;

use super::abreast::{self, Mean, Steady};
use super::{StudyError, cell};
use scene::load::Loaded;
use scene::{Grid, Scene};

/// A metric over two keys.
#[derive(Clone, Debug, PartialEq)]
pub struct GridResult {
    /// The grid asked for.
    pub grid: Grid,
    /// For each row, the metric in each column.
    pub cells: Vec<Vec<Option<f64>>>,
}

/// A cell before it is run.
struct Cell {
    place: String,
    scene: Scene,
    /// Its steady state, if that alone gives the metric.
    steady: Option<Steady>,
}

/// Runs every cell of a grid, in parallel; nothing if it is stopped.
pub(super) fn conduct(loaded: &Loaded, grid: &Grid, stop: &AtomicBool) -> Result<Option<GridResult>, StudyError> {
    let cells = cells(loaded, grid)?;
    let mean = Mean::named(&grid.metric);
    let studies: Vec<Steady> = cells.iter().filter_map(|cell| cell.steady).collect();
    let mut means = mean.map_or_else(Vec::new, |mean| mean.of(&studies)).into_iter();
    let stepped = |cell: &Cell| match cell.steady {
        Some(_) => Ok(None),
        None => Ok(cell::run(&cell.scene, &cell.place, stop)?.find(&grid.metric)),
    };
    let mut values = cells.par_iter().map(stepped).collect::<Result<Vec<_>, StudyError>>()?;
    for (value, _) in values.iter_mut().zip(&cells).filter(|(_, cell)| cell.steady.is_some()) {
        *value = means.next().flatten();
    }
    let cells = values.chunks(grid.columns.len()).map(<[_]>::to_vec).collect();
    Ok((!stop.load(Ordering::Relaxed)).then(|| GridResult { grid: grid.clone(), cells }))
}

/// The scenes of all cells, row by row.
fn cells(loaded: &Loaded, grid: &Grid) -> Result<Vec<Cell>, StudyError> {
    let by_means = Mean::named(&grid.metric).is_some();
    let template = loaded.template().map_err(|error| StudyError::Cell("every cell".to_owned(), error))?;
    let places: Vec<(f64, f64)> =
        grid.rows.iter().flat_map(|&row| grid.columns.iter().map(move |&column| (row, column))).collect();
    let cell = |&(row, column): &(f64, f64)| {
        let keys = [format!("{}={row}", grid.row_key), format!("{}={column}", grid.column_key)];
        let place = keys.join(", ");
        let scene = template.scene(&[grid.set.as_slice(), &keys].concat());
        let scene = scene.map_err(|error| StudyError::Cell(place.clone(), error))?;
        let steady = scene.excited().filter(|_| by_means).and_then(|scene| abreast::steady(&scene));
        Ok(Cell { place, scene, steady })
    };
    places.par_iter().map(cell).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use scene::load::load;

    fn grid(scene: &str, sets: &[&str], grid: &Grid) -> (Loaded, GridResult) {
        let sets: Vec<String> = sets.iter().map(|&set| set.to_owned()).collect();
        let loaded = load(scene, &sets).unwrap_or_else(|error| panic!("{error}"));
        let result = conduct(&loaded, grid, &AtomicBool::new(false)).expect("a result").expect("not stopped");
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
        let stop = AtomicBool::new(false);
        let run = |cell: &Cell| cell::run(&cell.scene, &cell.place, &stop).expect("a result").find(&grid.metric);
        cells(loaded, grid).expect("valid cells").iter().map(run).collect()
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
                assert!(cells(&loaded, &asked).expect("valid cells").iter().all(|cell| cell.steady.is_some()), "{law}");
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
            assert!(cells(&loaded, &asked).expect("valid cells").iter().all(|cell| cell.steady.is_none()), "{metric}, {set}");
            assert_eq!(result.cells.concat(), one_by_one(&loaded, &asked));
        }
    }

    /// A cell is the scene with its keys set, as if it were read anew.
    #[test]
    fn a_cell_is_a_scene_of_its_own() {
        for scene in ["contact-kinematic", "experiment-1", "experiment-2", "experiment-2-heavy", "usm-miscalibrated"] {
            let loaded = load(scene, &[]).expect("built in");
            let grid = loaded.scene.grid.as_ref().expect("a grid");
            for cell in cells(&loaded, grid).expect("valid cells") {
                let keys: Vec<String> = cell.place.split(", ").map(str::to_owned).collect();
                assert_eq!(cell.scene, loaded.cell(&[grid.set.as_slice(), &keys].concat()).expect("valid").scene, "{scene}");
            }
        }
    }
}
