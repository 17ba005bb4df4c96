//! `sim-host`: Sonoglide's simulator at the command line.

use std::process::ExitCode;

fn main() -> ExitCode {
    sim_host::cli::main()
}
