//! Field update of the flashed image on the model of its part: first stage, image in the slot, link. Skipped, with a message, where the images cannot be built.

mod cuts;
mod images;
mod refusals;
mod whole;
