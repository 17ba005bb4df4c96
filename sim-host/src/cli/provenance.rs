//! Provenance of the output of this process: command, commit and date.

use chrono::{DateTime, SecondsFormat, Utc};
use sim::provenance::{Provenance, command_line};

/// Commit that the program was built from, with `+` if files had changed since.
const COMMIT: Option<&str> = option_env!("SIM_HOST_COMMIT");

/// Returns the provenance of the output of this process.
pub(super) fn provenance() -> Provenance {
    let arguments: Vec<String> = std::env::args_os().skip(1).map(|word| word.to_string_lossy().into_owned()).collect();
    let words = std::iter::once("sim-host").chain(decisive(&arguments));
    // https://reproducible-builds.org/specs/source-date-epoch/
    let set = std::env::var("SOURCE_DATE_EPOCH").ok().and_then(|seconds| DateTime::from_timestamp(seconds.parse().ok()?, 0));
    let date = set.unwrap_or_else(Utc::now).to_rfc3339_opts(SecondsFormat::Secs, true);
    Provenance { command: Some(command_line(words)), commit: COMMIT.map(str::to_owned), date: Some(date) }
}

/// Removes the arguments that do not change the result: its folder, and the division of a sweep.
fn decisive(arguments: &[String]) -> Vec<&str> {
    let mut kept = Vec::new();
    let mut words = arguments.iter().map(String::as_str);
    while let Some(word) = words.next() {
        match word {
            "-o" | "--output" | "--jobs" | "--shard" => drop(words.next()),
            word if ["--output=", "--jobs=", "--shard="].iter().any(|option| word.starts_with(option)) => {}
            word if (word.starts_with("-o") && word.len() > 2) => {}
            word => kept.push(word),
        }
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::decisive;

    #[test]
    fn provenance_omits_the_folder_and_the_shard() {
        let words = |text: &str| text.split(' ').map(str::to_owned).collect::<Vec<_>>();
        for text in [
            "run lock -o out -q",
            "run lock --output out -q",
            "run lock --output=out -q",
            "run lock -oout -q",
            "run lock --jobs=2 --shard 1/2 -q",
        ] {
            assert_eq!(decisive(&words(text)), ["run", "lock", "-q"], "{text}");
        }
        assert_eq!(decisive(&words("run lock --set a.o=1")), ["run", "lock", "--set", "a.o=1"]);
    }
}
