//! Trait of the converters.

use firmware::seam::block::{DriveBlock, SenseBlock};

/// Analog side of the controller: plays a block of drive codes while it samples a block of sense
/// codes.
///
/// One call is one block of virtual time: `sense` holds the codes sampled **while** `drive` played.
/// An implementation fills `sense.v` and `sense.i` with as many codes as each lane of `drive` has,
/// and the slow readings of its sensors.
pub trait Analog {
    /// Plays `drive` and fills `sense` with the codes sampled at the same time.
    fn exchange(&mut self, drive: &DriveBlock, sense: &mut SenseBlock);
}

impl<A: Analog + ?Sized> Analog for &mut A {
    fn exchange(&mut self, drive: &DriveBlock, sense: &mut SenseBlock) {
        (**self).exchange(drive, sense);
    }
}
