//! Claims of 3.1 and 5 about the first experiment.

use super::{LOADS_N, SpeedRuns, labels, loads};
use crate::thesis::claim::{Check, Claim, number, series};
use crate::thesis::driven;
use crate::thesis::sweep::{falls, rises};
use contact::SolveError;

/// Largest distance from the thesis's 68 % that counts as "up to 68 %", percentage points.
const NEAR_POINTS: f64 = 2.0;
/// The thesis's largest reduction, % (5.1).
const STATED_PERCENT: f64 = 68.0;
/// Smallest decrease of the reduction from no load to 10 N that an experiment would show,
/// percentage points.
const MIN_CHANGE_POINTS: f64 = 1.0;

/// Shorter runs of the same scenes: friction settles within milliseconds.
const SHORT_RUN_SETTINGS: [&str; 3] = ["duration_s=0.7", "controller.burst.on_s=[0.4]", "controller.burst.off_s=[0.6]"];

/// Returns the reductions over load of a scene with changes, %.
pub(crate) fn reductions(scene: &str, more: &[&str]) -> Result<Vec<f64>, SolveError> {
    let all = |load: Vec<String>| [load, SHORT_RUN_SETTINGS.iter().chain(more).map(|&set| set.to_owned()).collect()].concat();
    let changes: Vec<Vec<String>> = loads().into_iter().map(all).collect();
    driven::each(scene, &changes)?.iter().map(|ran| ran.metric("reduction_percent")).collect()
}

/// Judges the claims from the runs at both speeds.
pub(super) fn judge(speeds: &[SpeedRuns]) -> Result<Vec<Claim>, SolveError> {
    let stiff = reductions("experiment-1", &["contact.dahl.stiffness_n_per_m=2e6"])?;
    let fitted = reductions("experiment-1-fitted", &[])?;
    let smooth = reductions("experiment-1", &["contact.dahl.mu=0.2"])?;
    Ok(vec![
        friction_over_load(speeds)?,
        lowers(speeds)?,
        speed(speeds)?,
        up_to(speeds, &smooth, &stiff, &fitted)?,
        load(speeds, &stiff, &fitted)?,
        cell(speeds)?,
    ])
}

fn friction_over_load(speeds: &[SpeedRuns]) -> Result<Claim, SolveError> {
    let check = |speed: &SpeedRuns| {
        let off: Vec<f64> = speed.ran.iter().map(|ran| ran.metric("friction_off_n")).collect::<Result<_, _>>()?;
        let condition = format!("{} m/s, OFF; model, nothing fitted", speed.sliding_m_per_s);
        Ok(Check::new(condition, rises(&off), series("friction [N]", &labels(), &off)))
    };
    Ok(Claim {
        id: "load-raises-friction",
        section: "3.1.5, Figs. 3.4a, 3.5a",
        says: "Without vibration friction rises with the load.",
        checks: speeds.iter().map(check).collect::<Result<_, SolveError>>()?,
    })
}

fn lowers(speeds: &[SpeedRuns]) -> Result<Claim, SolveError> {
    let check = |speed: &SpeedRuns| {
        let reductions = speed.reductions()?;
        let condition = format!("{} m/s, ON, every load; model, nothing fitted", speed.sliding_m_per_s);
        let holds = reductions.iter().all(|&reduction| reduction > MIN_CHANGE_POINTS);
        Ok(Check::new(condition, holds, series("reduction [%]", &labels(), &reductions)))
    };
    Ok(Claim {
        id: "vibration-lowers-friction",
        section: "3.1.5, Figs. 3.4b, 3.5b",
        says: "Vibration along the sliding lowers the friction force, at both speeds.",
        checks: speeds.iter().map(check).collect::<Result<_, SolveError>>()?,
    })
}

fn speed(speeds: &[SpeedRuns]) -> Result<Claim, SolveError> {
    let [slow, fast] = speeds else { return Err(SolveError::Unsuited { method: "a scene", reason: "two speeds".into() }) };
    let (slow, fast) = (slow.reductions()?, fast.reductions()?);
    let differences: Vec<f64> = slow.iter().zip(&fast).map(|(slow, fast)| slow - fast).collect();
    let holds = differences.iter().all(|&points| points > MIN_CHANGE_POINTS);
    let numbers = [
        vec![number("reduction at 0.038 m/s, no load [%]", slow[0]), number("at 0.068 m/s [%]", fast[0])],
        series("difference [points]", &labels(), &differences),
    ];
    Ok(Claim {
        id: "low-speed-reduces-more",
        section: "3.1.5, 5.1",
        says: "The reduction is greater at the lower speed.",
        checks: vec![Check::new("contact of Table 4.1; model, nothing fitted", holds, numbers.concat())],
    })
}

