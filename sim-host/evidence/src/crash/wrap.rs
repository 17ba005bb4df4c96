//! The friction along the wrap of the D-ring: tension ratios by direction, angle and speed, and the
//! possible effect of the normal part of the vibration.
//!
//! ```text
//! direction, wrap, speed --> law along the wrap (contact::wrap) --> tension ratio, friction lost      docs/evidence/dring.md
//! direction --> the crash on the plant alone, switched by a clock --> peak force, excursion
//! ```

use super::plant;
use super::scheduled::crash;
use crate::campaign::{cells, columns};
use crate::evidence::Error;
use crate::thesis::Belt;
use contact::SolveError;
use contact::wrap::normal::{FULL_M, Normal, NormalPart, Stiffnesses};
use contact::wrap::ode::Sliding;
use contact::wrap::{Pull, Ring};
use plant::dring::motion::Extremes;
use report::TableBlock;
use std::f64::consts::TAU;

const MU: f64 = 0.3;
const MU_LOW: f64 = 0.13;
const TIP_M_PER_S: f64 = 5.0;
const HZ: f64 = 20e3;
const RADIUS_M: f64 = 8e-3;
/// Force of the load limiter, N; it is the lower tension while the limiter yields.
const LIMITER_N: f64 = 2200.0;
const WRAPS_DEG: [f64; 4] = [90.0, 120.0, 150.0, 180.0];
/// Ratio of the tangential to the normal stiffness of a half-space of Poisson's ratio 0.3,
/// `(2 - 2 nu) / (2 - nu)`.
const HALF_SPACE: f64 = 0.8235;

