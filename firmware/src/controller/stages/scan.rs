//! The scan as a stage; both loops start from the transducer that it finds.

use crate::controller::chain::{Chain, Measured};
use crate::controller::stages::Stage;
use crate::find::scan::Scan;
use crate::generate::step::Step;
use crate::seam::block::Request;
use crate::seam::fault::Fault;
use crate::seam::phasor::magnitude;

impl Stage for Scan {
    fn begin(&mut self, _: &mut Chain) {
        self.restart();
    }

    // Not inlined: the code of every block must fit into the fast memory of a board.
    #[inline(never)]
    fn step(&mut self, chain: &mut Chain, measured: &Measured) -> Step {
        let step = self.listen(&chain.convert, measured.sense, measured.sensed);
        // An ordered scan reports a window without a resonance; a run repeats the scan.
        if matches!(step, Step::Failed(Fault::NoResonance))
            && measured.orders.request == Request::Run
            && let Some(step) = self.repeat()
        {
            return step;
        }
        if let Step::Failed(fault) = step
            && self.drives()
        {
            chain.generator.fade();
            return self.fail(fault);
        }
        if let (Step::Done { volts }, Some(found)) = (step, self.found()) {
            chain.track.adopt(found, self.modes());
            chain.generator.sweep.hold.retune(chain.track.tracker.offset_hz());
            chain.generator.amplitude.seed(&found.transducer, magnitude(measured.motional), volts);
        }
        step
    }
}
