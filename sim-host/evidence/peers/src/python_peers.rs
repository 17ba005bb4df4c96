//! SciPy's `solve_ivp` and heyoka's adaptive Taylor integrator, each in a Python process of its
//! own.

use anyhow::Context;
use serde::Serialize;

use crate::case::{Case, Kind};
use crate::peer::{Family, Outcome, Peer, Setting, Way, fine_tolerances, tolerances, with_longest_steps};
use crate::process::{Greeting, Process};
use crate::scaled::Scaled;

/// Methods of SciPy; `true` if reversals are events.
const SCIPY: [(&str, bool); 7] =
    [("DOP853", true), ("DOP853", false), ("RK45", true), ("RK45", false), ("LSODA", true), ("LSODA", false), ("Radau", true)];

/// SciPy, with its version.
pub struct Scipy(Process, String);

impl Scipy {
    /// Starts SciPy in a Python interpreter.
    ///
    /// # Errors
    /// If the interpreter lacks SciPy.
    pub fn start(python: &str) -> anyhow::Result<Self> {
        let (process, greeting) = Process::python(python, "scipy.integrate", include_str!("../scipy_peer.py"))?;
        Ok(Scipy(process, greeting.version))
    }
}

#[derive(Serialize)]
struct ScipyRequest<'a> {
    scaled: &'a Scaled,
    length: f64,
    method: &'a str,
    events: bool,
    longest: Option<f64>,
    tolerance: f64,
}

impl Peer for Scipy {
    fn name(&self) -> String {
        format!("{} (mostly Python)", self.1)
    }

    fn family(&self) -> Family {
        Family::Python
    }

    fn ways(&self, kind: Kind) -> Vec<Way> {
        let way = |(number, (method, events)): (usize, (&str, bool))| {
            let how = if events { "located reversals" } else { "sgn V in f" };
            Way::new(number, format!("{method}, {how}"), tolerances(4, 13))
        };
        let ways = SCIPY.into_iter().enumerate().map(way).collect::<Vec<_>>();
        // Short steps are slow in Python: only one, for the method that is best in the other cases.
        let count = ways.len();
        let mut ways = with_longest_steps(kind, ways);
        ways.retain(|way| way.longest.is_none() || way.number == 0 && way.longest == Some(0.03));
        debug_assert!(ways.len() >= count);
        ways
    }

    fn run(&mut self, case: &Case, way: &Way, setting: Setting) -> anyhow::Result<Outcome> {
        let (method, events) = SCIPY[way.number];
        let (scaled, length, longest, tolerance) = (&case.scaled, case.length(), way.longest, setting.tolerance()?);
        let request = ScipyRequest { scaled, length, method, events, longest, tolerance };
        self.0.ask(&serde_json::to_string(&request)?)
    }
}

/// Distance from a Stribeck peak at which heyoka's steps end, in Stribeck velocities; zero means
/// that they do not end there.
const EDGES: [f64; 5] = [0.0, 3.0, 4.0, 5.0, 6.0];

/// heyoka's adaptive Taylor integrator.
pub struct Heyoka {
    process: Process,
    greeting: Greeting,
}

/// Cost of events in heyoka, ns a period.
pub struct EventShare {
    /// The case itself, with reversals as events.
    pub flip: f64,
    /// With callbacks that do nothing. Friction then saturates, so the solution differs.
    pub idle: f64,
    /// With an event that is never reached; the solution differs in the same way.
    pub far: f64,
    /// Without events.
    pub none: f64,
    /// A callback in Python by itself, ns.
    pub callback_ns: f64,
    /// Compile time before the run, ns.
    pub compiling_ns: f64,
}

impl std::fmt::Display for EventShare {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let EventShare { flip, idle, far, none, callback_ns, compiling_ns } = self;
        write!(
            f,
            "heyoka's events at tolerance 1e-8, ns a period: {flip:.0} with located reversals, {idle:.0} if callbacks do \
             nothing, {far:.0} with an event that is never reached, {none:.0} without events; two callbacks alone take {:.0} in \
             Python, without the code that calls them; compiling took up to {:.0} ms before, which is not counted",
            2.0 * callback_ns,
            1e-6 * compiling_ns
        )
    }
}

#[derive(Serialize)]
struct HeyokaRequest<'a> {
    scaled: &'a Scaled,
    length: f64,
    tolerance: f64,
    phasor: bool,
    high_accuracy: bool,
    events: &'a str,
    edges: f64,
    longest: Option<f64>,
}

impl Heyoka {
    /// Starts heyoka in a Python interpreter.
    ///
    /// # Errors
    /// If the interpreter lacks heyoka.
    pub fn start(python: &str) -> anyhow::Result<Self> {
        let (process, greeting) = Process::python(python, "heyoka", include_str!("../heyoka_peer.py"))?;
        Ok(Heyoka { process, greeting })
    }

    fn ask(&mut self, case: &Case, way: &Way, tolerance: f64, events: &str) -> anyhow::Result<Outcome> {
        let (phasor, high_accuracy) = (way.number % 4 == 1, way.number % 4 == 2);
        let edges = EDGES[way.number / 4];
        let (scaled, length, longest) = (&case.scaled, case.length(), way.longest);
        let request = HeyokaRequest { scaled, length, tolerance, phasor, high_accuracy, events, edges, longest };
        self.process.ask(&serde_json::to_string(&request)?)
    }

    /// Measures the cost of events at a tolerance: the least of several runs each.
    ///
    /// # Errors
    /// If heyoka does not answer.
    pub fn event_share(&mut self, case: &Case, tolerance: f64) -> anyhow::Result<EventShare> {
        let way = self.ways(case.kind).into_iter().next().context("no way")?;
        let mut least = |events: &str| -> anyhow::Result<f64> {
            let mut least = f64::INFINITY;
            for _ in 0..10 {
                least = least.min(self.ask(case, &way, tolerance, events)?.wall_ns / f64::from(case.periods));
            }
            Ok(least)
        };
        let (flip, idle, far, none) = (least("flip")?, least("idle")?, least("far")?, least("none")?);
        let (callback_ns, compiling_ns) = (self.greeting.callback_ns, self.process.compiling_ns);
        Ok(EventShare { flip, idle, far, none, callback_ns, compiling_ns })
    }
}

impl Peer for Heyoka {
    fn name(&self) -> String {
        format!("{} (Python binding)", self.greeting.version)
    }

    fn family(&self) -> Family {
        Family::Compiled
    }

    fn ways(&self, kind: Kind) -> Vec<Way> {
        let forms = ["cos of time", "phasor", "cos of time, compensated"];
        let settings = || fine_tolerances(3, 17);
        let mut ways: Vec<Way> = forms.into_iter().enumerate().map(|(number, form)| Way::new(number, form, settings())).collect();
        if kind == Kind::Lugre {
            let edge = |(index, edge): (usize, &f64)| Way::new(4 * index, format!("events at {edge} Vs"), settings());
            ways.extend(EDGES.iter().enumerate().skip(1).map(edge));
            let limited =
                |longest: f64| Way { longest: Some(longest), ..Way::new(0, format!("h <= {longest}"), tolerances(4, 15)) };
            ways.extend([0.03, 0.01, 0.005].map(limited));
        }
        ways
    }

    fn run(&mut self, case: &Case, way: &Way, setting: Setting) -> anyhow::Result<Outcome> {
        self.ask(case, way, setting.tolerance()?, "flip")
    }
}
