//! Check that the rings of the ADC and of the DAC are in step: a lost trigger or transfer shifts
//! one of them.

/// Check that two rings of `RING` samples are in step: the lead of the DAC's ring must not change.
///
/// The positions must be read in a quiet part of the sample: after both rings have moved, and
/// before a ring that is half a sample late would move. Two conversions of an ADC may make a
/// sample, and a lost trigger of one of them delays the ring by half a sample.
///
/// A lead that is off by one counts in the second consecutive block: while flash is written, single
/// blocks read one.
///
/// ```text
/// | both rings move |<- quiet ->| half a sample later: a late ring moves |         | next sample
/// ```
#[derive(Clone, Debug, Default)]
pub struct Step<const RING: usize> {
    lead: Option<usize>,
    /// `true` if the last block had another lead.
    was_off: bool,
}

impl<const RING: usize> Step<RING> {
    /// Returns `true` if the rings are in step, from the positions in both rings (ADC, DAC). The
    /// first call sets the expected lead.
    #[inline]
    pub fn holds(&mut self, (adc, dac): (usize, usize)) -> bool {
        let lead = (dac + RING - adc % RING) % RING;
        if self.lead == Some(lead) {
            self.was_off = false;
            return true;
        }
        self.accepts(lead)
    }

    /// Returns `true` for the first lead, and for a first one that is off by one. Not in the fast
    /// memory of the block interrupt, which is full.
    #[cold]
    #[inline(never)]
    fn accepts(&mut self, lead: usize) -> bool {
        let Some(expected) = self.lead else {
            self.lead = Some(lead);
            return true;
        };
        let off = (lead + RING - expected) % RING;
        !core::mem::replace(&mut self.was_off, true) && (off == 1 || off == RING - 1)
    }
}
