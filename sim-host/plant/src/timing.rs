//! How a sample is divided: into steps of the flow, and into the converters' instants.

/// How a sample is divided.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Timing {
    /// Duration of a sample, s.
    pub sample_s: f64,
    /// Steps of the flow in a sample.
    pub steps: u32,
    /// ADC conversions in a sample, evenly spaced; the last at its end.
    pub conversions: u32,
    /// How much later the current is converted than the voltage, s.
    pub skew_s: f64,
}

impl Timing {
    /// Duration of a step, s.
    pub fn step_s(&self) -> f64 {
        self.sample_s / f64::from(self.steps)
    }

    /// For each step, how long after its beginning voltage and current are converted, s. The later of the two converts at the
    /// nominal time, the other before it; both belong to the step of the earlier.
    pub(super) fn instants(&self) -> Vec<Vec<[f64; 2]>> {
        let step_s = self.step_s();
        let mut instants = vec![Vec::new(); self.steps as usize];
        for conversion in 1..=self.conversions {
            let nominal = self.sample_s * f64::from(conversion) / f64::from(self.conversions);
            let both = [nominal - self.skew_s.max(0.0), nominal + self.skew_s.min(0.0)];
            // One that falls on the seam of two steps belongs to the earlier.
            let step = (both[0].min(both[1]) / step_s - 1e-9).floor().max(0.0);
            instants[step as usize].push(both.map(|instant| instant - step * step_s));
        }
        instants
    }
}