/// A direction of the vibration: its name, and its angles in the plane and out of it, degrees, as a
/// function of the wrap angle.
type Direction = (&'static str, fn(f64) -> (f64, f64));

const DIRECTIONS: [Direction; 4] = [
    ("radial at the middle", |_| (0.0, 0.0)),
    ("along the webbing at the middle", |_| (90.0, 0.0)),
    ("along the webbing at the exit to the shoulder", |wrap_deg| (90.0 + 0.5 * wrap_deg, 0.0)),
    ("along the ring's axis", |_| (0.0, 90.0)),
];

/// Maps an angle into the range of the scene's key; opposite directions are equal.
fn in_range(angle_deg: f64) -> f64 {
    if angle_deg > 180.0 { angle_deg - 180.0 } else { angle_deg }
}

/// Returns the lost part of the tension that friction adds, %, for a mean exponent.
fn lost_percent(exponent: f64, ring: &Ring) -> f64 {
    let off = (ring.mu * ring.wrap_rad).exp_m1();
    // A loss below zero is round-off.
    (100.0 * (1.0 - exponent.exp_m1() / off)).max(0.0)
}

fn ring(wrap_deg: f64, mu_low: f64, direction: (f64, f64)) -> Result<Ring, SolveError> {
    Ring::new(wrap_deg, MU, mu_low / MU, direction)
}

/// Returns the tension ratios with the in-surface part of the vibration.
fn by_direction() -> Result<TableBlock, SolveError> {
    let mut rows = Vec::new();
    for wrap_deg in WRAPS_DEG {
        for (name, direction) in DIRECTIONS {
            let ring = ring(wrap_deg, MU_LOW, direction(wrap_deg))?;
            let mut row = vec![format!("{wrap_deg:.0}"), name.to_owned(), format!("{:.3}", (MU * ring.wrap_rad).exp())];
            for speed in [0.025, 1.5, 3.0, 4.5] {
                let exponent = MU * ring.exponent(speed / TIP_M_PER_S, None, Pull::Shoulder).in_surface_rad;
                row.push(format!("{:.3} ({:.0})", exponent.exp(), lost_percent(exponent, &ring)));
            }
            rows.push(row);
        }
        let even = |mu: f64| mu * wrap_deg.to_radians();
        let whole = ring(wrap_deg, MU_LOW, (0.0, 0.0))?;
        let mut row =
            vec![format!("{wrap_deg:.0}"), "one coefficient for the wrap, tip along it".into(), format!("{:.3}", even(MU).exp())];
        for speed in [0.025f64, 1.5, 3.0, 4.5] {
            let ratio = (2.0 / std::f64::consts::PI * (speed / TIP_M_PER_S).min(1.0).asin()).max(MU_LOW / MU);
            row.push(format!("{:.3} ({:.0})", even(ratio * MU).exp(), lost_percent(even(ratio * MU), &whole)));
        }
        rows.push(row);
    }
    let caption = "Shoulder over retractor, and in brackets the lost part of the force that the D-ring adds, %. A ring of 5 m/s, \
                   mu 0.3, lowered to no less than 0.13 at any place; the vibration across the webbing is assumed to have no \
                   effect. The last row of each wrap is the model without a direction (actuator `tangential`).";
    let header = ["wrap [degrees]", "direction of the vibration", "OFF", "25 mm/s", "1.5 m/s", "3 m/s", "4.5 m/s"];
    Ok(TableBlock::new("ring-direction", "Tension ratio by the direction of the ring's vibration", caption, &header, rows))
}

/// Returns the assumptions about the normal part, with their names; without those of the belt if no
/// stiffness fits.
fn normal_parts(normal: Normal) -> Vec<(&'static str, NormalPart)> {
    let mut parts = vec![("no effect", NormalPart::None), ("the fitted law", NormalPart::Fitted(normal))];
    if let Some(belt) = Belt::measured() {
        let stiff = |tangential_n_per_m: f64| Stiffnesses { normal_n_per_m: belt.normal_n_per_m, tangential_n_per_m };
        parts.push((
            "a compliant contact, both stiffnesses through the belt",
            NormalPart::Compliant(normal, stiff(belt.tangential_n_per_m)),
        ));
        parts.push((
            "a compliant contact of a half-space",
            NormalPart::Compliant(normal, stiff(HALF_SPACE * belt.normal_n_per_m)),
        ));
    }
    parts
}

/// Returns the table of the possible effect of the normal part in the crash.
fn normal_part() -> Result<TableBlock, SolveError> {
    let normal = Normal { amplitude_m: TIP_M_PER_S / (TAU * HZ), radius_m: RADIUS_M };
    let mut rows = Vec::new();
    for (place, direction) in [("radial", (0.0, 0.0)), ("along, middle", (90.0, 0.0))] {
        let ring = ring(150.0, MU_LOW, direction)?;
        for (name, part) in normal_parts(normal) {
            let mut row = vec![place.to_owned(), name.to_owned()];
            for (speed_m_per_s, low_n) in [(0.025, 216.0), (0.1, LIMITER_N), (0.5, LIMITER_N), (1.5, LIMITER_N), (3.0, LIMITER_N)]
            {
                let sliding =
                    Sliding { speed_m_per_s, tip_m_per_s: TIP_M_PER_S, hz: HZ, low_n, pull: Pull::Shoulder, in_surface: true };
                row.push(format!("{:.3}", ring.tension_exponent(&part, &sliding).0.exp()));
            }
            rows.push(row);
        }
    }
    let caption = "Shoulder over retractor at 150 degrees (2.193 OFF), of a ring of 5 m/s and 20 kHz with a radius of 8 mm \
                   (ASSUMED), mu 0.3 lowered to no less than 0.13 by the in-surface part. The first row of each direction, \
                   without an effect of the vibration across the webbing, and the others, in which its effect multiplies, are \
                   the bounds. The third has an implausible tangential stiffness; the fourth contradicts the belt of experiment \
                   2 (docs/evidence/experiment-2.md).";
    let header = columns(
        "direction | assumed effect across the webbing | 25 mm/s, 216 N | 0.1 m/s, 2.2 kN | 0.5 m/s, 2.2 kN | 1.5 m/s, 2.2 kN | \
         3 m/s, 2.2 kN",
    );
    Ok(TableBlock::new("ring-normal", "Possible effect of the vibration across the webbing", caption, &header, rows))
}

/// Returns the table of the horn of experiment 2 as a ring.
fn belt() -> Result<TableBlock, SolveError> {
    let amplitude_m = 0.7 * FULL_M;
    let (tip_m_per_s, speed_m_per_s) = (TAU * HZ * amplitude_m, 0.025);
    let normal = Normal { amplitude_m, radius_m: RADIUS_M };
    // The tension at which a face of the horn is under 270 N.
    let low_n = 270.0 / normal.load_n(1.0);
    let mut rows = Vec::new();
    for wrap_deg in WRAPS_DEG {
        let ring = ring(wrap_deg, 0.0, (0.0, 0.0))?;
        let of = |part: NormalPart, in_surface: bool| {
            let sliding = Sliding { speed_m_per_s, tip_m_per_s, hz: HZ, low_n, pull: Pull::Shoulder, in_surface };
            format!("{:.3}", ring.tension_exponent(&part, &sliding).0.exp())
        };
        let fitted = NormalPart::Fitted(normal);
        // One coefficient: the effect at the middle of the wrap applies everywhere, at the lower
        // tension.
        let one = MU * ring.wrap_rad * fitted.ratio(1.0, low_n, speed_m_per_s, MU, HZ);
        rows.push(vec![
            format!("{wrap_deg:.0}"),
            format!("{:.3}", (MU * ring.wrap_rad).exp()),
            format!("{:.3}", one.exp()),
            of(fitted, false),
            of(NormalPart::None, true),
            of(fitted, true),
        ]);
    }
    let caption = "Shoulder over retractor if the horn of experiment 2 (20 kHz, 59.5 um, 7.5 m/s) were the ring, radial at the \
                   middle of the wrap: 25 mm/s, mu 0.3 without a lower bound, radius 8 mm (ASSUMED), 216 N at the retractor, at \
                   which a face of the horn (ASSUMED 10 mm long) is under its 270 N. Half of the amplitude has the whole fitted \
                   effect (ASSUMED), so that the fitted law alone weakens only near the ends of the wrap.";
    let header = columns(
        "wrap [degrees] | OFF | one coefficient, 58 % less | fitted normal part alone | in-surface part alone | both, multiplied",
    );
    Ok(TableBlock::new("ring-belt", "The horn of experiment 2 as a D-ring", caption, &header, rows))
}

/// Returns the table of the crash on the plant alone, by direction.
fn crashes() -> Result<TableBlock, Error> {
    const LOW_S: f64 = 33.2e-3;
    const LENGTH_S: f64 = 0.16;
    let case = |name: &str, sets: &[String]| -> Result<Vec<String>, Error> {
        let (bench, edge_s) = plant(sets)?;
        let on = crash(&bench, edge_s, LENGTH_S, |since_s| since_s >= LOW_S, |_, _| ()).extremes();
        let off = crash(&bench, edge_s, LENGTH_S, |_| false, |_, _| ()).extremes();
        let Extremes { shoulder_n, excursion_m, payout_m_per_s, .. } = on;
        let less = 100.0 * (1.0 - shoulder_n / off.shoulder_n);
        let added_mm = 1e3 * (excursion_m - off.excursion_m);
        let [less, added_mm] = [less, added_mm].map(|value| format!("{value:.1}"));
        Ok(cells![name, format!("{shoulder_n:.0}"), less, added_mm, format!("{payout_m_per_s:.2}")])
    };
    let set = |key: &str, value: String| format!("rig.dring.{key}={value}");
    let mut rows =
        vec![case("one coefficient, tip along the wrap", &[set("actuator", "tangential".into())])?, case("ideal switch", &[])?];
    for (name, direction) in DIRECTIONS {
        let (angle_deg, axis_deg) = direction(150.0);
        let sets = [
            set("actuator", "ring".into()),
            set("ring_angle_deg", in_range(angle_deg).to_string()),
            set("ring_axis_deg", axis_deg.to_string()),
        ];
        rows.push(case(name, &sets)?);
        if axis_deg == 0.0 {
            rows.push(case(
                &format!("{name}, with the fitted normal part"),
                &[&sets[..], &[set("ring_normal_part", "fitted".into())]].concat(),
            )?);
        }
    }
    let caption = "A light occupant, 150 degrees, LOW after 33.2 ms by a clock, on the plant alone; the passive belt has 4825 N. \
                   The tip or ring is assumed to keep its 5 m/s under two thousand newtons.";
    let header = ["vibrating part and direction", "peak [N]", "less [%]", "added excursion [mm]", "payout up to [m/s]"];
    Ok(TableBlock::new("ring-crash", "The crash by the direction of the ring's vibration", caption, &header, rows))
}

/// Returns all tables of the wrap.
pub fn tables() -> Result<Vec<TableBlock>, Error> {
    Ok(vec![by_direction()?, normal_part()?, belt()?, crashes()?])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn docs_of_the_wrap_have_these_numbers() {
        let command = "cargo test -p sonoglide-evidence docs_of_the_wrap";
        report::docs::block("evidence/dring.md", command, &report::markdown(&tables().unwrap()));
    }

    /// One coefficient gives 1.22 for the horn on a wrap of 90 degrees; the normal part alone, by
    /// angle, gives more.
    #[test]
    fn one_coefficient_differs_from_the_law_along_the_wrap() {
        let belt = belt().unwrap();
        let number = |row: usize, column: usize| belt.rows[row][column].parse::<f64>().unwrap();
        assert!((number(0, 2) - 1.22).abs() < 0.01, "{}", number(0, 2));
        // At 150 degrees and more, the normal part is small near the ends of the wrap.
        assert!((0..4).all(|row| number(row, 3) >= number(row, 2) - 1e-3));
        assert!(number(3, 3) > number(3, 2) + 0.01, "{} {}", number(3, 3), number(3, 2));
    }
}
