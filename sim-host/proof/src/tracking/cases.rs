//! The cases: a scene each, changed, and what is to be reached with it.

use scene::load::{LoadError, Loaded, load};

/// What a case is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Family {
    /// From rest, with what is told beforehand.
    Cold,
    /// A load that jumps.
    Step,
    /// A resonance that moves all the time.
    Drift,
    /// Everything at once.
    Anything,
}

/// The largest that a metric may be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Target {
    /// Metric of all runs.
    pub metric: &'static str,
    /// Its size at most, in its own unit.
    pub at_most: f64,
}

/// A scene with changes.
#[derive(Clone, Copy, Debug)]
pub struct Case {
    /// In words.
    pub name: &'static str,
    /// What it is about.
    pub family: Family,
    /// A built-in scene.
    pub scene: &'static str,
    /// Changes, in groups.
    pub sets: &'static [&'static [&'static str]],
    /// What is to be reached.
    pub targets: &'static [Target],
}

impl Case {
    fn changes(&self) -> Vec<String> {
        self.sets.concat().into_iter().map(str::to_owned).collect()
    }

    /// The scene, to be run so often.
    pub fn load(&self, runs: u32) -> Result<Loaded, LoadError> {
        load_many(self.scene, &self.changes(), runs)
    }

    /// How to run it by itself.
    pub fn command(&self) -> String {
        command(self.scene, &self.changes())
    }
}

/// A built-in scene with changes, to be run so often.
pub(super) fn load_many(scene: &str, sets: &[String], runs: u32) -> Result<Loaded, LoadError> {
    load(scene, &[sets, &[format!("runs={runs}")]].concat())
}

/// How to run a scene with changes.
pub(super) fn command(scene: &str, sets: &[String]) -> String {
    let sets: String = sets.iter().map(|set| format!(" --set {set}")).collect();
    format!("sim-host run {scene}{sets}")
}

/// A load of the 40 kHz stack, and the voltage that it can be driven with.
pub struct Load {
    /// Quality factor.
    pub q: u32,
    /// What makes it, of `lock-cold` and the scenes based on it.
    pub sets: &'static [&'static str],
}

impl Load {
    /// Heavy to none.
    pub const ALL: &'static [Load] =
        &[Load { q: 20, sets: Q20 }, Load { q: 65, sets: &[] }, Load { q: 200, sets: Q200 }, Load { q: 500, sets: Q500 }];
}

const Q20: &[&str] = &["stack.bvd.q=20", "controller.tracking.nominal_q=20"];
const Q200: &[&str] = &["stack.bvd.q=200", "controller.tracking.nominal_q=200"];
/// 0.4 ohm: 3 V would drive 4.3 A through it and the source, past the limit of 3 A and the end of the range, 4 A. 1.5 V drive 2.1 A.
const Q500: &[&str] = &["stack.bvd.q=500", "controller.tracking.nominal_q=500", "controller.drive.amplitude_v=1.5"];
/// 2.5 kW into it: 400 ohm, 7.5 mA; the range of the current sense follows.
const LOADED: &[&str] = &[
    "stack.bvd.q=99.5",
    "controller.tracking.nominal_q=99.5",
    "sensors.i_full_scale_a=0.02",
    "controller.limits.current_a=0.018",
];
const OVERLOADED: &[&str] = &[
    "stack.bvd.q=56.8",
    "controller.tracking.nominal_q=56.8",
    "sensors.i_full_scale_a=0.02",
    "controller.limits.current_a=0.018",
];
/// A second mode 7 % above, with a tenth and with three tenths of the motional capacitance.
const SECOND_MODE: [&[&str]; 2] = [
    &["stack.mode.0.series_resonance_hz=42800", "stack.mode.0.q=65", "stack.mode.0.lm_h=6.914e-3"],
    &["stack.mode.0.series_resonance_hz=42800", "stack.mode.0.q=65", "stack.mode.0.lm_h=2.305e-3"],
];
/// No step.
const CALM: &[&str] = &["disturbance=[]"];
const DUFFING: &[&str] = &["stack.bvd.duffing_hz_per_a2=-900", "controller.tracking.span=0.05"];

const fn at_most(metric: &'static str, at_most: f64) -> Target {
    Target { metric, at_most }
}

