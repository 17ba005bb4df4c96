//! Examples in the help of each command. The tests run them.

use clap::Command;

/// For each command, examples with what they do.
const EXAMPLES: [(&str, &[(&str, &str)]); 16] = [
    (
        "run",
        &[
            ("run lock", "a cold start, with its report in out/lock"),
            (
                "run contact --set excitation.velocity_ratio=0.2",
                "how much friction is left at a fifth of the vibration velocity?",
            ),
            ("run lock-cold --set runs=20 --format json", "twenty cold starts, as JSON"),
            ("run burst --junit burst.xml", "expectations as test cases, for CI"),
        ],
    ),
    (
        "sweep",
        &[
            (
                "sweep contact-kinematic --over excitation.velocity_ratio=0.1:0.9:9 --metric friction_ratio -o curve",
                "a curve of nine points",
            ),
            ("sweep plan lock --over stack.bvd.q=20:200:1000:log", "what a thousand locks would take"),
        ],
    ),
    ("merge", &[("merge mu-1 mu-2 -o mu", "one result of the shards in two folders")]),
    ("list", &[("list", "all built-in scenes")]),
    ("show", &[("show experiment-1 --set rig.slider.load_n=2", "every key with unit and meaning")]),
    ("check", &[("check experiment-1 --set rig.slider.load_n=2", "is it valid?")]),
    (
        "advise",
        &[("advise --frequency-hz 40e3 --q 65 --rm-ohm 3 --c0-f 300e-9", "settings for a transducer by what an analyser prints")],
    ),
    ("compare", &[("compare out/lock out/lock-pil --tolerance 1%", "two runs of a scene")]),
    ("explain", &[("explain friction_ratio", "a metric"), ("explain fault 21", "a fault"), ("explain trace.csv", "a file")]),
    ("import", &[("import admittance transducer.s1p -o transducer", "a circuit with standard deviations, and a scene")]),
    ("spectrum", &[("spectrum trace.csv --column friction_n", "which frequencies friction has when")]),
    ("schema", &[("schema", "for an editor that completes and checks TOML")]),
    (
        "link",
        &[
            ("link sim:lock status", "of a simulated board"),
            ("link /dev/ttyACM0 lock", "find and hold the resonance of a transducer"),
        ],
    ),
    (
        "validate",
        &[
            ("validate my-suite.toml", "each case against its targets"),
            ("validate my-suite.toml --list", "the command of each case"),
        ],
    ),
    ("completions", &[("completions bash", "source them, or put them where the shell looks")]),
    ("man", &[("man", "the manual page"), ("man -o pages", "with one of each command")]),
];

/// Adds the examples to the help of the commands, before what stands there.
pub(super) fn add(command: Command) -> Command {
    EXAMPLES.iter().fold(command, |command, (name, examples)| {
        command.mut_subcommand(name, |command| {
            let lines: String = examples.iter().map(|(line, does)| format!("  # {does}\n  sim-host {line}\n")).collect();
            let after = command.get_after_help().map_or_else(String::new, |after| format!("\n{after}"));
            command.after_help(format!("Examples:\n{lines}{after}"))
        })
    })
}

#[cfg(test)]
mod tests {
    use super::EXAMPLES;

    #[test]
    fn every_command_has_examples_and_each_can_be_read() {
        let command = super::super::command();
        for subcommand in command.get_subcommands().filter(|command| command.get_name() != "help") {
            assert!(EXAMPLES.iter().any(|(name, _)| *name == subcommand.get_name()), "{}", subcommand.get_name());
        }
        for (name, examples) in EXAMPLES {
            for (line, _) in examples {
                assert!(line.split(' ').next() == Some(name), "{line}");
                let words = ["sim-host"].into_iter().chain(line.split(' '));
                command.clone().try_get_matches_from(words).unwrap_or_else(|error| panic!("{line}: {error}"));
            }
        }
    }
}
