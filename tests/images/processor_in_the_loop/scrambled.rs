//! Converters that usually sample a load, and sometimes return arbitrary codes.

use firmware::seam::block::{BeltSense, Codes, DriveBlock, SenseBlock, SlowSense, Trips};
use firmware::seam::config::{Config, FrontEnd};
use hal_mock::analog::Analog;
use hal_mock::loop_back::LoopBack;
use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

use super::{one_in, pick};

/// Present input of the converters.
#[derive(Clone, Copy)]
enum Input {
    /// Loop-back with noise.
    Load,
    /// Arbitrary codes.
    Anything,
    /// One end of the range of the converters.
    Railed,
    /// Fewer codes than expected, or none.
    Cut,
}

/// Middleware on the converters: a capacitor with noise, and stretches of worse input.
pub(super) struct Scrambled {
    load: LoopBack,
    front_end: FrontEnd,
    random: Xoshiro256PlusPlus,
    input: Input,
    left: u32,
    /// Counts of the belt.
    counts: i32,
}

impl Scrambled {
    pub(super) fn new(config: &Config, seed: u64) -> Self {
        let front_end = config.front_end.clone();
        // Current codes per drive code of change: I = C dV/dt.
        let amperes = config.tracking.c0_f() * config.sample_hz * front_end.drive_volt_per_lsb;
        Scrambled {
            load: LoopBack::new(front_end.sense_mid_code, amperes / front_end.ampere_per_lsb),
            front_end,
            random: Xoshiro256PlusPlus::seed_from_u64(!seed),
            input: Input::Load,
            left: 400,
            counts: i32::MAX - 3000,
        }
    }

    /// Selects the next input: usually the load, for long enough that the controller makes
    /// progress.
    fn next_stretch(&mut self) {
        use Input::*;
        self.input = *pick(&mut self.random, &[Load, Load, Load, Load, Anything, Railed, Cut]);
        self.left = if matches!(self.input, Load) { 300 } else { 1 + self.random.next_u32() % 12 };
    }

    fn scramble(&mut self, channel: &mut Codes) {
        let (random, max) = (&mut self.random, self.front_end.sense_max_code);
        match self.input {
            Input::Load => {
                channel.iter_mut().for_each(|code| *code = code.saturating_add(random.next_u32() as u16 % 7).min(max));
            }
            Input::Anything => channel.iter_mut().for_each(|code| *code = random.next_u32() as u16),
            Input::Railed => channel.iter_mut().for_each(|code| *code = *pick(random, &[0, max])),
            Input::Cut => channel.truncate(*pick(random, &[0, 1, 2, 3, 7])),
        }
    }
}

impl Analog for Scrambled {
    fn exchange(&mut self, drive: &DriveBlock, sense: &mut SenseBlock) {
        self.load.exchange(drive, sense);
        let front_end = &self.front_end;
        let volts = |code: u16| (f32::from(code) - f32::from(front_end.drive_mid_code)) * front_end.drive_volt_per_lsb;
        for code in &mut sense.v {
            *code = (f32::from(front_end.sense_mid_code) + volts(*code) / front_end.volt_per_lsb) as u16;
        }
        if self.left == 0 {
            self.next_stretch();
        }
        self.left -= 1;
        self.scramble(&mut sense.v);
        self.scramble(&mut sense.i);
        sense.slow = slow(&mut self.random, &mut self.counts);
    }
}

/// Returns the readings of a belt that usually moves, and of sensors that usually work.
fn slow(random: &mut Xoshiro256PlusPlus, counts: &mut i32) -> SlowSense {
    *counts = counts.wrapping_add(*pick(random, &[0, 0, 1, 2, 7, -1]));
    SlowSense {
        belt: (!one_in(random, 5000)).then_some(BeltSense { counts: *counts, broken: one_in(random, 5000) }),
        temperature: *pick(random, &[None, Some(21.5)]),
        force: (!one_in(random, 5000)).then(|| (random.next_u32() % 1000) as f32 * 0.01),
        trips: one_in(random, 3000).then_some(Trips { over_current: true, ..Trips::default() }),
        missed_blocks: one_in(random, 3000).then_some(1),
    }
}
