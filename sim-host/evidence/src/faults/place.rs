//! Places of failures: a transducer, and its drive.

use firmware::seam::mode::Mode;
use plant::circuit::Circuit;
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

/// A scene in which a failure may be injected.
pub(super) struct Place {
    /// Name in tables.
    pub(super) name: &'static str,
    scene: &'static str,
    sets: &'static [&'static str],
    fails: Fails,
}

/// Time range of the failures.
enum Fails {
    /// Before the drive runs: in self-test, calibration, scan or lock.
    Early,
    /// This many seconds after the first locked block of the slowest run, within [`SPREAD_S`].
    Driven(f64),
}

/// All places.
pub(super) const PLACES: [Place; 12] = [
    Place::new("stack, Q 65, steady", "lock", &[ON, OFF]),
    Place::new(
        "stack, Q 20, steady",
        "lock",
        &[ON, OFF, "stack.bvd.q=20", "controller.tracking.nominal_q=20", "controller.tracking.mode=observer"],
    ),
    Place::new("stack, bursts", "lock", &["controller.burst.period_s=8e-3", "controller.burst.duty=0.5"]),
    Place::new("Langevin, 28 kHz, steady", "transducer-smbltd45f28h", &[]),
    Place::new("welder, steady", "transducer-skymen-60w", &[]),
    Place::new("friction, surveyed", "friction-ratio", &HELD),
    Place { fails: Fails::Driven(SURVEY_S), ..Place::new("friction, held", "friction-ratio", &HELD) },
    Place::new("D-ring", "dring-crash", &[]),
    Place::new("motor, four lanes", MOTOR, &[ON, OFF]),
    Place::early("stack, scan and lock", "lock", &[ON, OFF]),
    Place::early("stack, calibration and lock", "lock", &[ON, OFF, "controller.tracking.mode=observer"]),
    Place::early("motor, self-test to lock", MOTOR, &[ON, OFF]),
];

/// The scene of a motor.
pub(super) const MOTOR: &str = "usm";
/// Settings of a constant friction ratio.
const HELD: [&str; 2] = ["controller.friction.step_s=[]", "controller.friction.step_ratio=[]"];
/// Time from the lock until the friction ratio is held, s.
const SURVEY_S: f64 = 0.45;
pub(super) const ON: &str = "controller.burst.on_s=[0.0]";
pub(super) const OFF: &str = "controller.burst.off_s=[9.0]";
/// Number of pilot runs.
const PILOTS: u64 = 16;
/// Length of a pilot run, s.
const PILOT_S: f64 = 0.5;
/// Default time from the first locked block of the slowest run to the earliest failure, s.
const SETTLES_S: f64 = 0.02;
/// Time over which failures are spread, s.
const SPREAD_S: f64 = 0.01;
/// Earliest failure during the start, s: in the first block there is nothing yet to repeat or to
/// lose.
const EARLIEST_S: f64 = 1e-3;
/// Length of a run after a failure under drive, s.
const AFTER_S: f64 = 0.08;
/// Length of a run after a failure during the start, s: it must first reach a drive or an end.
const EARLY_AFTER_S: f64 = 0.4;

/// A place with the times measured in its pilot runs.
pub(super) struct Running {
    /// The place.
    pub(super) place: &'static Place,
    /// Earliest failure, s.
    from_s: f64,
    /// Time over which failures are spread, s.
    spread_s: f64,
    /// Length of a run after the failure, s.
    after_s: f64,
}

/// Result of a run with a failure.
pub(super) struct Failed {
    /// Voltage limit, V.
    pub(super) limit_v: f64,
    /// Half a bandwidth of the true resonance before the failure, Hz.
    pub(super) half_hz: f64,
    /// Record of the run.
    pub(super) record: Record,
    /// Time of the failure, s.
    pub(super) at_s: f64,
}

impl Place {
    pub(super) const fn new(name: &'static str, scene: &'static str, sets: &'static [&'static str]) -> Self {
        Place { name, scene, sets, fails: Fails::Driven(SETTLES_S) }
    }

    const fn early(name: &'static str, scene: &'static str, sets: &'static [&'static str]) -> Self {
        Place { name, scene, sets, fails: Fails::Early }
    }

    /// Runs the place without a failure, with several seeds, to measure when it locks: noise makes
    /// a scan up to three times as long.
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

    /// Returns `true` if failures begin before the drive runs.
    pub(super) fn is_during_start(&self) -> bool {
        matches!(self.fails, Fails::Early)
    }

    /// Returns the circuit of the place's stack.
    fn circuit(&self) -> Result<Circuit, Error> {
        let sets: Vec<String> = self.sets.iter().map(|&set| set.to_owned()).collect();
        let loaded = load(self.scene, &sets)?;
        Ok(circuit_of(&loaded.scene.driven().ok_or(StudyError::Incomplete)?))
    }

    /// Returns the settings that inject a failure into the plant of a scene.
    fn in_scene(&self, failure: Failure, at_s: f64) -> Result<Vec<String>, Error> {
        let fault = |kind: &str| vec![format!("fault.0.at_s={at_s}"), format!("fault.0.kind={kind}")];
        Ok(match failure {
            Failure::Scene(kind) => fault(kind),
            Failure::Lane(kind, lane) => {
                let other = (kind == "lanes_exchanged").then(|| format!("fault.0.other_lane={}", (lane + 1) % 4));
                fault(kind).into_iter().chain([format!("fault.0.lane={lane}")]).chain(other).collect()
            }
            Failure::Leak(relative) => {
                let ohm = relative * self.circuit()?.rm_ohm;
                fault("short").into_iter().chain([format!("fault.0.ohm={ohm}")]).collect()
            }
            Failure::Load(load) => {
                let circuit = self.circuit()?;
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

    /// Runs the place until `until_s` with a failure at `at_s`.
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
    /// Returns `true` if this kind can happen here: a stator has no stack that could break or be
    /// loaded, and a stack has no lanes.
    pub(super) fn has(&self, kind: &Kind) -> bool {
        let motor = self.place.scene == MOTOR;
        match (kind.draw)(&mut Random::new(0)) {
            Failure::Scene("short" | "open" | "depoled" | "cracked") | Failure::Load(_) | Failure::Leak(_) => !motor,
            Failure::Lane(..) => motor,
            _ => true,
        }
    }

    /// Runs a kind, or no failure; the same seed gives the same run.
    pub(super) fn fail(&self, kind: Option<&Kind>, seed: u64) -> Result<Failed, Error> {
        let mut random = Random::new(seed);
        let at_s = self.from_s + self.spread_s * random.part();
        let failure = kind.map_or(Failure::None, |kind| (kind.draw)(&mut random));
        self.place.run(failure, at_s, at_s + self.after_s, seed)
    }
}
