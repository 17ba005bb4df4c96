//! The rule of the converters: a code of the firmware has 16 bits.

use super::Rules;
use crate::diagnostic::Problem;

const BITS: &str = "sensors.adc_bits";
const CONVERSIONS: &str = "sensors.oversample";
const LARGEST_CODE: u64 = u16::MAX as u64;

impl Rules<'_> {
    /// Checks that the sum of a sample's conversions fits into one code.
    pub(super) fn converters(&mut self) {
        let (Some(bits), Some(conversions)) = (self.number(BITS), self.number(CONVERSIONS)) else { return };
        let (bits, conversions) = (bits as u32, conversions as u64);
        let largest = |bits: u32| (1u64 << bits) - 1;
        if largest(bits) * conversions <= LARGEST_CODE {
            return;
        }
        let from = if self.given(CONVERSIONS) { "" } else { ", the default" };
        let message = format!("a sample of {conversions} conversions of {bits} bits does not fit into 16 bits");
        let at = self.newer(BITS, CONVERSIONS);
        let label = if at == BITS {
            let most = (1..=bits).rev().find(|&bits| largest(bits) * conversions <= LARGEST_CODE).unwrap_or(1);
            format!("must be at most {most} with `oversample` {conversions}{from}")
        } else {
            format!("must be at most {} with {bits} bits", LARGEST_CODE / largest(bits))
        };
        let help = format!("a sample is the sum of its conversions, at most {LARGEST_CODE}: (2^adc_bits - 1) x oversample");
        let problem = Problem::new(self.place(at), message, label);
        self.add(at, problem.help(help));
    }
}
