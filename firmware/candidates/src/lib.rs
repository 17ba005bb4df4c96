//! Ways to make a sine and a cosine from a phase of 2^64 a turn: what a drive's generator could be.
//!
//! Each is one [`Generator`]. The image `counts` counts its instructions on the target, the host measures its error and its spectrum:
//! both walk the same list, [`each`]. Nothing of this is part of the controller, except the one it uses today ([`today`]).
#![no_std]
#![forbid(unsafe_code)]

#[cfg(test)]
extern crate std;

pub mod folded;
pub mod generator;
pub mod others;
pub mod recursive;
pub mod sines;
pub mod table;
pub mod table_of_pairs;
pub mod today;

pub use generator::{Generator, Pair};

/// Does something with every generator.
pub trait Visitor {
    /// Takes the next one.
    fn visit<G: Generator>(&mut self);
}

/// Every generator, from the plainest table on.
pub fn each(visitor: &mut impl Visitor) {
    visitor.visit::<table::Nearest>();
    visitor.visit::<table::Interpolated>();
    visitor.visit::<today::Rotation>();
    visitor.visit::<today::Swung>();
    visitor.visit::<table_of_pairs::FirstOrder256>();
    visitor.visit::<table_of_pairs::FirstOrder512>();
    visitor.visit::<table_of_pairs::FirstOrder1024>();
    visitor.visit::<table_of_pairs::SecondOrder256>();
    visitor.visit::<table_of_pairs::SecondOrder512>();
    visitor.visit::<folded::Degree5>();
    visitor.visit::<folded::Degree7>();
    visitor.visit::<folded::Degree9>();
    visitor.visit::<folded::Integer>();
    visitor.visit::<recursive::RotatingPhasor>();
    visitor.visit::<recursive::Recurrence>();
    visitor.visit::<others::Idsp>();
    visitor.visit::<others::Micromath>();
    visitor.visit::<others::Libm>();
}
