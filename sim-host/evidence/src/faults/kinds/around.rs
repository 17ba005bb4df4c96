//! Failures outside converters and amplifier, and changes that are not failures.

use super::super::injected::{Failure, Load};
use super::{Kind, breakdown, doubtful, harmless, reported};

/// Failures of transducer and cable.
pub(super) const TRANSDUCER: &[Kind] = &[
    reported("stack shorted", &[20, 21, 22, 28], "50 milliohm across the stack", |_| Failure::Scene("short")),
    doubtful("partial short", "0.1 to 10 times the motional resistance across the stack", |random| {
        Failure::Leak(10f64.powf(random.between(-1.0, 1.0)))
    }),
    Kind { named: &[20, 23], ..breakdown("current lead open", "the current channel reads zero", |_| Failure::Scene("open")) },
    doubtful("stack depoled", "C0 falls by a third, the coupling to a tenth", |_| Failure::Scene("depoled")),
    doubtful("stack cracked", "Q falls to a fifth, a second mode appears", |_| Failure::Scene("cracked")),
];

/// Failures reported by hardware or host.
pub(super) const REPORTED: &[Kind] = &[
    reported("too hot", &[44], "the sensor at the driver reads 200 degrees Celsius", |_| Failure::Scene("overtemperature")),
    reported("host lost", &[12], "the host is silent", |_| Failure::HostLost),
    reported("emergency stop", &[10], "the stop is pressed", |_| Failure::EmergencyStop),
    reported("comparator fires", &[21], "the hardware reports an over-current", |_| Failure::Comparator),
    reported("amplifier fault", &[13, 14], "the amplifier reports a failure, or its supply is outside its window", |random| {
        if random.toss() { Failure::AmplifierReports } else { Failure::Supply }
    }),
];

/// Changes that are not failures.
pub(super) const NONE: &[Kind] = &[
    harmless(
        "another load",
        "not a failure: Q changes to 0.3 to 2 times, C0 to 0.9 to 1.1 times its value, and the resonance moves by at most \
               half a bandwidth",
        |random| {
            Failure::Load(Load {
                q: random.between(0.3, 2.0),
                c0: random.between(0.9, 1.1),
                bandwidths: random.between(-0.5, 0.5),
            })
        },
    ),
    harmless("another amplitude", "not a failure: 0.3 to 1 times the scan's voltage is ordered", |random| {
        Failure::Ordered(random.between(0.3, 1.0))
    }),
];
