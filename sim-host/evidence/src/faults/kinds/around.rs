//! What fails around converters and amplifier, and what is no failure.

use super::super::injected::{Failure, Load};
use super::{Kind, REPORTED_MS, SENSE_MS, SENSE_OR_LIMIT};

/// Transducer and cable.
pub(super) const TRANSDUCER: &[Kind] = &[
    Kind {
        name: "stack shorted",
        what: "50 milliohm across the stack",
        draw: |_| Failure::Scene("short"),
        named: &[20, 21, 22, 28],
        off_ms: Some(REPORTED_MS),
    },
    Kind {
        name: "current lead open",
        what: "the current channel reads nothing",
        draw: |_| Failure::Scene("open"),
        named: &[20, 23],
        off_ms: Some(SENSE_MS),
    },
    Kind {
        name: "stack depoled",
        what: "C0 falls by a third, the coupling to a tenth",
        draw: |_| Failure::Scene("depoled"),
        named: SENSE_OR_LIMIT,
        off_ms: None,
    },
    Kind {
        name: "stack cracked",
        what: "Q falls to a fifth, a second mode appears",
        draw: |_| Failure::Scene("cracked"),
        named: SENSE_OR_LIMIT,
        off_ms: None,
    },
];

/// Reported.
pub(super) const REPORTED: &[Kind] = &[
    Kind {
        name: "too hot",
        what: "the sensor at the driver reads 200 degrees Celsius",
        draw: |_| Failure::Scene("overtemperature"),
        named: &[44],
        off_ms: Some(REPORTED_MS),
    },
    Kind {
        name: "host lost",
        what: "the host says nothing",
        draw: |_| Failure::HostLost,
        named: &[12],
        off_ms: Some(REPORTED_MS),
    },
    Kind {
        name: "emergency stop",
        what: "the stop is pressed",
        draw: |_| Failure::EmergencyStop,
        named: &[10],
        off_ms: Some(REPORTED_MS),
    },
    Kind {
        name: "comparator fires",
        what: "the hardware reports too much current",
        draw: |_| Failure::Comparator,
        named: &[21],
        off_ms: Some(REPORTED_MS),
    },
    Kind {
        name: "amplifier fault",
        what: "the amplifier says that it has failed, or its supply is outside its window",
        draw: |random| if random.toss() { Failure::AmplifierSays } else { Failure::Supply },
        named: &[13, 14],
        off_ms: Some(REPORTED_MS),
    },
];

/// No failure.
pub(super) const NONE: &[Kind] = &[
    Kind {
        name: "another load",
        what: "no failure: Q becomes 0.3 to 2 times, C0 0.9 to 1.1 times what it was, and the resonance moves by half a bandwidth at most",
        draw: |random| {
            Failure::Load(Load {
                q: random.between(0.3, 2.0),
                c0: random.between(0.9, 1.1),
                bandwidths: random.between(-0.5, 0.5),
            })
        },
        named: &[],
        off_ms: None,
    },
    Kind {
        name: "another amplitude",
        what: "no failure: 0.3 to 1 times the scan's voltage is ordered",
        draw: |random| Failure::Ordered(random.between(0.3, 1.0)),
        named: &[],
        off_ms: None,
    },
];
