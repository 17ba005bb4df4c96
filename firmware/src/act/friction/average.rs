//! A low-pass of the first order, which begins at its first value.

/// The low-pass: `value += (x - value) gain`.
#[derive(Clone, Copy, Debug)]
pub(super) struct LowPass {
    gain: f32,
    /// The filtered value; before the first sample, the nominal one.
    pub value: f32,
    begun: bool,
}

impl LowPass {
    /// With this part of the difference a block, and this value until there is another.
    pub(super) fn new(gain: f32, nominal: f32) -> Self {
        LowPass { gain: if gain < 1.0 { gain } else { 1.0 }, value: nominal, begun: false }
    }

    /// Takes a value; what is not a number is left out.
    pub(super) fn take(&mut self, x: f32) {
        if !x.is_finite() {
            return;
        }
        let gain = if self.begun { self.gain } else { 1.0 };
        self.value += gain * (x - self.value);
        self.begun = true;
    }
}
