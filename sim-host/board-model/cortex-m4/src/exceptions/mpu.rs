//! Memory protection unit (B3.5), for data. Fetches are not checked.

const REGIONS: usize = 8;

/// Memory protection unit with eight regions.
#[derive(Clone, Debug, Default)]
pub(crate) struct Mpu {
    /// MPU_CTRL.ENABLE
    pub(crate) enabled: bool,
    control: u32,
    number: usize,
    /// MPU_RBAR without its region number, and MPU_RASR.
    regions: [(u32, u32); REGIONS],
    /// First address of the lowest enabled region, and number of bytes to the end of the last one.
    spanned: (u32, u64),
}

/// Returns the first address and the size of a region, if it is enabled.
fn span((base, attributes): (u32, u32)) -> Option<(u32, u64)> {
    let bits = (attributes >> 1 & 0x1F) + 1;
    if attributes & 1 == 0 || bits < 5 {
        return None;
    }
    let size = 1u64 << bits;
    Some(((u64::from(base) & !(size - 1)) as u32, size))
}

impl Mpu {
    /// Reads a register by its offset from MPU_TYPE.
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
                // VALID: the value contains the region number.
                if value & 1 << 4 != 0 {
                    self.number = value as usize % REGIONS;
                }
                self.regions[self.number].0 = value & !0x1F;
            }
            0x10 | 0x18 | 0x20 | 0x28 => self.regions[self.number].1 = value,
            _ => {}
        }
        let spans = || self.regions.iter().filter_map(|region| span(*region));
        let first = spans().map(|(first, _)| first).min().unwrap_or(0);
        let end = spans().map(|(first, size)| u64::from(first) + size).max().unwrap_or(0);
        self.spanned = (first, end - u64::from(first));
    }

    /// Returns `true` if privileged code has full access to an address, because it is outside the
    /// span of all regions (MPU_CTRL.PRIVDEFENA).
    #[inline(always)]
    pub(crate) fn is_open(&self, address: u32) -> bool {
        self.control & 4 != 0 && u64::from(address.wrapping_sub(self.spanned.0)) >= self.spanned.1
    }

    /// Returns `true` if an access is permitted. At a `negative` execution priority the MPU is
    /// inactive unless HFNMIENA is set.
    pub(crate) fn allows(&self, address: u32, write: bool, privileged: bool, negative: bool) -> bool {
        if negative && self.control & 2 == 0 || address >> 20 == 0xE00 {
            return true;
        }
        let hit = self.regions.iter().rev().find(|region| {
            let Some((first, size)) = span(**region) else { return false };
            let offset = u64::from(address).wrapping_sub(u64::from(first));
            // Regions of at least 256 bytes can exclude each eighth.
            offset < size && (size < 256 || region.1 >> (8 + offset * 8 / size) & 1 == 0)
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn open_addresses_are_allowed_and_regions_are_not_open() {
        let mut mpu = Mpu::default();
        // Two regions without access: 32 bytes at 0x2000_0100, and 256 at 0x2000_0400.
        for (number, base, bits) in [(0, 0x2000_0100, 5), (3, 0x2000_0400, 8)] {
            mpu.write(0x08, number);
            mpu.write(0x0C, base);
            mpu.write(0x10, (bits - 1) << 1 | 1);
        }
        mpu.write(0x04, 1);
        assert!(!mpu.is_open(0), "without PRIVDEFENA no address is open");
        mpu.write(0x04, 5);
        for (address, open, allowed) in [
            (0x2000_00FF, true, true),
            (0x2000_0100, false, false),
            (0x2000_011F, false, false),
            (0x2000_0120, false, true),
            (0x2000_04FF, false, false),
            (0x2000_0500, true, true),
            (0, true, true),
            (u32::MAX, true, true),
        ] {
            assert_eq!((mpu.is_open(address), mpu.allows(address, true, true, false)), (open, allowed), "{address:#x}");
        }
    }
}
