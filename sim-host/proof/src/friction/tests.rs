//! The targets over a few cases, and the documentation.

use std::path::Path;

use super::cases::{all, few};
use super::{conduct, plot, table};
use report::{self, Report};

const MARK: &str = "<!-- tables: printed by `sim-host validate friction` -->\n";

#[test]
fn ratios_are_had_and_what_cannot_be_is_refused() {
    for found in conduct(few()).unwrap() {
        let steps: Vec<_> = found.steps.iter().map(|step| (step.wanted, step.error(), step.limit)).collect();
        assert!(found.holds(), "{}: {steps:?}\n{}", found.case.name(), found.case.command());
    }
}

/// What the controller believes is the truth, too.
#[test]
fn what_is_believed_is_true() {
    let amplitude = few().into_iter().filter(|case| case.way == super::cases::Way::Amplitude).take(2).collect();
    for found in conduct(amplitude).unwrap() {
        for step in found.steps {
            let estimate = step.estimate.unwrap();
            assert!((estimate - step.truth).abs() < 0.01, "{}: {step:?}", found.case.name());
        }
    }
}

/// `UPDATE_DOCS=1 cargo test -p sonoglide-proof --lib friction::tests` writes the tables and the plot anew.
#[test]
fn the_documentation_has_these_numbers() {
    let campaign = conduct(all()).unwrap();
    let docs = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs");
    let path = docs.join("friction.md");
    let text = std::fs::read_to_string(&path).expect("the page is there");
    let (head, tables) = text.split_once(MARK).expect("the page has its mark");
    let expected = format!("\n{}", table::markdown(&campaign));
    if std::env::var_os("UPDATE_DOCS").is_some() {
        std::fs::write(&path, format!("{head}{MARK}{expected}")).expect("the page can be written");
        let folder = std::env::temp_dir().join(format!("friction-{}", std::process::id()));
        report::write(&Report { figures: vec![plot::figure(&campaign)], ..Report::default() }, &folder).expect("a report");
        std::fs::copy(folder.join("friction-switch.png"), docs.join("friction-switch.png")).expect("the plot can be written");
    } else {
        assert!(tables == expected, "docs/friction.md has other numbers; run with UPDATE_DOCS=1");
    }
}
