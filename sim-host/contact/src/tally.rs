//! The sums that a method collects over the window, and the ratios computed from them.
//!
//! | ratio | definition | thesis |
//! |---|---|---|
//! | friction ratio r | mean F / Fc | 4.17 |
//! | power ratio phi | mean F V / (Fc Vt) | 4.18, 4.27 |
//! | input ratio phi_iu | mean Fe x' / (Fc Vt) | 4.31 |
//! | printed power ratio | `1 + phi_iu - phi_su`, phi_su from the mean stored energy | 4.35, which is wrong; given for comparison |
//!
//! From `m x'' + c x' + Ks x = Fe - F` and `V = Vt + s x'` (s = 1 passive, -1 literal), the energy
//! identity follows without approximation:
//!
//! ```text
//! phi = r + s (phi_iu - phi_c - dE / (Fc Vt T))
//! ```
//!
//! Here phi_c is the loss in the damper, and dE the energy gained by mass and spring. The
//! difference between both sides is the **residual**.

use super::problem::{Motion, Problem};
pub use super::state::State;
use super::timeline::Stretch;
pub use marks::Marks;

mod marks;

/// Integrals over time of forces, powers and energies.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Totals {
    /// Integral of the friction, N s.
    pub friction_n_s: f64,
    /// Integral of friction times slip velocity, J.
    pub friction_work_j: f64,
    /// Integral of the friction that acts on the oscillator, N s. A method that applies friction
    /// only at chosen moments does not apply exactly `friction_n_s`.
    pub felt_n_s: f64,
    /// Integral of slip velocity times the friction that acts on the oscillator, J.
    pub felt_work_j: f64,
    /// Integral of forcing times x', J. In a kinematic motion: of friction times x', which is the
    /// work that drives the motion.
    pub input_j: f64,
    /// Energy lost in the damper, J.
    pub damping_j: f64,
    /// Integral of the kinetic energy m x'^2 / 2, J s.
    pub kinetic_j_s: f64,
    /// Integral of the potential energy Ks x^2 / 2, J s.
    pub potential_j_s: f64,
}

/// Sums over the window, and peaks over the whole run.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Tally {
    /// Length of the window, s.
    pub time_s: f64,
    /// Integrals over the window.
    pub totals: Totals,
    /// State at the beginning of the window.
    pub first: State,
    /// State at the end of the window.
    pub last: State,
    /// Coulomb force at the end of the window, N; the reference for the friction ratio.
    pub coulomb_n: f64,
    /// Largest |x'| at the end of a step in the whole run, m/s.
    pub peak_velocity_m_per_s: f64,
    /// Largest |x| at the end of a step in the whole run, m.
    pub peak_displacement_m: f64,
    /// Largest |F| / Fc at the end of a step in the whole run, with the Fc of that moment.
    pub peak_force_ratio: f64,
    /// Number of steps in the whole run.
    pub steps: u64,
    /// Number of located slip reversals in the whole run.
    pub reversals: u64,
    /// `true` if the energies were added up, too; otherwise they are zero.
    pub accounted: bool,
    /// Integral of the friction at some moments of the window, for comparing two runs.
    pub marks: Marks,
}

/// Accumulator of the sums while a method runs.
#[derive(Clone, Copy, Debug, Default)]
pub struct Meter {
    /// Integrals since the beginning of the run.
    pub totals: Totals,
    /// Integrals and peaks of the run.
    pub tally: Tally,
    opened: Option<(Totals, State)>,
    closed: bool,
    /// Coulomb force of the current stretch, N.
    coulomb_n: f64,
}

impl Meter {
    /// Creates a meter at zero. With `accounted`, the method adds up the energies, too.
    pub fn new(accounted: bool) -> Self {
        Meter { tally: Tally { accounted, ..Tally::default() }, ..Meter::default() }
    }

    /// Starts a stretch in this state. If the window ends here, the new Coulomb force does not
    /// belong to it.
    pub fn at(&mut self, stretch: &Stretch, state: &State, coulomb_n: f64) {
        if stretch.opens {
            self.opened = Some((self.totals, *state));
        }
        if stretch.closes {
            self.close(state, self.coulomb_n);
        }
        self.coulomb_n = coulomb_n;
        if self.is_open() {
            self.tally.marks.add(stretch.start_s, self.totals.friction_n_s);
        }
    }

    /// Returns `true` within the window.
    pub fn is_open(&self) -> bool {
        self.opened.is_some() && !self.closed
    }

