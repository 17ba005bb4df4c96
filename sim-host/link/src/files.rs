//! Files of commands: on the disk, or in memory for a program without a disk, such as a page in a
//! browser.

pub mod in_memory;
#[cfg(feature = "host")]
mod on_disk;

#[cfg(not(feature = "host"))]
pub use in_memory::{ResultFolder, read};
#[cfg(feature = "host")]
pub use on_disk::{ResultFolder, read};
