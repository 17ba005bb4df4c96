//! Claims about the rotor (B.7, B.8).

use super::rotor::{Contact, drag};
use super::sheet::{D33_M_PER_V, DEPOLARISING_V_PER_M, Sheet, THICKNESS_M};
use super::{MEASURED_HZ, MEASURED_M, VOLTAGE_V};
use crate::thesis::case::GRAVITY_M_PER_S2;
use crate::thesis::claim::{Check, Claim, number, series};
use crate::thesis::picture::{dashed, figure as draw, line, ranged};
use crate::thesis::sweep;
use report::Figure;

/// Compared voltages, V.
const VOLTAGES_V: [f64; 4] = [15.0, 30.0, 45.0, 60.0];
/// Mean pressure over K a at 60 V with half of each wave touching.
const HALF_CONTACT_PRESSURE: f64 = std::f64::consts::FRAC_1_PI;
/// Mean pressure over K a at 60 V with the troughs also touching.
const FULL_CONTACT_PRESSURE: f64 = 2.0;
/// Hole, outer diameter and thickness of an assumed steel washer for M16 (ISO 7089), m; the thesis
/// gives neither size nor weight.
const WASHER_M: [f64; 3] = [17e-3, 30e-3, 3e-3];
/// Density of steel, kg/m^3.
const STEEL_KG_PER_M3: f64 = 7850.0;
/// Coefficient of friction of Table 4.1.
const MU: f64 = 0.1;
/// Largest torque that counts as low, N m.
const LOW_TORQUE_N_M: f64 = 1e-3;
/// Assumed force that presses rotor and stator together in the second case, N.
const PRESSED_N: f64 = 100.0;

fn crest_mm_per_s(frequency_hz: f64, voltage_v: f64) -> f64 {
    1e3 * Sheet::BEAM.crest_m_per_s(MEASURED_M * voltage_v / VOLTAGE_V, frequency_hz)
}

/// Returns the speed without load at a voltage, mm/s, for a mean pressure over K a that is given at
/// 60 V.
fn no_load_mm_per_s(frequency_hz: f64, voltage_v: f64, load_at_60_v: f64) -> f64 {
    let contact = Contact::loaded(load_at_60_v * VOLTAGE_V / voltage_v);
    contact.speed(0.0).unwrap_or(0.0) * crest_mm_per_s(frequency_hz, voltage_v)
}

/// Draws the speed over the voltage.
pub fn figure() -> Figure {
    let volts = sweep::spaced(1.0, 80.0, 159);
    let of = |value: &dyn Fn(f64) -> f64| volts.iter().map(|&v| value(v)).collect::<Vec<_>>();
    let mut all = Vec::new();
    for hz in MEASURED_HZ {
        let khz = hz / 1e3;
        all.push(line(format!("crest, {khz} kHz"), format!("crest_{khz}_khz_mm_per_s"), &volts, of(&|v| crest_mm_per_s(hz, v))));
        all.push(dashed(
            format!("rotor in contact everywhere, {khz} kHz"),
            format!("rotor_{khz}_khz_mm_per_s"),
            &volts,
            of(&|v| no_load_mm_per_s(hz, v, FULL_CONTACT_PRESSURE)),
        ));
    }
    let caption = "Speed along the sheet of the crests of a pure travelling wave of 20 nm at 60 V (assumed; the text gives \
                   no voltage for its 20 nm), and of a rotor without load that also touches the troughs (mean pressure \
                   twice K a at 60 V). A rotor with half of each wave in contact at 60 V lies between them."
        .into();
    let axes = [ranged("voltage [V]", 0.0, 80.0), ranged("speed [mm/s]", 0.0, 2.0)];
    draw("app-b-rotor", "Appendix B.7: speed of the rotor over voltage", caption, axes, all)
}

/// Judges the claims about the rotor.
pub fn claims() -> Vec<Claim> {
    vec![voltage(), opposing(), friction(), torque()]
}

