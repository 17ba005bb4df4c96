//! Division of a sample into steps of the flow, and the conversion times.

/// Division of a sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Timing {
    /// Duration of a sample, s.
    pub sample_s: f64,
    /// Number of steps of the flow in a sample.
    pub steps: u32,
    /// Number of ADC conversions in a sample, evenly spaced; the last at its end.
    pub conversions: u32,
    /// Delay of the current's conversion after that of the voltage, s.
    pub skew_s: f64,
}

impl Timing {
    /// Returns the duration of a step, s.
    pub fn step_s(&self) -> f64 {
        self.sample_s / f64::from(self.steps)
    }

    /// Returns the conversion times of voltage and current after the beginning of each step, s. The
    /// later of the two converts at the nominal time, the other before it; both belong to the step
    /// of the earlier one.
    pub(super) fn instants(&self) -> Vec<Vec<[f64; 2]>> {
        let step_s = self.step_s();
        let mut instants = vec![Vec::new(); self.steps as usize];
        for conversion in 1..=self.conversions {
            let nominal = self.sample_s * f64::from(conversion) / f64::from(self.conversions);
            let both = [nominal - self.skew_s.max(0.0), nominal + self.skew_s.min(0.0)];
            // A conversion at the boundary of two steps belongs to the earlier step.
            let step = (both[0].min(both[1]) / step_s - 1e-9).floor().max(0.0);
            instants[step as usize].push(both.map(|instant| instant - step * step_s));
        }
        instants
    }
}
