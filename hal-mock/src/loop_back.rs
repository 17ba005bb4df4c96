//! The simplest load: a capacitor on the drive, seen by both sense channels. Enough for power-up, self-test, burst,
//! emergency stop, watchdog and late blocks; it has no resonance to find.

use firmware::block::{DriveBlock, SenseBlock};

use crate::analog::Analog;

/// Wires the first drive lane back to the sense channels: the voltage as played, the current as its difference from sample
/// to sample, as a capacitor would draw.
#[derive(Clone, Debug)]
pub struct LoopBack {
    mid_code: u16,
    /// Current codes for one code of voltage change in a sample.
    current_per_step: f32,
    belt: Option<f32>,
    last: u16,
}

impl LoopBack {
    /// A capacitor that draws `current_per_step` current codes for a change of one voltage code in a sample. Both channels
    /// rest at `mid_code`.
    pub fn new(mid_code: u16, current_per_step: f32) -> Self {
        LoopBack { mid_code, current_per_step, belt: None, last: mid_code }
    }

    /// Sets what the belt sensor reads, m/s; `None` is no sensor.
    pub fn set_belt(&mut self, speed: Option<f32>) {
        self.belt = speed;
    }
}

impl Analog for LoopBack {
    fn exchange(&mut self, drive: &DriveBlock, sense: &mut SenseBlock) {
        let lane = drive.lanes.first().map_or(&[][..], |lane| lane.as_slice());
        sense.v = lane.iter().copied().collect();
        sense.i.clear();
        for &code in lane {
            let step = f32::from(code) - f32::from(self.last);
            self.last = code;
            // As long as the voltage codes, which fit.
            let _ = sense.i.push((f32::from(self.mid_code) + step * self.current_per_step).clamp(0.0, 65535.0) as u16);
        }
        sense.slow = firmware::block::SlowSense { belt: self.belt, ..Default::default() };
    }
}
