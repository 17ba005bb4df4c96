//! Instructions on the target: runs the image `counts` in QEMU.

use std::process::Command;

use serde::Deserialize;

use crate::evidence::Error;
use pil::machine::{ARGUMENTS, NO_SERIAL, PROGRAM, machine};
use pil::{PilError, counting_image};

/// Number of instructions in one tick of the system timer: 168 MHz, and a nanosecond per
/// instruction.
pub const INSTRUCTIONS_PER_TICK: f64 = 1000.0 / 168.0;

/// Counts of one kernel, as the image prints them.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct Counted {
    /// Group of the kernel.
    pub group: String,
    /// Name of the kernel.
    pub kernel: String,
    /// Number of samples in one repetition.
    pub samples: u32,
    /// Number of repetitions.
    pub repetitions: u32,
    /// Ticks of all repetitions.
    pub ticks: i64,
}

impl Counted {
    /// Returns the instructions of one repetition, which is a block.
    pub fn per_block(&self) -> f64 {
        self.ticks as f64 * INSTRUCTIONS_PER_TICK / f64::from(self.repetitions)
    }

    /// Returns the instructions per sample.
    pub fn per_sample(&self) -> f64 {
        self.per_block() / f64::from(self.samples)
    }
}

/// Builds the image, runs it, and reads its output.
pub fn count() -> Result<Vec<Counted>, Error> {
    let image = counting_image()?;
    let output = Command::new(PROGRAM)
        .args(["-M", machine(&image).map_err(PilError::Start)?])
        .args(NO_SERIAL)
        .args(ARGUMENTS)
        .arg(&image)
        .output()
        .map_err(PilError::Start)?;
    if !output.status.success() {
        let message = String::from_utf8_lossy(&output.stderr);
        return Err(Error::Counts(format!("{}: {}", output.status, message.trim())));
    }
    read(&output.stdout)
}

/// Reads the kernels from the CSV that the image prints.
fn read(text: &[u8]) -> Result<Vec<Counted>, Error> {
    let lines: Result<Vec<Counted>, csv::Error> = csv::Reader::from_reader(text).deserialize().collect();
    let counted = lines.map_err(|error| Error::Counts(error.to_string()))?;
    match counted.iter().find(|kernel| kernel.repetitions == 0 || kernel.ticks <= 0) {
        Some(kernel) => Err(Error::Counts(format!("{kernel:?}"))),
        None => Ok(counted),
    }
}

/// Finds a kernel by group and name.
pub fn find<'a>(counted: &'a [Counted], group: &str, kernel: &str) -> Result<&'a Counted, Error> {
    let found = counted.iter().find(|counted| counted.group == group && counted.kernel == kernel);
    found.ok_or_else(|| Error::Counts(format!("there is no {kernel:?} among the counts of {group:?}")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_read_and_ticks_are_instructions() {
        let counted = read(b"group,kernel,samples,repetitions,ticks\nstage,\"a, b\",32,100,16800\n").unwrap();
        let kernel = find(&counted, "stage", "a, b").unwrap();
        assert_eq!(kernel.per_block(), 1000.0);
        assert_eq!(kernel.per_sample(), 31.25);
        assert!(find(&counted, "process", "a, b").is_err());
    }

    #[test]
    fn invalid_counts_are_refused() {
        for text in ["group,kernel,samples,repetitions,ticks\nstage,a,32,0,5\n", "group,kernel\nstage,a\n", "stage,a,32,1,0\nb"] {
            assert!(read(text.as_bytes()).is_err(), "{text:?}");
        }
    }
}
