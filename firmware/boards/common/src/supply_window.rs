//! Whether the amplifier's supply is where it must be.

use firmware::seam::config::Supply;

/// The window of a supply, in codes of the converter that measures it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SupplyWindow {
    volt_per_code: f32,
    min_v: f32,
    max_v: f32,
    last_code: u16,
}

impl SupplyWindow {
    /// The window of the settings, at a converter of so many codes from zero to its reference, V;
    /// `None` where the supply is not measured.
    #[inline]
    pub fn of(supply: &Supply, reference_v: f32, codes: f32) -> Option<Self> {
        let Supply { divider, min_v, max_v } = *supply;
        divider.map(|divider| SupplyWindow {
            volt_per_code: divider * reference_v / codes,
            min_v,
            max_v,
            last_code: codes as u16 - 1,
        })
    }

    /// Whether a code is within it. The last one is not: how much more than the divider can show is
    /// there cannot be known.
    #[inline]
    pub fn holds(&self, code: u16) -> bool {
        let volts = f32::from(code) * self.volt_per_code;
        code < self.last_code && self.min_v <= volts && volts <= self.max_v
    }
}
