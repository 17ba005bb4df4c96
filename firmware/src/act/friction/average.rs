//! First-order low-pass that starts at its first value.

/// First-order low-pass: `value += (x - value) gain`.
#[derive(Clone, Copy, Debug)]
pub(super) struct LowPass {
    gain: f32,
    /// Filtered value; before the first sample, the nominal one.
    pub value: f32,
    begun: bool,
}

impl LowPass {
    /// Creates a filter with this gain per block, at most one, and this value until the first
    /// sample.
    pub(super) fn new(gain: f32, nominal: f32) -> Self {
        LowPass { gain: if gain < 1.0 { gain } else { 1.0 }, value: nominal, begun: false }
    }

    /// Takes a value; ignores NaN and infinity.
    pub(super) fn take(&mut self, x: f32) {
        if !x.is_finite() {
            return;
        }
        let gain = if self.begun { self.gain } else { 1.0 };
        self.value += gain * (x - self.value);
        self.begun = true;
    }
}
