//! Parts of a chain, each solved in closed form.
//!
//! A rod of variable section `A(x) = pi r(x)^2` (Webster's equation), with `w = r u`:
//!
//! ```text
//! w'' + K^2 w = 0,   K^2 = w^2 rho / E - r''/r,   F = pi E (r w' - r' w)
//! ```
//!
//! `r''/r` is constant, so that this is exact, for a cylinder and a cone (0), and for exponential
//! and catenoidal horns (E. Eisner, J. Acoust. Soc. Am. 41 (1967) 1126).
//!
//! A ring polarised along the axis has a uniform charge density `q / A`:
//!
//! ```text
//! F = A/sD u' - G q,   q = C0 (V + G (u2 - u1)),   G = g33/sD,   C0 = A epsS / t
//! ```

use std::f64::consts::PI;

use crate::material::Ceramic;
use crate::port::{C, Port, State};

/// A part of the chain.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Part {
    /// A rod of constant or variable section.
    Rod(Rod),
    /// A piezoelectric ring.
    Ring(Ring),
    /// A spring in series, without mass.
    Joint {
        /// Stiffness, N/m.
        stiffness: C,
    },
    /// A mass, spring and damper to ground at a place.
    Point {
        /// Mass, kg.
        mass: f64,
        /// Stiffness to ground, N/m.
        stiffness: f64,
        /// Damping to ground, N s/m.
        damping: f64,
    },
    /// Parts in the grip of a bolt.
    Clamp {
        /// Parts between the ends of the bolt, with the index of the element of each.
        inside: Vec<(usize, Part)>,
        /// The free length of the bolt.
        bolt: Rod,
    },
}

/// Shape of a rod: its radius, or that of a full rod of the same area.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Taper {
    /// Linear from one radius to the other.
    Linear,
    /// Exponential.
    Exponential,
    /// Hyperbolic cosine; the slope is zero at the thin end.
    Catenoidal,
}

/// A rod.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Rod {
    /// Shape of the rod.
    pub(crate) taper: Taper,
    /// Length, m.
    pub(crate) length: f64,
    /// Radii of full rods with the areas of both ends, m.
    pub(crate) radii: [f64; 2],
    /// Young's modulus, with its loss, Pa.
    pub(crate) modulus: C,
    /// Density, kg/m^3.
    pub(crate) density: f64,
    /// `nu^2 rp^2`, m^2: square of Poisson's ratio and of the polar radius of gyration, if the
    /// inertia of the lateral motion counts (Love's rod), else zero.
    pub(crate) lateral_m2: f64,
}

/// A ring with electrodes on its faces.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Ring {
    /// The ring as a rod with the modulus at constant charge.
    pub(crate) rod: Rod,
    /// Coupling of charge and force, N/C.
    pub(crate) gamma: C,
    /// Clamped capacitance, F.
    pub(crate) c0: C,
}

impl Rod {
    /// Returns the modulus with the lateral inertia, and the square of the wave number `K`.
    fn wave(&self, w: C) -> (C, C) {
        let modulus = self.modulus - w * w * (self.density * self.lateral_m2);
        (modulus, w * w * self.density / modulus - self.curvature())
    }

    /// Returns the frequency above which the lateral inertia leaves no waves, if it counts, Hz.
    pub(crate) fn cutoff_hz(&self) -> Option<f64> {
        (self.lateral_m2 > 0.0).then(|| (self.modulus.re / (self.density * self.lateral_m2)).sqrt() / (2.0 * PI))
    }

    /// Returns the number of half waves along the rod.
    pub(crate) fn half_waves(&self, w: f64) -> f64 {
        w * self.length * (self.density / self.modulus.re).sqrt() / PI
    }

    /// Returns `r''/r`, 1/m^2.
    fn curvature(&self) -> f64 {
        self.rate().powi(2)
    }

    /// Returns the rate of the exponential or hyperbolic shape, 1/m.
    fn rate(&self) -> f64 {
        let [left, right] = self.radii;
        match self.taper {
            Taper::Linear => 0.0,
            Taper::Exponential => (right / left).ln() / self.length,
            Taper::Catenoidal => (left.max(right) / left.min(right)).acosh() / self.length,
        }
    }

    /// Returns radius and slope of the shape at a distance from the left end, m and 1.
    pub(crate) fn shape(&self, x: f64) -> (f64, f64) {
        let ([left, right], rate) = (self.radii, self.rate());
        match self.taper {
            Taper::Linear => (left + (right - left) * x / self.length, (right - left) / self.length),
            Taper::Exponential => (left * (rate * x).exp(), rate * left * (rate * x).exp()),
            Taper::Catenoidal if right < left => {
                let from_thin = rate * (self.length - x);
                (right * from_thin.cosh(), -rate * right * from_thin.sinh())
            }
            Taper::Catenoidal => (left * (rate * x).cosh(), rate * left * (rate * x).sinh()),
        }
    }

    /// Returns the area at a distance from the left end, m^2.
    pub(crate) fn area(&self, x: f64) -> f64 {
        PI * self.shape(x).0.powi(2)
    }

