//! The targets over fewer runs, and the documentation.

use std::path::Path;
use std::sync::atomic::AtomicBool;

use super::single::{Case, Group};
use super::{Extent, by_clock, conduct, many, mass, table};

const MARK: &str = "<!-- tables: printed by `sim-host crash` -->\n";

fn metric(case: &str, metric: &str) -> f64 {
    let case = Case::ALL.iter().find(|found| found.name == case).unwrap();
    case.run().unwrap().metrics.get(metric).unwrap()
}

/// The numbers of the study that this follows, computed there with another program: 4825 N and 109 mm passive; an ideal switch -35.9 %
/// and +57 mm; a tip of 5 m/s by Dahl -25.1 % and +33 mm; 2.5 kW -26.2 % and +34 mm; the stack nothing.
#[test]
fn the_numbers_are_those_of_the_study() {
    for (case, force, way_mm) in [
        ("light", -35.9, 57.0),
        ("5 m/s tip, Coulomb", -35.9, 57.0),
        ("5 m/s tip, Dahl", -25.1, 33.0),
        ("2.5 kW into the contact", -26.2, 34.0),
        ("the 40 kHz stack", 0.0, 0.0),
    ] {
        let found = Case::ALL.iter().find(|found| found.name == case).unwrap().run().unwrap().metrics;
        let get = |metric: &str| found.get(metric).unwrap();
        let (passive, passive_mm) = (get("passive_peak_shoulder_force_n"), 1e3 * get("passive_torso_excursion_m"));
        assert!((passive - 4825.2).abs() < 0.1 && (passive_mm - 108.8).abs() < 0.5, "{passive} N, {passive_mm} mm");
        let (off, off_mm) = (-get("reduction_percent") - force, 1e3 * get("added_excursion_m") - way_mm);
        assert!(off.abs() < 0.06 && off_mm.abs() < 0.6, "{case}: {off} % and {off_mm} mm off");
        assert!(get("error_estimate") < 1e-6 && get("energy_residual").abs() < 1e-9, "{case}");
    }
}

#[test]
fn doubt_is_high() {
    for case in Case::ALL.iter().filter(|case| case.group == Group::Doubt) {
        let metrics = case.run().unwrap().metrics;
        assert_eq!((metrics.get("switched"), metrics.get("reduction_percent")), (Some(0.0), Some(0.0)), "{}", case.name);
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
    let (late, undone, right) = (of(60.0, None), of(35.0, Some(50.0)), of(35.0, None));
    assert!(right.0 < -0.35 && late.0 == 0.0 && late.1 > 0.01, "{right:?} {late:?}");
    assert!(undone.0 > right.0 + 0.1 && undone.1 > 0.0, "{undone:?}");
}

#[test]
fn the_crash_does_not_tell_the_mass_in_time_and_the_seat_does() {
    let known = mass::conduct(Extent::QUICK.crashes).unwrap();
    let r2 = |at_ms: Option<f64>| known.iter().find(|known| known.at_ms == at_ms).unwrap().r2;
    assert!(r2(Some(40.0)) < 0.3 && r2(None) > 0.7, "{known:?}");
}

#[test]
#[ignore = "minutes: run by hand, with UPDATE_DOCS=1 to write docs/crash.md"]
fn the_documentation_is_what_is_measured() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/crash.md");
    let page = std::fs::read_to_string(&path).expect("docs/crash.md");
    let (head, tables) = page.split_once(MARK).expect("docs/crash.md has its mark");
    let campaign = conduct(Extent::FULL, &mut |next| eprintln!("{next}")).unwrap();
    let expected = format!("\n{}", table::markdown(&campaign));
    if std::env::var_os("UPDATE_DOCS").is_some() {
        std::fs::write(&path, format!("{head}{MARK}{expected}")).expect("the page can be written");
    } else {
        assert!(tables == expected, "docs/crash.md has other numbers; run with UPDATE_DOCS=1");
    }
}
