//! The list of benches. Built-in suites and code both return [`Evidence`].

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
    /// Description in one line.
    pub about: &'static str,
    /// Text of its suite, if the bench is a suite.
    pub suite: Option<&'static str>,
    /// Function that runs the bench.
    pub run: fn(&mut Options) -> Result<Evidence, Error>,
}

/// All benches, in the order in which they run.
pub const BENCHES: [Bench; 22] = [
    bench(
        "tracking",
        |options| built_in(("tracking", TRACKING), options, |_, _| Ok(())),
        "every tracking case over many seeds, against targets, Cramer-Rao bounds and expected fault counts",
    )
    .with_suite(TRACKING),
    bench(
        "transducers",
        transducers::run,
        "600 random transducers with wrong nominal values, and disturbances that break a lock, each compared with the \
                plant and a baseline",
    )
    .with_suite(transducers::SUITE),
    bench(
        "estimates",
        transducers::estimates::evidence,
        "resonance as identified in seven scenes: stated deviation, error, and the bound of the same blocks",
    ),
    bench(
        "drift",
        transducers::drift::evidence,
        "12 random transducers that run for 100 s while temperature, load, bursts and amplitude change at once",
    ),
    bench(
        "commission",
        commission::run,
        "random transducers commissioned from a band alone (`link PORT commission`), each compared with the plant",
    ),
    bench(
        "import",
        imports::run,
        "600 synthetic admittance measurements in many formats, 500 friction logs and 10 000 damaged files, imported and \
                compared with the truth",
    ),
    bench("friction", friction::run, "friction ratios over many contacts, by amplitude and by bursts, set point against result")
        .with_suite(friction::SUITE),
    bench("guard", guard::evidence, "the weld guard when the belt stops or slows or its encoder fails, a thousand runs each"),
    bench(
        "crash",
        crash::run,
        "light, medium and heavy occupants with switched friction at the D-ring, against the passive belt",
    )
    .with_suite(crash::SUITE),
    bench(
        "faults",
        faults::evidence,
        "faults between a board and the controller while it drives six transducers, and as many runs without a fault",
    ),
    bench(
        "board-faults",
        board_faults::evidence,
        "faults of the driver board, with the flashed image on the model of its part: drive off in time, reason reported",
    ),
    bench(
        "board-scenes",
        board_scenes::evidence,
        "every scene that the board can play, by the flashed image on the model of its part, replayed on the host bit for \
                bit",
    ),
    bench("slot-scenes", board_scenes::in_slot, "the same scenes by the updatable image, which a first stage starts from a slot"),
    bench(
        "update-cuts",
        field_update::evidence,
        "power cuts while first stage and image update a board, on the model of the part: which image starts afterwards",
    ),
    bench(
        "fuzz",
        fuzz::evidence,
        "random and damaged structured input for the link, the stored settings, scenes, suites, scripts and updates",
    ),
    bench(
        "soak",
        fuzz::soak::evidence,
        "boards with plants under random orders, sensor faults that clear, and a noisy link, over 1e9 samples",
    ),
    bench(
        "features",
        features::evidence,
        "features of the controller, and the scenes that ran each one: simulated, in QEMU, by the flashed image, on \
                hardware",
    ),
    bench("contacts", contacts::run, "random contacts over ten decades of their parameters: accuracy and cost of `auto`"),
    bench("precision", precision::evidence, "speed against error of every contact method, the claims, and the hard cases"),
    bench("instructions", instructions::evidence, "instructions of the controller on an emulated Cortex-M4F, against the budget"),
    bench("thesis", thesis::evidence, "every figure, claim and contradiction of the thesis's chapters 2 to 4 and appendix B"),
    bench(
        "measurements",
        measurements::evidence,
        "published measurements and laws next to the models' predictions: agrees, MISS, open, or not comparable",
    ),
];

const fn bench(name: &'static str, run: fn(&mut Options) -> Result<Evidence, Error>, about: &'static str) -> Bench {
    Bench { name, about, suite: None, run }
}

impl Bench {
    const fn with_suite(self, text: &'static str) -> Self {
        Bench { suite: Some(text), ..self }
    }

    /// Loads the suite of this bench, if it has one.
    pub fn load(&self, quick: bool) -> Option<Result<LoadedSuite, LoadError>> {
        self.suite.map(|text| suite::load_text(self.name, text, quick))
    }
}

/// Finds the bench of this name.
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
