//! A span of webbing: its tension and its stored energy.
//!
//! ```text
//! T = T0 + k e            e < 0            the pretension relaxes
//!   = T0                  0 <= e <= slack  clothes and cushions yield
//!   = T0 + k (e - slack)  e > slack
//! ```

/// A span of webbing, as a spring with slack.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Span {
    /// Stiffness of the span, N/m.
    pub stiffness_n_per_m: f64,
    /// Elongation at constant force, m.
    pub slack_m: f64,
    /// Tension before the crash, N.
    pub pretension_n: f64,
}

/// Part of the law that applies to a span.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// The span is shorter than before the crash.
    Loose,
    /// The span is within its slack.
    Slack,
    /// The span is stretched beyond its slack.
    Taut,
}

impl Span {
    /// Returns the tension at an elongation, in one part of the law, N.
    pub fn tension_n(&self, elongation_m: f64, part: Part) -> f64 {
        self.pretension_n + self.stiffness_n_per_m * self.stretch_m(elongation_m, part)
    }

    /// Stiffness in one part of the law, N/m.
    pub fn slope_n_per_m(&self, part: Part) -> f64 {
        if part == Part::Slack { 0.0 } else { self.stiffness_n_per_m }
    }

    /// Returns the stored energy, J, relative to zero elongation.
    pub fn stored_j(&self, elongation_m: f64, part: Part) -> f64 {
        let stretch = self.stretch_m(elongation_m, part);
        self.pretension_n * elongation_m + 0.5 * self.stiffness_n_per_m * stretch * stretch
    }

    fn stretch_m(&self, elongation_m: f64, part: Part) -> f64 {
        match part {
            Part::Loose => elongation_m,
            Part::Slack => 0.0,
            Part::Taut => elongation_m - self.slack_m,
        }
    }
}
