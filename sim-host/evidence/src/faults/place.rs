//! Where something fails: a transducer, and how it is driven.

use firmware::seam::mode::Mode;
use plant::circuit_of;
use scene::load::load;
use scene::settings;
use sim::processor::Here;
use sim::record::Record;
use sim::run::{RunError, Watch, run_on};
use sim::study::StudyError;

use super::injected::{Failure, Injected};
use super::kinds::Kind;
use crate::evidence::Error;
use crate::random::Random;

/// A scene that runs, in which something may fail.
pub(super) struct Place {
    /// Name of the place, in tables.
    pub(super) name: &'static str,
    scene: &'static str,
    sets: &'static [&'static str],
    fails: Fails,
}

/// When something fails.
enum Fails {
    /// At some time before it drives: in self-test, calibration, scan or lock.
    Early,
    /// So many seconds after the first locked block of the slowest run, and within [`SPREAD_S`] from then on.
    Driven(f64),
}

/// All places.
pub(super) const PLACES: [Place; 12] = [
    Place::of("stack, Q 65, steady", "lock", &[ON, OFF]),
    Place::of(
        "stack, Q 20, steady",
        "lock",
        &[ON, OFF, "stack.bvd.q=20", "controller.tracking.nominal_q=20", "controller.tracking.mode=observer"],
    ),
    Place::of("stack, bursts", "lock", &["controller.burst.period_s=8e-3", "controller.burst.duty=0.5"]),
    Place::of("Langevin, 28 kHz, steady", "transducer-smbltd45f28h", &[]),
    Place::of("welder, steady", "transducer-skymen-60w", &[]),
    Place::of("friction, surveyed", "friction-ratio", &HELD),
    Place { fails: Fails::Driven(SURVEY_S), ..Place::of("friction, held", "friction-ratio", &HELD) },
    Place::of("D-ring", "dring-crash", &[]),
    Place::of("motor, four lanes", MOTOR, &[ON, OFF]),
    Place::early("stack, scan and lock", "lock", &[ON, OFF]),
    Place::early("stack, calibration and lock", "lock", &[ON, OFF, "controller.tracking.mode=observer"]),
    Place::early("motor, self-test to lock", MOTOR, &[ON, OFF]),
];

/// The scene of a motor.
pub(super) const MOTOR: &str = "usm";
/// One friction ratio throughout, and how long it takes until it is held, s.
const HELD: [&str; 2] = ["controller.friction.step_s=[]", "controller.friction.step_ratio=[]"];
const SURVEY_S: f64 = 0.45;
pub(super) const ON: &str = "controller.burst.on_s=[0.0]";
pub(super) const OFF: &str = "controller.burst.off_s=[9.0]";
/// How many pilot runs there are, and how long each is, s.
const PILOTS: u64 = 16;
const PILOT_S: f64 = 0.5;
/// From the first locked block of the slowest run to the earliest failure, where nothing else is waited for; and over how long failures are spread, s.
const SETTLES_S: f64 = 0.02;
const SPREAD_S: f64 = 0.01;
/// The earliest failure on the way to a drive, s: in the very first block there is nothing yet to repeat or to be lost.
const EARLIEST_S: f64 = 1e-3;
/// How long a run goes on after a failure, s: under drive, and where it has to come to a drive or an end first.
const AFTER_S: f64 = 0.08;
const EARLY_AFTER_S: f64 = 0.4;

/// A place in which the drive has been seen to run.
pub(super) struct Running {
    /// The place.
    pub(super) place: &'static Place,
    /// When failures begin, and over how long they are spread, s.
    from_s: f64,
    spread_s: f64,
    /// How long a run goes on after that, s.
    after_s: f64,
}

/// A run with a failure.
pub(super) struct Failed {
    /// The voltage limit, V.
    pub(super) limit_v: f64,
    /// Half a bandwidth of the true resonance before the failure, Hz.
    pub(super) half_hz: f64,
    /// The record.
    pub(super) record: Record,
    /// When it failed, s.
    pub(super) at_s: f64,
}

