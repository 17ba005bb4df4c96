//! This project's own methods, as peers among peers.

use std::time::Instant;

use anyhow::ensure;
use contact::linexp::{self, Options};
use contact::tally::Ratios;
use contact::{Problem, SolveError, State, Tally, rk4, rk4_events, rk4_tabulated, taylor};

use crate::case::Case;
use crate::peer::{Family, Outcome, Peer, Setting};

/// A method of `contact`.
pub struct Ours {
    name: &'static str,
    steps: &'static [u32],
    run: fn(&Problem, u32, &mut Quarters) -> Result<Tally, SolveError>,
}

/// All of them: a new method is a new entry here. Steps a period are multiples of four, so that quarter periods end steps.
pub const METHODS: &[Ours] = &[
    Ours {
        name: "linexp of order 2",
        steps: &[4, 8, 12, 16, 24, 32, 64],
        run: |problem, steps, quarters| linexp::run(problem, steps, 2, Options::Plain, &mut |state| quarters.see(state)),
    },
    Ours {
        name: "linexp of order 4",
        steps: &[4, 8, 12, 16, 24, 32, 64],
        run: |problem, steps, quarters| linexp::run(problem, steps, 4, Options::Plain, &mut |state| quarters.see(state)),
    },
    Ours {
        name: "linexp of order 6",
        steps: &[4, 8, 12, 16, 24, 32],
        run: |problem, steps, quarters| linexp::run(problem, steps, 6, Options::Plain, &mut |state| quarters.see(state)),
    },
    Ours {
        name: "Taylor of order 16",
        steps: &[4, 8, 12, 16],
        run: |problem, steps, quarters| taylor::run(problem, steps, 16, &mut |state| quarters.see(state)),
    },
    Ours {
        name: "rk4 with events",
        steps: &[20, 40, 100, 200, 400, 1000],
        run: |problem, steps, quarters| rk4_events::run_plain(problem, steps, &mut |state| quarters.see(state)),
    },
    Ours {
        name: "rk4 as the thesis steps it",
        steps: &[20, 40, 100, 200, 400, 1000, 2000, 4000, 10_000],
        run: |problem, steps, quarters| rk4::run_plain(problem, steps, &mut |state| quarters.see(state)),
    },
    Ours {
        name: "the same, cosines from a table",
        steps: &[20, 40, 100, 200, 400, 1000, 2000, 4000, 10_000],
        run: |problem, steps, quarters| rk4_tabulated::run(problem, steps, &mut |state| quarters.see(state)),
    },
];

/// Friction at the ends of those steps that end at quarter periods.
pub struct Quarters {
    per_second: f64,
    per_newton: f64,
    forces: Vec<f64>,
}

impl Quarters {
    #[inline]
    fn see(&mut self, state: &State) {
        let late = state.time_s * self.per_second - self.forces.len() as f64;
        if late.abs() < 1e-6 {
            self.forces.push(state.force_n * self.per_newton);
        }
    }
}

impl Peer for &Ours {
    fn name(&self) -> String {
        format!("ours: {}", self.name)
    }

    fn family(&self) -> Family {
        Family::Ours
    }

    fn settings(&self) -> Vec<Setting> {
        self.steps.iter().map(|&steps| Setting::Steps(steps)).collect()
    }

    fn run(&mut self, case: &Case, setting: Setting) -> anyhow::Result<Outcome> {
        let Setting::Steps(steps) = setting else { anyhow::bail!("{} has a fixed step", self.name) };
        let problem = &case.problem;
        let mut quarters = Quarters {
            per_second: 4.0 * problem.waveform.frequency_hz(),
            per_newton: 1.0 / problem.coulomb_n,
            forces: Vec::with_capacity(case.last_quarter() as usize + 1),
        };
        let began = Instant::now();
        quarters.see(&problem.start);
        let tally = (self.run)(problem, steps, &mut quarters)?;
        let mean = Ratios::of(problem, &tally).friction;
        let wall_ns = began.elapsed().as_secs_f64() * 1e9;
        let seen = quarters.forces.len();
        ensure!(seen == case.last_quarter() as usize + 1, "{} ended a step at {seen} quarter periods only", self.name);
        Ok(Outcome { mean, forces: quarters.forces, wall_ns })
    }
}
