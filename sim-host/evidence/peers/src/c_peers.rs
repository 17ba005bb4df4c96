//! SUNDIALS (CVODE, and ERKStep of ARKODE) and ODEPACK's LSODAR: C programs, compiled before the
//! comparison runs.

use std::path::Path;

use crate::case::{Case, Kind};
use crate::peer::{Family, Outcome, Peer, Setting, Way, fine_tolerances, tolerances, with_longest_steps};
use crate::process::{Greeting, Process};

/// Ways of the SUNDIALS program that use CVODE; the others use ERKStep.
const CVODE: &[&str] = &["Adams, located reversals", "BDF, located reversals", "Adams, sgn V in f", "BDF, sgn V in f"];
const ERK: &[&str] = &["order 5, located reversals", "order 6, located reversals", "order 8, located reversals"];
const LSODAR: &[&str] = &["located reversals", "sgn V in f"];

/// Path of deSolve's library in Debian's package.
const DESOLVE: &str = "/usr/lib/R/site-library/deSolve/libs/deSolve.so";

/// A C program, restricted to those of its ways that make up one peer.
pub struct Compiled {
    process: Process,
    name: String,
    /// Number of its first way.
    first: usize,
    ways: &'static [&'static str],
}

impl Compiled {
    /// Starts CVODE and ERKStep.
    ///
    /// # Errors
    /// If there is no C compiler or no SUNDIALS.
    pub fn sundials(folder: &Path) -> anyhow::Result<[Self; 2]> {
        let start = |name: &str| {
            let libraries = ["-lsundials_cvode", "-lsundials_arkode", "-lsundials_nvecserial"];
            Process::compiled(folder, (name, include_str!("../sundials_peer.c")), &libraries)
        };
        let (cvode, Greeting { version, .. }) = start("cvode")?;
        let (erk, _) = start("erkstep")?;
        let of = |process, what, first, ways| Compiled { process, name: format!("{version}, {what}"), first, ways };
        Ok([of(cvode, "CVODE", 0, CVODE), of(erk, "ERKStep", CVODE.len(), ERK)])
    }

    /// Starts LSODAR.
    ///
    /// # Errors
    /// If there is no C compiler or no deSolve.
    pub fn lsodar(folder: &Path) -> anyhow::Result<Self> {
        let libraries = [DESOLVE, "-L/usr/lib/R/lib", "-lR", "-Wl,-rpath,/usr/lib/R/lib", "-Wl,--allow-shlib-undefined"];
        let (process, Greeting { version, .. }) =
            Process::compiled(folder, ("lsodar", include_str!("../lsodar_peer.c")), &libraries)?;
        Ok(Compiled { process, name: version, first: 0, ways: LSODAR })
    }
}

impl Compiled {
    /// Returns a note with the time that compiling the program took.
    pub fn compile_note(&self) -> String {
        format!("{}: compiled by cc in {:.0} ms, which is not counted", self.name, 1e-6 * self.process.compiling_ns)
    }
}

impl Peer for Compiled {
    fn name(&self) -> String {
        self.name.clone()
    }

    fn family(&self) -> Family {
        Family::Compiled
    }

    fn ways(&self, kind: Kind) -> Vec<Way> {
        let settings = if self.ways == LSODAR { fine_tolerances(4, 14) } else { tolerances(4, 14) };
        let way = |(number, name): (usize, &&str)| Way::new(self.first + number, *name, settings.clone());
        with_longest_steps(kind, self.ways.iter().enumerate().map(way).collect())
    }

    fn run(&mut self, case: &Case, way: &Way, setting: Setting) -> anyhow::Result<Outcome> {
        let c = &case.scaled;
        let numbers = [
            way.longest.unwrap_or(0.0),
            setting.tolerance()?,
            c.sliding,
            c.kappa,
            c.spring,
            c.forcing,
            c.friction,
            c.share,
            c.excess,
            c.stribeck,
            c.damping,
            c.viscous,
            c.start,
            c.rate,
            case.length(),
        ];
        let text: Vec<String> = numbers.iter().map(|number| format!("{number:e}")).collect();
        self.process.ask(&format!("{} {}", way.number, text.join(" ")))
    }
}
