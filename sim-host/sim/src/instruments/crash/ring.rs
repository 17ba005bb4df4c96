//! Friction along the wrap of a D-ring that vibrates as a whole.

use crate::instruments::curves::axis;
use contact::wrap::normal::NormalPart;
use plant::dring::crash::RingMoment;
use report::{Figure, Series, Style};

/// Number of steps between the points of a curve.
const CURVE_STEPS: u32 = 720;

/// Returns the figure of the friction coefficient along the wrap at the time of the fastest
/// sliding.
pub(super) fn figure(moment: &RingMoment) -> Figure {
    let ring = &moment.ring;
    let step_rad = ring.wrap_rad / f64::from(CURVE_STEPS);
    let places: Vec<f64> = (0..=CURVE_STEPS).map(|step| step_rad * f64::from(step)).collect();
    let coefficients = coefficients(moment, &places);
    let degrees: Vec<f64> = places.iter().map(|place| place.to_degrees()).collect();
    let mean = (moment.shoulder_n / moment.retractor_n).ln() / ring.wrap_rad;
    let even = |value: f64| vec![value; places.len()];
    let series = |name: &str, column: &str, y: Vec<f64>, style: Style| Series {
        name: name.into(),
        csv_column: column.into(),
        x: degrees.clone(),
        y,
        style,
    };
    Figure {
        id: "ring-friction".into(),
        title: "Friction along the wrap".into(),
        caption: format!(
            "The whole ring vibrates in one direction at {} m/s, and the webbing slides at {} m/s. Vibration along the webbing, \
             or along the ring's axis, lowers friction; vibration normal to the webbing does not. The force grows along the \
             wrap according to the mean.",
            crate::numbers::number(moment.tip_m_per_s),
            crate::numbers::number(moment.speed_m_per_s)
        ),
        x: axis("angle along the wrap, from the retractor [degrees]"),
        y: axis("coefficient of friction"),
        series: vec![
            series("with vibration", "coefficient", coefficients, Style::Line),
            series("its mean", "mean_coefficient", even(mean), Style::Dashed),
            series("without vibration", "passive_coefficient", even(ring.mu), Style::Dashed),
        ],
        interactive: true,
        ..Figure::default()
    }
}

/// Returns the coefficients at places in equal steps from the retractor on. The tension, on which a
/// fitted normal part depends by the power 0.06, is integrated from place to place.
fn coefficients(moment: &RingMoment, places: &[f64]) -> Vec<f64> {
    let ring = &moment.ring;
    let part = moment.normal.map_or(NormalPart::None, NormalPart::Fitted);
    let mut tension_n = moment.retractor_n;
    let mut before = None;
    let found = places.iter().map(|&from_retractor| {
        let place = from_retractor - 0.5 * ring.wrap_rad;
        let in_surface = ring.in_surface(place, moment.speed_m_per_s / moment.tip_m_per_s);
        // The fitted law does not depend on the frequency.
        let normal = part.ratio(ring.parts(place).normal, tension_n, moment.speed_m_per_s, ring.mu, 0.0);
        let coefficient = ring.mu * in_surface * normal;
        let step = before.map_or(0.0, |before| from_retractor - before);
        tension_n *= (coefficient * step).exp();
        before = Some(from_retractor);
        coefficient
    });
    found.collect()
}
