//! Commissioning of the flashed image: from a band to tested settings. The settings are unchanged
//! at the end.

use firmware::seam::mode::Mode;
use link::script::Script;
use link::session::{Session, SessionOptions};
use plant::circuit_of;

use super::{connected, dummy_load, elf, powered};

const SCRIPT: &str = "settings get\ncommission --band 30k:45k --max-volts 3\nsettings get\n";

#[test]
fn commissioning_the_flashed_image_restores_its_settings() {
    let Some(elf) = elf() else { return };
    let (board, client) = connected(powered(elf, &[]));
    let mut session = Session::begin(client, SessionOptions::default()).expect("an answer");
    let mut found = Vec::new();
    let done = Script::parse("script", SCRIPT).expect("a script").run(&mut session, |_, done| {
        found.extend(done.as_ref().ok().map(|answer| answer.fields.clone()));
        Ok(())
    });
    done.unwrap_or_else(|error| panic!("{error}"));
    let of = |name: &str| found[1][name].as_f64().expect("a number");
    let true_hz = circuit_of(&dummy_load().scene.driven().expect("a driven scene")).series_resonance_hz();
    for name in ["series_resonance_hz", "locked_hz", "after_step_hz", "after_burst_hz"] {
        assert!((of(name) - true_hz).abs() < 3.0, "{name}: {} Hz instead of {true_hz} Hz", of(name));
    }
    // The number of stores is not compared.
    [0, 2].iter().for_each(|&n| assert!(found[n].remove("stores").is_some()));
    assert_eq!(found[0], found[2], "the settings must not change");
    assert_eq!(session.status().expect("a report").mode, Mode::Idle);
    println!("{:.3} s of the board's time", board.borrow().now().as_secs_f64());
}
