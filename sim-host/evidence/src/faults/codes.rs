//! Raises every code of a fault or a limit once, through the whole chain.

use firmware::seam::fault::{Fault, Limit};
use rayon::prelude::*;
use report::{TableBlock, verdict};

use super::injected::Channel::Voltage;
use super::injected::{Failure, Load};
use super::place::{MOTOR, OFF, ON, Place};
use crate::campaign::{cells, digits, or_dash};
use crate::evidence::Error;

/// A run that raises a code.
struct Example {
    code: u8,
    what: &'static str,
    scene: &'static str,
    sets: &'static [&'static str],
    failure: Failure,
    /// Time of the failure, s.
    at_s: f64,
    /// Length of the run, s.
    until_s: f64,
}

/// An example with the time from the failure to the first report of the code, s.
struct Raised {
    example: &'static Example,
    after_s: Option<f64>,
}

impl Example {
    /// Creates a run of this scene with a failure at a time.
    const fn failing(
        code: u8,
        what: &'static str,
        scene: &'static str,
        sets: &'static [&'static str],
        (failure, at_s, until_s): (Failure, f64, f64),
    ) -> Self {
        Example { code, what, scene, sets, failure, at_s, until_s }
    }

    /// Creates a run of this scene without a failure other than the scene's own.
    const fn new(code: u8, what: &'static str, scene: &'static str, sets: &'static [&'static str], until_s: f64) -> Self {
        Example::failing(code, what, scene, sets, (Failure::None, 0.0, until_s))
    }

    fn raise(&'static self) -> Result<Raised, Error> {
        let failed = Place::new(self.what, self.scene, self.sets).run(self.failure, self.at_s, self.until_s, 0)?;
        let first = failed.record.rows.iter().find(|row| row.fault == self.code || row.limit == self.code);
        Ok(Raised { example: self, after_s: first.map(|row| row.time_s - failed.at_s) })
    }
}

