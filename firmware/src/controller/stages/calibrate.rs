//! The calibration of the lanes as a stage. Afterwards the lane with the largest gain under the new
//! trims determines the voltage limit.

use crate::controller::chain::{Chain, Measured};
use crate::controller::stages::Stage;
use crate::find::calibrate::Calibrate;
use crate::generate::step::Step;

impl Stage for Calibrate {
    fn begin(&mut self, chain: &mut Chain) {
        self.abandon(&mut chain.generator.phasing);
    }

    // Not inlined: the code of every block must fit into the fast memory of a board.
    #[inline(never)]
    fn step(&mut self, chain: &mut Chain, measured: &Measured) -> Step {
        let step = self.listen(&mut chain.generator.phasing, measured.sensed);
        if matches!(step, Step::Done { .. }) {
            chain.generator.sweep.hold.retune(0.0);
            chain.generator.set_loudest();
        }
        step
    }
}
