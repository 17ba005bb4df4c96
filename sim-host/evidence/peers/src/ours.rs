//! This project's own methods, as a peer like the others.

use std::time::Instant;

use contact::linexp::{self, Options};
use contact::tally::Ratios;
use contact::{Problem, SolveError, Tally, midpoint, rk4_events, taylor};

use crate::case::{Case, Kind};
use crate::peer::{Family, Outcome, Peer, Setting, Way};

/// The methods of `contact`.
pub struct Ours;

type Run = fn(&Problem, u32) -> Result<Tally, SolveError>;

/// A method with the numbers of steps a period that are tried.
struct Method {
    name: &'static str,
    steps: &'static [u32],
    run: Run,
    /// `true` if the method solves LuGre's friction.
    lugre: bool,
}

const LINEXP_STEPS: &[u32] = &[2, 3, 4, 5, 6, 7, 8, 10, 12, 16, 20, 24, 32, 48, 64, 96, 128, 192, 256];
const TAYLOR_STEPS: &[u32] = &[2, 3, 4, 5, 6, 8, 10, 12, 16, 24];
const FIXED_STEPS: &[u32] = &[20, 40, 60, 100, 150, 200, 300, 400, 1000, 2000, 4000];

/// All methods that are the cheapest for some error; a new method is a new entry here.
const METHODS: &[Method] = &[
    Method {
        name: "linexp of order 2",
        steps: LINEXP_STEPS,
        lugre: false,
        run: |p, n| linexp::run(p, n, 2, Options::Plain, &mut |_| ()),
    },
    Method {
        name: "linexp of order 4",
        steps: LINEXP_STEPS,
        lugre: false,
        run: |p, n| linexp::run(p, n, 4, Options::Plain, &mut |_| ()),
    },
    Method {
        name: "linexp of order 6",
        steps: LINEXP_STEPS,
        lugre: false,
        run: |p, n| linexp::run(p, n, 6, Options::Plain, &mut |_| ()),
    },
    Method {
        name: "linexp of order 10",
        steps: LINEXP_STEPS,
        lugre: false,
        run: |p, n| linexp::run(p, n, 10, Options::Plain, &mut |_| ()),
    },
    Method { name: "taylor of order 8", steps: TAYLOR_STEPS, lugre: true, run: |p, n| taylor::run_plain(p, n, 8, &mut |_| ()) },
    Method { name: "taylor of order 12", steps: TAYLOR_STEPS, lugre: true, run: |p, n| taylor::run_plain(p, n, 12, &mut |_| ()) },
    Method { name: "taylor of order 16", steps: TAYLOR_STEPS, lugre: true, run: |p, n| taylor::run_plain(p, n, 16, &mut |_| ()) },
    Method { name: "taylor of order 20", steps: TAYLOR_STEPS, lugre: true, run: |p, n| taylor::run_plain(p, n, 20, &mut |_| ()) },
    Method { name: "rk4-events", steps: FIXED_STEPS, lugre: true, run: |p, n| rk4_events::run_plain(p, n, &mut |_| ()) },
    Method { name: "midpoint", steps: FIXED_STEPS, lugre: true, run: |p, n| midpoint::run(p, n, &mut |_| ()) },
];

impl Peer for Ours {
    fn name(&self) -> String {
        "ours".into()
    }

    fn family(&self) -> Family {
        Family::Ours
    }

    fn ways(&self, kind: Kind) -> Vec<Way> {
        let suited = METHODS.iter().enumerate().filter(|(_, method)| method.lugre || kind != Kind::Lugre);
        let settings = |method: &Method| method.steps.iter().map(|&steps| Setting::Steps(steps)).collect();
        suited.map(|(number, method)| Way::new(number, method.name, settings(method))).collect()
    }

    fn run(&mut self, case: &Case, way: &Way, setting: Setting) -> anyhow::Result<Outcome> {
        let Setting::Steps(steps) = setting else { anyhow::bail!("{} has a fixed step", way.name) };
        let problem = &case.problem;
        let began = Instant::now();
        let tally = (METHODS[way.number].run)(problem, steps)?;
        let mean = Ratios::of(problem, &tally).friction;
        let wall_ns = began.elapsed().as_secs_f64() * 1e9;
        let [length, velocity, force] = case.scales();
        let last = tally.last;
        Ok(Outcome { mean, end: [last.x_m / length, last.v_m_per_s / velocity, last.force_n / force], wall_ns })
    }
}
