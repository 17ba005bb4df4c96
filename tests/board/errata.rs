//! Errata of the microcontroller: their table in the documentation, and what the code refuses.

use std::fs;
use std::path::Path;

use nucleo_g474re::baud::divider;
use nucleo_g474re::errata::{ERRATA, Handling, is_refused, letter};

#[test]
fn revisions_before_y_are_refused() {
    assert_eq!([0x2001, 0x2002, 0x2003].map(letter), [Some('Z'), Some('Y'), Some('X')]);
    assert_eq!([0x1000, 0x2001, 0x2002, 0x2003, 0x2004].map(is_refused), [true, true, false, false, false]);
    assert_eq!(letter(0x2004), None);
}

#[test]
fn dividers_with_which_the_uart_fails_are_refused() {
    assert_eq!(divider(170_000_000, 921_600), Some(47_222));
    assert_eq!((divider(3_000_000, 1_000_000), divider(4_000_000, 1_000_000)), (Some(0x300), Some(0x400)));
    assert!([3_004_000, 3_500_000, 3_990_000].iter().all(|&clock_hz| divider(clock_hz, 1_000_000).is_none()));
}

#[test]
fn docs_of_the_errata() {
    let mut table = "| section of ES0430 | limitation | on this board | test | source |\n|---|---|---|---|---|\n".to_owned();
    for erratum in &ERRATA {
        let (handling, test) = match erratum.handling {
            Handling::NotMet(why) => (format!("not met: {why}"), None),
            Handling::Handled { how, test } => (format!("handled: {how}"), test),
            Handling::Refused(which) => (format!("**refused**: {which}"), None),
            Handling::Open(why) => (format!("**open**: {why}"), None),
            Handling::Unread => ("**not read**".to_owned(), None),
        };
        let named = test.map_or("–".to_owned(), |(file, text)| {
            let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(file);
            let content = fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
            assert!(content.contains(text), "{file} does not contain `{text}`");
            format!("`{text}`")
        });
        table += &format!("| {} | {} | {handling} | {named} | {} |\n", erratum.sections, erratum.limitation, erratum.source);
    }
    report::docs::block("errata.md", "cargo test -p scenarios docs_of_the_errata", &table);
}
