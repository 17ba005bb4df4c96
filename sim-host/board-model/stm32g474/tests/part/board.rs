//! Board with settable levels and voltages.

use std::collections::VecDeque;

use cortex_m4::Cycle;
use sonoglide_stm32g474::{Drive, Level, Pin, Received, Wires};

use crate::rig::{Rig, Setup};

/// Board with settable levels and voltages.
pub struct Board {
    /// Voltage at PA1 and PA7, V.
    pub current: [f64; 2],
    pub stop_released: bool,
    pub due: Cycle,
    pub position: i32,
    pub bytes: VecDeque<u8>,
    pub sent: Vec<(Cycle, u8)>,
    pub enable: Vec<(Cycle, Level)>,
}

impl Default for Board {
    fn default() -> Self {
        Board {
            current: [1.65; 2],
            stop_released: true,
            due: Cycle::MAX,
            position: 0,
            bytes: VecDeque::new(),
            sent: Vec::new(),
            enable: Vec::new(),
        }
    }
}

impl Wires for Board {
    fn dac(&mut self, _at: Cycle, _dac: u8, _codes: [u16; 2], _triggered: bool) {}

    fn volts(&mut self, _at: Cycle, pin: Pin) -> f64 {
        if pin == Pin::new('A', 7) { self.current[1] } else { self.current[0] }
    }

    fn celsius(&mut self, _at: Cycle) -> f64 {
        80.0
    }

    fn output(&mut self, at: Cycle, pin: Pin, level: Level) {
        if pin == Pin::new('A', 10) {
            self.enable.push((at, level));
        }
    }

    fn inputs(&mut self, _at: Cycle, port: u8) -> Drive {
        // The contact connects PC3 to the supply; the pull-down is in the microcontroller.
        if port == 2 && self.stop_released { Drive { driven: 8, high: 8 } } else { Drive::default() }
    }

    fn encoder(&mut self, _at: Cycle) -> i32 {
        self.position
    }

    fn due(&self) -> Cycle {
        self.due
    }

    fn byte_due(&self) -> Cycle {
        if self.bytes.is_empty() { Cycle::MAX } else { 0 }
    }

    fn receive(&mut self, _at: Cycle) -> Option<Received> {
        self.bytes.pop_front().map(|byte| Received { byte, ..Received::default() })
    }

    fn sent(&mut self, at: Cycle, byte: u8) {
        self.sent.push((at, byte));
    }
}

pub fn board() -> Rig<Board> {
    let mut rig = Rig::on(Board::default());
    rig.clocks(Setup::default());
    rig
}
