//! Check that the rings of the ADC and of the DAC are in step: a lost trigger or transfer shifts
//! one of them.

/// Check that two rings of `RING` samples are in step: the lead of the DAC's ring must not change.
///
/// In each sample the lead differs for a moment: after one ring has moved and before the other has.
/// Three looks are taken a third of a sample apart. At most one of them meets this moment, if it is
/// short enough:
///
/// ```text
/// moment < time between two looks < (sample - moment) / 2      (times in cycles)
/// ```
#[derive(Clone, Debug, Default)]
pub struct Step<const RING: usize> {
    lead: Option<usize>,
}

impl<const RING: usize> Step<RING> {
    /// Returns `true` if the rings are in step, from the positions in both rings (ADC, DAC).
    ///
    /// If the lead differs from the expected one, `again` is called three times. Each call must
    /// read the positions a third of a sample after the one before. These three decide, because
    /// `positions` may be a sample older. The first call of `holds` sets the expected lead.
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
