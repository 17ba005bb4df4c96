//! Field update of the flashed image on the model of its microcontroller: first stage, image in the
//! slot, link. Skipped, with a message, if the images cannot be built.

mod cuts;
mod images;
mod refusals;
mod whole;
