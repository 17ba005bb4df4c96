//! The list of benches. Built-in suites and code give the same [`Evidence`].

use crate::evidence::{Error, Evidence, Options, built_in};
use crate::{
    board_faults, board_scenes, commission, contacts, crash, faults, features, field_update, friction, fuzz, guard, imports,
    instructions, measurements, precision, thesis, transducers,
};
use scene::load::LoadError;
use scene::suite::{self, LoadedSuite};

const TRACKING: &str = include_str!("../suites/tracking.toml");

/// A bench of `evidence`.
pub struct Bench {
    /// Name of the bench on the command line.
    pub name: &'static str,
    /// What it does, in one line.
    pub about: &'static str,
    /// The text of its suite, if it is one.
    pub suite: Option<&'static str>,
    /// Function that runs the bench.
    pub run: fn(&mut Options) -> Result<Evidence, Error>,
}

/// All benches, in the order in which they run.
pub const BENCHES: [Bench; 20] = [
    Bench {
        name: "tracking",
        about: "every tracking case over many seeds, against targets, Cramer-Rao bounds and the numbers of its faults",
        suite: Some(TRACKING),
        run: |options| built_in(("tracking", TRACKING), options, |_, _| Ok(())),
    },
    Bench {
        name: "transducers",
        about: "600 random transducers with wrong nominal values, and what breaks a lock, each judged against the plant and a baseline",
        suite: Some(transducers::SUITE),
        run: transducers::run,
    },
    Bench {
        name: "commission",
        about: "random transducers commissioned from a band alone (`link PORT commission`), each judged against the plant",
        suite: None,
        run: commission::run,
    },
    Bench {
        name: "import",
        about: "600 synthetic measurements of admittances in many formats and 500 friction logs, imported and held against their truth, and 10 000 damaged ones",
        suite: None,
        run: imports::run,
    },
    Bench {
        name: "friction",
        about: "friction ratios over contacts, by amplitude and by bursts, set point against result",
        suite: Some(friction::SUITE),
        run: friction::run,
    },
    Bench {
        name: "guard",
        about: "a belt that stops or slows, or whose encoder fails, a thousand times each, against the weld guard",
        suite: None,
        run: guard::evidence,
    },
    Bench {
        name: "crash",
        about: "light, medium and heavy occupants with the D-ring's friction switched, against the passive belt",
        suite: Some(crash::SUITE),
        run: crash::run,
    },
    Bench {
        name: "faults",
        about: "what fails between a board and the controller while it drives six transducers, and as many runs in which nothing does",
        suite: None,
        run: faults::evidence,
    },
    Bench {
        name: "board-faults",
        about: "faults of the driver board against the flashed image on the model of its part: is it off in time, does it say why",
        suite: None,
        run: board_faults::evidence,
    },
    Bench {
        name: "board-scenes",
        about: "every scene that the board can play by the flashed image on the model of its part, replayed on the host bit for bit",
        suite: None,
        run: board_scenes::evidence,
    },
    Bench {
        name: "slot-scenes",
        about: "the same by the image in the slot behind a first stage, which can be updated",
        suite: None,
        run: board_scenes::in_slot,
    },
    Bench {
        name: "update-cuts",
        about: "power cuts while first stage and image update a board, on the model of the part: who starts afterwards",
        suite: None,
        run: field_update::evidence,
    },
    Bench {
        name: "fuzz",
        about: "random and damaged input, made by its structure: the link, the stored settings, scenes, suites, scripts, updates",
        suite: None,
        run: fuzz::evidence,
    },
    Bench {
        name: "soak",
        about: "boards with their plants under random orders, sensors that fail and heal, and a noisy link, for a thousand million samples",
        suite: None,
        run: fuzz::soak::evidence,
    },
    Bench {
        name: "features",
        about: "features of the controller, and the scenes by which each was run: simulated, in QEMU, by the flashed image, on hardware",
        suite: None,
        run: features::evidence,
    },
    Bench {
        name: "contacts",
        about: "random contacts over ten decades of their parameters: does `auto` keep its word, and what does it cost",
        suite: None,
        run: contacts::run,
    },
    Bench {
        name: "precision",
        about: "speed against error of every contact method, the claims, and the hard cases",
        suite: None,
        run: precision::evidence,
    },
    Bench {
        name: "instructions",
        about: "instructions of the controller on an emulated Cortex-M4F, against the budget",
        suite: None,
        run: instructions::evidence,
    },
    Bench {
        name: "thesis",
        about: "every figure, claim and contradiction of the thesis's chapters 3, 4 and appendix B",
        suite: None,
        run: thesis::evidence,
    },
    Bench {
        name: "measurements",
        about: "published measurements and laws, each beside what the models predict of it: agrees, MISS, open, or not comparable",
        suite: None,
        run: measurements::evidence,
    },
];

impl Bench {
    /// The suite of this bench, loaded.
    pub fn load(&self, quick: bool) -> Option<Result<LoadedSuite, LoadError>> {
        self.suite.map(|text| suite::load_text(self.name, text, quick))
    }
}

/// The bench of this name.
pub fn named(name: &str) -> Option<&'static Bench> {
    BENCHES.iter().find(|bench| bench.name == name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_built_in_suite_is_valid_and_its_quick_variant_is_less() {
        let load = |bench: &Bench, quick| bench.load(quick).map(|loaded| loaded.unwrap_or_else(|error| panic!("{error}")));
        for bench in &BENCHES {
            let (Some(full), Some(quick)) = (load(bench, false), load(bench, true)) else { continue };
            let runs = |suite: &LoadedSuite| suite.cases.iter().map(|case| case.loaded.scene.runs).sum::<u32>();
            assert!(runs(&quick) * 4 < runs(&full), "{}: {} of {}", bench.name, runs(&quick), runs(&full));
        }
    }
}
