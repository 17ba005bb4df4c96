//! An ON time that is spread over bursts that repeat.

/// An ON time that is spread from period to period. A burst lasts whole periods of the drive, which may keep step with those of the schedule: what is
/// spread evenly over one of them is rounded right on an average.
#[derive(Clone, Copy, Debug)]
pub(super) struct Dithered {
    /// Samples, on an average and from the least to the most.
    mean: f32,
    spread: f32,
    /// In steps of the golden section, 2^32 a turn: evenly spread over any number of periods.
    turn: u32,
}

impl Dithered {
    /// Another mean and spread, in step with what was before.
    pub(super) fn after(before: Option<Dithered>, mean: f32, spread: f32) -> Self {
        Dithered { mean, spread, turn: before.map_or(0, |before| before.turn) }
    }

    pub(super) fn next(&mut self, period: u64) -> u64 {
        const GOLDEN: u32 = 0x9e37_79b9;
        self.turn = self.turn.wrapping_add(GOLDEN);
        let part = (self.turn >> 8) as f32 / (1 << 24) as f32;
        // By 32 bits, which are 1.2 hours at 1 MHz: a conversion to 64 is a call, which the fast memory of a board has no room for.
        u64::from(libm::roundf(self.mean + (part - 0.5) * self.spread).clamp(0.0, period as f32) as u32)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whatever the drive's periods make of it, the mean over a few bursts is what was set.
    #[test]
    fn the_mean_is_the_one_that_was_set() {
        for mean in [203.3f32, 400.0, 512.5, 849.9] {
            let mut dithered = Dithered::after(None, mean, 25.0);
            let of = |dithered: &mut Dithered, periods: u32| {
                let sum: u64 = (0..periods).map(|_| dithered.next(1000)).sum();
                sum as f32 / periods as f32
            };
            // Whole periods of 25 samples, always rounded up, are half a period more on an average.
            let rounded_up: f32 = (0..200).map(|_| dithered.next(1000).div_ceil(25) as f32 * 25.0).sum::<f32>() / 200.0;
            assert!((rounded_up - mean - 12.5).abs() < 0.6, "{mean}: {rounded_up}");
            // Measured: 0.4 of 8 bursts, and of 50, with a step of one sample.
            assert!((of(&mut dithered, 8) - mean).abs() < 0.6 && (of(&mut dithered, 50) - mean).abs() < 0.6, "{mean}");
        }
        assert_eq!(Dithered::after(None, -5.0, 0.0).next(1000), 0);
        assert_eq!(Dithered::after(None, 2e9, 0.0).next(1000), 1000);
        assert_eq!(Dithered::after(None, f32::NAN, 0.0).next(1000), 0);
    }
}