    /// Returns the four-pole from the left end to a distance from it.
    fn four_pole(&self, w: C, x: f64) -> [[C; 2]; 2] {
        let (modulus, square) = self.wave(w);
        let wave = square.sqrt();
        let angle = wave * x;
        let cos = angle.cos();
        let sin = if angle.norm() < 1e-8 { C::new(x, 0.0) } else { angle.sin() / wave };
        let ((r1, s1), (r2, s2)) = (self.shape(0.0), self.shape(x));
        let stiff = modulus * PI;
        // w and its derivative at the left end, by displacement and tension there.
        let left = [[C::new(r1, 0.0), C::default()], [C::new(s1, 0.0), (stiff * r1).inv()]];
        let over = [[cos, sin], [-square * sin, cos]];
        let right = |of: usize| {
            let w = over[0][0] * left[0][of] + over[0][1] * left[1][of];
            let slope = over[1][0] * left[0][of] + over[1][1] * left[1][of];
            (w / r2, stiff * (slope * r2 - w * s2))
        };
        let ((u_u, f_u), (u_f, f_f)) = (right(0), right(1));
        [[u_u, u_f], [f_u, f_f]]
    }

    /// Returns the number of modes below `w` with both ends clamped.
    fn clamped(&self, w: C) -> usize {
        let square = self.wave(w).1.re;
        if square > 0.0 { (square.sqrt() * self.length / PI) as usize } else { 0 }
    }
}

impl Ring {
    /// Creates a ring with two faces.
    pub(crate) fn new(rod: Rod, ceramic: &Ceramic) -> Self {
        let area = rod.area(0.0);
        let modulus = ceramic.modulus_d();
        let thickness = rod.length;
        Ring { gamma: ceramic.g33() * modulus, c0: ceramic.permittivity_s() * (area / thickness), rod: Rod { modulus, ..rod } }
    }

    /// Returns the relation of both ends.
    fn port(&self, w: C) -> Port {
        let [[t00, t01], [t10, t11]] = self.rod.four_pole(w, self.rod.length);
        let (gamma, one) = (self.gamma, C::new(1.0, 0.0));
        let back = t01 * gamma * gamma * self.c0;
        let part = (one - back).inv();
        let u = [(t00 - back) * part, t01 * part, t01 * gamma * self.c0 * part];
        let q = [(u[0] - one) * gamma * self.c0, u[1] * gamma * self.c0, (one + gamma * u[2]) * self.c0];
        let by_charge = (t11 - one) * gamma;
        let f = [t10 + by_charge * q[0], t11 + by_charge * q[1], by_charge * q[2]];
        Port { m: [u, f], q }
    }
}

impl Part {
    /// Returns the relation of both ends.
    pub(crate) fn port(&self, w: C) -> Port {
        let one = C::new(1.0, 0.0);
        match self {
            Part::Rod(rod) => Port::mechanical(rod.four_pole(w, rod.length)),
            Part::Ring(ring) => ring.port(w),
            Part::Joint { stiffness } => Port::mechanical([[one, stiffness.inv()], [C::default(), one]]),
            &Part::Point { mass, stiffness, damping } => {
                let force = C::new(stiffness, 0.0) + w * C::new(0.0, damping) - w * w * mass;
                Port::mechanical([[one, C::default()], [force, one]])
            }
            Part::Clamp { inside, bolt } => chain(inside, w).beside(&Port::mechanical(bolt.four_pole(w, bolt.length))),
        }
    }

    /// Returns the number of modes below `w` with both ends clamped and the electrodes shorted. A
    /// point has no length.
    fn clamped(&self, w: C) -> usize {
        match self {
            Part::Rod(rod) => rod.clamped(w),
            // A clamped ring without a voltage has no charge.
            Part::Ring(ring) => ring.rod.clamped(w),
            Part::Joint { .. } | Part::Point { .. } => 0,
            Part::Clamp { inside, bolt } => crossings(inside, w, State::CLAMPED).0 + bolt.clamped(w),
        }
    }

    /// Returns the state at a distance from the left end of a rod or ring, from the state there and
    /// the charge.
    pub(crate) fn state_at(&self, w: C, x: f64, left: State, charge: C) -> State {
        let (rod, held) = match self {
            Part::Rod(rod) => (rod, C::default()),
            Part::Ring(ring) => (&ring.rod, ring.gamma * charge),
            Part::Joint { .. } | Part::Point { .. } | Part::Clamp { .. } => return left,
        };
        let port = Port::mechanical(rod.four_pole(w, x));
        let (state, _) = port.apply(State { f: left.f + held, ..left }, C::default());
        State { f: state.f - held, ..state }
    }

    /// Returns the rod of a rod or ring.
    pub(crate) fn rod(&self) -> Option<&Rod> {
        match self {
            Part::Rod(rod) => Some(rod),
            Part::Ring(ring) => Some(&ring.rod),
            Part::Joint { .. } | Part::Point { .. } | Part::Clamp { .. } => None,
        }
    }
}

/// Returns the relation over a chain of parts.
pub(crate) fn chain(parts: &[(usize, Part)], w: C) -> Port {
    let (one, zero) = (C::new(1.0, 0.0), C::default());
    let start = Port::mechanical([[one, zero], [zero, one]]);
    parts.iter().fold(start, |port, (_, part)| port.then(&part.port(w)))
}

/// Returns the number of negative pivots of the dynamic stiffness of a chain, with the modes of its
/// clamped parts, and the state at its right end.
///
/// The algorithm of Wittrick and Williams (Q. J. Mech. Appl. Math. 24 (1971) 263), with the pivots
/// as signs of the displacements at the joints: none is missed, however close two modes are. The
/// last pivot depends on the right end and is left to the caller.
pub(crate) fn crossings(parts: &[(usize, Part)], w: C, left: State) -> (usize, State) {
    let mut below = 0;
    let mut state = left;
    for (_, part) in parts {
        let port = part.port(w);
        let (next, _) = port.apply(state, C::default());
        if !matches!(part, Part::Point { .. }) {
            below += part.clamped(w);
            below += usize::from(state.u.re * next.u.re * port.m[0][1].re < 0.0);
        }
        state = next;
    }
    (below, state)
}
