//! Temperature of the stack: the hottest of three values.
//!
//! * The bound by the [energy balance](super::balance), if the thermal resistance is known.
//! * The series resonance, which changes by `hz_per_k`. A load also shifts it. A reading that falls
//!   faster than the stack can cool is a load, and the same shift is added to all later readings.
//!   A reading that rises faster than the energy allows takes such a shift back, but never more.
//! * The clamped capacitance, which changes by the part `c0_per_k` a kelvin. No load shifts it.
//!
//! The motional resistance is not a thermometer: it changes more by a load than by the temperature.
//! Its loss is part of the energy.
//!
//! The reference of resonance and capacitance is their value at the first lock after power-on. The
//! stack then has the temperature of the surroundings, or the bound if the thermal resistance is
//! known. After an assumed warm start there is no reference until the bound has settled.

use super::balance::{Balance, Change};
use crate::seam::config::Config;

/// Deviation from the possible changes of the temperature that is accepted as noise, K.
const NOISE_K: f32 = 2.0;
/// Remaining rise of an assumed warm start below which the bound is a reference, K.
const SETTLED_K: f32 = 2.0;

/// Estimates of the tracker that depend on the temperature of the stack.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Thermometers {
    /// Series resonance, Hz, as an offset from any fixed frequency.
    pub resonance_hz: f32,
    /// Susceptance of the clamped capacitance at a fixed frequency, in any unit.
    pub(crate) susceptance: f32,
}

/// Temperature of the stack.
#[derive(Clone, Debug)]
pub(super) struct Stack {
    balance: Balance,
    is_used: bool,
    kelvin_per_hz: f32,
    kelvin_per_part: f32,
    /// Temperature of the surroundings, °C: the last reading of the board's sensor, or the
    /// configured one.
    surroundings_c: f32,
    /// Estimates at the first lock, and the temperature of the stack at that time, °C.
    cold: Option<(Thermometers, f32)>,
    /// Shift of the resonance by loads, as a temperature, K.
    load_k: f32,
    /// Lowest and highest temperature that the last readings of the resonance and the possible
    /// changes since then allow, °C.
    possible_c: (f32, f32),
    /// Hotter one of the two thermometers, °C.
    read_c: f32,
}

impl Stack {
    /// Builds the estimate from the configured thermal resistance, heat capacity and coefficients.
    pub(super) fn build(config: &Config, block_s: f32) -> Self {
        let thermometer = &config.thermometer;
        let inverse = |per_k: f32| if per_k == 0.0 { 0.0 } else { 1.0 / per_k };
        let balance = Balance::build(config, block_s);
        Stack {
            is_used: balance.is_known() || thermometer.hz_per_k != 0.0 || thermometer.c0_per_k != 0.0,
            balance,
            kelvin_per_hz: inverse(thermometer.hz_per_k),
            kelvin_per_part: inverse(thermometer.c0_per_k),
            surroundings_c: thermometer.ambient_c,
            cold: None,
            load_k: 0.0,
            possible_c: (f32::NEG_INFINITY, f32::INFINITY),
            read_c: f32::NEG_INFINITY,
        }
    }

    /// Returns `true` if a value is configured from which the temperature follows.
    pub(super) fn is_used(&self) -> bool {
        self.is_used
    }

    /// Returns `true` if there is an energy balance.
    pub(super) fn has_balance(&self) -> bool {
        self.balance.is_known()
    }

    /// Returns `true` if resonance or capacitance were read.
    #[inline]
    pub(super) fn has_reading(&self) -> bool {
        self.cold.is_some()
    }

    /// Returns `true` if the temperature of the stack is known.
    pub(super) fn is_known(&self) -> bool {
        self.balance.is_known() || self.cold.is_some()
    }

    /// Adds a block: the reading of the board's sensor, °C, and the mean electrical power, W.
    // Not inlined: the fast memory of a board has no room for it.
    #[inline(never)]
    pub(super) fn add(&mut self, board_c: Option<f32>, power_w: f32) {
        // A reading that is not a number is a fault of its own, and must not stay in the balance.
        self.surroundings_c = board_c.filter(|celsius| celsius.is_finite()).unwrap_or(self.surroundings_c);
        if !self.is_known() {
            return;
        }
        if let Some(Change { rise_k, remains }) = self.balance.add(power_w, self.surroundings_c) {
            let (least, most) = &mut self.possible_c;
            *least = least.min(self.surroundings_c + (*least - self.surroundings_c) * remains);
            *most = most.max(self.surroundings_c) + rise_k;
        }
    }

    /// Reads the thermometers.
    // Not inlined: the fast memory of a board has no room for it.
    #[inline(never)]
    pub(super) fn read(&mut self, now: &Thermometers) {
        if self.kelvin_per_hz == 0.0 && self.kelvin_per_part == 0.0 || self.balance.start_k() > SETTLED_K {
            return;
        }
        let start_c = if self.balance.is_known() { self.balance.bound_c() } else { self.surroundings_c };
        let (cold, cold_c) = *self.cold.get_or_insert((*now, start_c));
        let by_capacitance = cold_c + (now.susceptance / cold.susceptance - 1.0) * self.kelvin_per_part;
        let by_resonance = cold_c + (now.resonance_hz - cold.resonance_hz) * self.kelvin_per_hz;
        let (least, most) = self.possible_c;
        if by_resonance + self.load_k < least - NOISE_K {
            self.load_k = least - by_resonance;
        } else if by_resonance + self.load_k > most + NOISE_K {
            self.load_k = (most - by_resonance).max(0.0).min(self.load_k);
        }
        let by_resonance = by_resonance + self.load_k;
        self.possible_c = (least.max(by_resonance), most.min(by_resonance));
        self.read_c = by_resonance.max(by_capacitance);
    }

    /// Returns the temperature, °C; minus infinity if it is unknown.
    pub(super) fn celsius(&self) -> f32 {
        self.read_c.max(self.balance.bound_c())
    }

    /// Returns the temperature or that of the board, °C, if this is higher or not a number.
    // Not inlined: the fast memory of a board has no room for it.
    #[inline(never)]
    pub(super) fn hotter(&self, board_c: Option<f32>) -> f32 {
        let stack_c = self.celsius();
        // Not `max`: a board reading that is not a number must be reported.
        board_c.map_or(stack_c, |board_c| if stack_c > board_c { stack_c } else { board_c })
    }
}
