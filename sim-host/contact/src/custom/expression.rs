//! A friction law as text, in the notation of the scene table `[contact.expression]`.
//!
//! ```text
//! rate.z = "v - k*abs(v)*z/Fc"      force = "k*z + s1*dz"
//! ```
//!
//! Names: `v` (slip velocity, m/s), `N` (normal force, N), `mu`, `Fc = mu N`, the states, `d` and a
//! state for its rate (only in the force), the parameters, `pi`. Operators `+ - * / ^`, with the
//! usual priorities: `-v^2` is `-(v^2)`. Functions: `exp ln log10 sqrt cbrt sin cos tan asin acos
//! atan sinh cosh tanh`, and `abs sign max min`.
//!
//! The last four have kinks or jumps, at which an integrator loses its order: each zero of their
//! arguments is an event. `sign(a)` is constant between two events. A relay is a switch with
//! memory: it becomes one when its `on` is above zero, and zero when its `off` is.

mod parse;
mod program;

use std::collections::BTreeMap;

use super::{At, FrictionLaw, Partial};
use parse::Names;
use program::Program;

/// Largest number of names in one law.
const MAX_NAMES: usize = 128;

/// Texts and numbers of a law.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Source {
    /// Coefficient of friction.
    pub mu: f64,
    /// Rate of each state, per second.
    pub rates: BTreeMap<String, String>,
    /// Friction, N.
    pub force: String,
    /// Values of the states at the start; zero if they are missing.
    pub start: BTreeMap<String, f64>,
    /// Parameters of the law.
    pub parameters: BTreeMap<String, f64>,
    /// Relays: the conditions `on` and `off`, each true above zero.
    pub relays: BTreeMap<String, (String, String)>,
}

/// Mistake in a law.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{message}")]
pub struct ExpressionError {
    /// Key of the text or number with the mistake: `force`, `rate.z`, `parameter.k`, `relay.s.on`.
    pub key: String,
    /// Mistake, for the user.
    pub message: String,
}

/// Friction law from text.
#[derive(Clone, Debug)]
pub struct Expression {
    mu: f64,
    start: Vec<f64>,
    rates: Vec<Program>,
    force: Program,
    /// Arguments of `sign`, `abs`, `max` and `min`, in the order of their nesting.
    arguments: Vec<Program>,
    /// Conditions of the relays.
    relays: Vec<(Program, Program)>,
    /// Values of the parameters.
    parameters: Vec<f64>,
    places: Places,
}

/// Places of the variables in the list of values.
#[derive(Clone, Copy, Debug)]
struct Places {
    rates: usize,
    parameters: usize,
    relays: usize,
    /// Signs of the arguments of functions with kinks.
    arguments: usize,
}

const SLIP: usize = 0;
const SIGN: usize = 1;
const NORMAL: usize = 2;
const MU: usize = 3;
const COULOMB: usize = 4;
const FIRST_STATE: usize = 5;

impl Expression {
    /// Builds a law from its texts.
    ///
    /// # Errors
    /// If a text is not an expression, or a name in it is not known or given twice.
    pub fn new(source: &Source) -> Result<Self, ExpressionError> {
        let names = Names::new(source)?;
        let mut arguments = Vec::new();
        let mut parsed = |key: String, text: &str, with_rates: bool| {
            parse::parse(text, &names, with_rates, &mut arguments).map_err(|message| ExpressionError { key, message })
        };
        let rates = source.rates.iter().map(|(state, text)| parsed(format!("rate.{state}"), text, false));
        let rates: Vec<Program> = rates.collect::<Result<_, _>>()?;
        let force = parsed("force".to_owned(), &source.force, true)?;
        let relays = source.relays.iter().map(|(name, (on, off))| {
            Ok((parsed(format!("relay.{name}.on"), on, false)?, parsed(format!("relay.{name}.off"), off, false)?))
        });
        let relays: Vec<(Program, Program)> = relays.collect::<Result<_, ExpressionError>>()?;
        let places = names.places();
        // A mistyped name of a change would otherwise be one more parameter.
        let of_relays = relays.iter().flat_map(|(on, off)| [on, off]);
        let all: Vec<&Program> = rates.iter().chain([&force]).chain(of_relays).chain(&arguments).collect();
        let named = (places.parameters..).zip(source.parameters.keys().map(|name| ("parameter", name)));
        let relayed = (places.relays..).zip(source.relays.keys().map(|name| ("relay", name)));
        for (place, (kind, name)) in named.chain(relayed) {
            if !all.iter().any(|program| program.uses(place)) {
                let message = format!("`{name}` is not used in any text of the law");
                return Err(ExpressionError { key: format!("{kind}.{name}"), message });
            }
        }
        Ok(Expression {
            mu: source.mu,
            start: source.rates.keys().map(|state| source.start.get(state).copied().unwrap_or(0.0)).collect(),
            rates,
            force,
            relays,
            arguments,
            parameters: source.parameters.values().copied().collect(),
            places,
        })
    }

