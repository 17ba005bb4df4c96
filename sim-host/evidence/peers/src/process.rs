//! A peer that is not in Rust: a separate program that answers one line at a time.
//!
//! The program times the integration itself, so its start and the communication do not count.

use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use std::time::Instant;

use anyhow::{Context, bail, ensure};
use serde::Deserialize;

use crate::peer::Outcome;

/// The program's first line, which identifies it.
#[derive(Clone, Debug, Deserialize)]
pub struct Greeting {
    /// The library's version and language.
    pub version: String,
    /// Cost of one callback by itself, ns, if the peer has callbacks.
    #[serde(default)]
    pub callback_ns: f64,
}

#[derive(Deserialize)]
#[serde(untagged)]
enum Answer {
    Outcome {
        #[serde(flatten)]
        outcome: Outcome,
        #[serde(default)]
        jit_ns: f64,
    },
    Failure {
        failure: String,
    },
}

/// A running program.
pub struct Process {
    child: Child,
    requests: Option<ChildStdin>,
    answers: BufReader<ChildStdout>,
    /// Compile time, ns, not counted in any run: of the C program, or the longest just-in-time
    /// compilation.
    pub compiling_ns: f64,
}

impl Process {
    /// Starts a script in a Python interpreter that has a module.
    ///
    /// # Errors
    /// If the interpreter does not start or lacks the module, with the reason.
    pub fn python(python: &str, module: &str, script: &str) -> anyhow::Result<(Self, Greeting)> {
        let probe = Command::new(python).args(["-c", &format!("import {module}")]).stdin(Stdio::null()).output();
        let probe = probe.with_context(|| format!("`{python}` does not start"))?;
        let complaint = String::from_utf8_lossy(&probe.stderr);
        ensure!(probe.status.success(), "`{python}`: {}", complaint.trim().lines().last().unwrap_or("it failed"));
        Process::start(Command::new(python).args(["-c", script]))
    }

    /// Compiles a C program into a folder, with the shared header, and starts it.
    ///
    /// # Errors
    /// If the compiler or a library is missing, with the compiler's first error.
    pub fn compiled(folder: &Path, (name, source): (&str, &str), libraries: &[&str]) -> anyhow::Result<(Self, Greeting)> {
        std::fs::create_dir_all(folder)?;
        std::fs::write(folder.join("contact.h"), include_str!("../contact.h"))?;
        std::fs::write(folder.join(name).with_extension("c"), source)?;
        let program = std::path::absolute(folder.join(name))?;
        let mut cc = Command::new("cc");
        cc.current_dir(folder)
            .args(["-O3", "-march=native", "-o"])
            .arg(&program)
            .arg(format!("{name}.c"))
            .args(libraries)
            .arg("-lm");
        let began = Instant::now();
        let output = cc.output().context("`cc` does not start")?;
        let compiling_ns = began.elapsed().as_secs_f64() * 1e9;
        let complaint = String::from_utf8_lossy(&output.stderr);
        let first = complaint.lines().find(|line| line.contains("error") || line.contains("cannot find")).unwrap_or("it failed");
        ensure!(output.status.success(), "`cc`: {first}");
        let (mut process, greeting) = Process::start(&mut Command::new(program))?;
        process.compiling_ns = compiling_ns;
        Ok((process, greeting))
    }

    fn start(command: &mut Command) -> anyhow::Result<(Self, Greeting)> {
        let mut child = command.stdin(Stdio::piped()).stdout(Stdio::piped()).spawn()?;
        let requests = child.stdin.take();
        let answers = child.stdout.take().context("no standard output")?;
        let mut process = Process { child, requests, answers: BufReader::new(answers), compiling_ns: 0.0 };
        let greeting = serde_json::from_str(&process.line()?)?;
        Ok((process, greeting))
    }

    /// Requests one run.
    ///
    /// # Errors
    /// If there is no answer, or the answer is a failure.
    pub fn ask(&mut self, request: &str) -> anyhow::Result<Outcome> {
        writeln!(self.requests.as_mut().context("no standard input")?, "{request}")?;
        match serde_json::from_str(&self.line()?)? {
            Answer::Outcome { outcome, jit_ns } => {
                self.compiling_ns = self.compiling_ns.max(jit_ns);
                Ok(outcome)
            }
            Answer::Failure { failure } => bail!(failure),
        }
    }

    /// Returns the program's next line, without the output of libraries.
    fn line(&mut self) -> anyhow::Result<String> {
        loop {
            let mut line = String::new();
            ensure!(self.answers.read_line(&mut line)? > 0, "the program ended");
            if line.starts_with('{') {
                return Ok(line);
            }
        }
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        // The program ends at the end of its input.
        self.requests = None;
        if let Err(error) = self.child.wait() {
            eprintln!("a peer's program did not end: {error}");
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_missing_interpreter_is_reported() {
        let Err(error) = Process::python("no-such-interpreter", "scipy", "") else { panic!() };
        assert!(format!("{error:#}").starts_with("`no-such-interpreter` does not start"), "{error:#}");
    }
}
