//! Commands of a run.

use firmware::seam::block::{Gate, Orders, Request, Target};
use firmware::seam::mode::Mode;
use firmware::seam::units::{Hertz, Turns};

use scene::Driven;

/// Commands of a run, which may begin with a calibration.
pub struct Script {
    /// Present orders.
    pub orders: Orders,
    /// Times, s, and friction ratios to be commanded; the last one first.
    friction: Vec<(f64, f64)>,
    /// `true` if the calibration has begun.
    calibrating: bool,
}

impl Script {
    /// Creates the commands of a scene.
    pub fn new(scene: &Driven) -> Self {
        let controller = scene.controller;
        let request = if controller.phasing.calibrate { Request::Calibrate } else { Request::Run };
        let orders = Orders {
            sequence: 1,
            attempt: 1,
            request,
            gate: Gate::Scheduled,
            detune: Hertz(controller.drive.detune_hz as f32),
            quadrature: controller.phasing.quadrature_turns.map(|turns| Turns(turns as f32)),
            torso_kg: scene.dring().and_then(|dring| dring.seat_reading_kg()).map(|kg| kg as f32),
            ..Orders::default()
        };
        let friction = controller.friction.iter();
        let friction =
            friction.flat_map(|friction| friction.step_s.iter().copied().zip(friction.step_ratio.iter().copied()).rev());
        Script { orders, friction: friction.collect(), calibrating: false }
    }

    /// Commands the friction that is due.
    pub fn order_friction(&mut self, time_s: f64) {
        while let Some((_, ratio)) = self.friction.pop_if(|(at_s, _)| *at_s <= time_s) {
            let sequence = self.orders.sequence + 1;
            self.orders = Orders { sequence, friction: Some(Target::Ratio(ratio as f32)), ..self.orders };
        }
    }

    /// Commands the run once the calibration is over. After a fault, no command follows.
    pub fn follow(&mut self, mode: Mode) {
        self.calibrating |= mode == Mode::Calibrate;
        if self.calibrating && mode == Mode::Idle {
            self.calibrating = false;
            self.orders = Orders { sequence: self.orders.sequence + 1, attempt: 2, request: Request::Run, ..self.orders };
        }
    }
}
