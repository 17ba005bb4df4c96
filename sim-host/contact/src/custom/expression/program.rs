//! Expressions as programs for a stack, which give a value and its derivative.
//!
//! A program needs no recursion, so that a long sum is as cheap as its terms. The crate `exmex` was
//! tried instead: it has no derivative of `abs` and `cbrt`, reads `1e-3` as a name and `-v^2` as
//! `(-v)^2`, and overflows the stack of a thread for long sums.

/// Largest number of values on the stack.
pub(super) const MAX_STACK: usize = 96;

/// Value with its derivative.
#[derive(Clone, Copy, Debug, Default)]
struct Dual {
    value: f64,
    slope: f64,
}

/// Function of one argument.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Function {
    Exp,
    Ln,
    Log10,
    Sqrt,
    Cbrt,
    Sin,
    Cos,
    Tan,
    Asin,
    Acos,
    Atan,
    Sinh,
    Cosh,
    Tanh,
    Abs,
}

/// Functions without kinks, by name.
pub(super) const FUNCTIONS: [(&str, Function); 14] = [
    ("exp", Function::Exp),
    ("ln", Function::Ln),
    ("log10", Function::Log10),
    ("sqrt", Function::Sqrt),
    ("cbrt", Function::Cbrt),
    ("sin", Function::Sin),
    ("cos", Function::Cos),
    ("tan", Function::Tan),
    ("asin", Function::Asin),
    ("acos", Function::Acos),
    ("atan", Function::Atan),
    ("sinh", Function::Sinh),
    ("cosh", Function::Cosh),
    ("tanh", Function::Tanh),
];

impl Function {
    /// Returns the function at a value, and its derivative there.
    fn at(self, x: f64) -> (f64, f64) {
        match self {
            Function::Exp => (x.exp(), x.exp()),
            Function::Ln => (x.ln(), x.recip()),
            Function::Log10 => (x.log10(), (x * std::f64::consts::LN_10).recip()),
            Function::Sqrt => (x.sqrt(), 0.5 / x.sqrt()),
            Function::Cbrt => (x.cbrt(), x.cbrt().powi(-2) / 3.0),
            Function::Sin => (x.sin(), x.cos()),
            Function::Cos => (x.cos(), -x.sin()),
            Function::Tan => (x.tan(), x.cos().powi(-2)),
            Function::Asin => (x.asin(), (1.0 - x * x).sqrt().recip()),
            Function::Acos => (x.acos(), -(1.0 - x * x).sqrt().recip()),
            Function::Atan => (x.atan(), (1.0 + x * x).recip()),
            Function::Sinh => (x.sinh(), x.cosh()),
            Function::Cosh => (x.cosh(), x.sinh()),
            Function::Tanh => (x.tanh(), x.cosh().powi(-2)),
            Function::Abs => (x.abs(), x.signum()),
        }
    }
}

/// Step of a program.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Step {
    Number(f64),
    /// Value at this place.
    Variable(usize),
    Add,
    Subtract,
    Multiply,
    Divide,
    Power,
    Negate,
    Call(Function),
    Max,
    Min,
    /// Replaces the top by the value at this place: the sign of the top, constant between two
    /// events.
    Sign(usize),
}

/// Program in postfix order.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Program(Vec<Step>);

impl Program {
    /// Builds a program; `None` if it needs too large a stack.
    pub(super) fn new(steps: Vec<Step>) -> Option<Self> {
        let mut depth = 0usize;
        for step in &steps {
            match step {
                Step::Number(_) | Step::Variable(_) => depth += 1,
                Step::Negate | Step::Call(_) | Step::Sign(_) => {}
                _ => depth -= 1,
            }
            if depth > MAX_STACK {
                return None;
            }
        }
        Some(Program(steps))
    }

    /// Returns `true` if the value at a place is used.
    pub(super) fn uses(&self, place: usize) -> bool {
        self.0.iter().any(|step| matches!(step, Step::Variable(used) | Step::Sign(used) if *used == place))
    }

    /// Returns the value.
    pub(super) fn value(&self, values: &[f64]) -> f64 {
        self.run(values, usize::MAX).value
    }

    /// Returns the derivative by the value at a place.
    pub(super) fn derivative(&self, place: usize, values: &[f64]) -> f64 {
        self.run(values, place).slope
    }

    fn run(&self, values: &[f64], by: usize) -> Dual {
        let mut stack = [Dual::default(); MAX_STACK];
        let mut top = 0;
        for step in &self.0 {
            match *step {
                Step::Number(value) => {
                    stack[top] = Dual { value, slope: 0.0 };
                    top += 1;
                }
                Step::Variable(place) => {
                    stack[top] = Dual { value: values[place], slope: f64::from(u8::from(place == by)) };
                    top += 1;
                }
                Step::Sign(place) => stack[top - 1] = Dual { value: values[place], slope: 0.0 },
                Step::Negate => {
                    let x = &mut stack[top - 1];
                    (x.value, x.slope) = (-x.value, -x.slope);
                }
                Step::Call(function) => {
                    let x = &mut stack[top - 1];
                    let (value, slope) = function.at(x.value);
                    *x = Dual { value, slope: if x.slope == 0.0 { 0.0 } else { slope * x.slope } };
                }
                _ => {
                    top -= 1;
                    stack[top - 1] = binary(*step, stack[top - 1], stack[top]);
                }
            }
        }
        stack[0]
    }
}

fn binary(step: Step, a: Dual, b: Dual) -> Dual {
    match step {
        Step::Add => Dual { value: a.value + b.value, slope: a.slope + b.slope },
        Step::Subtract => Dual { value: a.value - b.value, slope: a.slope - b.slope },
        Step::Multiply => Dual { value: a.value * b.value, slope: a.slope * b.value + a.value * b.slope },
        Step::Divide => {
            let value = a.value / b.value;
            Dual { value, slope: (a.slope - value * b.slope) / b.value }
        }
        Step::Max => {
            if a.value >= b.value {
                a
            } else {
                b
            }
        }
        Step::Min => {
            if a.value <= b.value {
                a
            } else {
                b
            }
        }
        _ => {
            let value = a.value.powf(b.value);
            // Each part only if it is needed: zero times infinity is not zero.
            let of_base = if a.slope == 0.0 { 0.0 } else { b.value * a.value.powf(b.value - 1.0) * a.slope };
            let of_exponent = if b.slope == 0.0 { 0.0 } else { value * a.value.ln() * b.slope };
            Dual { value, slope: of_base + of_exponent }
        }
    }
}
