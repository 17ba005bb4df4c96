//! The targets over fewer runs, and the documentation.

use std::sync::atomic::AtomicBool;

use super::single::{Case, Group};
use super::{Extent, by_clock, many, mass};
use scene::load::load;

fn metric(case: &str, metric: &str) -> f64 {
    let case = Case::ALL.iter().find(|found| found.name == case).unwrap();
    case.run().unwrap().metrics.get(metric).unwrap()
}

/// What the firmware makes of it. It switches a little before 35 ms, which costs a millimetre more than the +57 mm of a clock at 35 ms.
#[test]
fn the_firmware_switches_for_the_light_occupant_alone() {
    let of = |name: &str| Case::ALL.iter().find(|found| found.name == name).unwrap().run().unwrap().metrics;
    let light = of("light");
    let get = |metric: &str| light.get(metric).unwrap();
    let (passive, passive_mm) = (get("passive_peak_shoulder_force_n"), 1e3 * get("passive_torso_excursion_m"));
    assert!((passive - 4825.2).abs() < 0.1 && (passive_mm - 108.7).abs() < 0.1, "{passive} N, {passive_mm} mm");
    assert!((get("shoulder_force_reduction_percent") - 35.92).abs() < 0.01, "{light:?}");
    let added = 1e3 * get("added_excursion_m");
    assert!((57.0..59.0).contains(&added) && (25.0..35.0).contains(&get("switch_time_ms")), "{light:?}");
    assert!(get("error_estimate") < 1e-6 && get("energy_residual").abs() < 1e-9, "{light:?}");
    let heavy = of("heavy");
    assert_eq!(
        ["switched", "shoulder_force_reduction_percent", "added_excursion_m"].map(|metric| heavy.get(metric)),
        [Some(0.0); 3]
    );
}

/// The tip of the stack is a fifteenth as fast as the webbing: nothing, to four digits.
#[test]
fn the_stack_has_no_authority_and_power_has() {
    let stack = metric("the 40 kHz stack", "shoulder_force_reduction_percent");
    assert!(stack.abs() < 0.01, "{stack} %");
    // Measured: 27.6 %.
    let power = metric("2.5 kW into the contact", "shoulder_force_reduction_percent");
    assert!(power >= 20.0 && (power - 27.6).abs() < 0.3, "{power} %");
}

#[test]
fn doubt_is_high() {
    for case in Case::ALL.iter().filter(|case| case.group == Group::Doubt) {
        let metrics = case.run().unwrap().metrics;
        assert_eq!(
            (metrics.get("switched"), metrics.get("shoulder_force_reduction_percent")),
            (Some(0.0), Some(0.0)),
            "{}",
            case.name
        );
    }
    assert_eq!(metric("the seat reads nothing", "fault_code"), 0.0);
}

#[test]
fn of_many_crashes_the_right_ones_are_switched() {
    let classes = many::conduct(Extent::QUICK.runs, &AtomicBool::new(false)).unwrap();
    let counts: Vec<_> = classes.iter().map(|class| (class.low(), class.faulted())).collect();
    assert_eq!(counts, [(Extent::QUICK.runs as usize, 0), (0, 0), (0, 0)]);
}

/// LOW after the peak, and LOW that goes back, keep the peak of the passive belt and cost way.
#[test]
fn late_and_undone_is_worse_than_nothing() {
    let timed = by_clock::conduct().unwrap();
    let of = |low: f64, high: Option<f64>| {
        let found = timed.iter().find(|timed| (timed.occupant, timed.low_ms, timed.high_ms) == ("5th", Some(low), high)).unwrap();
        (found.extremes.shoulder_n / found.passive.shoulder_n - 1.0, found.extremes.excursion_m - found.passive.excursion_m)
    };
    let (late, undone, right) = (of(65.0, None), of(35.0, Some(50.0)), of(35.0, None));
    // The study that this follows, with another program: -35.9 % and +57 mm.
    assert!((100.0 * right.0 + 35.92).abs() < 0.01 && (1e3 * right.1 - 57.0).abs() < 0.1, "{right:?}");
    // Measured: +3.4 and +8.7 mm.
    assert!(late.0.abs() < 1e-9 && late.1 > 3e-3, "{late:?}");
    assert!(undone.0.abs() < 1e-9 && undone.1 > 8e-3, "{undone:?}");
}

/// Measured: 0.37 at 40 ms, of signals without noise; 0.84 by the seat.
#[test]
fn the_crash_does_not_tell_the_mass_in_time_and_the_seat_does() {
    let known = mass::conduct(Extent::QUICK.crashes).unwrap();
    let r2 = |at_ms: Option<f64>| known.iter().find(|known| known.at_ms == at_ms).unwrap().r2;
    assert!(r2(Some(40.0)) < 0.45 && r2(None) > 0.8, "{known:?}");
}

/// The page holds all it shows: the view with its moments, and nothing from elsewhere. `CRASH_PAGE=DIR` keeps it, to be looked at.
#[test]
fn the_page_has_a_view_that_loads_nothing() {
    let loaded = load(super::SCENE, &[]).unwrap_or_else(|error| panic!("{error}"));
    let study = sim::study::run(&loaded, sim::study::Options::default()).unwrap();
    assert!(study.passes(), "{:#?}", study.judged);
    let report = sim::tables::report(&study);
    let view = report.crash.as_ref().unwrap();
    assert!(view.low_ms.is_some_and(|ms| (20.0..40.0).contains(&ms)) && view.instants.len() > 200, "{:?}", view.low_ms);
    let dir = std::env::var_os("CRASH_PAGE").map_or_else(|| std::env::temp_dir().join("crash-page"), std::path::PathBuf::from);
    sim::output::write(&loaded, &study, &dir).unwrap();
    let page = std::fs::read_to_string(dir.join("report.html")).unwrap();
    assert!(page.contains("id=\"crash-view\"") && page.contains("prefers-reduced-motion"));
    assert!(!page.contains("src=\"http") && !page.contains("href=\"http"));
}
