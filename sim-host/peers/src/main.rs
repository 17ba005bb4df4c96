//! Peers side by side: other projects' integrators and ours on the same case, compared at the same error.
//!
//! ```text
//! cargo run --release -p peers                     ours, diffsol, ode_solvers, and SciPy if `python3` has it
//! cargo run --release -p peers -- --quick          a coarse look in seconds
//! ```
//!
//! Each peer is used as well as its interface allows: reversals of the slip as located events with the sign as discrete state, where it
//! can; the sign in the right-hand side, where that is better. What is compared is cost at equal error, in the mean friction ratio and
//! in friction over time; what is printed are ratios, since times are those of one machine.

mod bench;
mod case;
mod diffsol_peer;
mod dop853_peer;
mod files;
mod interpolate;
mod ode_solvers_peer;
mod ours;
mod peer;
mod reference;
mod scipy_peer;
mod table;

use std::io::Write;
use std::path::PathBuf;

use clap::Parser;

use bench::Entry;
use peer::Peer;

/// Other projects' integrators and ours on the same case, compared at the same error.
#[derive(Parser)]
#[command(version)]
struct Arguments {
    /// Periods of the case for Rust; the means are over the second half.
    #[arg(long, value_name = "N", default_value_t = 1000)]
    periods: u32,
    /// Periods of the case for Python, which is slow.
    #[arg(long, value_name = "N", default_value_t = 100)]
    python_periods: u32,
    /// How often everything is run in turn; the least time counts.
    #[arg(long, value_name = "N", default_value_t = 5)]
    rounds: u32,
    /// Two rounds of a tenth of the periods, 20 for Python.
    #[arg(long)]
    quick: bool,
    /// The interpreter that has SciPy.
    #[arg(long, value_name = "PATH", default_value = "python3")]
    python: String,
    /// Print a table of times too, which are this machine's.
    #[arg(long)]
    times: bool,
    /// Folder for points, ratios, report and figures.
    #[arg(short, long = "output", value_name = "DIR", default_value = "out/peers")]
    output: PathBuf,
}

fn main() -> anyhow::Result<()> {
    let mut arguments = Arguments::parse();
    if arguments.quick {
        (arguments.periods, arguments.python_periods, arguments.rounds) = (arguments.periods.div_ceil(10), 20, 2);
    }
    let mut out = std::io::stdout().lock();
    let mut facts = vec![("Rust peers".to_string(), "versions in Cargo.lock".to_string())];
    let mut entries: Vec<Entry> = rust_peers().into_iter().map(|peer| Entry::new(peer, arguments.periods)).collect();
    match scipy_peer::all(&arguments.python) {
        Ok((peers, version)) => {
            facts.push(("Python peers".into(), version));
            entries.extend(peers.into_iter().map(|peer| Entry::new(Box::new(peer), arguments.python_periods)));
        }
        Err(error) => writeln!(
            out,
            "SKIPPED   SciPy: {error:#}. To have it: python3 -m venv DIR && DIR/bin/pip install scipy==1.17.1, then --python DIR/bin/python"
        )?,
    }
    for (whose, periods) in [("Rust", arguments.periods), ("Python", arguments.python_periods)] {
        facts.push((format!("periods, {whose}"), periods.to_string()));
    }
    facts.push(("rounds".into(), arguments.rounds.to_string()));

    bench::run(&mut entries, arguments.rounds, |line| eprintln!("{line}"))?;

    writeln!(out, "{}", table::ratios(&entries).terminal(false))?;
    if arguments.times {
        writeln!(out, "{}", table::costs(&entries).terminal(false))?;
    }
    for line in table::troubles(&entries) {
        writeln!(out, "{line}")?;
    }
    files::write(&entries, &facts, &arguments.output)?;
    writeln!(out, "{}: report.html, points.csv, ratios.csv and figures", arguments.output.display())?;
    Ok(())
}

/// Ours first, then those of the Rust libraries.
fn rust_peers() -> Vec<Box<dyn Peer>> {
    use diffsol_peer::{Diffsol, Method};
    use dop853_peer::Dop853Peer;
    use ode_solvers_peer::Dopri5Peer;

    let mut peers: Vec<Box<dyn Peer>> = Vec::new();
    peers.extend(ours::METHODS.iter().map(|method| Box::new(method) as Box<dyn Peer>));
    peers.extend([Method::Tsit45, Method::Bdf, Method::Esdirk34].map(|method| Box::new(Diffsol(method)) as Box<dyn Peer>));
    peers.extend([Dopri5Peer::Events, Dopri5Peer::Plain].map(|way| Box::new(way) as Box<dyn Peer>));
    peers.extend(
        [Dop853Peer::AutonomousEvents, Dop853Peer::Autonomous, Dop853Peer::Plain].map(|way| Box::new(way) as Box<dyn Peer>),
    );
    peers
}
