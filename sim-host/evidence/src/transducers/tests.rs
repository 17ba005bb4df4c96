//! Tests that the random set has the documented ranges, and that no count is worse than its
//! baseline.

use std::path::Path;

use super::baseline::FILE;
use super::draw::{KINDS, MIN_FIGURE_OF_MERIT, MIN_RM_OHM, Transducer};
use super::outcome::Outcome;
use super::{TransducerRuns, run, run_transducer};
use crate::campaign::quick;
use crate::evidence::Evidence;
use report::docs::is_update;

/// Writes the baseline: the counts of the quick variant, and those of these results of the full
/// one.
pub(crate) fn write_baseline(full: &Evidence) {
    let counts =
        |of: &Evidence| of.files.iter().find(|(name, _)| *name == FILE).map(|(_, text)| text.clone()).unwrap_or_default();
    let (quick, full) = (counts(&quick(run, None)), counts(full));
    let (_, rows) = full.split_once('\n').unwrap_or_default();
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/transducers").join(FILE);
    std::fs::write(&path, format!("{quick}{rows}")).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
}

/// Compares the counts of the quick variant with the committed baseline, unless an update writes
/// it.
#[test]
fn no_count_is_worse_than_its_baseline() {
    if is_update() {
        return;
    }
    let missed = quick(run, None).missed;
    assert!(missed.is_empty(), "\n{}", missed.join("\n"));
}

/// These healthy transducers ended in fault 21 or 28: a scan began while the stack still vibrated
/// after a lock.
#[test]
fn a_scan_after_a_lock_exceeds_no_limit() {
    for number in [23_230, 24_389, 24_813, 21_731, 28_672] {
        let TransducerRuns { observer, .. } = run_transducer(Transducer::draw_wider(number), false, None).unwrap();
        assert!(matches!(observer.judged.outcome, Outcome::Locked | Outcome::Good), "{number}: {:?}", observer.judged);
    }
}

/// The set covers its ranges, and the resonance of each transducer is observable.
#[test]
fn the_set_covers_its_ranges() {
    let set: Vec<Transducer> = (0..600).map(Transducer::draw).collect();
    assert_eq!(set[17], Transducer::draw(17));
    assert!(set.iter().all(|one| one.figure_of_merit() >= MIN_FIGURE_OF_MERIT && one.rm_ohm() >= MIN_RM_OHM));
    let range = |of: fn(&Transducer) -> f64| {
        set.iter().map(of).fold((f64::INFINITY, 0f64), |(least, most), value| (least.min(value), most.max(value)))
    };
    let ranges = [range(|one| one.q), range(|one| one.coupling), range(|one| one.c0_f), range(|one| one.hz)];
    for ((least, most), (from, to)) in ranges.into_iter().zip([(7.0, 4500.0), (0.025, 0.72), (0.4e-9, 2.5e-6), (19e3, 97e3)]) {
        assert!(least < from && most > to, "{least} to {most}");
    }
    for kind in &KINDS {
        let of_kind = set.iter().filter(|one| one.kind == kind);
        let known = of_kind.clone().filter(|one| one.band_only).count();
        assert_eq!((of_kind.count(), known), (100, 16), "{}", kind.name);
    }
}

/// The errors of the nominal values are within the stated bounds.
#[test]
fn nominal_values_are_wrong_within_their_bounds() {
    for one in (0..600).map(Transducer::draw) {
        let nominal = one.nominal;
        assert!((nominal.hz / one.hz - 1.0).abs() < 0.8 * nominal.span + 1e-9, "{one:?}");
        assert_eq!((nominal.lm_h.is_none(), nominal.c0_f.is_none()), (one.band_only, one.band_only));
        if !one.band_only {
            assert!(nominal.c0_f.is_some_and(|c0_f| (1.0 / 1.3001..1.3001).contains(&(c0_f / one.c0_f))), "{one:?}");
            assert!(nominal.lm_h.is_some_and(|lm_h| (0.4999..2.0001).contains(&(lm_h / one.lm_h()))), "{one:?}");
            assert!((1.0 / 3.0001..3.0001).contains(&(nominal.q / one.q)) || nominal.q == 2.0, "{one:?}");
        }
    }
}
