//! Snapshots of the program's output for commands of a new user (`tests/commands/*.md`).
//!
//! `TRYCMD=overwrite cargo test -p sonoglide-sim-host --test commands` writes the current output.
//! Check the difference before committing it.

#[test]
fn commands_print_their_snapshots() {
    trycmd::TestCases::new().case("tests/commands/*.md");
}
