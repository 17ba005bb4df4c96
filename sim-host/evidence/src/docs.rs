//! Compares the blocks of the documentation that `evidence` writes with the output of the command.
//!
//!     UPDATE_DOCS=1 cargo test -p sonoglide-evidence docs -- --include-ignored
//!
//! regenerates them. Tests that take minutes are ignored:
//! `cargo test -p sonoglide-evidence --lib -- --ignored` runs them.

use crate::bench::named;
use crate::evidence::{Evidence, Options};
use crate::thesis;
use crate::transducers::tests::write_baseline;
use report::docs::{block, is_update, path};
use report::markdown;

fn evidence(name: &str, page: &str) -> Evidence {
    let mut options = Options { quick: false, count: None, seed: None, counted: None, stop: None, progress: &mut |_| () };
    let evidence = (named(name).unwrap().run)(&mut options).unwrap_or_else(|error| panic!("{error}"));
    block(page, &format!("evidence {name}"), &markdown(&evidence.docs));
    evidence
}

/// The page lists the missed targets under "What falls short".
#[test]
#[ignore = "takes minutes"]
fn tracking_has_these_numbers() {
    const KNOWN_MISSES: [&str; 4] =
        ["open, while running", "depoled, while running", "cracked, while running", "cracked, at power-on"];
    let missed = evidence("tracking", "evidence/tracking.md").missed;
    let other: Vec<_> = missed.iter().filter(|missed| !KNOWN_MISSES.iter().any(|known| missed.contains(known))).collect();
    assert!(other.is_empty(), "{other:?}");
}

/// The baseline contains the counts that fall short; a worse count is missed.
#[test]
#[ignore = "takes minutes"]
fn transducers_have_these_numbers() {
    let evidence = evidence("transducers", "evidence/transducers.md");
    if is_update() {
        write_baseline(&evidence);
    } else {
        assert_eq!(evidence.missed, [""; 0]);
    }
}

/// The page gives the number of right ones under "What falls short".
#[test]
#[ignore = "takes minutes"]
fn commission_has_these_numbers() {
    let missed = evidence("commission", "evidence/transducers.md").missed;
    let other: Vec<_> = missed.iter().filter(|missed| !missed.contains("and in time")).collect();
    assert!(other.is_empty(), "{other:?}");
}

#[test]
#[ignore = "takes minutes"]
fn import_has_these_numbers() {
    assert_eq!(evidence("import", "evidence/import.md").missed, [""; 0]);
}

#[test]
#[ignore = "takes minutes"]
fn friction_has_these_numbers() {
    let evidence = evidence("friction", "evidence/friction.md");
    assert_eq!(evidence.missed, [""; 0]);
    if is_update() {
        let folder = std::env::temp_dir().join(format!("friction-{}", std::process::id()));
        report::write(&evidence.report, &folder).unwrap();
        std::fs::copy(folder.join("friction-switch.png"), path("friction-switch.png")).unwrap();
    }
}

#[test]
#[ignore = "takes minutes"]
fn crash_has_these_numbers() {
    assert_eq!(evidence("crash", "evidence/crash.md").missed, [""; 0]);
}

#[test]
#[ignore = "takes minutes"]
fn guard_has_these_numbers() {
    assert_eq!(evidence("guard", "evidence/guard.md").missed, [""; 0]);
}

/// Runs if QEMU is installed; another test reports if it is not.
#[test]
fn instructions_has_these_counts() {
    if pil::missing().is_none() {
        assert_eq!(evidence("instructions", "evidence/instructions.md").missed, [""; 0]);
    }
}

#[test]
fn features_have_these_levels() {
    assert_eq!(evidence("features", "evidence/features.md").missed, [""; 0]);
}

#[test]
#[ignore = "takes minutes"]
fn thesis_has_these_numbers() {
    block("evidence/thesis-errata.md", "evidence thesis", &markdown(&thesis::table::in_short(&thesis::tests::FINDINGS)));
}

#[test]
fn experiment_2_has_these_numbers() {
    block("evidence/experiment-2.md", "evidence thesis", &markdown(&thesis::experiment_2_tables()));
}

/// The page lists the failures of the models under "Where a model fails".
#[test]
fn measurements_has_these_numbers() {
    const KNOWN_MISSES: [&str; 6] =
        ["rail-load of", "belt-load of", "belt-amplitude-450 of", "pin-87 of", "tip-vanishes of", "tip-load of"];
    let evidence = evidence("measurements", "evidence/measurements.md");
    let other: Vec<_> =
        evidence.missed.iter().filter(|missed| !KNOWN_MISSES.iter().any(|known| missed.starts_with(known))).collect();
    assert!(other.is_empty(), "{other:?}");
    if is_update() {
        let folder = std::env::temp_dir().join(format!("measurements-{}", std::process::id()));
        report::write(&evidence.report, &folder).unwrap();
        std::fs::copy(folder.join("pin-over-speed.png"), path("measurements.png")).unwrap();
    }
}