impl Place {
    pub(super) const fn of(name: &'static str, scene: &'static str, sets: &'static [&'static str]) -> Self {
        Place { name, scene, sets, fails: Fails::Driven(SETTLES_S) }
    }

    const fn early(name: &'static str, scene: &'static str, sets: &'static [&'static str]) -> Self {
        Place { name, scene, sets, fails: Fails::Early }
    }

    /// The place, once its drive has run without a failure, for some seeds: by noise a scan takes once or thrice as long.
    pub(super) fn pilot(&'static self) -> Result<Running, Error> {
        let locked_s = |seed: u64| -> Result<f64, Error> {
            let rows = self.run(Failure::None, 0.0, PILOT_S, seed)?.record.rows;
            let locked = rows.iter().find(|row| row.mode == Mode::Run && row.locked && row.drive_v > 0.0);
            Ok(locked.map_or(PILOT_S, |row| row.time_s))
        };
        let locked_s = (0..PILOTS).map(locked_s).collect::<Result<Vec<f64>, Error>>()?;
        let first_s = locked_s.iter().copied().fold(PILOT_S, f64::min);
        let last_s = locked_s.iter().copied().fold(0.0, f64::max);
        Ok(match self.fails {
            Fails::Early => Running { place: self, from_s: EARLIEST_S, spread_s: first_s - EARLIEST_S, after_s: EARLY_AFTER_S },
            Fails::Driven(settles_s) => Running { place: self, from_s: last_s + settles_s, spread_s: SPREAD_S, after_s: AFTER_S },
        })
    }

    /// Whether it fails before it drives.
    pub(super) fn is_early(&self) -> bool {
        matches!(self.fails, Fails::Early)
    }

    /// What a scene has to be told of a failure that happens to its plant.
    fn in_scene(&self, failure: Failure, at_s: f64) -> Result<Vec<String>, Error> {
        let fault = |kind: &str| vec![format!("fault.0.at_s={at_s}"), format!("fault.0.kind={kind}")];
        Ok(match failure {
            Failure::Scene(kind) => fault(kind),
            Failure::Lane(kind, lane) => {
                let other = (kind == "lanes_exchanged").then(|| format!("fault.0.other_lane={}", (lane + 1) % 4));
                fault(kind).into_iter().chain([format!("fault.0.lane={lane}")]).chain(other).collect()
            }
            Failure::Load(load) => {
                let sets: Vec<String> = self.sets.iter().map(|&set| set.to_owned()).collect();
                let loaded = scene::load::load(self.scene, &sets)?;
                let circuit = circuit_of(&loaded.scene.driven().ok_or(StudyError::Incomplete)?);
                let (hz, q) = (circuit.series_resonance_hz(), circuit.q());
                let to = [
                    ("series_resonance_hz", hz * (1.0 + load.bandwidths / q)),
                    ("q", q * load.q),
                    ("c0_f", circuit.c0_f * load.c0),
                ];
                let one = |(n, (key, to)): (usize, (&str, f64))| {
                    [format!("at_s={at_s}"), format!("key=stack.bvd.{key}"), format!("to={to}")]
                        .map(|set| format!("disturbance.{n}.{set}"))
                };
                to.into_iter().enumerate().flat_map(one).collect()
            }
            _ => Vec::new(),
        })
    }

    /// A run of this length in which this fails then.
    pub(super) fn run(&self, failure: Failure, at_s: f64, until_s: f64, seed: u64) -> Result<Failed, Error> {
        let mut sets: Vec<String> = self.sets.iter().map(|&set| set.to_owned()).collect();
        sets.extend([format!("duration_s={until_s}"), format!("seed={seed}")]);
        sets.extend(self.in_scene(failure, at_s)?);
        let loaded = load(self.scene, &sets)?;
        let scene = loaded.scene.driven().ok_or(StudyError::Incomplete)?;
        let mut config = settings::config(&scene);
        if failure == Failure::NoScale {
            config.front_end.metre_per_count = None;
        }
        let block_s = f64::from(config.block_samples) / f64::from(config.sample_hz);
        let at_block = (at_s / block_s) as u64;
        let mut injected = Injected::new(Here::new(&config)?, failure, at_block, &config);
        let record = run_on(&mut injected, &scene, Watch::default()).map_err(|error: RunError| StudyError::from(error))?;
        let circuit = circuit_of(&scene);
        Ok(Failed {
            limit_v: scene.controller.limits.voltage_v,
            half_hz: 0.5 * circuit.series_resonance_hz() / circuit.q(),
            record,
            at_s: at_block as f64 * block_s,
        })
    }
}

impl Running {
    /// Whether this kind can happen here: a stator has no stack that could break or be loaded, and a stack no lanes.
    pub(super) fn has(&self, kind: &Kind) -> bool {
        let motor = self.place.scene == MOTOR;
        match (kind.draw)(&mut Random::new(0)) {
            Failure::Scene("short" | "open" | "depoled" | "cracked") | Failure::Load(_) => !motor,
            Failure::Lane(..) => motor,
            _ => true,
        }
    }

    /// A run in which this kind fails, or nothing does; the same seed is the same run.
    pub(super) fn fail(&self, kind: Option<&Kind>, seed: u64) -> Result<Failed, Error> {
        let mut random = Random::new(seed);
        let at_s = self.from_s + self.spread_s * random.part();
        let failure = kind.map_or(Failure::None, |kind| (kind.draw)(&mut random));
        self.place.run(failure, at_s, at_s + self.after_s, seed)
    }
}
