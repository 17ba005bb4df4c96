//! Check that the rings of the ADC and of the DAC are in step: a lost trigger or transfer shifts
//! one of them.

/// Check that two rings of `RING` samples are in step: the lead of the DAC's ring must not change.
///
/// The positions must be read in a quiet part of the sample: after both rings have moved, and
/// before a ring that is half a sample late would move. Two conversions of an ADC may make a
/// sample, and a lost trigger of one of them delays the ring by half a sample.
///
/// ```text
/// | both rings move |<- quiet ->| half a sample later: a late ring moves |         | next sample
/// ```
#[derive(Clone, Debug, Default)]
pub struct Step<const RING: usize> {
    lead: Option<usize>,
}

impl<const RING: usize> Step<RING> {
    /// Returns `true` if the rings are in step, from the positions in both rings (ADC, DAC). The
    /// first call sets the expected lead.
    #[inline]
    pub fn holds(&mut self, (adc, dac): (usize, usize)) -> bool {
        let lead = (dac + RING - adc % RING) % RING;
        *self.lead.get_or_insert(lead) == lead
    }
}