/// The example of each code.
const EXAMPLES: &[Example] = &[
    Example::failing(10, "the emergency stop is pressed", "lock", &[ON, OFF], (Failure::EmergencyStop, 0.1, 0.15)),
    Example::failing(11, "a block is late", "lock", &[ON, OFF], (Failure::Scene("late_block"), 0.1, 0.15)),
    Example::failing(12, "the host is silent", "lock", &[ON, OFF], (Failure::HostLost, 0.1, 0.15)),
    Example::failing(13, "the amplifier reports a failure", "lock", &[ON, OFF], (Failure::AmplifierReports, 0.1, 0.15)),
    Example::failing(14, "the supply leaves its window", "lock", &[ON, OFF], (Failure::Supply, 0.1, 0.15)),
    Example::failing(20, "the voltage channel reads half", "lock", &[ON, OFF], (Failure::Gain(Voltage, 0.5), 0.1, 0.15)),
    Example::failing(21, "the comparator fires", "lock", &[ON, OFF], (Failure::Comparator, 0.1, 0.15)),
    Example::failing(22, "the cable is shorted", "lock", &[ON, OFF], (Failure::Scene("short"), 0.0, 0.05)),
    Example::failing(23, "the cable is open", "lock", &[ON, OFF], (Failure::Scene("open"), 0.0, 0.05)),
    Example::failing(24, "a lane is weak", MOTOR, &[ON, OFF], (Failure::Lane("lane_weak", 2), 0.0, 0.3)),
    Example::failing(25, "the stack has depoled", "lock", &[ON, OFF, OBSERVER], (Failure::Scene("depoled"), 0.0, 0.1)),
    Example::failing(26, "the stack is cracked", "lock", &[ON, OFF, OBSERVER], (Failure::Scene("cracked"), 0.0, 0.3)),
    Example::failing(27, "voltage and current are exchanged", "lock", &[ON, OFF], (Failure::Exchanged, 0.0, 0.05)),
    Example::failing(28, "the current exceeds its channel", "lock", &[ON, OFF], (Failure::Scene("saturation"), 0.1, 0.15)),
    Example::failing(29, "a lane is open", MOTOR, &[ON, OFF], (Failure::Lane("lane_open", 2), 0.0, 0.3)),
    Example::new(30, "the resonance is outside the window", "lock", &[ON, OFF, "stack.bvd.series_resonance_hz=45e3"], 0.3),
    Example::new(31, "the phase of the total current, which has no zero at Q 6, is tracked", "lock", &NO_ZERO, 0.3),
    Example::failing(
        32,
        "the resonance jumps by 8 bandwidths",
        "lock",
        &[ON, OFF],
        (Failure::Load(Load { q: 1.0, c0: 1.0, bandwidths: 8.0 }), 0.1, 0.2),
    ),
    Example::failing(
        33,
        "4.5 times C0 and eight times Q: another transducer is connected",
        "lock",
        &[ON, OFF, OBSERVER],
        (Failure::Load(Load { q: 8.0, c0: 4.5, bandwidths: 0.3 }), 0.05, 0.15),
    ),
    Example::new(
        34,
        "Lm is a quarter of its nominal value",
        "lock",
        &[ON, OFF, OBSERVER, "controller.tracking.nominal_lm_h=3.2e-3"],
        0.4,
    ),
    Example::new(40, "the belt stops", "belt-stop", &[], 0.35),
    Example::new(41, "a line of the encoder breaks", "belt-stop-lost", &[], 0.3),
    Example::new(42, "the belt stops, but the encoder continues to count", "belt-stop-lies", &[], 0.3),
    Example::new(43, "more than the allowed 1 J/m is driven", "belt-stop", &["controller.limits.energy_j_per_m=1"], 0.3),
    Example::failing(44, "the board is too hot", "lock", &[ON, OFF], (Failure::Scene("overtemperature"), 0.1, 0.2)),
    Example::new(45, "the drive is on for longer than 0.05 s", "lock", &[ON, OFF, "controller.limits.on_time_s=0.05"], 0.2),
    Example::new(46, "the force channel is stuck", "belt-stop", &["fault.0.at_s=0.1", "fault.0.kind=force_stuck"], 0.3),
    Example::failing(47, "the encoder of a D-ring has no scale", "dring-crash", &[], (Failure::NoScale, 0.0, 0.22)),
    Example::new(
        96,
        "the command needs more than the limit of 2 V",
        "belt-stop",
        &["controller.limits.voltage_v=2", "controller.drive.scan_v=1.5"],
        0.3,
    ),
    Example::new(
        97,
        "the resonance drifts out of the window",
        "lock",
        &[ON, OFF, "disturbance.0.at_s=0.1", "disturbance.0.key=stack.bvd.series_resonance_hz", "disturbance.0.rate_per_s=5e3"],
        0.3,
    ),
    Example::new(98, "bursts of 0.16 ms", "lock", &["controller.burst.period_s=0.4e-3", "controller.burst.duty=0.4"], 0.3),
    Example::failing(99, "a quadrature of 0.3 turns is ordered", MOTOR, &[ON, OFF], (Failure::Quadrature(0.3), 0.3, 0.35)),
    Example::new(100, "the power limit is 20 mW", "lock", &[ON, OFF, "controller.limits.power_w=0.02"], 0.3),
    Example::new(101, "the belt stops", "belt-stop", &[], 0.35),
    Example::new(
        102,
        "the belt is faster than the tip",
        "friction-ratio",
        &["rig.slider.speed_m_per_s=0.2", "controller.friction.speed_m_per_s=0.2"],
        0.8,
    ),
    Example::new(
        103,
        "a friction ratio of 0.15 is ordered",
        "friction-ratio",
        &["controller.friction.step_s=[]", "controller.friction.step_ratio=[]", "controller.friction.target_ratio=0.15"],
        0.7,
    ),
    Example::new(104, "boosted edges within 3 V", "burst", &["controller.limits.voltage_v=3.0"], 0.24),
    Example::new(105, "the seat reads no mass", "dring-crash", &["rig.dring.seat_reads=false"], 0.22),
    Example::new(106, "the lock begins", "lock", &[ON, OFF, OBSERVER], 0.3),
    Example::new(
        107,
        "a second resonance within a broad one",
        "lock",
        &[
            ON,
            OFF,
            OBSERVER,
            "stack.bvd.q=7.5",
            "controller.tracking.nominal_q=7.5",
            "stack.mode.0.series_resonance_hz=39500",
            "stack.mode.0.q=16",
            "stack.mode.0.lm_h=8e-3",
        ],
        0.4,
    ),
    Example::new(108, "the current limit is 0.95 A", "lock", &[ON, OFF, OBSERVER, "controller.limits.current_a=0.95"], 0.3),
];
const OBSERVER: &str = "controller.tracking.mode=observer";
const NO_ZERO: [&str; 5] = [ON, OFF, "controller.tracking.mode=zero_phase", "stack.bvd.q=6", "controller.tracking.nominal_q=6"];

/// Returns codes and names of all faults and limits.
fn all() -> impl Iterator<Item = (u8, &'static str)> {
    let faults = Fault::ALL.iter().map(|fault| (fault.code(), fault.called()));
    faults.chain(Limit::ALL.iter().map(|limit| (limit.code(), limit.called())))
}

/// Raises every code, and returns the table and the codes that were not raised.
pub(super) fn raise_all() -> Result<(TableBlock, Vec<String>), Error> {
    let tried = EXAMPLES.par_iter().map(Example::raise).collect::<Result<Vec<_>, _>>()?;
    let of = |code: u8| tried.iter().find(|raised| raised.example.code == code);
    let row = |(code, called): (u8, &str)| {
        let example = of(code).map(|raised| raised.example);
        let (what, scene) = example.map_or(("–", "–"), |example| (example.what, example.scene));
        let after_s = of(code).and_then(|raised| raised.after_s);
        cells![code, called, what, scene, or_dash(after_s, |after_s| digits(1e3 * after_s)), verdict(after_s.is_some())]
    };
    let missed = all().filter(|&(code, _)| of(code).is_none_or(|raised| raised.after_s.is_none()));
    let missed = missed.map(|(code, called)| format!("code {code}, {called}: not raised")).collect();
    let caption = "A run of the scene, with a few other settings, raises each code through the whole chain from the converters \
                   to the report. After: time from the event, or from the beginning of the run if there is none.";
    let header = ["code", "name", "raised by", "scene", "after [ms]", ""];
    let table = TableBlock::new("codes", "Every fault and limit, raised", caption, &header, all().map(row).collect());
    Ok((table, missed))
}
