//! SciPy's `solve_ivp`, in a Python process of its own that answers one request a line (`scipy_peer.py`).
//!
//! The time is taken inside Python, around the integration, so that neither the start of the interpreter nor the talk with it counts.

use std::cell::RefCell;
use std::io::{BufRead, BufReader, Write};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use std::rc::Rc;

use anyhow::{Context, bail, ensure};
use serde::{Deserialize, Serialize};

use crate::case::{Case, Scaled};
use crate::peer::{Family, Outcome, Peer, Setting, tolerances};

const SCRIPT: &str = include_str!("../scipy_peer.py");

/// Methods, and whether reversals are events. Without them, Radau is worse throughout.
const USES: [(&str, bool); 7] =
    [("RK45", true), ("RK45", false), ("DOP853", true), ("DOP853", false), ("LSODA", true), ("LSODA", false), ("Radau", true)];

/// One way to use `solve_ivp`.
pub struct Scipy {
    method: &'static str,
    events: bool,
    server: Rc<RefCell<Server>>,
}

/// All ways to use SciPy that are compared, and its version.
///
/// # Errors
/// If the interpreter does not start or has no SciPy, with the reason.
pub fn all(python: &str) -> anyhow::Result<(Vec<Scipy>, String)> {
    let (server, version) = Server::start(python)?;
    let server = Rc::new(RefCell::new(server));
    let peers = USES.map(|(method, events)| Scipy { method, events, server: Rc::clone(&server) });
    Ok((peers.into(), version))
}

impl Peer for Scipy {
    fn name(&self) -> String {
        format!("SciPy {}, {}", self.method, if self.events { "events" } else { "sgn V in f" })
    }

    fn family(&self) -> Family {
        Family::Python
    }

    fn settings(&self) -> Vec<Setting> {
        tolerances()
    }

    fn run(&mut self, case: &Case, setting: Setting) -> anyhow::Result<Outcome> {
        let Setting::Tolerance(tolerance) = setting else { bail!("SciPy has no fixed step") };
        let (method, events) = (self.method, self.events);
        let request = Request { scaled: &case.scaled, periods: case.periods, method, events, tolerance };
        match self.server.borrow_mut().ask(&request)? {
            Answer::Outcome { mean, forces, wall_ns } => Ok(Outcome { mean, forces, wall_ns }),
            Answer::Failure { failure } => bail!(failure),
        }
    }
}

#[derive(Serialize)]
struct Request<'a> {
    scaled: &'a Scaled,
    periods: u32,
    method: &'a str,
    events: bool,
    tolerance: f64,
}

#[derive(Deserialize)]
#[serde(untagged)]
enum Answer {
    Outcome { mean: f64, forces: Vec<f64>, wall_ns: f64 },
    Failure { failure: String },
}

#[derive(Deserialize)]
struct Versions {
    scipy: String,
    python: String,
}

/// The Python process.
struct Server {
    child: Child,
    requests: Option<ChildStdin>,
    answers: BufReader<ChildStdout>,
}

impl Server {
    fn start(python: &str) -> anyhow::Result<(Self, String)> {
        let probe = Command::new(python).args(["-c", "import scipy.integrate"]).stdin(Stdio::null()).output();
        let probe = probe.with_context(|| format!("`{python}` does not start"))?;
        let complaint = String::from_utf8_lossy(&probe.stderr);
        ensure!(probe.status.success(), "`{python}`: {}", complaint.trim().lines().last().unwrap_or("it failed"));

        let mut child = Command::new(python).args(["-c", SCRIPT]).stdin(Stdio::piped()).stdout(Stdio::piped()).spawn()?;
        let requests = child.stdin.take();
        let answers = child.stdout.take().context("no standard output")?;
        let mut server = Server { child, requests, answers: BufReader::new(answers) };
        let Versions { scipy, python } = serde_json::from_str(&server.line()?)?;
        Ok((server, format!("SciPy {scipy}, Python {python}")))
    }

    fn ask(&mut self, request: &Request<'_>) -> anyhow::Result<Answer> {
        let mut line = serde_json::to_vec(request)?;
        line.push(b'\n');
        self.requests.as_mut().context("no standard input")?.write_all(&line)?;
        Ok(serde_json::from_str(&self.line()?)?)
    }

    /// The next line of the script's own; a library's chatter is none.
    fn line(&mut self) -> anyhow::Result<String> {
        loop {
            let mut line = String::new();
            ensure!(self.answers.read_line(&mut line)? > 0, "the Python process ended");
            if line.starts_with('{') {
                return Ok(line);
            }
        }
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        // The end of its input ends it.
        self.requests = None;
        if let Err(error) = self.child.wait() {
            eprintln!("the Python process did not end: {error}");
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reference::Reference;

    #[test]
    fn no_interpreter_is_a_reason() {
        let Err(error) = all("no-such-interpreter") else { panic!() };
        assert!(format!("{error:#}").starts_with("`no-such-interpreter` does not start"), "{error:#}");
    }

    #[test]
    fn scipy_solves_the_case() {
        let (peers, _) = match all("python3") {
            Ok(all) => all,
            Err(error) => return println!("SKIPPED SciPy: {error:#}"),
        };
        let case = Case::new(6);
        let reference = Reference::new(&case).unwrap();
        for mut peer in peers {
            let outcome = peer.run(&case, Setting::Tolerance(1e-8)).unwrap();
            let (mean, force) = reference.errors(&outcome);
            println!("{}: {mean:.1e} {force:.1e}", peer.name());
            let most = if peer.events { (1e-7, 4e-7) } else { (3e-6, 2e-5) };
            assert!(mean < most.0 && force < most.1, "{}: {mean:e} {force:e}", peer.name());
        }
    }
}
