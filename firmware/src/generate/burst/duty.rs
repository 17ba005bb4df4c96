//! Spreading of an ON time over periodic bursts.

/// ON time that varies from period to period. A burst lasts whole periods of the drive, which may
/// be synchronous with those of the schedule. An ON time spread evenly over one period of the drive
/// is rounded correctly on average.
#[derive(Clone, Copy, Debug)]
pub(super) struct Dithered {
    /// Mean ON time, samples.
    mean: f32,
    /// Difference between the longest and the shortest ON time, samples.
    spread: f32,
    /// Position within the spread, 2^32 a turn. Steps of the golden section spread evenly over any
    /// number of periods.
    turn: u32,
}

impl Dithered {
    /// Creates another mean and spread, which continue the sequence of `before`.
    pub(super) fn continuing(before: Option<Dithered>, mean: f32, spread: f32) -> Self {
        Dithered { mean, spread, turn: before.map_or(0, |before| before.turn) }
    }

    pub(super) fn next(&mut self, period: u64) -> u64 {
        const GOLDEN: u32 = 0x9e37_79b9;
        self.turn = self.turn.wrapping_add(GOLDEN);
        let part = (self.turn >> 8) as f32 / (1 << 24) as f32;
        // Via 32 bits, which are 1.2 hours at 1 MHz: a conversion to 64 bits is a call, for which
        // the fast memory of a board has no room.
        u64::from(libm::roundf(self.mean + (part - 0.5) * self.spread).clamp(0.0, period as f32) as u32)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The mean over a few bursts is the set one, however periods of the drive round them.
    #[test]
    fn the_mean_on_time_is_the_set_one() {
        for mean in [203.3f32, 400.0, 512.5, 849.9] {
            let mut dithered = Dithered::continuing(None, mean, 25.0);
            let of = |dithered: &mut Dithered, periods: u32| {
                let sum: u64 = (0..periods).map(|_| dithered.next(1000)).sum();
                sum as f32 / periods as f32
            };
            // Whole periods of 25 samples, always rounded up, are half a period longer on average.
            let rounded_up: f32 = (0..200).map(|_| dithered.next(1000).div_ceil(25) as f32 * 25.0).sum::<f32>() / 200.0;
            assert!((rounded_up - mean - 12.5).abs() < 0.6, "{mean}: {rounded_up}");
            // Measured: 0.4 over 8 bursts and over 50, with a step of one sample.
            assert!((of(&mut dithered, 8) - mean).abs() < 0.6 && (of(&mut dithered, 50) - mean).abs() < 0.6, "{mean}");
        }
        assert_eq!(Dithered::continuing(None, -5.0, 0.0).next(1000), 0);
        assert_eq!(Dithered::continuing(None, 2e9, 0.0).next(1000), 1000);
        assert_eq!(Dithered::continuing(None, f32::NAN, 0.0).next(1000), 0);
    }
}
