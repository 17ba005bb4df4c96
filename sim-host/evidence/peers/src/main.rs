//! Compares other projects' integrators with ours on the same cases, at the same error.
//!
//! ```text
//! cargo run --release -p peers                     ours, diffsol, ode_solvers, and the installed others
//! cargo run --release -p peers -- --quick          a coarse look
//! ```
//!
//! The others are heyoka and SciPy (`pip install heyoka scipy`), SUNDIALS and LSODAR
//! (`apt-get install libsundials-dev r-cran-desolve` and a C compiler). A missing one is skipped,
//! with a message. Each peer is used as well as its interface allows: reversals of the slip as
//! located events with the sign as discrete state, or the sign in the right-hand side. A search
//! over its ways and tolerances finds the cheapest for each error. Times are wall times around the
//! integration on one machine; only their ratios count.

mod bench;
mod c_peers;
mod case;
mod choice;
mod diffsol_peer;
mod dop853;
mod files;
mod ode_solvers_peer;
mod ours;
mod peer;
mod process;
mod python_peers;
mod reference;
mod scaled;
mod table;

use std::io::Write;
use std::path::PathBuf;

use clap::Parser;

use c_peers::Compiled;
use case::{Case, Kind};
use peer::Peer;
use python_peers::{Heyoka, Scipy};

/// Tolerance at which the cost of heyoka's events is measured.
const EVENTS_TOLERANCE: f64 = 1e-8;

/// Other projects' integrators and ours on the same cases, compared at the same error.
#[derive(Parser)]
#[command(version)]
struct Arguments {
    /// Periods of a case; the means are over the second half.
    #[arg(long, value_name = "N", default_value_t = 1000)]
    periods: u32,
    /// Periods of a case for SciPy, which is slow.
    #[arg(long, value_name = "N", default_value_t = 100)]
    python_periods: u32,
    /// Number of rounds in which the cheapest settings are timed; the median counts.
    #[arg(long, value_name = "N", default_value_t = 5)]
    rounds: u32,
    /// One round of a tenth of the periods, 20 for SciPy.
    #[arg(long)]
    quick: bool,
    /// Only these cases.
    #[arg(long, value_name = "CASE", value_delimiter = ',')]
    cases: Vec<Kind>,
    /// Python interpreter that has heyoka and SciPy.
    #[arg(long, value_name = "PATH", default_value = "python3")]
    python: String,
    /// Print the tables as Markdown.
    #[arg(long)]
    markdown: bool,
    /// Folder for points, costs, report, figures, and the C programs.
    #[arg(short, long = "output", value_name = "DIR", default_value = "out/peers")]
    output: PathBuf,
}

fn main() -> anyhow::Result<()> {
    let mut arguments = Arguments::parse();
    if arguments.quick {
        (arguments.periods, arguments.python_periods, arguments.rounds) = (arguments.periods.div_ceil(10), 20, 1);
    }
    let mut out = std::io::stdout().lock();
    let (mut peers, mut notes) = peers(&arguments);
    for note in &notes {
        writeln!(out, "{note}")?;
    }
    let kinds = if arguments.cases.is_empty() { Kind::ALL.to_vec() } else { arguments.cases.clone() };
    let mut all = Vec::new();
    for kind in kinds {
        let periods = (arguments.periods, arguments.python_periods);
        all.push(bench::run(kind, &mut peers, periods, arguments.rounds, &|line| eprintln!("{line}"))?);
    }
    for results in &all {
        for block in [table::costs(results), table::settings(results)] {
            let text = if arguments.markdown { block.markdown() } else { block.terminal(false) };
            writeln!(out, "{text}")?;
        }
    }
    let printed = notes.len();
    notes.extend(all.iter().flat_map(|results| std::iter::once(results.reference.clone()).chain(table::failure_notes(results))));
    for note in &notes[printed..] {
        writeln!(out, "{note}")?;
    }
    let facts = [
        ("periods".to_string(), arguments.periods.to_string()),
        ("periods, SciPy".to_string(), arguments.python_periods.to_string()),
        ("rounds".to_string(), arguments.rounds.to_string()),
        ("Rust peers".to_string(), "versions in Cargo.lock".to_string()),
    ];
    files::write(&all, &notes, &facts, &arguments.output)?;
    writeln!(out, "{}: report.html, points.csv, costs.csv and figures", arguments.output.display())?;
    Ok(())
}

/// Starts our peer and all installed others, and returns them with the notes to print.
fn peers(arguments: &Arguments) -> (Vec<Box<dyn Peer>>, Vec<String>) {
    let mut peers: Vec<Box<dyn Peer>> = vec![Box::new(ours::Ours)];
    let mut notes = Vec::new();
    let skipped = |name: &str, error: anyhow::Error, how: &str| format!("SKIPPED   {name}: {error:#}. To install it: {how}");
    let pip = "python3 -m venv DIR && DIR/bin/pip install heyoka scipy, then --python DIR/bin/python";
    match Heyoka::start(&arguments.python) {
        Ok(mut heyoka) => {
            match heyoka.event_share(&Case::new(Kind::Ordinary, arguments.periods), EVENTS_TOLERANCE) {
                Ok(share) => notes.push(share.to_string()),
                Err(error) => notes.push(format!("FAILED    heyoka's events: {error:#}")),
            }
            peers.push(Box::new(heyoka));
        }
        Err(error) => notes.push(skipped("heyoka", error, pip)),
    }
    let apt = "apt-get install --no-install-recommends gcc libsundials-dev r-cran-desolve";
    match Compiled::lsodar(&arguments.output) {
        Ok(lsodar) => {
            notes.push(lsodar.compile_note());
            peers.push(Box::new(lsodar));
        }
        Err(error) => notes.push(skipped("LSODAR", error, apt)),
    }
    match Compiled::sundials(&arguments.output) {
        Ok(both) => {
            notes.extend(both.iter().map(Compiled::compile_note));
            peers.extend(both.map(|peer| Box::new(peer) as Box<dyn Peer>));
        }
        Err(error) => notes.push(skipped("CVODE, ERKStep", error, apt)),
    }
    peers.push(Box::new(ode_solvers_peer::OdeSolvers));
    peers.push(Box::new(diffsol_peer::Diffsol));
    match Scipy::start(&arguments.python) {
        Ok(scipy) => peers.push(Box::new(scipy)),
        Err(error) => notes.push(skipped("SciPy", error, pip)),
    }
    (peers, notes)
}
