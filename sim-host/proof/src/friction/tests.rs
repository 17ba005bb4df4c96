//! The targets over a few cases, and the documentation.

use super::cases::few;
use super::conduct;

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
