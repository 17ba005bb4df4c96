//! A unit gives the results of the run, and refuses wrong steps and values.

use super::variables::reference;
use super::*;
use crate::run::{Watch, run};
use scene::load::{Loaded, load};

fn loaded(name: &str, changes: &[&str]) -> Loaded {
    let changes: Vec<String> = changes.iter().map(|&change| change.to_owned()).collect();
    load(name, &changes).unwrap_or_else(|error| panic!("{error}"))
}

fn instance(loaded: &Loaded, kind: Kind) -> Instance {
    let text = scene_text(loaded);
    Instance::new(&text, &token(&text, kind)).unwrap_or_else(|error| panic!("{error}"))
}

fn float(instance: &Instance, reference: u32) -> f64 {
    match instance.get(reference) {
        Some(Value::Float(value)) => *value,
        other => panic!("{reference}: {other:?}"),
    }
}

#[test]
fn a_board_has_hash_and_friction_of_the_run() {
    let bursts = ["controller.burst.on_s=[0.1]", "controller.burst.off_s=[0.2]", "duration_s=0.32"];
    for (name, changes) in [("experiment-1", &bursts[..]), ("friction-ratio", &[]), ("lock", &[])] {
        let loaded = loaded(name, changes);
        let record = run(&loaded.scene.driven().unwrap(), Watch::default()).unwrap();
        let mut board = instance(&loaded, Kind::Board);
        let mut sum = 0.0;
        let steps = (1e3 * loaded.scene.duration_s).round() as u32;
        for step in 0..steps {
            board.step(1e-3 * f64::from(step), 1e-3).unwrap();
            // A stack without a contact has none.
            sum += board.get(reference::FRICTION).map_or(0.0, |_| float(&board, reference::FRICTION));
        }
        assert_eq!(board.get(reference::HASH), Some(&Value::Unsigned(record.drive_hash)), "{name}");
        let truths: Vec<f64> = record.rows.iter().map(|row| row.truth.friction_mean_n).collect();
        let mean = truths.iter().sum::<f64>() / truths.len() as f64;
        // Steps have 31 or 32 blocks.
        let of_steps = sum / f64::from(steps);
        assert!((of_steps - mean).abs() <= 1e-3 * mean.abs(), "{name}: {of_steps} {mean}");
    }
}

#[test]
fn inputs_act() {
    let loaded = loaded("experiment-1", &["controller.burst.off_s=[9]", "duration_s=10", "controller.drive.amplitude_v=5"]);
    let mut board = instance(&loaded, Kind::Board);
    let mut time_s = 0.0;
    let mut run = |board: &mut Instance, steps: u32| {
        for _ in 0..steps {
            board.step(time_s, 1e-3).unwrap();
            time_s += 1e-3;
        }
        (float(board, reference::FRICTION), float(board, reference::TIP_VELOCITY))
    };
    let (off, still) = run(&mut board, 100);
    board.set(reference::GATE, Value::Integer(1)).unwrap();
    let (on, tip) = run(&mut board, 300);
    assert!(on < 0.7 * off && tip > 10.0 * still, "{off} {on} {still} {tip}");
    board.set(reference::AMPLITUDE, Value::Float(2.5)).unwrap();
    let (_, half) = run(&mut board, 300);
    assert!((half / tip - 0.5).abs() < 0.1, "{tip} {half}");
    board.set(reference::AMPLITUDE, Value::Float(-1.0)).unwrap();
    let (_, again) = run(&mut board, 300);
    assert!((again / tip - 1.0).abs() < 0.05, "{tip} {again}");
    board.set(reference::GATE, Value::Integer(2)).unwrap();
    board.set(reference::LOAD, Value::Float(10.0)).unwrap();
    let (loaded_n, _) = run(&mut board, 300);
    assert!(loaded_n > 1.5 * off, "{off} {loaded_n}");
    board.reset().unwrap();
    assert_eq!(float(&board, reference::FRICTION), 0.0);
}

