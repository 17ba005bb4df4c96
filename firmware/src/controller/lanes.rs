//! The inputs of the lane check for one block.

use crate::controller::chain::Chain;
use crate::find::lanes::{Expected, Rule};
use crate::generate::signal_generator::Played;
use crate::seam::block::Orders;
use crate::seam::mode::Mode;
use crate::sense::demod::Sensed;

impl Chain {
    /// Passes a measured block of a drive with several lanes to the lane check. If the block is of
    /// another lane, the last phasors of lane 0 replace its own in `sensed`.
    // Not inlined: the fast memory of a board has no room for it.
    #[inline(never)]
    pub(super) fn listen_to_lanes(&mut self, orders: &Orders, played: &Played, sensed: &mut Sensed) {
        let Chain { supervisor, track, generator, lanes, calibrates, continuity, .. } = self;
        let rule = match supervisor.mode() {
            // The calibration selects its lanes itself.
            Mode::Calibrate => return lanes.return_home(),
            Mode::SelfTest if !*calibrates => Rule::Once,
            Mode::Run => Rule::InTurn,
            _ => Rule::Rest,
        };
        lanes.doubt(rule == Rule::InTurn && (track.is_in_doubt() || continuity.has_failed()));
        let tone = played.lane != 0 || played.audible.is_some();
        let steady = tone && played.is_full() && (rule == Rule::Once || generator.sweep.holds());
        let expected = Expected {
            quadrature: generator.phasing.quadrature(orders.quadrature).0,
            gain: generator.phasing.gain(played.lane.into()) / generator.phasing.gain(0),
            clamped_siemens: track.tracker.branch().y0.im.abs(),
        };
        lanes.update(played, sensed, if steady { rule } else { Rule::Rest }, &expected);
    }
}
