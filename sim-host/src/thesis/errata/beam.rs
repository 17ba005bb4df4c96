//! Equations whose sides have different dimensions: the beam of appendix B, and 4.13.

use super::Erratum;
use crate::thesis::claim::{Check, number};

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

    fn over(self, other: Dimension) -> Dimension {
        Dimension(std::array::from_fn(|i| self.0[i] - other.0[i]))
    }
}

/// The equations.
pub fn errata() -> Vec<Erratum> {
    let inertia = DENSITY.times(AREA).times(LENGTH).times(ACCELERATION);
    let moment = FORCE.times(LENGTH);
    vec![
        unequal(
            "beam-force",
            "B.5",
            "dV/dx + f = rho A dx w''.",
            "Without dx on the right, and with -dV/dx, by B.2.",
            FORCE.over(LENGTH),
            inertia,
        ),
        unequal("beam-moment", "B.6", "(dM/dx) dx - V = 0.", "dM/dx - V = 0, by B.3.", moment, FORCE),
        unequal(
            "beam-combined",
            "B.7, B.9",
            "-d2M/dx2 + f = rho A dx w''.",
            "Without dx; B.9 has dropped it, and gained a stray s. The line between says V = dV/dx for V = dM/dx.",
            moment.over(LENGTH).over(LENGTH),
            inertia,
        ),
        unequal(
            "lugre-rate",
            "4.13",
            "The rate of LuGre's force equals Dahl's force.",
            "It equals the rate of Dahl's force (4.15).",
            FORCE.over(TIME),
            FORCE,
        ),
    ]
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
