//! Contradictions about the transducer of Table 3.1.

use std::f64::consts::TAU;

use super::Erratum;
use crate::thesis::claim::{Check, number};
use crate::thesis::experiment_1::table_3_1::{
    BOLT_N_PER_M, CAPACITANCE_F, D33_M_PER_V, DISCS, DRIVE_A, DRIVE_V, FREQUENCY_HZ, NOMINAL_M, PRINTED_CURRENT_A,
    PRINTED_IMPEDANCE_OHM, REQUIRED_M, STACK_N_PER_M, voltage_v,
};

/// Power that 5.2 states, W.
const PRINTED_POWER_W: f64 = 6.0;

/// Returns the contradictions about the transducer.
pub fn errata() -> Vec<Erratum> {
    vec![frequency(), coupling(), displacement(), power()]
}

fn frequency() -> Erratum {
    let current = |hz: f64| TAU * hz * CAPACITANCE_F * voltage_v();
    let impedance = |hz: f64| 1.0 / (TAU * hz * CAPACITANCE_F);
    let other_hz = 60e3;
    let fits = |hz: f64| {
        (current(hz) / PRINTED_CURRENT_A - 1.0).abs() < 0.01 && (impedance(hz) / PRINTED_IMPEDANCE_OHM - 1.0).abs() < 0.01
    };
    let numbers = vec![
        number("I at 40 kHz [A]", current(FREQUENCY_HZ)),
        number("I at 60 kHz [A]", current(other_hz)),
        number("Z at 40 kHz [ohm]", impedance(FREQUENCY_HZ)),
        number("Z at 60 kHz [ohm]", impedance(other_hz)),
        number("C for 8.84 ohm at 40 kHz [nF]", 1e9 / (TAU * FREQUENCY_HZ * PRINTED_IMPEDANCE_OHM)),
    ];
    Erratum {
        id: "transducer-frequency",
        places: "Table 3.1",
        printed: "At 40 kHz and 300 nF: 1.75 A and 8.84 ohm.",
        instead: "Both are values for 60 kHz (or for 450 nF).",
        evidence: Check::new("2 pi f C V and 1/(2 pi f C)", fits(other_hz) && !fits(FREQUENCY_HZ), numbers),
    }
}

fn coupling() -> Erratum {
    // Force factor d33 n K; k^2 = (d33 n)^2 K / C is the converted share of the energy.
    let factor = D33_M_PER_V * DISCS * STACK_N_PER_M;
    let k2 = D33_M_PER_V * DISCS * factor / CAPACITANCE_F;
    let numbers = vec![number("force factor d33 n K [N/V]", factor), number("k^2 = (d33 n)^2 K/C", k2)];
    Erratum {
        id: "transducer-coupling",
        places: "Table 3.1",
        printed: "d33 n = 45.3 nm/V, stack stiffness 3.14e8 N/m and 300 nF.",
        instead: "The three values exclude each other: the coupling would exceed one, and a passive stack would convert \
                  more energy than it receives.",
        evidence: Check::new("free stack", k2 > 1.0, numbers),
    }
}

fn displacement() -> Erratum {
    let maximum = NOMINAL_M * STACK_N_PER_M / (STACK_N_PER_M + BOLT_N_PER_M);
    let numbers = vec![
        number("maximum displacement by the table's formula [um]", 1e6 * maximum),
        number("voltage for the nominal 36 um [V]", NOMINAL_M / (D33_M_PER_V * DISCS)),
        number("voltage for the required 0.7 um, the table's maximum voltage [V]", voltage_v()),
        number("nominal over required", NOMINAL_M / REQUIRED_M),
    ];
    Erratum {
        id: "transducer-displacement",
        places: "Table 3.1",
        printed: "Maximum displacement 32.2 um at a maximum voltage of 15.466 V.",
        instead: "At that voltage d33 n gives 0.7 um; 36 um would need about 800 V.",
        evidence: Check::new("quasi-static", NOMINAL_M > 10.0 * REQUIRED_M, numbers),
    }
}

fn power() -> Erratum {
    // The mean power of two sines in phase is half the product of their peaks.
    let most = 0.5 * DRIVE_V * DRIVE_A;
    let numbers = vec![
        number("largest power of 6 V and 2 A peak to peak [W]", most),
        number("5.2 states [W]", PRINTED_POWER_W),
        number("Vpp Ipp/2 [W]", 0.5 * (2.0 * DRIVE_V) * (2.0 * DRIVE_A)),
    ];
    Erratum {
        id: "transducer-power",
        places: "5.2, against 3.1.4",
        printed: "6 W for a reduction of 68 % at 6 V and 2 A peak to peak.",
        instead: "At most 1.5 W; 6 W is half the product of the peak-to-peak values.",
        evidence: Check::new("sines in phase", PRINTED_POWER_W > 1.01 * most, numbers),
    }
}
