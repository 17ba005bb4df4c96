//! Every code that the controller has for a fault or a limit, raised once by the whole chain.

use super::table::digits;
use firmware::seam::fault::{Fault, Limit};
use rayon::prelude::*;
use report::{TableBlock, verdict};

use super::injected::Channel::{Current, Voltage};
use super::injected::{Failure, Load};
use super::place::{MOTOR, OFF, ON, Place};
use crate::evidence::Error;

/// A run in which a code is raised.
struct Example {
    code: u8,
    what: &'static str,
    scene: &'static str,
    sets: &'static [&'static str],
    failure: Failure,
    /// When it fails, and how long the run is, s.
    at_s: f64,
    until_s: f64,
}

/// An example, and how soon after the failure the code was seen first, s.
struct Raised {
    example: &'static Example,
    after_s: Option<f64>,
}

impl Example {
    /// A run as this scene says, in which this fails then.
    const fn failing(
        code: u8,
        what: &'static str,
        scene: &'static str,
        sets: &'static [&'static str],
        (failure, at_s, until_s): (Failure, f64, f64),
    ) -> Self {
        Example { code, what, scene, sets, failure, at_s, until_s }
    }

    /// A run in which nothing fails but what this scene says.
    const fn of(code: u8, what: &'static str, scene: &'static str, sets: &'static [&'static str], until_s: f64) -> Self {
        Example::failing(code, what, scene, sets, (Failure::None, 0.0, until_s))
    }

    fn raise(&'static self) -> Result<Raised, Error> {
        let failed = Place::of(self.what, self.scene, self.sets).run(self.failure, self.at_s, self.until_s, 0)?;
        let first = failed.record.rows.iter().find(|row| row.fault == self.code || row.limit == self.code);
        Ok(Raised { example: self, after_s: first.map(|row| row.time_s - failed.at_s) })
    }
}

