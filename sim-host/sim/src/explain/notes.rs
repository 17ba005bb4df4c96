//! Likely causes, checks and an example for each fault and limit.

/// Blocks of the number of a fault or limit, its likely cause, a check, and a command of `sim-host`
/// that shows it in simulation.
const NOTES: &str = include_str!("notes.txt");

/// Returns likely cause, check and command of a fault or limit; a text that is missing is empty.
pub(crate) fn note(code: u8) -> [&'static str; 3] {
    let number = code.to_string();
    let block = NOTES.split("\n\n").find(|block| block.lines().next() == Some(&number)).unwrap_or_default();
    ["cause: ", "check: ", "example: "].map(|label| block.lines().find_map(|line| line.strip_prefix(label)).unwrap_or_default())
}

#[cfg(test)]
mod tests {
    use firmware::seam::fault::{Fault, Limit};
    use scene::load::load;

    use super::*;
    use crate::study::{Options, run};

    fn noted() -> impl Iterator<Item = u8> {
        NOTES.split("\n\n").map(|block| block.lines().next().and_then(|line| line.parse().ok()).expect("a number"))
    }

    #[test]
    fn every_fault_and_limit_has_a_note() {
        let codes = Fault::ALL.iter().map(|fault| fault.code()).chain(Limit::ALL.iter().map(|limit| limit.code()));
        assert!(codes.eq(noted()));
    }

    #[test]
    fn each_run_ends_in_its_fault_or_limit() {
        for code in noted() {
            let [.., command] = note(code);
            let mut words = command.split_whitespace().filter(|word| *word != "--set");
            if words.next() != Some("run") {
                continue; // tests/documented.rs runs the commands of a board
            }
            let name = words.next().expect("a scene");
            let loaded =
                load(name, &words.map(str::to_owned).collect::<Vec<_>>()).unwrap_or_else(|error| panic!("{code}: {error}"));
            let study = run(&loaded, Options::default()).expect("a study");
            let metric = if Fault::try_from(code).is_ok() { "fault_code" } else { "limit_code" };
            assert_eq!(study.metrics.get(metric), Some(f64::from(code)), "{command}");
        }
    }
}
