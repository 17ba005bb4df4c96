//! Equations whose sides have different units: the beam of appendix B, with all its equations
//! checked, and 4.13.

use super::Erratum;
use crate::thesis::claim::{Check, number};
use crate::thesis::motor::{MEASURED_HZ, Sheet};
use report::TableBlock;

/// Powers of kilogram, metre and second.
#[derive(Clone, Copy, PartialEq)]
struct Dimension([i32; 3]);

const DENSITY: Dimension = Dimension([1, -3, 0]);
const AREA: Dimension = Dimension([0, 2, 0]);
const LENGTH: Dimension = Dimension([0, 1, 0]);
const ACCELERATION: Dimension = Dimension([0, 1, -2]);
const FORCE: Dimension = Dimension([1, 1, -2]);
const TIME: Dimension = Dimension([0, 0, 1]);

impl Dimension {
    fn times(self, other: Dimension) -> Dimension {
        Dimension(std::array::from_fn(|i| self.0[i] + other.0[i]))
    }

    fn to(self, power: i32) -> Dimension {
        Dimension(self.0.map(|own| own * power))
    }

    /// Formats the dimension as a unit: `kg m s^-2`.
    fn unit(self) -> String {
        let part = |(name, power): (&str, i32)| match power {
            0 => None,
            1 => Some(name.to_owned()),
            _ => Some(format!("{name}^{power}")),
        };
        let parts: Vec<String> = ["kg", "m", "s"].into_iter().zip(self.0).filter_map(part).collect();
        if parts.is_empty() { "1".into() } else { parts.join(" ") }
    }

    fn over(self, other: Dimension) -> Dimension {
        Dimension(std::array::from_fn(|i| self.0[i] - other.0[i]))
    }
}

/// Equation of appendix B with the dimensions of its sides, or of two of its terms.
struct Equation {
    place: &'static str,
    printed: &'static str,
    left: Dimension,
    right: Dimension,
}

/// Returns B.1 to B.14 as printed. A stray `s` in B.9 is omitted; the section is A in B.1 and S in
/// B.12.
fn printed() -> Vec<Equation> {
    let inertia = DENSITY.times(AREA).times(LENGTH).times(ACCELERATION);
    let moment = FORCE.times(LENGTH);
    let per_length = FORCE.over(LENGTH);
    let bending = FORCE.times(AREA);
    let ratio = Dimension([0, 0, 0]);
    let equation = |place, printed, left, right| Equation { place, printed, left, right };
    vec![
        equation("B.1", "inertia force: rho A dx w''", inertia, FORCE),
        equation("B.2", "-(V + dV) + f dx + V = rho A dx w''", FORCE, inertia),
        equation("B.3", "(M + dM) - (V + dV) dx + f dx dx/2 - M = 0", moment, FORCE.times(LENGTH)),
        equation("B.4", "dV = (dV/dx) dx, dM = (dM/dx) dx", FORCE, per_length.times(LENGTH)),
        equation("B.5", "dV/dx + f = rho A dx w''", per_length, inertia),
        equation("B.6", "(dM/dx) dx - V = 0", moment.over(LENGTH).times(LENGTH), FORCE),
        equation("before B.7", "V = dV/dx", FORCE, per_length),
        equation("B.7", "-d2M/dx2 + f = rho A dx w''", moment.over(AREA), inertia),
        equation("B.8", "M = EI d2w/dx2", moment, bending.times(LENGTH).over(AREA)),
        equation("B.9", "d2(EI d2w/dx2)/dx2 + rho A w'' = f", bending.times(LENGTH).over(AREA.to(2)), per_length),
        equation(
            "B.10",
            "c^2 d4w/dx4 + w'' = 0, c = sqrt(EI/(rho A))",
            bending.over(DENSITY.times(AREA)).over(LENGTH.to(3)),
            ACCELERATION,
        ),
        equation("B.11", "w = a sin(w t - k x)", LENGTH, LENGTH),
        equation(
            "B.12",
            "k = w^(1/2) (rho S/EI)^(1/4), to the fourth",
            LENGTH.to(-4),
            TIME.to(-2).times(DENSITY.times(AREA)).over(bending),
        ),
        equation("B.13", "u = -z dw/dx = a z k cos(w t - k x)", LENGTH.times(LENGTH).over(LENGTH), AREA.over(LENGTH)),
        equation("B.14", "u^2/(a z k)^2 + w^2/a^2 = 1", AREA.over(AREA), ratio),
    ]
}

