//! Expectations of a run as JUnit test cases, the format that CI systems read.

use std::fs;
use std::io;
use std::path::Path;

use quick_junit::{NonSuccessKind, Report, TestCase, TestCaseStatus, TestSuite};

use scene::shown;
use sim::study::{Judged, Study};

/// Writes the test suite of a run, with one test case per expectation. An interrupted run has a
/// failed test case in addition.
pub(super) fn write(study: &Study, path: &Path) -> anyhow::Result<()> {
    let mut suite = TestSuite::new(study.name.as_str());
    for judged in &study.judged {
        suite.add_test_case(case(judged));
    }
    if study.interrupted {
        suite.add_test_case(failure("the whole run", "interrupted", NonSuccessKind::Error));
    }
    let mut report = Report::new("sim-host");
    report.add_test_suite(suite);
    if let Some(folder) = path.parent() {
        fs::create_dir_all(folder)?;
    }
    Ok(fs::write(path, report.to_string().map_err(io::Error::other)?)?)
}

fn case(judged: &Judged) -> TestCase {
    let of = judged.case.as_ref().map_or_else(String::new, |(case, equal)| format!(" ({case}, equal {})", equal.name()));
    let name = format!("{}{of}: {}", judged.metric, judged.limit);
    if judged.pass {
        return TestCase::new(name, TestCaseStatus::success());
    }
    if !judged.counts {
        let mut status = TestCaseStatus::skipped();
        status.set_message("expectation of the base scene, whose inputs were changed");
        return TestCase::new(name, status);
    }
    let value = judged.value.map_or_else(|| "no value in this run".to_owned(), shown);
    let source = if judged.source.is_empty() { String::new() } else { format!(" ({})", judged.source) };
    failure(&name, &format!("{value}, expected {}{source}", judged.limit), NonSuccessKind::Failure)
}

fn failure(name: &str, message: &str, kind: NonSuccessKind) -> TestCase {
    let mut status = TestCaseStatus::non_success(kind);
    status.set_message(message);
    TestCase::new(name, status)
}
