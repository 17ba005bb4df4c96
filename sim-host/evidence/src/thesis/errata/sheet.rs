//! Contradictions about the sheet of appendix B and its electrodes.

use std::f64::consts::TAU;

use super::Erratum;
use crate::thesis::claim::{Check, number};
use crate::thesis::motor::{
    DENSITY_5A_KG_PER_M3, DENSITY_5H_KG_PER_M3, DENSITY_KG_PER_M3, DENSITY_SIMULATED_KG_PER_M3, MEASURED_HZ, Pattern, Sheet,
};

/// Returns the contradictions in the values of the sheet.
pub fn errata() -> Vec<Erratum> {
    vec![material(), density(), pattern()]
}

fn material() -> Erratum {
    let off = |density: f64| (DENSITY_SIMULATED_KG_PER_M3 / density - 1.0).abs();
    let numbers = vec![
        number("density of Table B.1 [kg/m^3]", DENSITY_SIMULATED_KG_PER_M3),
        number("of PZT-5A, from the literature", DENSITY_5A_KG_PER_M3),
        number("of PZT-5H", DENSITY_5H_KG_PER_M3),
    ];
    Erratum {
        id: "sheet-material",
        places: "B.3, against Table B.1 and B.4",
        printed: "The simulated sheet is PZT-5H.",
        instead: "PZT-5A: the simulation has its density, and the prototype is made of it.",
        evidence: Check::new("densities", off(DENSITY_5A_KG_PER_M3) < 0.01 && off(DENSITY_5H_KG_PER_M3) > 0.03, numbers),
    }
}

fn density() -> Erratum {
    let simulated = Sheet { density_kg_per_m3: DENSITY_SIMULATED_KG_PER_M3, ..Sheet::BEAM };
    let [k, other] = [Sheet::BEAM, simulated].map(|sheet| sheet.wave_number(MEASURED_HZ[1]));
    let numbers = vec![
        number("Figure B.8 [kg/m^3]", DENSITY_KG_PER_M3),
        number("Table B.1", DENSITY_SIMULATED_KG_PER_M3),
        number("k by B.12 at 40 kHz, Figure B.8 [rad/m]", k),
        number("Table B.1", other),
    ];
    Erratum {
        id: "sheet-density",
        places: "Table B.1, against Figure B.8",
        printed: "7750 kg/m^3 in the simulation of a sheet of 7800 kg/m^3.",
        instead: "7800 kg/m^3 for this sheet; the wave number changes by 0.2 % only.",
        evidence: Check::new("densities", DENSITY_KG_PER_M3 > 1.005 * DENSITY_SIMULATED_KG_PER_M3, numbers),
    }
}

fn pattern() -> Erratum {
    let asked = Pattern::PRINTED.wave_number();
    let wave_mm = |k: f64| 1e3 * TAU / k;
    let [low, high] = MEASURED_HZ.map(|hz| Sheet::BEAM.wave_number(hz));
    let numbers = vec![
        number("four tabs [mm]", wave_mm(asked)),
        number("bending wave at 20 kHz [mm]", wave_mm(low)),
        number("at 40 kHz [mm]", wave_mm(high)),
        number("frequency of a wave of four tabs, beam [Hz]", Sheet::BEAM.frequency_hz(asked)),
        number("plate [Hz]", Sheet::PLATE.frequency_hz(asked)),
    ];
    // Twelve tabs in phase do not excite waves off by a third of their wave number: the first zero
    // of their transform.
    let fits = |k: f64| (k / asked - 1.0).abs() < 1.0 / 3.0;
    Erratum {
        id: "tabs-and-wave",
        places: "B.4.1, B.4.2 and B.5, against B.12",
        printed: "Twelve tabs 6.08 mm apart, signals a quarter period apart, driven at 20 and 40 kHz.",
        instead: "Four such tabs are one wave length at 9 kHz; the waves at 20 and 40 kHz are two thirds and half as long.",
        evidence: Check::new("B.12 with Figure B.8", !fits(low) && !fits(high), numbers),
    }
}