const TO_20_HZ: Target = at_most("lock_time_20hz_ms_p95", 0.5);
const TO_20_HZ_HALF: Target = at_most("lock_time_20hz_ms", 0.3);
const TO_4_HZ: Target = at_most("lock_time_4hz_ms_p95", 1.0);
const TO_4_HZ_HALF: Target = at_most("lock_time_4hz_ms", 0.6);
const QUICK: &[Target] = &[TO_20_HZ_HALF, TO_20_HZ, TO_4_HZ_HALF, TO_4_HZ];
const AND_STEADY: &[Target] = &[
    TO_20_HZ_HALF,
    TO_20_HZ,
    TO_4_HZ_HALF,
    TO_4_HZ,
    at_most("frequency_bias_hz_p95", 0.3),
    at_most("frequency_jitter_hz_p95", 0.25),
];
const HEAVY: &[Target] = &[at_most("lock_time_20hz_ms_p95", 1.0), at_most("frequency_bias_hz_p95", 2.0)];

const fn cold(name: &'static str, sets: &'static [&'static [&'static str]], targets: &'static [Target]) -> Case {
    Case { name, family: Family::Cold, scene: "lock-cold", sets, targets }
}

const fn welder(name: &'static str, sets: &'static [&'static [&'static str]], targets: &'static [Target]) -> Case {
    Case { name, family: Family::Cold, scene: "lock-welder", sets, targets }
}

const fn step(name: &'static str, sets: &'static [&'static [&'static str]], targets: &'static [Target]) -> Case {
    Case { name, family: Family::Step, scene: "lock-load", sets, targets }
}

const fn drift(name: &'static str, sets: &'static [&'static [&'static str]], targets: &'static [Target]) -> Case {
    Case { name, family: Family::Drift, scene: "lock-load", sets, targets }
}

/// Everything at once about a Q; the step of Q goes from a third of it to six fifths.
macro_rules! anything {
    ($q:literal, $volts:literal, $least:literal, $most:literal) => {
        Case {
            name: concat!("anything, Q ", $q),
            family: Family::Anything,
            scene: "lock-any",
            sets: &[&[
                concat!("stack.bvd.q=", $q),
                concat!("controller.tracking.nominal_q=", $q),
                concat!("controller.drive.amplitude_v=", $volts),
                concat!("disturbance.1.to=", $q),
                concat!("vary.14.from=", $least),
                concat!("vary.14.to=", $most),
            ]],
            targets: &[],
        }
    };
}

