//! The converters, as one trait.

use firmware::seam::block::{DriveBlock, SenseBlock};

/// An analog side: it plays a block of drive codes and samples a block of sense codes at the same time.
///
/// One call is one block of virtual time: `sense` holds what was sampled **while** `drive` played. An implementer fills
/// `sense.v` and `sense.i` with as many codes as each lane of `drive` has, and the slow readings it has sensors for.
pub trait Analog {
    /// Plays `drive`, and fills `sense` with the codes sampled meanwhile.
    fn exchange(&mut self, drive: &DriveBlock, sense: &mut SenseBlock);
}

impl<A: Analog + ?Sized> Analog for &mut A {
    fn exchange(&mut self, drive: &DriveBlock, sense: &mut SenseBlock) {
        (**self).exchange(drive, sense);
    }
}
