//! Whether the rings of the ADC and of the DAC are still in step: a lost trigger or a lost transfer
//! moves one of them.

/// Whether two rings of `RING` samples are in step: how far the DAC's is ahead does not change.
///
/// For a moment of each sample the lead is another one: after the one ring has moved, and before
/// the other has. Of three looks a third of a sample apart at most one meets it, as long as that
/// moment is shorter:
///
/// ```text
/// moment < from one look to the next < (sample - moment) / 2      (times in cycles)
/// ```
#[derive(Clone, Debug, Default)]
pub struct Step<const RING: usize> {
    lead: Option<usize>,
}

impl<const RING: usize> Step<RING> {
    /// Takes the positions in both rings, of the ADC and of the DAC. Where the lead is another one
    /// than before, `again` looks three more times, a third of a sample later each, and these
    /// decide: the first look may lie a whole sample before one of them, and does not count. The
    /// first call says what is in step.
    #[inline]
    pub fn holds(&mut self, positions: (usize, usize), mut again: impl FnMut() -> (usize, usize)) -> bool {
        let lead = |(adc, dac): (usize, usize)| (dac + RING - adc % RING) % RING;
        if self.lead == Some(lead(positions)) {
            return true;
        }
        let [first, second, third] = [(); 3].map(|()| lead(again()));
        let usual = if second == third { second } else { first };
        *self.lead.get_or_insert(usual) == usual
    }
}
