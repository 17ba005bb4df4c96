//! The self-test as a stage; all later stages use the noise that it measures.

use crate::controller::chain::{Chain, Measured};
use crate::controller::stages::Stage;
use crate::find::self_test::SelfTest;
use crate::generate::step::Step;

impl Stage for SelfTest {
    fn begin(&mut self, chain: &mut Chain) {
        chain.convert.v.restore_zero();
        chain.convert.i.restore_zero();
        self.restart();
    }

    // Not inlined: the code of every block must fit into the fast memory of a board.
    #[inline(never)]
    fn step(&mut self, chain: &mut Chain, measured: &Measured) -> Step {
        let played_v = measured.played.volts * measured.played.audible.unwrap_or(1.0);
        let step = self.listen(&mut chain.convert, measured.sense, measured.sensed, played_v);
        if matches!(step, Step::Done { .. }) {
            // Reported only after lane 0 has passed, because the other lanes are compared with it.
            if let Some(fault) = chain.lanes.found() {
                return Step::Failed(fault);
            }
            let (v, i) = self.noise();
            let (convert, samples) = (&chain.convert, chain.generator.samples);
            chain.track.noise = (convert.v.phasor_variance(v, samples), convert.i.phasor_variance(i, samples));
            chain.generator.sweep.hold.retune(0.0);
        }
        match step {
            Step::Tone { offset_hz, volts, .. } => Step::Tone { offset_hz, volts, lane: chain.lanes.ordered() },
            step => step,
        }
    }
}