fn voltage() -> Claim {
    let labels = VOLTAGES_V.map(|v| format!("{v} V"));
    let check = |condition: &str, speeds: [f64; 4]| {
        // A speed other than zero must rise by at least one per cent.
        let rises = speeds.windows(2).all(|pair| pair[1] > 1.01 * pair[0].abs() + 1e-9);
        Check::new(condition, rises, series("speed in mm/s", &labels, &speeds))
    };
    let hz = MEASURED_HZ[1];
    let mut checks = vec![
        check(
            "pure travelling wave, half of each wave in contact at 60 V, 40 kHz",
            VOLTAGES_V.map(|v| no_load_mm_per_s(hz, v, HALF_CONTACT_PRESSURE)),
        ),
        check(
            "pure travelling wave, rotor in contact everywhere, 40 kHz",
            VOLTAGES_V.map(|v| no_load_mm_per_s(hz, v, FULL_CONTACT_PRESSURE)),
        ),
        check("standing wave: backward wave equal to the forward wave", VOLTAGES_V.map(|v| drag(1.0) * crest_mm_per_s(hz, v))),
    ];
    let field = VOLTAGE_V / THICKNESS_M / DEPOLARISING_V_PER_M;
    checks[0].numbers.push(number("field at 60 V over that of depolarisation", field));
    checks[0].numbers.push(number("d33 V at 60 V [nm]", 1e9 * D33_M_PER_V * VOLTAGE_V));
    Claim { id: "voltage-raises-speed", section: "B.7", says: "The higher the voltage, the faster the rotor turns.", checks }
}

fn opposing() -> Claim {
    let check = |condition: &str, name: &str, drag: f64, mut numbers: Vec<(String, f64)>| {
        numbers.insert(0, number(name, drag));
        Check::new(condition, drag.abs() > 0.01, numbers)
    };
    let towards = "drag towards the stronger wave's source over a w z k";
    // One wave left of the axis, its opposite right of it: forces cancel, moments add.
    let (left, right) = (drag(0.0), -drag(0.0));
    let net = vec![number("net drag on the axis", 0.5 * (left + right))];
    Claim {
        id: "opposing-waves-turn",
        section: "B.7",
        says: "If travelling waves oppose each other at a distance, the washer is set in motion.",
        checks: vec![
            check("on one line, equal", towards, drag(1.0), vec![]),
            check("on one line, one half as large", towards, drag(0.5), vec![]),
            check("side by side, left and right of the washer's axis", "drag at the rim over a w z k", 0.5 * (left - right), net),
        ],
    }
}

fn friction() -> Claim {
    let contact = Contact::loaded(HALF_CONTACT_PRESSURE);
    let mus = [0.1, 0.2, 0.3];
    let labels = mus.map(|mu| format!("mu {mu}"));
    let speeds = |force_over_load: f64| mus.map(|mu| contact.speed(force_over_load / mu).unwrap_or(0.0));
    let check = |condition: &str, force_over_load: f64| {
        let speeds = speeds(force_over_load);
        Check::new(condition, sweep::rises(&speeds), series("speed over the crest's", &labels, &speeds))
    };
    Claim {
        id: "friction-prevents-slip",
        section: "B.8",
        says: "A high coefficient of friction between stator and rotor prevents slip: the rotor is faster.",
        checks: vec![check("braked with a twentieth of the pressing force", 0.05), check("without load", 0.0)],
    }
}

fn torque() -> Claim {
    let [hole, outer, thick] = WASHER_M;
    let weight_n = std::f64::consts::FRAC_PI_4 * (outer * outer - hole * hole) * thick * STEEL_KG_PER_M3 * GRAVITY_M_PER_S2;
    let radius_m = 0.25 * (outer + hole);
    let check = |condition: &str, pressed_n: f64| {
        let torque = MU * pressed_n * radius_m;
        let speed = 1e-3 * crest_mm_per_s(MEASURED_HZ[1], VOLTAGE_V);
        let numbers = vec![
            number("pressing force [N]", pressed_n),
            number("largest torque [mN m]", 1e3 * torque),
            number("crest's speed at 20 nm, 40 kHz [rev/min]", 60.0 * speed / (std::f64::consts::TAU * radius_m)),
            number("largest power, torque times speed [mW]", 1e3 * MU * pressed_n * speed),
        ];
        Check::new(condition, torque < LOW_TORQUE_N_M, numbers)
    };
    Claim {
        id: "low-torque",
        section: "B.8",
        says: "These motors suit low torque (below 1 mN m).",
        checks: vec![
            check("steel washer for M16 under its own weight, mu 0.1", weight_n),
            check("steel washer for M16 pressed on with 100 N, mu 0.1", PRESSED_N),
        ],
    }
}
