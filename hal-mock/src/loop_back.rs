//! The simplest load: a capacitor on the drive, connected to both sense channels. It is sufficient
//! for power-up, self-test, burst, emergency stop, watchdog and late blocks; it has no resonance.

use firmware::seam::block::{Amplitude, BeltSense, DriveBlock, MAX_LANES, SenseBlock};
use firmware::seam::config::{
    Burst, Config, Drive, FrontEnd, HeatSink, Limits, Link, Phasing, Supply, Sweep, Thermometer, Tracking, TrackingMode,
};

use crate::analog::Analog;

/// Load that connects the selected drive lane back to the sense channels.
///
/// The voltage is as played. The current is its difference from sample to sample, as drawn by a
/// capacitor. Each lane has its own capacitor.
#[derive(Clone, Debug)]
pub struct LoopBack {
    mid_code: u16,
    /// Current codes per code of voltage change in a sample.
    current_per_step: f32,
    belt: Option<BeltSense>,
    counts_per_block: i32,
    last: [u16; MAX_LANES],
}

impl LoopBack {
    /// Creates a capacitor that draws `current_per_step` current codes for a change of one voltage
    /// code in a sample. Both channels rest at `mid_code`.
    pub fn new(mid_code: u16, current_per_step: f32) -> Self {
        LoopBack { mid_code, current_per_step, belt: None, counts_per_block: 0, last: [mid_code; MAX_LANES] }
    }

    /// Creates the nominal clamped capacitance of a configuration, `i = C0 dV/dt`. The voltage
    /// sense must have the scale of the drive, as in [`config`].
    pub fn of(config: &Config) -> Self {
        let front_end = &config.front_end;
        let amperes_per_step = config.tracking.c0_f() * config.sample_hz * front_end.drive_volt_per_lsb;
        LoopBack::new(front_end.sense_mid_code, amperes_per_step / front_end.ampere_per_lsb)
    }

    /// Multiplies the capacitance, to simulate a shorted or a nearly disconnected transducer.
    pub fn times(self, factor: f32) -> Self {
        LoopBack { current_per_step: self.current_per_step * factor, ..self }
    }

    /// Sets the speed of the belt, counts per block; `None` means that there is no encoder.
    pub fn set_belt(&mut self, counts_per_block: Option<i32>) {
        self.belt = counts_per_block.map(|_| self.belt.unwrap_or_default());
        self.counts_per_block = counts_per_block.unwrap_or(0);
    }
}

/// Returns a configuration for which [`LoopBack::of`] is a healthy transducer: 3 V at a constant
/// 40.4 kHz without tracking, because there is no resonance. The converters have 12 bits, at 10 mV
/// and 2 mA per code.
pub fn config() -> Config {
    Config {
        sample_hz: 1e6,
        block_samples: 32,
        lanes: 1,
        front_end: FrontEnd {
            volt_per_lsb: 0.01,
            ampere_per_lsb: 0.002,
            sense_mid_code: 2048,
            sense_max_code: 4095,
            drive_volt_per_lsb: 0.01,
            drive_mid_code: 2048,
            drive_max_code: 4095,
            drive_lanes: 4,
            metre_per_count: None,
            force_hz: None,
            newton_per_lsb: None,
        },
        drive: Drive::sine(40_400.0, Amplitude::Volts(3.0), 1.0),
        sweep: Sweep::Hold,
        phasing: Phasing::default(),
        burst: Burst::default(),
        tracking: Tracking {
            mode: TrackingMode::Off,
            span: 0.05,
            bandwidth_hz: 100.0,
            nominal_c0_f: Some(200e-9),
            ..Tracking::new(50.0)
        },
        thermometer: Thermometer::default(),
        heat_sink: HeatSink::default(),
        supply: Supply::default(),
        limits: Limits { voltage_v: 12.0, current_a: 3.0, belt_stop_ms: 5.0, ..Limits::default() },
        friction: None,
        restraint: None,
        link: Link::default(),
    }
}

impl Analog for LoopBack {
    fn exchange(&mut self, drive: &DriveBlock, sense: &mut SenseBlock) {
        let listen = usize::from(drive.listen).min(MAX_LANES - 1);
        let lane = drive.lanes.get(listen).map_or(&[][..], |lane| lane.as_slice());
        sense.v = lane.iter().copied().collect();
        sense.i.clear();
        let mut last = self.last[listen];
        for (last, lane) in self.last.iter_mut().zip(&drive.lanes) {
            *last = lane.last().copied().unwrap_or(*last);
        }
        for &code in lane {
            let step = f32::from(code) - f32::from(last);
            last = code;
            // Cannot fail: there are as many current codes as voltage codes.
            let _ = sense.i.push((f32::from(self.mid_code) + step * self.current_per_step).clamp(0.0, 65535.0) as u16);
        }
        if let Some(belt) = &mut self.belt {
            belt.counts = belt.counts.wrapping_add(self.counts_per_block);
        }
        sense.slow = firmware::seam::block::SlowSense { belt: self.belt, ..Default::default() };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn draws_the_current_of_the_nominal_capacitance() {
        // 200 nF, 1 V per sample of 1 us: 0.2 A.
        let mut load = LoopBack::of(&config());
        let mut sense = SenseBlock::default();
        load.exchange(
            &DriveBlock {
                lanes: [[2048, 2148, 2148, 2048].into_iter().collect()].into_iter().collect(),
                listen: 0,
                drops_queue: false,
            },
            &mut sense,
        );
        assert_eq!(sense.v, [2048, 2148, 2148, 2048]);
        assert_eq!(sense.i, [2048, 2148, 2048, 1948]);
    }
}