    /// Returns the values of all variables at a moment; the rates of the states are zero.
    fn values(&self, at: &At) -> [f64; MAX_NAMES] {
        let mut values = [0.0; MAX_NAMES];
        (values[SLIP], values[SIGN], values[MU]) = (at.slip_m_per_s, at.sign, self.mu);
        (values[NORMAL], values[COULOMB]) = (at.coulomb_n / self.mu, at.coulomb_n);
        values[FIRST_STATE..self.places.rates].copy_from_slice(at.states);
        values[self.places.parameters..self.places.relays].copy_from_slice(&self.parameters);
        for ((place, value), is_on) in values.iter_mut().enumerate().skip(self.places.relays).zip(at.switches) {
            let off = if place < self.places.arguments { 0.0 } else { -1.0 };
            *value = if *is_on { 1.0 } else { off };
        }
        values
    }
}

impl FrictionLaw for Expression {
    fn start(&self) -> Vec<f64> {
        self.start.clone()
    }

    fn rates(&self, at: &At, rates: &mut [f64]) -> f64 {
        let mut values = self.values(at);
        for ((rate, function), place) in rates.iter_mut().zip(&self.rates).zip(self.places.rates..) {
            *rate = function.value(&values);
            values[place] = *rate;
        }
        self.force.value(&values)
    }

    fn derivatives(&self, at: &At, partial: &mut Partial) -> bool {
        let (mut values, states) = (self.values(at), self.start.len());
        for (i, function) in self.rates.iter().enumerate() {
            for j in 0..states {
                partial.rates_by_states[i * states + j] = function.derivative(FIRST_STATE + j, &values);
            }
        }
        if partial.is_motion_given {
            return true;
        }
        for (i, function) in self.rates.iter().enumerate() {
            partial.rates_by_slip[i] = function.derivative(SLIP, &values);
        }
        for (function, place) in self.rates.iter().zip(self.places.rates..) {
            values[place] = function.value(&values);
        }
        // The force depends on the states also through their rates.
        let by_rates: Vec<f64> = (0..states).map(|i| self.force.derivative(self.places.rates + i, &values)).collect();
        for j in 0..states {
            let through: f64 = by_rates.iter().enumerate().map(|(i, by)| by * partial.rates_by_states[i * states + j]).sum();
            partial.force_by_states[j] = self.force.derivative(FIRST_STATE + j, &values) + through;
        }
        let through: f64 = by_rates.iter().zip(&partial.rates_by_slip).map(|(by, slip)| by * slip).sum();
        partial.force_by_slip = self.force.derivative(SLIP, &values) + through;
        true
    }

    fn switches(&self) -> Vec<bool> {
        let mut switches = vec![false; self.relays.len()];
        // The arguments of `sign`: positive until their first event says otherwise.
        switches.resize(self.relays.len() + self.arguments.len(), true);
        switches
    }

    fn margin(&self, switch: usize, at: &At) -> f64 {
        let mut values = self.values(at);
        if let Some((on, off)) = self.relays.get(switch) {
            return -if at.switches[switch] { off.value(&values) } else { on.value(&values) };
        }
        for (function, place) in self.rates.iter().zip(self.places.rates..) {
            values[place] = function.value(&values);
        }
        let argument = self.arguments[switch - self.relays.len()].value(&values);
        if at.switches[switch] { argument } else { -argument }
    }
}
