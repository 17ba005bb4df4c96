//! Causes of the erratic mode shapes (B.6): the thesis's two reasons, and four that it does not
//! name, on one scale.
//!
//! The scale is the weaker of two opposite waves over the stronger. Above a third, the amplitude
//! varies more than twofold along the sheet, which no longer looks like a travelling wave.

use super::backward::{AMPLIFIER_DEG, StandingWaveErrors, standing_wave_ratio};
use super::charge::{Electrode, travel_s};
use super::electrodes::{Pattern, SignalOrder, TRAVELLING_RATIO};
use super::sheet::{QUALITY, SIDE_M, Sheet};
use super::{MEASURED_HZ, plate};
use crate::thesis::claim::{Check, Claim, number};
use crate::thesis::picture::{dashed, figure as draw, line, ranged};
use crate::thesis::sweep;
use report::{Figure, Marker};

/// Largest assumed resistivity of a thin sputtered film over that of bulk nickel.
const THIN_FILM_RESISTIVITY: f64 = 3.0;
/// Relative imbalance of the two standing waves, in addition to the phase error.
const IMBALANCE_REL: f64 = 0.1;

/// Returns the wave reflected from the far edge over the incident wave, at the middle of the sheet.
/// Bending waves decay by `exp(-k x/(4 Q))`, and a free edge reflects all.
fn from_the_edge(frequency_hz: f64) -> f64 {
    (-Sheet::BEAM.wave_number(frequency_hz) * SIDE_M / (4.0 * QUALITY)).exp()
}

/// Converts a delay to degrees.
fn degrees(frequency_hz: f64, delay_s: f64) -> f64 {
    360.0 * frequency_hz * delay_s
}

/// Draws each cause over frequency.
pub fn figure() -> Figure {
    let khz = sweep::spaced(2.0, 50.0, 481);
    let of = |value: &dyn Fn(f64) -> f64| khz.iter().map(|khz| value(1e3 * khz)).collect::<Vec<_>>();
    let tab = Electrode::tab(THIN_FILM_RESISTIVITY);
    let pattern = |hz: f64| Pattern::PRINTED.weaker_over_stronger(Sheet::BEAM.wave_number(hz));
    let series = vec![
        line("tabs that do not fit the wave", "pattern", &khz, of(&pattern)),
        line("far edge", "edge", &khz, of(&from_the_edge)),
        dashed(
            "amplifier, 10 degrees",
            "amplifier_10_deg",
            &khz,
            of(&|_| StandingWaveErrors::degrees(AMPLIFIER_DEG[1]).backward()),
        ),
        dashed("charge along a tab", "charge", &khz, of(&|hz| StandingWaveErrors::degrees(tab.lag_deg(hz)).backward())),
    ];
    let caption = "The weaker of two opposite waves over the stronger, for each cause. Tabs: each a quarter period after \
                   the last, endless sheet. Far edge: free, Q 80, at the middle of the sheet. Charge: nickel of 1000 \
                   angstroms with three times the resistivity of bulk; as an upper bound, the whole lag of a tab's far end \
                   counts as an error between tabs. Above the line the amplitude varies more than twofold."
        .into();
    let axes = [ranged("frequency [kHz]", 0.0, 50.0), ranged("weaker over stronger wave", 0.0, 1.0)];
    let mut drawn = draw("app-b-causes", "Appendix B.6: causes that disturb a travelling wave", caption, axes, series);
    drawn.hlines = vec![(TRAVELLING_RATIO, "amplitude varies twofold".into())];
    drawn.markers = MEASURED_HZ.map(|hz| Marker { x: hz / 1e3, y: pattern(hz), label: format!("{:.2}", pattern(hz)) }).to_vec();
    drawn
}

/// Judges the claims about the shapes of the waves.
pub fn claims() -> Vec<Claim> {
    vec![charge(), amplifier(), erratic()]
}

/// Checks if a backward wave is large enough to make the shapes erratic.
fn spoils(condition: impl Into<String>, backward: f64, mut numbers: Vec<(String, f64)>) -> Check {
    numbers.insert(0, number("weaker over stronger wave", backward));
    Check::new(condition, backward > TRAVELLING_RATIO, numbers)
}

