//! This project's own methods, as peers among peers.

use std::time::Instant;

use anyhow::ensure;
use sim_host::contact::tally::Ratios;
use sim_host::contact::{Problem, State, Tally, Trouble, rk4};

use crate::case::Case;
use crate::peer::{Family, Outcome, Peer, Setting};

/// A method of `sim_host::contact`.
pub struct Ours {
    name: &'static str,
    steps: &'static [u32],
    run: fn(&Problem, u32, &mut Quarters) -> Result<Tally, Trouble>,
}

/// All of them: a new method is a new entry here. Steps a period are multiples of four, so that quarter periods end steps.
pub const METHODS: &[Ours] = &[Ours {
    name: "rk4 as the thesis steps it",
    steps: &[20, 40, 100, 200, 400, 1000, 2000, 4000, 10_000],
    run: |problem, steps, quarters| rk4::run(problem, steps, &mut |state| quarters.see(state)),
}];

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