fn up_to(speeds: &[SpeedRuns], smooth: &[f64], stiff: &[f64], fitted: &[f64]) -> Result<Claim, SolveError> {
    let check = |condition: &str, percent: f64| {
        Check::new(condition, (percent - STATED_PERCENT).abs() <= NEAR_POINTS, vec![number("reduction, no load [%]", percent)])
    };
    let plain = speeds.first().map_or(Ok(Vec::new()), SpeedRuns::reductions)?;
    let first = |reductions: &[f64]| reductions.first().copied().unwrap_or(f64::NAN);
    Ok(Claim {
        id: "up-to-68-percent",
        section: "5.1, 5.2",
        says: "At loads up to 10 N friction falls by up to 68 % (within two points, at 0.038 m/s without load).",
        checks: vec![
            check("contact of Table 4.1, mu 0.3; model, nothing fitted", first(&plain)),
            check("contact of Table 4.1, mu 0.2; model, nothing fitted", first(smooth)),
            check("Kt 2e6 N/m instead of 0.056e6; model, nothing fitted", first(stiff)),
            check("Kt 2e6 N/m and half the tip velocity; FITTED (scene experiment-1-fitted)", first(fitted)),
        ],
    })
}

fn load(speeds: &[SpeedRuns], stiff: &[f64], fitted: &[f64]) -> Result<Claim, SolveError> {
    let check = |condition: &str, reductions: &[f64]| {
        let fall = reductions[0] - reductions[LOADS_N.len() - 1];
        let numbers = [series("reduction [%]", &labels(), reductions), vec![number("fall to 10 N [points]", fall)]].concat();
        Check::new(condition, fall > MIN_CHANGE_POINTS && falls(reductions), numbers)
    };
    let plain: Vec<Vec<f64>> = speeds.iter().map(SpeedRuns::reductions).collect::<Result<_, _>>()?;
    let mut checks: Vec<Check> = speeds
        .iter()
        .zip(&plain)
        .map(|(speed, reductions)| {
            check(&format!("contact of Table 4.1, {} m/s; model, nothing fitted", speed.sliding_m_per_s), reductions)
        })
        .collect();
    checks.push(check("Kt 2e6 N/m, 0.038 m/s; model, nothing fitted, but without the 68 %", stiff));
    checks.push(check("Kt 2e6 N/m and half the tip velocity, 0.038 m/s; FITTED (scene experiment-1-fitted)", fitted));
    Ok(Claim {
        id: "load-lowers-reduction",
        section: "3.1.1, 5.1",
        says: "A load lowers the reduction (by more than a point from no load to 10 N).",
        checks,
    })
}

/// Compares the steady reduction, which the cell shows, and the length of a block, which hides its
/// edge.
fn cell(speeds: &[SpeedRuns]) -> Result<Claim, SolveError> {
    let check = |speed: &SpeedRuns| {
        let Some(ran) = speed.ran.first() else {
            return Err(SolveError::Unsuited { method: "a scene", reason: "no run".into() });
        };
        let (truth, cell) = (ran.metric("reduction_percent")?, ran.metric("load_cell_reduction_percent")?);
        let numbers = vec![number("true reduction [%]", truth), number("by the load cell [%]", cell)];
        let condition = format!("{} m/s, no load, 80 Hz; model, nothing fitted", speed.sliding_m_per_s);
        Ok(Check::new(condition, (truth - cell).abs() < 0.1, numbers))
    };
    let mut checks: Vec<Check> = speeds.iter().map(check).collect::<Result<_, SolveError>>()?;
    // The analyser takes 2.56 samples a second per hertz of span.
    let (block, span_hz) = (256.0, 80.0);
    let block_s = block / (2.56 * span_hz);
    checks.push(Check::new(
        "one block of 256 at a span of 80 Hz, longer than the time to the end of the ON window of 2 s",
        block_s > 5.0,
        vec![number("length of a block [s]", block_s), number("end of the ON window [s]", 5.0)],
    ));
    Ok(Claim {
        id: "load-cell-shows-the-mean",
        section: "3.1.3",
        says: "The load cell measures the average friction force (within 0.1 points), in records of 256 samples at a span \
               of 80 Hz.",
        checks,
    })
}