/// All of them.
pub const CASES: &[Case] = &[
    cold("Q 20", &[Q20], HEAVY),
    cold("Q 65", &[], AND_STEADY),
    cold("Q 200", &[Q200], QUICK),
    cold("Q 500", &[Q500], QUICK),
    welder("20 kHz, Q 1592", &[], &[at_most("lock_time_4hz_ms_p95", 1.5)]),
    welder("20 kHz, Q 99.5", &[LOADED], &[]),
    welder("20 kHz, Q 56.8", &[OVERLOADED], &[]),
    cold("told within 5 %", &[&["controller.tracking.span=0.055", "vary.0.spread=0.05"]], &[]),
    cold("Lm within 30 %", &[&["vary.2.spread=0.3"]], &[at_most("lock_time_20hz_ms_p95", 0.8)]),
    cold("Lm within 30 %, Q 500", &[Q500, &["vary.2.spread=0.3"]], &[at_most("lock_time_20hz_ms_p95", 0.8)]),
    cold("noise of 2 LSB", &[&["sensors.noise_lsb=2"]], &[]),
    cold("noise of 4 LSB", &[&["sensors.noise_lsb=4"]], &[]),
    cold("noise of 8 LSB", &[&["sensors.noise_lsb=8"]], &[]),
    cold("second mode at 7 %, 10 % of Cm", &[SECOND_MODE[0]], &[]),
    cold("second mode at 7 %, 30 % of Cm", &[SECOND_MODE[1]], &[]),
    cold("C0 told 5 % too large", &[&["controller.tracking.nominal_c0_f=315e-9", "vary.3.spread=1e-6"]], &[]),
    cold("C0 told 5 % too large, Q 20", &[Q20, &["controller.tracking.nominal_c0_f=315e-9", "vary.3.spread=1e-6"]], &[]),
    cold("skew of 20 ns", &[&["sensors.skew_s=20e-9"]], AND_STEADY),
    cold("skew of -20 ns", &[&["sensors.skew_s=-20e-9"]], AND_STEADY),
    cold("skew of 20 ns, Q 20", &[Q20, &["sensors.skew_s=20e-9"]], HEAVY),
    cold("Duffing -900 Hz/A2, 1 V", &[DUFFING, &["controller.drive.amplitude_v=1.0"]], &[]),
    cold("Duffing -900 Hz/A2, 3 V", &[DUFFING], &[]),
    step("+200 Hz, Q 65 to 20", &[], &[at_most("relock_time_20hz_ms_p95", 0.3)]),
    step("-400 Hz, Q 65", &[&["disturbance.0.to=39600", "disturbance.1.to=65"]], &[]),
    step("Q 500 to 60", &[Q500, &["disturbance.0.to=40000", "disturbance.1.to=60"]], &[]),
    step("+200 Hz, Q 65 to 20, in bursts of 2 ms in 4 ms", &[BURSTS], &[]),
    drift("10 kHz/s, Q 65, from its start", &[CALM, RAMP, &["duration_s=0.1", "disturbance.0.at_s=0.08"]], FOLLOWED),
    drift("10 kHz/s, Q 20, from its start", &[CALM, Q20, RAMP, &["duration_s=0.1", "disturbance.0.at_s=0.08"]], &[]),
    drift("10 kHz/s, Q 65, once it lasts", &[CALM, RAMP, &["duration_s=0.085", "disturbance.0.at_s=0.052"]], FOLLOWED),
    drift("10 kHz/s, Q 20, once it lasts", &[CALM, Q20, RAMP, &["duration_s=0.085", "disturbance.0.at_s=0.052"]], &[]),
    drift(
        "100 Hz/s, Q 65",
        &[CALM, &["duration_s=0.2", "disturbance.0.at_s=0.08", RESONANCE, "disturbance.0.rate_per_s=100"]],
        &[],
    ),
    drift(
        "100 Hz/s, Q 20",
        &[CALM, Q20, &["duration_s=0.2", "disturbance.0.at_s=0.08", RESONANCE, "disturbance.0.rate_per_s=100"]],
        &[],
    ),
    drift(
        "sine of 20 Hz, 100 Hz to either side",
        &[
            CALM,
            &[
                "duration_s=0.2",
                "disturbance.0.at_s=0.08",
                RESONANCE,
                "disturbance.0.sine_amplitude=100",
                "disturbance.0.sine_hz=20",
            ],
        ],
        &[],
    ),
    drift("bursts of 2 ms in 4 ms, Q 65", &[CALM, BURSTS], &[]),
    drift("bursts of 2 ms in 4 ms, Q 20", &[CALM, Q20, BURSTS], &[]),
    drift("bursts of 2 ms in 4 ms, and 1 kHz/s, Q 65", &[CALM, BURSTS, SLOPE], &[]),
    drift("bursts of 2 ms in 4 ms, and 1 kHz/s, Q 20", &[CALM, Q20, BURSTS, SLOPE], &[]),
    drift(
        "C0 rises by 5 % at once",
        &[CALM, &["duration_s=0.2", "disturbance.0.at_s=0.08", "disturbance.0.key=stack.bvd.c0_f", "disturbance.0.to=315e-9"]],
        &[],
    ),
    anything!(20, 3.0, 6.7, 24),
    anything!(28, 3.0, 9.3, 34),
    anything!(40, 3.0, 13.3, 48),
    anything!(56, 3.0, 18.7, 67),
    anything!(80, 3.0, 26.7, 96),
    anything!(112, 2.0, 37, 134),
    anything!(160, 2.0, 53, 192),
    anything!(225, 1.2, 75, 270),
    anything!(320, 1.2, 107, 384),
    anything!(450, 1.0, 150, 540),
];
/// A ramp of the resonance that is steeper than any load makes it.
const RAMP: &[&str] = &[RESONANCE, "disturbance.0.rate_per_s=10e3"];
const FOLLOWED: &[Target] = &[at_most("frequency_error_max_hz_p95", 3.0)];
const BURSTS: &[&str] = &["controller.burst.period_s=4e-3", "controller.burst.duty=0.5"];
/// With a step that is none: times count from it.
const SLOPE: &[&str] = &[
    "disturbance.0.at_s=0.07",
    RESONANCE,
    "disturbance.0.rate_per_s=1000",
    "disturbance.1.at_s=0.07",
    "disturbance.1.key=stack.bvd.c0_f",
    "disturbance.1.to=300e-9",
];
const RESONANCE: &str = "disturbance.0.key=stack.bvd.series_resonance_hz";
