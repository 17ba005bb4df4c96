//! A program beside this one, asked one line at a time: a peer that is not Rust.
//!
//! The program takes its time itself, around the integration, so that neither its start nor the talk with it counts.

use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use std::time::Instant;

use anyhow::{Context, bail, ensure};
use serde::Deserialize;

use crate::peer::Outcome;

/// The first line: what answers.
#[derive(Clone, Debug, Deserialize)]
pub struct Greeting {
    /// The library's version and language.
    pub version: String,
    /// What one callback costs by itself, ns, of a peer that has them.
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
    /// What compiling took, which is in no time of a run: of a C program, or the longest of what was compiled to be run, ns.
    pub compiling_ns: f64,
}

impl Process {
    /// Starts a script in a Python that has a module.
    ///
    /// # Errors
    /// If the interpreter does not start or does not have the module, with the reason.
    pub fn python(python: &str, module: &str, script: &str) -> anyhow::Result<(Self, Greeting)> {
        let probe = Command::new(python).args(["-c", &format!("import {module}")]).stdin(Stdio::null()).output();
        let probe = probe.with_context(|| format!("`{python}` does not start"))?;
        let complaint = String::from_utf8_lossy(&probe.stderr);
        ensure!(probe.status.success(), "`{python}`: {}", complaint.trim().lines().last().unwrap_or("it failed"));
        Process::start(Command::new(python).args(["-c", script]))
    }

    /// Compiles a C program into a folder, with the header that all share, and starts it.
    ///
    /// # Errors
    /// If there is no compiler, or a library is missing, with the compiler's first complaint.
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

    /// Asks for one run.
    ///
    /// # Errors
    /// If there is no answer, or the answer is that it failed.
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

    /// The next line of the program's own; a library's chatter is none.
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
        // The end of its input ends it.
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
    fn no_interpreter_is_a_reason() {
        let Err(error) = Process::python("no-such-interpreter", "scipy", "") else { panic!() };
        assert!(format!("{error:#}").starts_with("`no-such-interpreter` does not start"), "{error:#}");
    }
}