/// The example of each code.
const EXAMPLES: &[Example] = &[
    Example::failing(10, "the emergency stop is pressed", "lock", &[ON, OFF], (Failure::EmergencyStop, 0.1, 0.15)),
    Example::failing(11, "a block is late", "lock", &[ON, OFF], (Failure::Scene("late_block"), 0.1, 0.15)),
    Example::failing(12, "the host is silent", "lock", &[ON, OFF], (Failure::HostLost, 0.1, 0.15)),
    Example::failing(13, "the amplifier says that it has failed", "lock", &[ON, OFF], (Failure::AmplifierSays, 0.1, 0.15)),
    Example::failing(14, "the supply leaves its window", "lock", &[ON, OFF], (Failure::Supply, 0.1, 0.15)),
    Example::failing(20, "the voltage channel reads half", "lock", &[ON, OFF], (Failure::Gain(Voltage, 0.5), 0.1, 0.15)),
    Example::failing(21, "the comparator fires", "lock", &[ON, OFF], (Failure::Comparator, 0.1, 0.15)),
    Example::failing(22, "the cable is shorted", "lock", &[ON, OFF], (Failure::Scene("short"), 0.0, 0.05)),
    Example::failing(23, "the cable is open", "lock", &[ON, OFF], (Failure::Scene("open"), 0.0, 0.05)),
    Example::failing(24, "a lane is weak", MOTOR, &[ON, OFF], (Failure::Lane("lane_weak", 2), 0.0, 0.3)),
    Example::failing(25, "the stack has depoled", "lock", &[ON, OFF, OBSERVER], (Failure::Scene("depoled"), 0.0, 0.1)),
    Example::failing(26, "the stack is cracked", "lock", &[ON, OFF, OBSERVER], (Failure::Scene("cracked"), 0.0, 0.3)),
    Example::failing(27, "voltage and current are exchanged", "lock", &[ON, OFF], (Failure::Exchanged, 0.0, 0.05)),
    Example::failing(28, "the current is beyond its channel", "lock", &[ON, OFF], (Failure::Scene("saturation"), 0.1, 0.15)),
    Example::failing(29, "a lane is open", MOTOR, &[ON, OFF], (Failure::Lane("lane_open", 2), 0.0, 0.3)),
    Example::of(30, "the resonance is outside the window", "lock", &[ON, OFF, "stack.bvd.series_resonance_hz=45e3"], 0.3),
    Example::of(31, "the phase of the whole current is followed, which has no zero at Q 6", "lock", &NO_ZERO, 0.3),
    Example::failing(
        32,
        "the resonance leaps by 8 bandwidths",
        "lock",
        &[ON, OFF],
        (Failure::Load(Load { q: 1.0, c0: 1.0, bandwidths: 8.0 }), 0.1, 0.2),
    ),
    Example::failing(
        33,
        "the current channel reads twice the current, in a survey",
        "friction-ratio",
        &["controller.friction.step_s=[]", "controller.friction.step_ratio=[]"],
        (Failure::Gain(Current, 2.0), 0.1, 0.2),
    ),
    Example::of(
        34,
        "Lm is a quarter of its nominal value",
        "lock",
        &[ON, OFF, OBSERVER, "controller.tracking.nominal_lm_h=3.2e-3"],
        0.4,
    ),
    Example::of(40, "the belt stops", "belt-stop", &[], 0.35),
    Example::of(41, "a line of the encoder breaks", "belt-stop-lost", &[], 0.3),
    Example::of(42, "the belt stops, and the encoder counts on", "belt-stop-lies", &[], 0.3),
    Example::of(43, "1 J/m is allowed, and more is driven", "belt-stop", &["controller.limits.energy_j_per_m=1"], 0.3),
    Example::failing(44, "the board is too hot", "lock", &[ON, OFF], (Failure::Scene("overtemperature"), 0.1, 0.2)),
    Example::of(45, "0.05 s are allowed", "lock", &[ON, OFF, "controller.limits.on_time_s=0.05"], 0.2),
    Example::of(46, "the force channel stands", "belt-stop", &["fault.0.at_s=0.1", "fault.0.kind=force_stuck"], 0.3),
    Example::failing(47, "the encoder of a D-ring has no scale", "dring-crash", &[], (Failure::NoScale, 0.0, 0.22)),
    Example::of(
        96,
        "more is asked for than 2 V give",
        "belt-stop",
        &["controller.limits.voltage_v=2", "controller.drive.scan_v=1.5"],
        0.3,
    ),
    Example::of(
        97,
        "the resonance drifts out of the window",
        "lock",
        &[ON, OFF, "disturbance.0.at_s=0.1", "disturbance.0.key=stack.bvd.series_resonance_hz", "disturbance.0.rate_per_s=5e3"],
        0.3,
    ),
    Example::of(98, "bursts of 0.16 ms", "lock", &["controller.burst.period_s=0.4e-3", "controller.burst.duty=0.4"], 0.3),
    Example::failing(99, "a quadrature of 0.3 turns is ordered", MOTOR, &[ON, OFF], (Failure::Quadrature(0.3), 0.3, 0.35)),
    Example::of(100, "20 mW are allowed", "lock", &[ON, OFF, "controller.limits.power_w=0.02"], 0.3),
    Example::of(101, "the belt stops", "belt-stop", &[], 0.35),
    Example::of(
        102,
        "the belt is faster than the tip",
        "friction-ratio",
        &["rig.slider.speed_m_per_s=0.2", "controller.friction.speed_m_per_s=0.2"],
        0.8,
    ),
    Example::of(
        103,
        "a friction ratio of 0.15 is ordered",
        "friction-ratio",
        &["controller.friction.step_s=[]", "controller.friction.step_ratio=[]", "controller.friction.target_ratio=0.15"],
        0.7,
    ),
    Example::of(104, "boosted edges within 3 V", "burst", &["controller.limits.voltage_v=3.0"], 0.24),
    Example::of(105, "the seat reads no mass", "dring-crash", &["rig.dring.seat_reads=false"], 0.22),
    Example::of(106, "the lock begins", "lock", &[ON, OFF, OBSERVER], 0.3),
    Example::of(
        107,
        "a second resonance half a bandwidth below",
        "lock",
        &[ON, OFF, OBSERVER, "stack.mode.0.series_resonance_hz=40300", "stack.mode.0.q=60", "stack.mode.0.lm_h=3e-3"],
        0.4,
    ),
    Example::of(108, "0.95 A are allowed", "lock", &[ON, OFF, OBSERVER, "controller.limits.current_a=0.95"], 0.3),
];
const OBSERVER: &str = "controller.tracking.mode=observer";
const NO_ZERO: [&str; 5] = [ON, OFF, "controller.tracking.mode=zero_phase", "stack.bvd.q=6", "controller.tracking.nominal_q=6"];

/// Codes and names of all faults and limits.
fn all() -> impl Iterator<Item = (u8, &'static str)> {
    let faults = Fault::ALL.iter().map(|fault| (fault.code(), fault.called()));
    faults.chain(Limit::ALL.iter().map(|limit| (limit.code(), limit.called())))
}

/// Raises every code: a table, and what was not raised.
pub(super) fn raised() -> Result<(TableBlock, Vec<String>), Error> {
    let tried = EXAMPLES.par_iter().map(Example::raise).collect::<Result<Vec<_>, _>>()?;
    let of = |code: u8| tried.iter().find(|raised| raised.example.code == code);
    let row = |(code, called): (u8, &str)| {
        let what = of(code).map_or("–", |raised| raised.example.what);
        let scene = of(code).map_or("–", |raised| raised.example.scene);
        let after_s = of(code).and_then(|raised| raised.after_s);
        let after_ms = after_s.map_or_else(|| "–".into(), |after_s| digits(1e3 * after_s));
        vec![
            code.to_string(),
            called.to_owned(),
            what.to_owned(),
            scene.to_owned(),
            after_ms,
            verdict(after_s.is_some()).to_owned(),
        ]
    };
    let missed = all().filter(|&(code, _)| of(code).is_none_or(|raised| raised.after_s.is_none()));
    let missed = missed.map(|(code, called)| format!("code {code}, {called}: not raised")).collect();
    let caption = "Each is raised by a run of this scene with a few other settings, from the converters to the report. \
                   After: from what happens, or from the beginning of the run where nothing fails.";
    let header = ["code", "name", "raised by", "scene", "after [ms]", ""];
    let table = TableBlock::new("codes", "Every fault and limit, raised", caption, &header, all().map(row).collect());
    Ok((table, missed))
}
