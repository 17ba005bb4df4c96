//! The program as a newcomer meets it: what it prints for what is typed, word by word (`tests/commands/*.md`).
//!
//! `TRYCMD=overwrite cargo test -p sonoglide-sim-host --test commands` writes down what it prints now; read the difference before it is committed.

#[test]
fn what_is_typed_is_answered_as_written_down() {
    trycmd::TestCases::new().case("tests/commands/*.md");
}
