//! The measurement of the clamped branch at power-on as a stage: the observer begins on what it has found.

use crate::controller::chain::{Chain, Measured};
use crate::controller::stages::Stage;
use crate::find::clamped::PowerOn;
use crate::generate::step::Step;

impl Stage for PowerOn {
    fn begin(&mut self, _: &mut Chain) {
        self.restart();
    }

    // Not inlined: what runs in every block is small enough for the fast memory of a board so.
    #[inline(never)]
    fn step(&mut self, chain: &mut Chain, measured: &Measured) -> Step {
        let step = self.listen(measured.sensed);
        // Taken in silence; the block in which it is over has its tone.
        if let (Step::Silence, Some(clamped)) = (step, self.found()) {
            chain.generator.sweep.hold.retune(0.0);
            chain.track.observe(clamped);
        }
        step
    }
}
