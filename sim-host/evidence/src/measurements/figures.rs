//! Figures: measured points and the curves of the models.

use super::Findings;
use super::across::empirical_percent;
use super::belt;
use super::data::Datum;
use super::laws::transverse;
use crate::thesis::experiment_1::LOADS_N as RAIL_N;
use crate::thesis::experiment_2::compliant::{Belt, Pin};
use crate::thesis::experiment_2::normal;
use crate::thesis::picture::{axis, dashed, figure, line, log_axis, ranged};
use crate::thesis::sweep::{geometric, spaced};
use contact::Shape;
use contact::closed::coulomb_friction_ratio;
use contact::compliant::{friction_ratio, popov_ratio};
use contact::hertz::contact_loss_threshold;
use report::{Figure, Marker, Series, Style};
use sim::instruments::belt::law::{AMPLITUDES, Curve, LOADS_N, POINTS};

const REDUCTION: &str = "reduction [%]";

/// Returns a series of separate dots.
fn points(name: &str, column: &str, x: Vec<f64>, y: Vec<f64>) -> Series {
    Series { name: name.into(), csv_column: column.into(), x, y, style: Style::Points }
}

/// Draws all figures.
pub fn all(found: &Findings) -> Vec<Figure> {
    vec![pin(found), belt(found), rail(found), directions(found), parting(found), popov()]
}

/// Returns the number of a datum, if it has one.
fn value(found: &Findings, id: &str) -> Option<f64> {
    let mut data = found.sources.iter().flat_map(|source| &source.data);
    data.find(|datum: &&Datum| datum.id == id).and_then(|datum| datum.value)
}

fn pin(found: &Findings) -> Figure {
    let pin = Pin::measured();
    let speed = geometric(1e-3, 1.0, 241);
    let of = |law: &dyn Fn(f64) -> f64| speed.iter().map(|&speed| law(speed)).collect::<Vec<_>>();
    let mm: Vec<f64> = speed.iter().map(|speed| 1e3 * speed).collect();
    let hertz = 100.0 * normal::reduction(normal::ratio_for(0.01 * POINTS[2].percent));
    let closed =
        |speed: f64| popov_ratio(pin.indentations, speed / pin.critical_m_per_s).map_or(f64::NAN, |ratio| 100.0 * (1.0 - ratio));
    let data: Vec<(f64, Option<f64>)> =
        found.sources.iter().flat_map(|source| &source.data).filter_map(|datum| Some((datum.at?, datum.value))).collect();
    let (x, y) = data.iter().filter_map(|&(speed, percent)| Some((1e3 * speed, percent?))).unzip();
    let series = vec![
        line("compliant contact, FITTED to both points", "compliant_percent", &mm, of(&|speed| pin.percent(speed))),
        dashed("the paper's closed form", "closed_form_percent", &mm, of(&closed)),
        line("empirical law, FITTED to both points", "empirical_percent", &mm, of(&empirical_percent)),
        line("Hertz's mean area, FITTED to the first", "hertz_percent", &mm, of(&|_| hertz)),
        points("measured (JoVE 52931)", "measured_percent", x, y),
    ];
    let open = |&(speed, percent): &(f64, Option<f64>)| {
        let by = pin.percent(speed);
        percent.is_none().then(|| Marker { x: 1e3 * speed, y: by, label: format!("open: {by:.1} %") })
    };
    let caption = "A pin on a disc, 22 kHz across the contact. Two laws with two parameters each pass through the two \
                   numbers that were read. At 40.6 mm/s, which was measured but whose number was not available, they differ \
                   by four percentage points. Above 260 mm/s, which was not measured, one law predicts no reduction and the \
                   other a tenth.";
    Figure {
        markers: data.iter().filter_map(open).collect(),
        ..figure(
            "pin-over-speed",
            "Friction reduction of a pin on a disc over sliding speed",
            caption.into(),
            [log_axis("sliding speed [mm/s]"), ranged(REDUCTION, 0.0, 85.0)],
            series,
        )
    }
}

fn belt(found: &Findings) -> Figure {
    let load = spaced(200.0, 800.0, 121);
    let of = |curve: &Curve| load.iter().map(|&load| curve.percent(load, AMPLITUDES[1], 2.0)).collect::<Vec<_>>();
    let mut series = vec![
        line("empirical law, FITTED", "empirical_percent", &load, of(&Curve::fitted())),
        dashed("Hertz's mean area, FITTED to 58 %", "hertz_percent", &load, of(&belt::hertz())),
    ];
    series.extend(
        Belt::measured().map(|belt| line("compliant contact, FITTED to both", "compliant_percent", &load, of(&belt.curve()))),
    );
    let stated = [("belt-58", LOADS_N[0]), ("belt-55", LOADS_N[2])];
    let (x, y) = stated.iter().filter_map(|&(id, load)| Some((load, value(found, id)?))).unzip();
    series.push(points("stated by the thesis", "stated_percent", x, y));
    let caption = "Experiment 2 at 70 % amplitude after 2 s. Hertz's contact, fitted to 58 % at 270 N, predicts 55 % at 670 \
                   N. The compliant contact, fitted to both, rises between them, which contradicts the thesis.";
    figure(
        "belt-over-load",
        "Friction reduction of the belt over load",
        caption.into(),
        [axis("load [N]"), ranged(REDUCTION, 50.0, 64.0)],
        series,
    )
}

