//! Translation of a user's text to a program.

use std::collections::BTreeMap;

use super::program::{FUNCTIONS, Function, Program, Step};
use super::{COULOMB, ExpressionError, FIRST_STATE, MAX_NAMES, MU, NORMAL, Places, SIGN, SLIP, Source};

/// Functions with kinks, and the number of their arguments.
const KINKED: [(&str, usize); 4] = [("abs", 1), ("sign", 1), ("max", 2), ("min", 2)];
/// Largest depth of parentheses, functions and signs.
const MAX_DEPTH: u32 = 64;
/// Largest number of steps of a text, each as often as its value is needed.
const MAX_STEPS: usize = 20_000;

/// Names of a law and their places.
#[derive(Debug)]
pub(super) struct Names {
    by_name: BTreeMap<String, usize>,
    places: Places,
}

impl Names {
    pub(super) fn new(source: &Source) -> Result<Self, ExpressionError> {
        let rates = FIRST_STATE + source.rates.len();
        let parameters = rates + source.rates.len();
        let relays = parameters + source.parameters.len();
        let places = Places { rates, parameters, relays, arguments: relays + source.relays.len() };
        let given = [("v", SLIP), ("N", NORMAL), ("mu", MU), ("Fc", COULOMB)];
        let mut names = Names { by_name: given.map(|(name, place)| (name.to_owned(), place)).into(), places };
        for (index, state) in source.rates.keys().enumerate() {
            let key = format!("rate.{state}");
            names.add(&key, state, FIRST_STATE + index)?;
            names.add(&key, &format!("d{state}"), rates + index)?;
        }
        for (place, parameter) in (parameters..).zip(source.parameters.keys()) {
            names.add(&format!("parameter.{parameter}"), parameter, place)?;
        }
        for (place, relay) in (relays..).zip(source.relays.keys()) {
            names.add(&format!("relay.{relay}"), relay, place)?;
        }
        match source.start.keys().find(|state| !source.rates.contains_key(*state)) {
            Some(state) => {
                let message = format!("`{state}` has a start, but no rate");
                Err(ExpressionError { key: format!("start.{state}"), message })
            }
            None => Ok(names),
        }
    }

    pub(super) fn places(&self) -> Places {
        self.places
    }

    fn add(&mut self, key: &str, name: &str, place: usize) -> Result<(), ExpressionError> {
        let mut letters = name.chars();
        let is_name = letters.next().is_some_and(|letter| letter.is_ascii_alphabetic())
            && letters.all(|letter| letter.is_ascii_alphanumeric() || letter == '_');
        let message = if !is_name {
            format!("`{name}` is not a name: a letter comes first, then letters, digits and _")
        } else if name == "pi" || is_function(name) {
            format!("`{name}` already means something else")
        } else if place >= MAX_NAMES {
            format!("a law has at most {MAX_NAMES} names")
        } else if self.by_name.insert(name.to_owned(), place).is_some() {
            format!("`{name}` is the name of two things")
        } else {
            return Ok(());
        };
        Err(ExpressionError { key: key.to_owned(), message })
    }

    fn place(&self, name: &str, with_rates: bool) -> Result<usize, String> {
        let is_rate = |place: usize| (self.places.rates..self.places.parameters).contains(&place);
        match self.by_name.get(name) {
            Some(place) if !with_rates && is_rate(*place) => Err(format!("`{name}`, a rate, can be used only in `force`")),
            Some(place) => Ok(*place),
            None => {
                let known: Vec<&str> = self.by_name.keys().map(String::as_str).collect();
                Err(format!("`{name}` is not known; the names here are {}", known.join(", ")))
            }
        }
    }
}

fn is_function(name: &str) -> bool {
    function(name).is_some() || KINKED.iter().any(|(known, _)| *known == name)
}

fn function(name: &str) -> Option<Function> {
    FUNCTIONS.iter().find(|(known, _)| *known == name).map(|(_, function)| *function)
}

