//! What is added up over the steps of one block.

/// Sums over the steps of a block.
#[derive(Clone, Debug)]
pub(super) struct Sums {
    pub(super) lost: f64,
    pub(super) current_peak: f64,
    /// Power into the further modes, and lost in them.
    pub(super) further_supplied: f64,
    pub(super) further_lost: f64,
    pub(super) in_phase: f64,
    pub(super) quadrature: f64,
    pub(super) friction: f64,
    pub(super) friction_on_tip: f64,
    pub(super) friction_min: f64,
    pub(super) friction_max: f64,
}

impl Sums {
    pub(super) fn new() -> Self {
        Sums {
            lost: 0.0,
            current_peak: 0.0,
            further_supplied: 0.0,
            further_lost: 0.0,
            in_phase: 0.0,
            quadrature: 0.0,
            friction: 0.0,
            friction_on_tip: 0.0,
            friction_min: f64::INFINITY,
            friction_max: f64::NEG_INFINITY,
        }
    }
}
