//! Gauss-Legendre collocation along the wrap, in panels that are halved until both halves agree
//! with the whole.
//!
//! Between two kinks the position is `p = a + (b - a) s^2 (3 - 2 s)`, which turns square roots of
//! the distance from a kink, as in the law along the sliding, into polynomials of s. In each panel
//! of s the state is computed by collocation at 16 Gauss points, of order 32.

use std::sync::LazyLock;

use super::super::closed::gauss;

/// Number of nodes in a panel.
pub(super) const NODES: usize = 16;
/// Largest number of halvings of a panel.
const MAX_HALVINGS: u32 = 24;
/// Largest number of iterations for a state on which its rate depends.
const MAX_ITERATIONS: usize = 60;

/// Two quantities that are integrated along the wrap.
pub(super) type State = [f64; 2];

pub(super) struct Rule {
    /// Nodes, from 0 to 1, and their weights.
    pub(super) nodes: [(f64, f64); NODES],
    /// Integrals of the interpolating polynomials from 0 to each node.
    pub(super) until: [[f64; NODES]; NODES],
    /// Matrix that gives the last Legendre coefficients of a function from its values at the nodes.
    pub(super) last: [[f64; NODES]; 3],
}

pub(super) static RULE: LazyLock<Rule> = LazyLock::new(|| {
    let nodes: [(f64, f64); NODES] = std::array::from_fn(|i| gauss::node(NODES, NODES - 1 - i));
    // P_0 to P_NODES at a point of [-1, 1].
    let legendre = |x: f64| {
        let mut p = [1.0; NODES + 1];
        p[1] = x;
        for k in 2..=NODES {
            let n = k as f64;
            p[k] = ((2.0 * n - 1.0) * x * p[k - 1] - (n - 1.0) * p[k - 2]) / n;
        }
        p
    };
    // The polynomial that is one at node j is w_j sum (k + 1/2) P_k(x_j) P_k(x), and the integral
    // of P_k is (P_(k+1) - P_(k-1)) / (2 k + 1).
    let until = nodes.map(|(to, _)| {
        let at_end = legendre(to);
        nodes.map(|(at, weight)| {
            let at_node = legendre(at);
            let above = (1..NODES).map(|k| 0.5 * at_node[k] * (at_end[k + 1] - at_end[k - 1]));
            0.5 * weight * (0.5 * (to + 1.0) + above.sum::<f64>())
        })
    });
    // c_k = (k + 1/2) sum w_j P_k(x_j) f_j
    let last = std::array::from_fn(|i| {
        let k = NODES - 3 + i;
        nodes.map(|(at, weight)| (k as f64 + 0.5) * weight * legendre(at)[k])
    });
    Rule { nodes: nodes.map(|(x, w)| (0.5 * (1.0 + x), 0.5 * w)), until, last }
});

/// Returns the position between two kinks at s, and its derivative with respect to s.
pub(super) fn between(ends: &[f64], s: f64) -> (f64, f64) {
    let wide = ends[1] - ends[0];
    // Measured from the nearer kink, so that a small distance keeps its precision.
    let near = |s: f64| wide * s * s * (3.0 - 2.0 * s);
    let place = if s < 0.5 { ends[0] + near(s) } else { ends[1] - near(1.0 - s) };
    (place, wide * 6.0 * s * (1.0 - s))
}

/// Panel that has been integrated.
#[derive(Clone, Copy)]
struct Walked {
    from: f64,
    to: f64,
    rise: State,
}

/// Integrand: properties of a position, and the rise of the state there.
pub(super) struct Walk<'a, P> {
    /// Properties of a position that do not depend on the state; expensive.
    pub(super) place: &'a dyn Fn(f64) -> P,
    /// Rise of the state per radian.
    pub(super) rate: &'a dyn Fn(&P, State) -> State,
    /// `true` if the rate depends on the state, not only on the position.
    pub(super) feels_state: bool,
    /// Permitted error of a panel.
    pub(super) tolerance: f64,
}

impl<P> Walk<'_, P> {
    /// Returns the state at the end of the wrap, from that at its beginning, and its error.
    pub(super) fn along(&self, kinks: &[f64], state: State) -> (State, f64) {
        kinks.windows(2).fold((state, 0.0), |(state, error), ends| {
            let whole = self.panel(ends, 0.0, 1.0, state);
            let (rise, more) = self.refined(ends, whole, state, MAX_HALVINGS);
            ([state[0] + rise[0], state[1] + rise[1]], error + more)
        })
    }

    fn panel(&self, ends: &[f64], from: f64, to: f64, state: State) -> Walked {
        let rule = &*RULE;
        let long = to - from;
        let places: [(P, f64); NODES] = rule.nodes.map(|(at, _)| {
            let (place, per_s) = between(ends, from + long * at);
            ((self.place)(place), long * per_s)
        });
        let mut states = [state; NODES];
        let mut rates = [[0.0; 2]; NODES];
        for _ in 0..MAX_ITERATIONS {
            for (rate, ((place, scale), state)) in rates.iter_mut().zip(places.iter().zip(states)) {
                *rate = (self.rate)(place, state).map(|rate| scale * rate);
            }
            if !self.feels_state {
                break;
            }
            let next = rule.until.map(|row| {
                let sum = |which: usize| row.iter().zip(&rates).map(|(part, rate)| part * rate[which]).sum::<f64>();
                [state[0] + sum(0), state[1] + sum(1)]
            });
            let moved = |which: usize| next.iter().zip(&states).map(|(a, b)| (a[which] - b[which]).abs()).fold(0.0, f64::max);
            let moved = moved(0).max(moved(1));
            states = next;
            if moved < 1e-15 {
                break;
            }
        }
        let rise = |which: usize| rule.nodes.iter().zip(&rates).map(|((_, weight), rate)| weight * rate[which]).sum::<f64>();
        Walked { from, to, rise: [rise(0), rise(1)] }
    }

    /// Returns the rise of the state over a panel, and its error.
    fn refined(&self, ends: &[f64], whole: Walked, state: State, halvings: u32) -> (State, f64) {
        let middle = 0.5 * (whole.from + whole.to);
        let first = self.panel(ends, whole.from, middle, state);
        let between = [state[0] + first.rise[0], state[1] + first.rise[1]];
        let second = self.panel(ends, middle, whole.to, between);
        let rise = [first.rise[0] + second.rise[0], first.rise[1] + second.rise[1]];
        let error = (rise[0] - whole.rise[0]).abs().max((rise[1] - whole.rise[1]).abs());
        if error <= self.tolerance || halvings == 0 {
            return (rise, error);
        }
        let (one, off) = self.refined(ends, first, state, halvings - 1);
        let between = [state[0] + one[0], state[1] + one[1]];
        let second = self.panel(ends, middle, whole.to, between);
        let (other, more) = self.refined(ends, second, between, halvings - 1);
        ([one[0] + other[0], one[1] + other[1]], off + more)
    }
}
