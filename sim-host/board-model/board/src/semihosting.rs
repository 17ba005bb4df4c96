//! Semihosting of ARM, limited to the calls of the image: files of the host through breakpoints.

use cortex_m4::{Access, Breakpoint, Chip, Cycle, Fault, Memory, Ports};

/// Handle of the file of records from the host.
const FROM_HOST: u32 = 3;
/// Handle of the file of records to the host.
const TO_HOST: u32 = 4;
/// Handle of the messages.
const MESSAGES: u32 = 2;

/// Finding that the image waits for a record.
#[derive(Debug, thiserror::Error)]
#[error("the image waits for a record")]
pub struct Waits;

/// Finding that the image has ended, or makes an unknown call.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
struct Ended(String);

/// Chip with semihosting and nothing else.
#[derive(Default)]
pub struct Host {
    /// Bytes that the image has not read yet.
    pub from_host: Vec<u8>,
    /// Bytes that the image has written.
    pub to_host: Vec<u8>,
    messages: String,
}

impl Chip for Host {
    fn read(&mut self, _: Access, _: Ports) -> Result<u32, Fault> {
        Err(Fault::Bus)
    }
    fn write(&mut self, _: Access, _: u32, _: Ports) -> Result<(), Fault> {
        Err(Fault::Bus)
    }
    fn due(&self) -> Cycle {
        Cycle::MAX
    }
    fn advance(&mut self, _: Cycle, _: Ports) -> Result<(), Fault> {
        Ok(())
    }
    fn fetch_wait(&mut self, _: u32, _: Cycle) -> u32 {
        0
    }
    fn load_wait(&mut self, _: u32, _: Cycle) -> u32 {
        0
    }
    fn damaged(&mut self, _: u32, _: Ports) -> Result<(), Fault> {
        Ok(())
    }
    fn lockup(&mut self, _: Cycle, _: Ports) -> Result<(), Fault> {
        Err(Fault::Stop(Box::new(Ended("the processor has locked up".into()))))
    }
    fn reset(&mut self, _: Cycle, _: Ports) {}

    fn breakpoint(&mut self, breakpoint: Breakpoint, ports: Ports) -> Result<Option<u32>, Fault> {
        if breakpoint.number != 0xAB {
            return Ok(None);
        }
        let ended = |why: String| Err(Fault::Stop(Box::new(Ended(why)) as _));
        let memory = ports.memory;
        let block = |word: u32| word_at(memory, breakpoint.r1 + 4 * word);
        match breakpoint.r0 {
            // SYS_OPEN: a name and its length.
            0x01 => {
                let name = memory.get(block(0), block(2) as usize).unwrap_or_default();
                Ok(Some(match name {
                    b"/dev/fd/3" => FROM_HOST,
                    b"/dev/fd/4" => TO_HOST,
                    _ => MESSAGES,
                }))
            }
            // SYS_WRITE: a file, bytes and their number; returns the number of bytes that are not
            // written.
            0x05 => {
                let bytes = memory.get(block(1), block(2) as usize).unwrap_or_default();
                match block(0) {
                    TO_HOST => self.to_host.extend_from_slice(bytes),
                    _ => self.messages.push_str(&String::from_utf8_lossy(bytes)),
                }
                Ok(Some(0))
            }
            // SYS_READ: a file, an address and a number of bytes; returns the number that is not
            // read.
            0x06 => {
                let (to, len) = (block(1), block(2) as usize);
                let count = len.min(self.from_host.len());
                if count == 0 {
                    return Err(Fault::Stop(Box::new(Waits)));
                }
                if let Some(room) = memory.get_mut(to, count) {
                    self.from_host.drain(..count).zip(room).for_each(|(byte, place)| *place = byte);
                }
                Ok(Some((len - count) as u32))
            }
            // SYS_EXIT and SYS_EXIT_EXTENDED
            0x18 | 0x20 => ended(format!("the image has ended: {}", self.messages.trim())),
            other => ended(format!("semihosting call {other:#04x} is not supported")),
        }
    }
}

fn word_at(memory: &Memory, address: u32) -> u32 {
    memory.get(address, 4).and_then(|bytes| bytes.first_chunk()).map_or(0, |bytes| u32::from_le_bytes(*bytes))
}
