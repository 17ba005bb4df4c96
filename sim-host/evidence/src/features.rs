//! Features of the controller, and the scenes that ran each of them at each level.
//!
//! | level | the controller runs | scenes |
//! |---|---|---|
//! | SIL | in the simulator | all built-in ones, and the cases of their comparisons |
//! | PIL | as thumb code in QEMU | all built-in ones, without comparisons |
//! | flashed image | as the flashed image on the model of its part | those of [`board_scenes`](crate::board_scenes) |
//! | HIL | on the board | none |
//!
//! The settings of a scene determine its features.

use firmware::seam::block::Amplitude;
use firmware::seam::config::{Around, Config, Edge, Prefer, Schedule, ShapeKind, Sweep, TrackingMode};
use report::TableBlock;
use scene::load::{LoadError, Loaded, load};
use scene::{Driven, builtin};

use crate::board_scenes::{self, CASES};
use crate::campaign;
use crate::evidence::{Error, Evidence, Options};

/// A feature: its name, and a function that returns `true` if a scene has it.
type Feature = (&'static str, fn(&Driven, &Config) -> bool);

const FEATURES: &[Feature] = &[
    ("observer", |_, config| config.tracking.mode == TrackingMode::Observer),
    ("scan and phase lock", |_, config| config.tracking.mode == TrackingMode::PhaseLock),
    ("drive at a fixed frequency", |_, config| config.tracking.mode == TrackingMode::Off),
    ("drift of the clamped capacitance", |_, config| config.tracking.c0_drift_per_s > 0.0),
    ("tip velocity held (motional current)", |_, config| matches!(config.drive.amplitude, Amplitude::MotionalCurrent(_))),
    ("bursts by windows", |_, config| matches!(config.burst.schedule, Schedule::Windows(_))),
    ("bursts by period and duty", |_, config| matches!(config.burst.schedule, Schedule::Periodic { .. })),
    ("soft edges", |_, config| config.burst.edge == Edge::Soft),
    ("boosted edges", |_, config| config.burst.edge == Edge::Boost),
    ("square", |_, config| config.drive.shape == ShapeKind::Square),
    ("sawtooth", |_, config| config.drive.shape == ShapeKind::Sawtooth),
    ("noise", |_, config| config.drive.shape == ShapeKind::Noise),
    ("dither", |_, config| config.drive.dither),
    ("chirp between two frequencies", |_, config| sweeps(config) == Some(Around::Zero)),
    ("chirp about the resonance", |_, config| sweeps(config) == Some(Around::Resonance)),
    ("four lanes", |_, config| config.lanes == 4),
    ("calibration of lanes", |scene, _| scene.controller.phasing.calibrate),
    ("friction switch, by amplitude", |_, config| config.friction.as_ref().is_some_and(|of| of.prefer == Prefer::Amplitude)),
    ("friction switch, by bursts", |_, config| config.friction.as_ref().is_some_and(|of| of.prefer == Prefer::Bursts)),
    ("belt encoder and weld interlock", |_, config| config.front_end.metre_per_count.is_some()),
    ("energy for each metre of belt", |_, config| config.limits.energy_j_per_m.is_some()),
    ("force channel", |_, config| config.front_end.force_hz.is_some()),
    ("restraint at a D-ring", |_, config| config.restraint.is_some()),
];

fn sweeps(config: &Config) -> Option<Around> {
    if let Sweep::Chirp(chirp) = &config.sweep { Some(chirp.around) } else { None }
}

/// Returns for each feature whether a scene has it.
fn features_of(loaded: &Loaded) -> Vec<bool> {
    loaded.scene.driven().map_or_else(Vec::new, |scene| {
        let config = scene::settings::config(&scene);
        FEATURES.iter().map(|(_, has)| has(&scene, &config)).collect()
    })
}

/// A run at one level: its name, and for each feature `true` if the run has it.
struct RunFeatures(String, Vec<bool>);

/// Loads every built-in scene that has a controller.
fn scenes() -> Result<Vec<Loaded>, LoadError> {
    let loaded = builtin::all().iter().map(|(name, _)| load(name, &[]));
    Ok(loaded.collect::<Result<Vec<_>, _>>()?.into_iter().filter(|loaded| loaded.scene.driven().is_some()).collect())
}

/// Returns the cases of the comparison of a scene.
fn cases(loaded: &Loaded) -> Result<Vec<RunFeatures>, LoadError> {
    let cases = loaded.scene.comparison.iter().flat_map(|comparison| &comparison.case);
    cases.map(|case| Ok(RunFeatures(format!("{}: {}", loaded.name, case.name), features_of(&loaded.cell(&case.set)?)))).collect()
}

/// Formats the first run that has a feature, and the number of others.
fn cell(ran: &[RunFeatures], feature: usize) -> String {
    let with: Vec<&str> = ran
        .iter()
        .filter(|RunFeatures(_, has)| has.get(feature) == Some(&true))
        .map(|RunFeatures(name, _)| name.as_str())
        .collect();
    match with.as_slice() {
        [] => "none".to_owned(),
        [only] => format!("`{only}`"),
        [first, rest @ ..] => format!("`{first}` and {} more", rest.len()),
    }
}

/// Returns the table of features.
pub fn evidence(_: &mut Options) -> Result<Evidence, Error> {
    let scenes = scenes()?;
    let pil: Vec<RunFeatures> = scenes.iter().map(|loaded| RunFeatures(loaded.name.clone(), features_of(loaded))).collect();
    let cases = scenes.iter().map(cases).collect::<Result<Vec<_>, _>>()?;
    let sil: Vec<RunFeatures> = pil
        .iter()
        .map(|RunFeatures(name, has)| RunFeatures(name.clone(), has.clone()))
        .chain(cases.into_iter().flatten())
        .collect();
    let of_board = CASES.iter().map(|case| Ok(RunFeatures(case.name(), features_of(&board_scenes::loaded(case)?))));
    let board = of_board.collect::<Result<Vec<_>, LoadError>>()?;
    let row = |(place, (name, _)): (usize, &Feature)| {
        vec![(*name).to_owned(), cell(&sil, place), cell(&pil, place), cell(&board, place), "none".to_owned()]
    };
    let caption = "Scenes by which each feature was run. SIL: the controller in the simulator; `scene: case` is a case of its \
                   comparison. PIL: its thumb code in QEMU, codes compared with the host's. Flashed image: the image of the \
                   driver board on the model of its part, replayed bit for bit. HIL: the board.";
    let header = ["feature", "SIL", "PIL", "flashed image on the model", "HIL"];
    let rows = FEATURES.iter().enumerate().map(row).collect();
    let table = TableBlock::new("features", "Features by level", caption, &header, rows);
    Ok(campaign::evidence("Features by level", "", vec![table], Vec::new(), Vec::new()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_other_feature_has_a_scene() {
        let scenes = scenes().unwrap();
        let mut ran: Vec<RunFeatures> =
            scenes.iter().map(|loaded| RunFeatures(loaded.name.clone(), features_of(loaded))).collect();
        ran.extend(scenes.iter().flat_map(|loaded| cases(loaded).unwrap()));
        let without: Vec<&str> =
            FEATURES.iter().enumerate().filter(|(place, _)| cell(&ran, *place) == "none").map(|(_, (name, _))| *name).collect();
        // Other tests run these: docs/evidence/features.md names them.
        assert_eq!(without, ["soft edges"]);
    }

    #[test]
    fn features_of_a_scene_follow_from_its_settings() {
        let has = |name: &str| {
            let all = features_of(&load(name, &[]).unwrap());
            FEATURES.iter().zip(all).filter(|(_, has)| *has).map(|((name, _), _)| *name).collect::<Vec<_>>()
        };
        assert!(has("dring-crash").contains(&"restraint at a D-ring") && has("usm").contains(&"four lanes"));
        assert!(!has("lock").contains(&"belt encoder and weld interlock"));
    }
}