fn rail(found: &Findings) -> Figure {
    let series = vec![
        line("0.038 m/s, nothing fitted", "slow_percent", &RAIL_N, found.rail.slow.clone()),
        line("0.068 m/s, nothing fitted", "fast_percent", &RAIL_N, found.rail.fast.clone()),
        dashed("0.038 m/s, FITTED", "fitted_percent", &RAIL_N, found.rail.fitted.clone()),
    ];
    let stated = value(found, "rail-68").map(|percent| (percent, format!("up to {percent} % (thesis)")));
    let caption = "Experiment 1, as in its scenes. The contact of Table 4.1 reproduces the thesis's 68 % but hardly falls \
                   with load; a stiffer contact on a slower tip, FITTED, does both.";
    Figure {
        hlines: stated.into_iter().collect(),
        ..figure(
            "rail-over-load",
            "Friction reduction of experiment 1 over load",
            caption.into(),
            [axis("load [N]"), ranged(REDUCTION, 0.0, 80.0)],
            series,
        )
    }
}

fn directions(found: &Findings) -> Figure {
    let z = geometric(0.02, 4.0, 1601);
    let of = |law: fn(f64) -> f64| z.iter().map(|&z| law(z)).collect::<Vec<_>>();
    let bristles = |id: &str| -> (Vec<f64>, Vec<f64>) {
        let rows = found.laws.iter().find(|(law, _)| law.id == id).map(|(_, rows)| rows.as_slice()).unwrap_or_default();
        rows.iter().filter_map(|row| Some((row.at, row.models.last()?.1))).unzip()
    };
    let (along, across) = (bristles("longitudinal"), bristles("transverse"));
    let series = vec![
        line("along, (2/pi) asin z", "along_law", &z, of(coulomb_friction_ratio)),
        points("along, bristles", "along_bristles", along.0, along.1),
        line("across, elliptic integral", "across_law", &z, of(transverse)),
        points("across, bristles", "across_bristles", across.0, across.1),
    ];
    let caption = "Laws, no measurements. Lines: formulas. Dots: Dahl's bristles of 1e-13 of the amplitude, solved in one \
                   and in two dimensions.";
    figure(
        "laws-in-the-plane",
        "Vibration along and across the sliding",
        caption.into(),
        [log_axis("velocity ratio z"), ranged("friction ratio", 0.0, 1.1)],
        series,
    )
}

fn parting(found: &Findings) -> Figure {
    let threshold = contact_loss_threshold(Shape::Sine).unwrap_or(f64::NAN);
    let ratio = spaced(0.0, 2.0, 201);
    let of = |law: &dyn Fn(f64) -> f64| ratio.iter().map(|&ratio| 100.0 * law(ratio)).collect::<Vec<_>>();
    let compliant = |speed: f64| move |ratio: f64| 1.0 - friction_ratio(ratio, speed, true);
    let series = vec![
        line("Hertz's mean area", "hertz_percent", &ratio, of(&normal::reduction)),
        line("compliant contact, slowly", "compliant_0_percent", &ratio, of(&compliant(0.0))),
        line("compliant contact, a third of the critical speed", "compliant_third_percent", &ratio, of(&compliant(1.0 / 3.0))),
        dashed("compliant contact, nine tenths of it", "compliant_nine_tenths_percent", &ratio, of(&compliant(0.9))),
    ];
    let about = value(found, "hertz-10").map(|percent| (percent, format!("about {percent} % (Hess and Soom)")));
    let caption = "Vibration across the contact until contact is lost, for Hertz's contact at 0.885 and for the compliant \
                   contact at 1. Hess and Soom: before this, about ten per cent at most. Dinelli and others: at a tip of \
                   nanometres friction vanishes when contact is lost, and falls well before. The mean of Hertz's area \
                   cannot reproduce this; the compliant contact can, in proportion to the amplitude, if it slides slowly.";
    Figure {
        markers: vec![Marker { x: threshold, y: 100.0 * normal::reduction(threshold), label: "Hertz: contact lost".into() }],
        hlines: about.into_iter().collect(),
        ..figure(
            "until-contact-is-lost",
            "Vibration across the contact until contact is lost",
            caption.into(),
            [axis("amplitude over static deflection"), ranged(REDUCTION, 0.0, 110.0)],
            series,
        )
    }
}

fn popov() -> Figure {
    let speed = spaced(0.0, 1.2, 121);
    let of = |law: &dyn Fn(f64) -> f64| speed.iter().map(|&speed| law(speed)).collect::<Vec<_>>();
    let model = |indentations: f64| move |speed: f64| friction_ratio(indentations, speed, true);
    let closed = |indentations: f64| move |speed: f64| popov_ratio(indentations, speed).unwrap_or(f64::NAN);
    let series = vec![
        line("A = 1, arcs", "arcs_1", &speed, of(&model(1.0))),
        dashed("A = 1, closed form", "closed_1", &speed, of(&closed(1.0))),
        line("A = 0.5, arcs", "arcs_half", &speed, of(&model(0.5))),
        dashed("A = 0.5, closed form", "closed_half", &speed, of(&closed(0.5))),
        line("A = 10, constant load", "arcs_10", &speed, of(&model(10.0))),
    ];
    let caption = "Laws, no measurements. The closed form approximates its own model within 0.0144. At and above the \
                   critical speed there is no reduction. If the mean position is a gap (A = 10), the model's critical speed \
                   is lower than the formula's.";
    figure(
        "popov-critical-speed",
        "Friction ratio of a compliant contact over sliding speed",
        caption.into(),
        [axis("sliding speed over mu kz w a / kx"), ranged("friction ratio", 0.0, 1.1)],
        series,
    )
}