/// Tabulates the equations of appendix B with the units of their sides.
pub fn table() -> TableBlock {
    let row = |equation: Equation| {
        let agrees = if equation.left == equation.right { "agree" } else { "differ" };
        vec![equation.place.into(), equation.printed.into(), equation.left.unit(), equation.right.unit(), agrees.into()]
    };
    let caption = "Signs by B.2 and B.3: in B.5 the sign before dV/dx is wrong, in B.7 and B.9 it is right. c of B.10 is \
                   not a speed. B.14 follows from B.11 and B.13, not from B.12 and B.13.";
    let header = ["equation", "as printed", "left", "right", "units"];
    TableBlock::new(
        "equations-b",
        "Appendix B: units of the equations",
        caption,
        &header,
        printed().into_iter().map(row).collect(),
    )
}

/// Returns the contradictions in the equations of the beam.
pub fn errata() -> Vec<Erratum> {
    let of = |id, place: &str, places, instead| {
        let found = printed().into_iter().find(|equation| equation.place == place);
        found.map(|equation| unequal(id, places, equation.printed, instead, equation.left, equation.right))
    };
    let beam = [
        of("beam-force", "B.5", "B.5", "Without dx on the right-hand side, and with -dV/dx, by B.2."),
        of("beam-moment", "B.6", "B.6", "dM/dx - V = 0, by B.3."),
        of("beam-shear", "before B.7", "between B.6 and B.7", "V = dM/dx."),
        of("beam-combined", "B.7", "B.7, B.9", "Without dx; B.9 omits it, but has a stray s."),
    ];
    let lugre = unequal(
        "lugre-rate",
        "4.13",
        "The rate of LuGre's force equals Dahl's force.",
        "It equals the rate of Dahl's force (4.15).",
        FORCE.over(TIME),
        FORCE,
    );
    beam.into_iter().flatten().chain([sign(), lugre]).collect()
}

/// Inserts B.11 into B.5 (without dx) and B.8; the number is the residual over the inertia.
fn sign() -> Erratum {
    let sheet = Sheet::BEAM;
    let hz = MEASURED_HZ[0];
    let inertia = sheet.density_kg_per_m3 * sheet.thickness_m * (std::f64::consts::TAU * hz).powi(2);
    let stiff = sheet.stiffness_n_m() * sheet.wave_number(hz).powi(4);
    let (printed, instead) = ((stiff + inertia) / inertia, (inertia - stiff) / inertia);
    // Nine decimals, as further ones are round-off.
    let nine = |value: f64| (1e9 * value).round() / 1e9;
    let numbers = vec![number("residual with dV/dx", nine(printed)), number("with -dV/dx", nine(instead))];
    Erratum {
        id: "beam-shear-sign",
        places: "B.5, against B.2",
        printed: "dV/dx + f = ...",
        instead: "-dV/dx + f = ...: a bending wave (B.11, B.12) does not solve the equation with the sign as printed.",
        evidence: Check::new(
            "B.11 and B.8 inserted without dx, over rho A w'', 20 kHz",
            printed > 1.0 && instead.abs() < 1e-9,
            numbers,
        ),
    }
}

fn unequal(
    id: &'static str,
    places: &'static str,
    printed: &'static str,
    instead: &'static str,
    left: Dimension,
    right: Dimension,
) -> Erratum {
    let [_, metres, seconds] = [0, 1, 2].map(|unit: usize| (f64::from(left.0[unit]), f64::from(right.0[unit])));
    let numbers = vec![
        number("power of metre, left", metres.0),
        number("right", metres.1),
        number("power of second, left", seconds.0),
        number("right", seconds.1),
    ];
    Erratum { id, places, printed, instead, evidence: Check::new("dimensions of both sides", left != right, numbers) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn four_lines_of_appendix_b_have_sides_of_different_units() {
        let wrong: Vec<&str> = printed().iter().filter(|equation| equation.left != equation.right).map(|e| e.place).collect();
        assert_eq!(wrong, ["B.5", "B.6", "before B.7", "B.7"]);
        assert_eq!(errata().len(), wrong.len() + 2);
    }

    #[test]
    fn units_are_readable() {
        assert_eq!((FORCE.unit(), LENGTH.over(LENGTH).unit()), ("kg m s^-2".into(), "1".to_owned()));
    }
}