/// A friction target acts also if the scene's own steps have changed it, and after an amplitude.
#[test]
fn a_friction_target_replaces_the_scene() {
    let loaded = loaded("friction-ratio", &[]);
    let mut board = instance(&loaded, Kind::Board);
    let mut time_s = 0.0;
    let mut run = |board: &mut Instance, until_s: f64| {
        while time_s < until_s - 1e-6 {
            board.step(time_s, 1e-3).unwrap();
            time_s += 1e-3;
        }
        float(board, reference::FRICTION)
    };
    run(&mut board, 0.9);
    board.set(reference::FRICTION_TARGET, Value::Float(0.8)).unwrap();
    let high_n = run(&mut board, 1.2);
    board.set(reference::AMPLITUDE, Value::Float(4.0)).unwrap();
    let driven_n = run(&mut board, 1.3);
    board.set(reference::AMPLITUDE, Value::Float(-1.0)).unwrap();
    let again_n = run(&mut board, 1.6);
    assert!(driven_n < 0.6 * high_n && (again_n / high_n - 1.0).abs() < 0.15, "{high_n} {driven_n} {again_n}");
}

/// The codes of a board's controller, which gets the same codes, are those of the controller alone.
#[test]
fn a_controller_answers_codes() {
    let loaded = loaded("lock", &[]);
    let scene = loaded.scene.driven().unwrap();
    let mut controller = instance(&loaded, Kind::Controller);
    let mut other = crate::stepping::Stepping::new(&scene).unwrap();
    let mut drive = other.silence();
    let step_s = Kind::Controller.step_s(&scene);
    for block in 0..200u16 {
        let codes: Vec<u16> = (0..scene.controller.block_samples).map(|sample| 2048 + (block + sample) % 5).collect();
        controller.set(reference::V, Value::Codes(codes.clone())).unwrap();
        controller.set(reference::I, Value::Codes(codes.clone())).unwrap();
        controller.step(f64::from(block) * step_s, step_s).unwrap();
        let codes = codes.iter().copied().collect::<firmware::seam::block::Codes>();
        let sense = firmware::seam::block::SenseBlock { v: codes.clone(), i: codes, ..Default::default() };
        other.process(&sense, &mut drive).unwrap();
        let played = drive.lanes.iter().flatten().copied().collect();
        assert_eq!(controller.get(reference::CODES), Some(&Value::Codes(played)));
    }
}

#[test]
fn mistakes_are_named() {
    let loaded = loaded("experiment-1", &[]);
    let mut board = instance(&loaded, Kind::Board);
    let says = |result: Result<(), StepError>, words: &str| {
        let error = result.unwrap_err().to_string();
        assert!(error.contains(words), "{error}");
    };
    says(board.step(0.0, 2e-3), "a fixed step of 0.001 s");
    says(board.step(0.0, f64::NAN), "a fixed step of 0.001 s");
    says(board.set(99, Value::Float(1.0)), "no variable 99");
    says(board.step(1e-3, 1e-3), "the last one ended at 0 s");
    says(board.step(f64::INFINITY, 1e-3), "the last one ended at 0 s");
    says(board.set(reference::GATE, Value::Float(1.0)), "no variable 1 of this type");
    says(board.set(reference::GATE, Value::Integer(3)), "`gate` cannot be 3");
    says(board.set(reference::LOAD, Value::Float(1e300)), "`load_n` cannot be");
    says(board.set(reference::FRICTION, Value::Float(1.0)), "`friction_n` is not an input");
    says(board.set(reference::LOAD, Value::Float(f64::NAN)), "`load_n` cannot be NaN");
    says(board.set(reference::LOAD, Value::Float(-1.0)), "`load_n` cannot be -1");
    board.set(reference::AMPLITUDE, Value::Float(1.0)).unwrap();
    let mut controller = instance(&loaded, Kind::Controller);
    says(controller.set(reference::V, Value::Codes(vec![0])), "`v_code` has");
    let text = scene_text(&loaded);
    says(Instance::new(&text, "0").map(|_| ()), "export the unit again");
    says(Instance::new(&format!("{text}\n"), &token(&text, Kind::Board)).map(|_| ()), "export the unit again");
}

/// Every variable is described once, with its reference; special letters of a title are escaped.
#[test]
fn the_description_lists_all_variables() {
    for kind in Kind::ALL {
        let loaded = loaded("friction-ratio", &["title=\"a < b & \\\"c\\\"\""]);
        let xml = description(&loaded, kind).unwrap();
        for variable in variables(&loaded.scene.driven().unwrap(), kind) {
            let place = format!(r#"name="{}" valueReference="{}""#, variable.name, variable.reference);
            assert_eq!(xml.matches(&place).count(), 1, "{place}\n{xml}");
        }
        assert!(xml.contains("a &lt; b &amp; &quot;c&quot;"), "{xml}");
    }
    assert_eq!(description(&loaded("contact", &[]), Kind::Board), None);
}