/// Translates a text; only the force may use the rates of the states. The argument of each kink is
/// added to `arguments`.
pub(super) fn parse(text: &str, names: &Names, with_rates: bool, arguments: &mut Vec<Program>) -> Result<Program, String> {
    let mut parser = Parser { tokens: tokens(text)?, next: 0, names, with_rates, arguments, depth: 0 };
    let steps = parser.sum()?;
    match parser.tokens.get(parser.next) {
        None => program(steps),
        Some(token) => Err(format!("unexpected `{token}`")),
    }
}

fn program(steps: Vec<Step>) -> Result<Program, String> {
    Program::new(steps).ok_or_else(|| "the expression is nested too deeply".to_owned())
}

/// Splits a text into numbers, names and signs.
fn tokens(text: &str) -> Result<Vec<String>, String> {
    let mut tokens = Vec::new();
    let mut rest = text.trim_start();
    while let Some(first) = rest.chars().next() {
        let length = if first.is_ascii_digit() || first == '.' {
            number_length(rest)
        } else if first.is_ascii_alphabetic() {
            rest.find(|letter: char| !letter.is_ascii_alphanumeric() && letter != '_').unwrap_or(rest.len())
        } else if "+-*/^(),".contains(first) {
            1
        } else {
            return Err(format!("`{}` cannot be used in an expression", first.escape_debug()));
        };
        tokens.push(rest[..length].to_owned());
        rest = rest[length..].trim_start();
    }
    Ok(tokens)
}

/// Returns the length of the number at the beginning, with its exponent.
fn number_length(text: &str) -> usize {
    let after_digits =
        |from: usize| text[from..].find(|letter: char| !letter.is_ascii_digit()).map_or(text.len(), |length| from + length);
    let mut end = after_digits(0);
    if text[end..].starts_with('.') {
        end = after_digits(end + 1);
    }
    if text[end..].starts_with(['e', 'E']) {
        let digits = end + 1 + usize::from(text[end + 1..].starts_with(['+', '-']));
        if text[digits..].starts_with(|letter: char| letter.is_ascii_digit()) {
            end = after_digits(digits);
        }
    }
    end
}

struct Parser<'a> {
    tokens: Vec<String>,
    next: usize,
    names: &'a Names,
    with_rates: bool,
    arguments: &'a mut Vec<Program>,
    depth: u32,
}

