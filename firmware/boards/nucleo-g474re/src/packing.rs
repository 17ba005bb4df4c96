//! Words of DMA: two converters move as one, so that they stay together.
//!
//! The ADC pair writes `V` in the lower half-word and `I` in the upper, each the sum of two conversions (RM0440 21.4.30: the master's
//! data in the lower half of `ADC_CDR`). A DAC pair takes its first lane in the lower half-word and its second in the upper
//! (RM0440 22.7.9, `DAC_DHR12RD`).

use firmware::seam::block::{DriveBlock, SenseBlock};

/// Separates a block of words from the ADC pair into voltage and current. Words beyond a block are left out.
pub fn sense(words: impl Iterator<Item = u32>, sense: &mut SenseBlock) {
    sense.v.clear();
    sense.i.clear();
    for word in words {
        // A block that is cut short is a fault of its own.
        let _ = sense.v.push(word as u16);
        let _ = sense.i.push((word >> 16) as u16);
    }
}

/// The word that a DAC pair plays: lanes `2 * pair` and `2 * pair + 1`. A lane or a sample that is not there is silence.
pub fn drive(block: &DriveBlock, pair: usize, sample: usize, silence: u16) -> u32 {
    let code = |lane: usize| block.lanes.get(lane).and_then(|codes| codes.get(sample)).copied().unwrap_or(silence);
    word(code(2 * pair), code(2 * pair + 1))
}

/// Two codes as one word.
pub fn word(first: u16, second: u16) -> u32 {
    u32::from(second) << 16 | u32::from(first)
}
