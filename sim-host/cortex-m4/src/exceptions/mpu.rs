//! The memory protection unit (B3.5), for data. Fetches are not checked.

const REGIONS: usize = 8;

/// The eight regions of the Cortex-M4's MPU.
#[derive(Clone, Debug, Default)]
pub(crate) struct Mpu {
    /// MPU_CTRL.ENABLE
    pub(crate) enabled: bool,
    control: u32,
    number: usize,
    /// MPU_RBAR without its region number, MPU_RASR.
    regions: [(u32, u32); REGIONS],
}

impl Mpu {
    /// By the offset from MPU_TYPE.
    pub(crate) fn read(&self, register: u32) -> u32 {
        match register {
            0x00 => (REGIONS as u32) << 8,
            0x04 => self.control,
            0x08 => self.number as u32,
            0x0C | 0x14 | 0x1C | 0x24 => self.regions[self.number].0 | self.number as u32,
            _ => self.regions[self.number].1,
        }
    }

    pub(crate) fn write(&mut self, register: u32, value: u32) {
        match register {
            0x04 => {
                self.control = value & 7;
                self.enabled = value & 1 == 1;
            }
            0x08 => self.number = value as usize % REGIONS,
            0x0C | 0x14 | 0x1C | 0x24 => {
                // VALID: the value names its region.
                if value & 1 << 4 != 0 {
                    self.number = value as usize % REGIONS;
                }
                self.regions[self.number].0 = value & !0x1F;
            }
            0x10 | 0x18 | 0x20 | 0x28 => self.regions[self.number].1 = value,
            _ => {}
        }
    }

    /// Whether an access may happen. `negative` is an execution priority below 0, which the MPU sits out unless HFNMIENA is set.
    pub(crate) fn allows(&self, address: u32, write: bool, privileged: bool, negative: bool) -> bool {
        if negative && self.control & 2 == 0 || address >> 20 == 0xE00 {
            return true;
        }
        let hit = self.regions.iter().rev().find(|(base, attributes)| {
            let bits = (attributes >> 1 & 0x1F) + 1;
            if attributes & 1 == 0 || bits < 5 {
                return false;
            }
            let size = 1u64 << bits;
            let offset = u64::from(address).wrapping_sub(u64::from(*base) & !(size - 1));
            // From 256 bytes on each eighth can be left out.
            offset < size && (bits < 8 || attributes >> (8 + (offset >> (bits - 3))) & 1 == 0)
        });
        let Some((_, attributes)) = hit else { return privileged && self.control & 4 != 0 };
        match (attributes >> 24 & 7, write) {
            (0b001, _) | (0b010, true) => privileged,
            (0b010, false) | (0b011, _) => true,
            (0b101, false) => privileged,
            (0b110 | 0b111, false) => true,
            _ => false,
        }
    }
}