impl Parser<'_> {
    fn accept(&mut self, token: &str) -> bool {
        let is_next = self.tokens.get(self.next).is_some_and(|next| next == token);
        self.next += usize::from(is_next);
        is_next
    }

    fn expect(&mut self, token: &str) -> Result<(), String> {
        if self.accept(token) {
            return Ok(());
        }
        Err(match self.tokens.get(self.next) {
            Some(next) => format!("`{token}` is missing before `{next}`"),
            None => format!("`{token}` is missing at the end"),
        })
    }

    fn sum(&mut self) -> Result<Vec<Step>, String> {
        let mut steps = self.product()?;
        loop {
            let step = match self.accept("+") {
                true => Step::Add,
                false if self.accept("-") => Step::Subtract,
                false => return Ok(steps),
            };
            let next = self.product()?;
            append(&mut steps, next, step)?;
        }
    }

    fn product(&mut self) -> Result<Vec<Step>, String> {
        let mut steps = self.signed()?;
        loop {
            let step = match self.accept("*") {
                true => Step::Multiply,
                false if self.accept("/") => Step::Divide,
                false => return Ok(steps),
            };
            let next = self.signed()?;
            append(&mut steps, next, step)?;
        }
    }

    /// A sign binds less than a power: `-v^2` is `-(v^2)`.
    fn signed(&mut self) -> Result<Vec<Step>, String> {
        self.depth += 1;
        if self.depth > MAX_DEPTH {
            return Err(format!("an expression has at most {MAX_DEPTH} levels"));
        }
        let steps = if self.accept("-") {
            let mut steps = self.signed()?;
            steps.push(Step::Negate);
            steps
        } else if self.accept("+") {
            self.signed()?
        } else {
            self.power()?
        };
        self.depth -= 1;
        Ok(steps)
    }

    /// Powers bind to the right: `a^b^c` is `a^(b^c)`.
    fn power(&mut self) -> Result<Vec<Step>, String> {
        let mut steps = self.atom()?;
        if self.accept("^") {
            let next = self.signed()?;
            append(&mut steps, next, Step::Power)?;
        }
        Ok(steps)
    }

    fn atom(&mut self) -> Result<Vec<Step>, String> {
        let Some(token) = self.tokens.get(self.next).cloned() else {
            return Err(if self.tokens.is_empty() { "it is empty" } else { "something is missing at the end" }.to_owned());
        };
        self.next += 1;
        if token == "(" {
            let inner = self.sum()?;
            self.expect(")")?;
            return Ok(inner);
        }
        if token.starts_with(|letter: char| letter.is_ascii_digit() || letter == '.') {
            return Ok(vec![Step::Number(number(&token)?)]);
        }
        if !token.starts_with(|letter: char| letter.is_ascii_alphabetic()) {
            return Err(format!("unexpected `{token}`"));
        }
        if self.accept("(") {
            return self.call(&token);
        }
        if is_function(&token) {
            return Err(format!("`{token}` is a function: write `{token}(…)`"));
        }
        if token == "pi" {
            return Ok(vec![Step::Number(std::f64::consts::PI)]);
        }
        Ok(vec![Step::Variable(self.names.place(&token, self.with_rates)?)])
    }

    /// Translates a function after its opening parenthesis.
    fn call(&mut self, name: &str) -> Result<Vec<Step>, String> {
        let count = match KINKED.iter().find(|(known, _)| *known == name) {
            Some((_, count)) => *count,
            None if function(name).is_some() => 1,
            None if name == "log" => return Err("`log` has two meanings: write `ln` or `log10`".to_owned()),
            None => {
                let known: Vec<&str> = FUNCTIONS.iter().map(|(name, _)| *name).chain(KINKED.map(|(name, _)| name)).collect();
                return Err(format!("`{name}` is not a function; the functions are {}", known.join(", ")));
            }
        };
        let mut given = vec![self.sum()?];
        while self.accept(",") {
            given.push(self.sum()?);
        }
        self.expect(")")?;
        if given.len() != count {
            return Err(format!("`{name}` takes {count} argument{}", if count == 1 { "" } else { "s" }));
        }
        let second = if count == 2 { given.pop() } else { None };
        let mut steps = given.pop().unwrap_or_default();
        match (function(name), second) {
            (Some(function), _) => steps.push(Step::Call(function)),
            (None, Some(second)) => {
                let mut difference = steps.clone();
                append(&mut difference, second.clone(), Step::Subtract)?;
                self.sign(&difference)?;
                append(&mut steps, second, if name == "max" { Step::Max } else { Step::Min })?;
            }
            (None, None) => {
                let place = self.sign(&steps)?;
                steps.push(if name == "abs" { Step::Call(Function::Abs) } else { Step::Sign(place) });
            }
        }
        Ok(steps)
    }

    /// Returns the place of the sign of an argument, which is located where it changes.
    fn sign(&mut self, argument: &[Step]) -> Result<usize, String> {
        if argument == [Step::Variable(SLIP)] {
            return Ok(SIGN);
        }
        let argument = program(argument.to_vec())?;
        let known = self.arguments.iter().position(|known| *known == argument);
        let index = known.unwrap_or_else(|| {
            self.arguments.push(argument);
            self.arguments.len() - 1
        });
        let place = self.names.places.arguments + index;
        if place >= MAX_NAMES {
            return Err(format!("a law has at most {MAX_NAMES} names, each `sign`, `abs`, `max` and `min` included"));
        }
        Ok(place)
    }
}

/// Adds the steps of the second operand, and the step that joins both.
fn append(steps: &mut Vec<Step>, second: Vec<Step>, step: Step) -> Result<(), String> {
    steps.extend(second);
    steps.push(step);
    if steps.len() > MAX_STEPS {
        return Err(format!("the expression has more than {MAX_STEPS} steps"));
    }
    Ok(())
}

/// Parses a number. One that is too small would silently be zero.
fn number(token: &str) -> Result<f64, String> {
    let digits = token.split(['e', 'E']).next().unwrap_or_default();
    let is_zero = digits.chars().all(|letter| matches!(letter, '0' | '.'));
    let number = token.parse::<f64>().ok().filter(|number| number.is_finite() && (*number != 0.0 || is_zero));
    number.ok_or_else(|| format!("`{token}` is not a number"))
}