    /// Records the end of a step, with the friction as a fraction of the Coulomb force.
    #[inline]
    pub fn step(&mut self, state: &State, force_ratio: f64) {
        let tally = &mut self.tally;
        tally.peak_velocity_m_per_s = tally.peak_velocity_m_per_s.max(state.v_m_per_s.abs());
        tally.peak_displacement_m = tally.peak_displacement_m.max(state.x_m.abs());
        tally.peak_force_ratio = tally.peak_force_ratio.max(force_ratio.abs());
        tally.steps += 1;
    }

    /// Ends the run and returns its sums.
    pub fn finish(mut self, state: &State, coulomb_n: f64) -> Tally {
        self.close(state, coulomb_n);
        self.tally
    }

    fn close(&mut self, state: &State, coulomb_n: f64) {
        let Some((before, first)) = self.opened.filter(|_| !self.closed) else { return };
        self.closed = true;
        self.tally.time_s = state.time_s - first.time_s;
        self.tally.totals = self.totals.since(&before);
        (self.tally.first, self.tally.last, self.tally.coulomb_n) = (first, *state, coulomb_n);
    }
}

impl Totals {
    fn since(&self, before: &Totals) -> Totals {
        Totals {
            friction_n_s: self.friction_n_s - before.friction_n_s,
            friction_work_j: self.friction_work_j - before.friction_work_j,
            felt_n_s: self.felt_n_s - before.felt_n_s,
            felt_work_j: self.felt_work_j - before.felt_work_j,
            input_j: self.input_j - before.input_j,
            damping_j: self.damping_j - before.damping_j,
            kinetic_j_s: self.kinetic_j_s - before.kinetic_j_s,
            potential_j_s: self.potential_j_s - before.potential_j_s,
        }
    }
}

/// Ratios of a window.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Ratios {
    /// Mean friction over Coulomb force.
    pub friction: f64,
    /// Dissipated power over the power that Coulomb friction dissipates without vibration. `None`
    /// without sliding.
    pub power: Option<f64>,
    /// Power delivered by the forcing, over the same reference.
    pub input: Option<f64>,
    /// Energy gained by mass and spring, over the energy of that reference.
    pub stored: Option<f64>,
    /// Energy lost in the damper, over the same reference.
    pub damping: Option<f64>,
    /// The thesis's `1 + phi_iu - phi_su` (4.35).
    pub power_as_printed: Option<f64>,
    /// Residual of the energy identity, over the same reference.
    pub energy_residual: Option<f64>,
}

impl Ratios {
    /// Computes the ratios from a tally.
    pub fn of(problem: &Problem, tally: &Tally) -> Self {
        let totals = &tally.totals;
        let friction = totals.friction_n_s / (tally.coulomb_n * tally.time_s);
        let sliding_j = tally.coulomb_n * problem.sliding_m_per_s * tally.time_s;
        if sliding_j == 0.0 {
            return Ratios { friction, ..Ratios::default() };
        }
        let (stored_j, moved_j_s) = match problem.motion {
            Motion::Kinematic => (0.0, 0.0),
            Motion::Sdof { mass_kg: m, stiffness_n_per_m: k, .. } => {
                let energy = |state: &State| 0.5 * m * state.v_m_per_s * state.v_m_per_s + 0.5 * k * state.x_m * state.x_m;
                let moved = m * problem.sliding_m_per_s * (tally.last.x_m - tally.first.x_m);
                (energy(&tally.last) - energy(&tally.first), moved)
            }
        };
        let over = |joule: f64| Some(joule / sliding_j);
        // A run without energies may not add up the friction work, either. With friction and
        // sliding, real work is never zero.
        let power = over(totals.friction_work_j).filter(|power| *power != 0.0);
        if !tally.accounted {
            return Ratios { friction, power, ..Ratios::default() };
        }
        let s = problem.sign.factor();
        let left = totals.felt_work_j - problem.sliding_m_per_s * totals.felt_n_s;
        let right = s * (totals.input_j - totals.damping_j - stored_j);
        let printed_j = (totals.kinetic_j_s + moved_j_s + totals.potential_j_s) / tally.time_s;
        Ratios {
            friction,
            power,
            input: over(totals.input_j),
            stored: over(stored_j),
            damping: over(totals.damping_j),
            power_as_printed: over(sliding_j + totals.input_j - printed_j),
            energy_residual: over(left - right),
        }
    }
}
