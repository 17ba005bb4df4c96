//! Check of the amplifier's supply voltage.

use firmware::seam::config::Supply;

/// Permitted range of a supply, in codes of the converter that measures it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SupplyWindow {
    volt_per_code: f32,
    min_v: f32,
    max_v: f32,
    last_code: u16,
}

impl SupplyWindow {
    /// Creates the range from the settings, for a converter with this number of codes from zero to
    /// its reference, V. Returns `None` if the supply is not measured.
    #[inline]
    pub fn from_settings(supply: &Supply, reference_v: f32, codes: f32) -> Option<Self> {
        let Supply { divider, min_v, max_v } = *supply;
        divider.map(|divider| SupplyWindow {
            volt_per_code: divider * reference_v / codes,
            min_v,
            max_v,
            last_code: codes as u16 - 1,
        })
    }

    /// Returns `true` if a code is within the range. The highest code is never within: the real
    /// voltage may be higher than the divider can show.
    #[inline]
    pub fn holds(&self, code: u16) -> bool {
        let volts = f32::from(code) * self.volt_per_code;
        code < self.last_code && self.min_v <= volts && volts <= self.max_v
    }
}
