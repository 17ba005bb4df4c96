//! The measurement of the clamped branch at power-on as a stage; the observer starts from its
//! result.

use crate::controller::chain::{Chain, Measured};
use crate::controller::stages::Stage;
use crate::find::clamped::PowerOn;
use crate::generate::step::Step;

impl Stage for PowerOn {
    fn begin(&mut self, _: &mut Chain) {
        self.restart();
    }

    // Not inlined: the code of every block must fit into the fast memory of a board.
    #[inline(never)]
    fn step(&mut self, chain: &mut Chain, measured: &Measured) -> Step {
        let step = self.listen(measured.sensed);
        // The result is taken in silence; the last block of the measurement still has its tone.
        if let (Step::Silence, Some(clamped)) = (step, self.found()) {
            chain.generator.sweep.hold.retune(0.0);
            chain.track.observe(clamped);
        }
        step
    }
}
