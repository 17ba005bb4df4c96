//! Examples in the help of each command. The tests run them.

use clap::Command;

/// Examples of each command: arguments and description.
const EXAMPLES: [(&str, &[(&str, &str)]); 20] = [
    (
        "run",
        &[
            ("run lock", "cold start, with a report in out/lock"),
            (
                "run contact --set excitation.velocity_ratio=0.2",
                "friction at a sliding speed of a fifth of the vibration velocity",
            ),
            ("run lock-cold --set runs=20 --format json", "twenty cold starts, as JSON"),
            ("run burst --junit burst.xml", "expectations as JUnit test cases, for CI"),
        ],
    ),
    (
        "sweep",
        &[
            (
                "sweep contact-kinematic --over excitation.velocity_ratio=0.1:0.9:9 --metric friction_ratio -o curve",
                "a curve of nine points",
            ),
            ("sweep plan lock --over stack.bvd.q=20:200:1000:log", "estimate the cost of a thousand locks"),
        ],
    ),
    (
        "solve",
        &[(
            "solve contact-kinematic --set excitation.sliding_m_per_s=0.05 --for reduction_percent=50 --by rig.kinematic.vibration_amplitude_m=1e-8:1e-5:log",
            "the amplitude that halves the friction",
        )],
    ),
    (
        "optimise",
        &[(
            "optimise contact-kinematic --set excitation.sliding_m_per_s=0.05 --minimise rig.kinematic.vibration_amplitude_m --subject-to \"friction_ratio<=0.5\" --over rig.kinematic.vibration_amplitude_m=1e-8:1e-5:log --over excitation.frequency_hz=60e3:100e3",
            "the frequency at which the smallest amplitude halves the friction",
        )],
    ),
    ("merge", &[("merge mu-1 mu-2 -o mu", "join the shards in two folders")]),
    ("list", &[("list", "all built-in scenes")]),
    ("show", &[("show experiment-1 --set rig.slider.load_n=2", "every key with its unit and meaning")]),
    ("check", &[("check experiment-1 --set rig.slider.load_n=2", "check a changed scene")]),
    (
        "advise",
        &[
            ("advise --frequency-hz 40e3 --q 65 --rm-ohm 3 --c0-f 300e-9", "settings from the values of an impedance analyser"),
            ("advise lock --amplifier --tip-m 1e-6", "volts, amperes and power for a tip amplitude"),
        ],
    ),
    (
        "design",
        &[
            ("design langevin", "resonances, circuit and stresses of a built-in transducer"),
            ("design langevin --set design.element.3.length_m=0.035", "the same with a longer horn"),
        ],
    ),
    ("export", &[("export fmu lock -o lock.fmu", "a unit for co-simulation; needs its library")]),
    ("compare", &[("compare out/lock out/lock-pil --tolerance 1%", "compare two runs of a scene")]),
    ("explain", &[("explain friction_ratio", "a metric"), ("explain fault 21", "a fault"), ("explain trace.csv", "a file")]),
    ("import", &[("import admittance transducer.s1p -o transducer", "fit an equivalent circuit and write a scene")]),
    ("spectrum", &[("spectrum trace.csv --column friction_true_n", "frequencies of the friction force over time")]),
    ("schema", &[("schema", "for editors that complete and check TOML")]),
    (
        "link",
        &[
            ("link sim:lock status", "status of a simulated board"),
            ("link /dev/ttyACM0 lock", "find and hold the resonance of a transducer"),
        ],
    ),
    (
        "validate",
        &[
            ("validate my-suite.toml", "compare each case with its targets"),
            ("validate my-suite.toml --list", "the command of each case"),
        ],
    ),
    ("completions", &[("completions bash", "source the output, or save it where the shell looks for completions")]),
    ("man", &[("man", "the manual page"), ("man -o pages", "manual pages of the program and of each command")]),
];

/// Adds the examples to the help of the commands, before other text at its end.
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
    fn every_command_has_examples_that_parse() {
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
