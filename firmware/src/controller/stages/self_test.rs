//! The self-test as a stage: what it has measured is the noise that all later stages reckon with.

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

    // Not inlined: what runs in every block is small enough for the fast memory of a board so.
    #[inline(never)]
    fn step(&mut self, chain: &mut Chain, measured: &Measured) -> Step {
        let played_v = measured.played.volts * measured.played.audible.unwrap_or(1.0);
        let step = self.listen(&mut chain.convert, measured.sense, measured.sensed, played_v);
        if matches!(step, Step::Done { .. }) {
            // Known before, and said after what is wrong with lane 0, beside which the others are judged.
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
