//! `sim-host validate`: our own evidence, each bench held against its targets.

mod campaign;
mod crash;
mod friction;
mod guard;
mod instructions;
mod precision;
mod thesis;
mod tracking;

use std::ffi::OsString;
use std::process::ExitCode;

use clap::{Args, Parser, Subcommand};

use super::{Color, EXIT_CODES};

/// Arguments of the command.
#[derive(Args)]
#[command(args_conflicts_with_subcommands = true)]
pub(super) struct ValidateArgs {
    /// The bench. Without one, all of them, one after the other.
    #[command(subcommand)]
    bench: Option<Bench>,
    /// Of every bench its quick variant, where it has one.
    #[arg(long)]
    quick: bool,
}

#[derive(Subcommand)]
enum Bench {
    /// Run every tracking case over many seeds, and compare it with its targets, its Cramér-Rao bound and its faults.
    #[command(after_help = EXIT_CODES)]
    Tracking(tracking::TrackingArgs),
    /// Order friction ratios over contacts, by amplitude and by bursts, and compare what is held with what was ordered.
    #[command(after_help = EXIT_CODES)]
    Friction(friction::FrictionArgs),
    /// Stop or slow the belt, or break its encoder, a thousand times each, and compare the weld guard with its targets.
    #[command(after_help = EXIT_CODES)]
    Guard(guard::GuardArgs),
    /// Crash light, medium and heavy occupants with the D-ring's friction switched, and compare them with the passive belt.
    #[command(after_help = EXIT_CODES)]
    Crash(crash::CrashArgs),
    /// Measure speed against error of every contact method, judge the claims, and run the hard cases.
    #[command(after_help = EXIT_CODES)]
    Precision(precision::PrecisionArgs),
    /// Count the instructions of the controller on an emulated Cortex-M4F, and compare them with the budget.
    #[command(after_help = EXIT_CODES)]
    Instructions(instructions::InstructionsArgs),
    /// Compute every figure, claim and contradiction of the thesis's chapters 3, 4 and appendix B.
    #[command(after_help = EXIT_CODES)]
    Thesis(thesis::ThesisArgs),
}

/// The names of the benches, in the order in which all of them run. Until version 0.1 each was a command by itself.
const BENCHES: [&str; 7] = ["tracking", "friction", "guard", "crash", "precision", "instructions", "thesis"];
/// Those with a quick variant.
const QUICK: [&str; 5] = ["tracking", "friction", "guard", "crash", "precision"];

/// A bench by its name.
#[derive(Parser)]
struct Line {
    #[command(subcommand)]
    bench: Bench,
}

/// Runs a bench, or all of them; the exit code is that of the first that fails.
pub(super) fn run(args: &ValidateArgs, color: Color) -> anyhow::Result<ExitCode> {
    if let Some(bench) = &args.bench {
        return of(bench, color);
    }
    let mut failed = None;
    for name in BENCHES {
        say!("validate {name}");
        let quick = (args.quick && QUICK.contains(&name)).then_some("--quick");
        let line = Line::try_parse_from(["sim-host validate", name].into_iter().chain(quick))?;
        let code = of(&line.bench, color)?;
        failed = failed.or((code != ExitCode::SUCCESS).then_some(code));
    }
    Ok(failed.unwrap_or(ExitCode::SUCCESS))
}

fn of(bench: &Bench, color: Color) -> anyhow::Result<ExitCode> {
    match bench {
        Bench::Tracking(args) => tracking::run(args, color),
        Bench::Friction(args) => friction::run(args, color),
        Bench::Guard(args) => guard::run(args, color),
        Bench::Crash(args) => crash::run(args, color),
        Bench::Precision(args) => precision::run(args, color),
        Bench::Instructions(args) => instructions::run(args, color),
        Bench::Thesis(args) => thesis::run(args, color),
    }
}

/// The arguments of a process, with `validate` before the name of a bench that stands by itself, as it did until version 0.1.
pub(super) fn with_verb(mut arguments: Vec<OsString>) -> Vec<OsString> {
    let verb = arguments.iter().skip(1).position(|argument| BENCHES.iter().any(|&name| argument == name));
    // Only what stands first is a command: `--color` may be before it.
    let Some(place) = verb.map(|place| place + 1).filter(|&place| match place {
        1 => true,
        2 => arguments[1].to_str().is_some_and(|text| text.starts_with("--color=")),
        3 => arguments[1] == "--color",
        _ => false,
    }) else {
        return arguments;
    };
    let name = arguments[place].to_string_lossy().into_owned();
    say!("note: `sim-host {name}` is `sim-host validate {name}` now; the old name goes with the next version");
    arguments.insert(place, "validate".into());
    arguments
}