fn charge() -> Claim {
    let at = MEASURED_HZ[1];
    let electrode = |condition: &str, electrode: Electrode| {
        let lag = electrode.lag_deg(at);
        let numbers = vec![
            number("resistance [ohm]", electrode.ohm()),
            number("capacitance [nF]", 1e9 * electrode.farad()),
            number("lag of the far end [deg]", lag),
            number("voltage at the far end over that at the feed", electrode.far_end(at).norm()),
        ];
        spoils(condition, StandingWaveErrors::degrees(lag).backward(), numbers)
    };
    let light = degrees(at, travel_s());
    let numbers = vec![number("time along the sheet [ns]", 1e9 * travel_s()), number("lag [deg]", light)];
    Claim {
        id: "charge-makes-erratic",
        section: "B.6",
        says: "Charge needs a finite time through the electrode, so the shapes are erratic (amplitude varying more than \
               twofold).",
        checks: vec![
            electrode("a tab fed at its end, bulk nickel, 40 kHz", Electrode::tab(1.0)),
            electrode("a tab fed at its end, three times the resistivity, 40 kHz", Electrode::tab(THIN_FILM_RESISTIVITY)),
            electrode(
                "the whole face fed along an edge, three times the resistivity, 40 kHz",
                Electrode::whole(THIN_FILM_RESISTIVITY),
            ),
            spoils("light through the ceramic, 40 kHz", StandingWaveErrors::degrees(light).backward(), numbers),
        ],
    }
}

fn amplifier() -> Claim {
    let check = |condition: String, errors: StandingWaveErrors| {
        let numbers = [
            errors.numbers("closed form"),
            vec![number("largest over smallest amplitude", standing_wave_ratio(errors.backward()))],
        ]
        .concat();
        spoils(condition, errors.backward(), numbers)
    };
    let [low, high] = AMPLIFIER_DEG;
    Claim {
        id: "amplifier-makes-erratic",
        section: "B.6",
        says: "The amplifier's phase shift of 5 to 10 degrees makes the shapes erratic (amplitude varying more than twofold).",
        checks: vec![
            check(format!("{low} degrees"), StandingWaveErrors::degrees(low)),
            check(format!("{high} degrees"), StandingWaveErrors::degrees(high)),
            check(
                "10 degrees, and one standing wave 10 % too large".into(),
                StandingWaveErrors { gain: IMBALANCE_REL, ..StandingWaveErrors::degrees(high) },
            ),
        ],
    }
}

fn erratic() -> Claim {
    let mut checks = Vec::new();
    for order in [SignalOrder::FourPhase, SignalOrder::TwoGroups] {
        let pattern = Pattern { order, ..Pattern::PRINTED };
        for hz in MEASURED_HZ {
            let [beam, wide] = [Sheet::BEAM, Sheet::PLATE].map(|sheet| pattern.weaker_over_stronger(sheet.wave_number(hz)));
            let condition = format!("tabs that do not fit the wave, {}, {} kHz", order.words(), hz / 1e3);
            checks.push(spoils(condition, beam.min(wide), vec![number("as beam", beam), number("as plate", wide)]));
        }
    }
    for hz in MEASURED_HZ {
        let condition = format!("free far edge, Q 80, {} kHz", hz / 1e3);
        checks.push(spoils(condition, from_the_edge(hz), vec![]));
    }
    for hz in MEASURED_HZ {
        let overlap = plate::overlap(hz);
        let band = 0.1 * hz;
        let density = plate::density_per_hz(&Sheet::PLATE, SIDE_M);
        let numbers = vec![
            number("bending modes within f/Q", overlap),
            number("within 10 % of f, by density", 2.0 * band * density),
            number("within 10 % of f, counted by Warburton", plate::counted(hz - band, hz + band) as f64),
        ];
        let condition = format!("resonances of the square sheet overlap (one or more within f/Q), {} kHz", hz / 1e3);
        checks.push(Check::new(condition, overlap >= 1.0, numbers));
    }
    Claim {
        id: "shapes-are-erratic",
        section: "B.6",
        says: "On this sheet the shapes are erratic, and there are several waves (amplitude varying more than twofold).",
        checks,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_wave_from_the_edge_decays_with_q() {
        // With an energy loss of 1/Q per radian the amplitude falls by exp(-w t/(2 Q)); bending
        // energy travels at twice the phase speed.
        let (hz, sheet) = (40e3, Sheet::BEAM);
        let omega = std::f64::consts::TAU * hz;
        let group = 2.0 * omega / sheet.wave_number(hz);
        let expected = (-omega * SIDE_M / group / (2.0 * QUALITY)).exp();
        assert!((from_the_edge(hz) - expected).abs() < 1e-12);
    }
}
