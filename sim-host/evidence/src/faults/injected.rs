//! A controller with a failure between it and its converters: its inputs are corrupted before a
//! block, its outputs after it.

use firmware::seam::block::{Amplitude, Codes, DriveBlock, Orders, SenseBlock};
use firmware::seam::config::Config;
use firmware::seam::telemetry::Telemetry;
use firmware::seam::units::Turns;
use sim::processor::{Here, Lost, Processor};

use crate::random::Random;

/// A sense channel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Channel {
    /// The voltage channel.
    Voltage,
    /// The current channel.
    Current,
}

/// A failure between board and controller, from a given block on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Failure {
    /// No failure.
    None,
    /// The effect of a scene's `[[fault]]` of this kind on the plant.
    Scene(&'static str),
    /// A `[[fault]]` of this kind in a lane of a motor; if two lanes are exchanged, also in the
    /// next.
    Lane(&'static str, u8),
    /// The load changes at once: Q and C0 by factors, the resonance by a number of bandwidths.
    Load(Load),
    /// A resistance across the stack, relative to its motional resistance.
    Leak(f64),
    /// Another amplitude is ordered, relative to that of the scan.
    Ordered(f64),
    /// The gain of a channel changes by this factor; a negative factor is a reversed line.
    Gain(Channel, f64),
    /// A channel is offset by this number of codes.
    Offset(Channel, i32),
    /// A channel is stuck at this code.
    Stuck(Channel, u16),
    /// A bit of a channel's codes is stuck low or high.
    Bit(Channel, u8, bool),
    /// A channel is late by this number of samples.
    Late(Channel, usize),
    /// A channel has noise, uniform within this number of codes to either side.
    Noise(Channel, u16),
    /// A single sample of a channel is at the end of its range.
    Spike(Channel),
    /// Voltage and current are exchanged.
    Exchanged,
    /// The converters return the same block forever.
    Stale,
    /// The converters return one block twice.
    StaleOnce,
    /// The halves of the buffer are exchanged: each is read a block late.
    Halves,
    /// The DAC plays the same block forever.
    Repeats,
    /// The DAC holds its code.
    Holds,
    /// A bit of the DAC's codes is stuck low or high.
    DacBit(u8, bool),
    /// The gain of the amplifier changes by this factor.
    Amplifier(f64),
    /// The gain of the amplifier changes by this factor gradually, within this number of blocks.
    Drifts(f64, u32),
    /// The amplifier plays only one half wave.
    HalfWave,
    /// The amplifier clips at this fraction of the drive.
    Clips(f64),
    /// The output of the amplifier changes by at most this fraction of the drive per sample.
    Slews(f64),
    /// The gain of the amplifier ripples by this fraction, with a period of this number of blocks.
    Ripples(f64, u32),
    /// The amplifier is dead.
    Dead,
    /// A quadrature of this number of turns is ordered.
    Quadrature(f32),
    /// The belt's encoder has no scale.
    NoScale,
    /// The host is silent for longer than its timeout.
    HostLost,
    /// The emergency stop is pressed.
    EmergencyStop,
    /// The hardware's comparator on the current has fired.
    Comparator,
    /// The amplifier reports a failure.
    AmplifierReports,
    /// The amplifier's supply is outside its window.
    Supply,
}

/// A change of the load.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Load {
    /// Factor by which Q changes.
    pub(super) q: f64,
    /// Factor by which C0 changes.
    pub(super) c0: f64,
    /// Shift of the resonance, bandwidths before the change.
    pub(super) bandwidths: f64,
}

/// A controller with an injected failure.
pub(super) struct Injected {
    controller: Here,
    failure: Failure,
    at_block: u64,
    block: u64,
    /// Mid-codes of sense and drive.
    middle: (u16, u16),
    /// Largest code of the sense channels.
    end: u16,
    /// Peak voltage of the scan, V.
    scan_v: f32,
    last_sense: SenseBlock,
    held_sense: Option<SenseBlock>,
    last_drive: DriveBlock,
    held_drive: Option<DriveBlock>,
    followed: f64,
    random: Random,
}

impl Injected {
    /// Injects a failure from a block on.
    pub(super) fn new(controller: Here, failure: Failure, at_block: u64, config: &Config) -> Self {
        let front = &config.front_end;
        Injected {
            controller,
            failure,
            at_block,
            block: 0,
            middle: (front.sense_mid_code, front.drive_mid_code),
            end: front.sense_max_code,
            scan_v: config.drive.scan_volts,
            last_sense: SenseBlock::default(),
            held_sense: None,
            last_drive: DriveBlock::default(),
            held_drive: None,
            followed: 0.0,
            random: Random::new(at_block),
        }
    }

    /// Returns the sense block that the controller receives, corrupted from that of the converters.
    fn corrupt_sense(&mut self, sense: &SenseBlock) -> SenseBlock {
        let (mut corrupted, middle, end) = (sense.clone(), i32::from(self.middle.0), i32::from(self.end));
        let code = |code: i32| code.clamp(0, end) as u16;
        let first = self.block == self.at_block;
        match self.failure {
            Failure::Gain(channel, gain) => {
                change_channel(&mut corrupted, channel, |was| {
                    code(middle + (gain * f64::from(i32::from(was) - middle)).round() as i32)
                });
            }
            Failure::Offset(channel, codes) => change_channel(&mut corrupted, channel, |was| code(i32::from(was) + codes)),
            Failure::Stuck(channel, at) => change_channel(&mut corrupted, channel, |_| at),
            Failure::Bit(channel, bit, high) => change_channel(&mut corrupted, channel, |was| with_bit(was, bit, high)),
            Failure::Late(channel, samples) => {
                let (before, now) = (self.last_sense.clone(), sense.clone());
                let late: Codes = {
                    let (before, now) = (lane(&before, channel), lane(&now, channel));
                    let from = before.len().saturating_sub(samples);
                    before[from..].iter().chain(now).take(now.len()).copied().collect()
                };
                *lane_mut(&mut corrupted, channel) = late;
            }
            Failure::Noise(channel, codes) => {
                let mut codes_of = core::mem::take(lane_mut(&mut corrupted, channel));
                for was in &mut codes_of {
                    *was = code(i32::from(*was) + self.random.whole(0, 2 * u32::from(codes)) as i32 - i32::from(codes));
                }
                *lane_mut(&mut corrupted, channel) = codes_of;
            }
            Failure::Spike(channel) if first => {
                let at = self.random.whole(0, lane(&corrupted, channel).len().saturating_sub(1) as u32) as usize;
                if let Some(was) = lane_mut(&mut corrupted, channel).get_mut(at) {
                    *was = self.end;
                }
            }
            Failure::Exchanged => core::mem::swap(&mut corrupted.v, &mut corrupted.i),
            Failure::Stale => {
                let held = self.held_sense.get_or_insert_with(|| sense.clone());
                (corrupted.v, corrupted.i) = (held.v.clone(), held.i.clone());
            }
            // The half that is read was filled one block earlier.
            Failure::Halves => (corrupted.v, corrupted.i) = (self.last_sense.v.clone(), self.last_sense.i.clone()),
            Failure::StaleOnce if first => (corrupted.v, corrupted.i) = (self.last_sense.v.clone(), self.last_sense.i.clone()),
            Failure::Comparator => corrupted.slow.trips.get_or_insert_default().over_current = true,
            Failure::AmplifierReports => corrupted.slow.trips.get_or_insert_default().amplifier_fault = true,
            Failure::Supply => corrupted.slow.trips.get_or_insert_default().supply = true,
            _ => {}
        }
        corrupted
    }

    /// Corrupts the drive block of the controller into that which the amplifier plays.
    fn corrupt_drive(&mut self, drive: &mut DriveBlock) {
        let middle = f64::from(self.middle.1);
        let scaled = |was: u16, by: f64| (middle + by * (f64::from(was) - middle)).round().clamp(0.0, 2.0 * middle) as u16;
        match self.failure {
            Failure::Repeats | Failure::Holds => {
                let holds = self.failure == Failure::Holds;
                let held = self.held_drive.get_or_insert_with(|| {
                    let mut held = self.last_drive.clone();
                    for lane in held.lanes.iter_mut().filter(|_| holds) {
                        let code = lane.last().copied().unwrap_or(self.middle.1);
                        lane.fill(code);
                    }
                    held
                });
                drive.lanes.clone_from(&held.lanes);
            }
            Failure::DacBit(bit, high) => change_lanes(drive, |was| with_bit(was, bit, high)),
            Failure::Amplifier(gain) => change_lanes(drive, |was| scaled(was, gain)),
            Failure::HalfWave => change_lanes(drive, |was| was.max(self.middle.1)),
            Failure::Clips(part) => {
                let most = part * f64::from(swing(&self.last_drive, self.middle.1).max(swing(drive, self.middle.1)));
                change_lanes(drive, |was| (middle + (f64::from(was) - middle).clamp(-most, most)).round() as u16);
            }
            Failure::Slews(part) => {
                let most = part * f64::from(swing(&self.last_drive, self.middle.1).max(swing(drive, self.middle.1)));
                let mut at = self.followed;
                for code in drive.lanes.iter_mut().take(1).flatten() {
                    at += (f64::from(*code) - middle - at).clamp(-most, most);
                    *code = (middle + at).round() as u16;
                }
                self.followed = at;
            }
            Failure::Ripples(part, blocks) => {
                let turn = std::f64::consts::TAU * self.block as f64 / f64::from(blocks);
                change_lanes(drive, |was| scaled(was, 1.0 + part * turn.sin()));
            }
            Failure::Drifts(gain, blocks) => {
                let part = (self.block - self.at_block) as f64 / f64::from(blocks);
                change_lanes(drive, |was| scaled(was, 1.0 + (gain - 1.0) * part.min(1.0)));
            }
            Failure::Dead => change_lanes(drive, |_| self.middle.1),
            _ => {}
        }
    }
}

/// Changes the codes of a channel.
fn change_channel(sense: &mut SenseBlock, channel: Channel, change: impl Fn(u16) -> u16) {
    lane_mut(sense, channel).iter_mut().for_each(|code| *code = change(*code));
}

fn lane(sense: &SenseBlock, channel: Channel) -> &Codes {
    match channel {
        Channel::Voltage => &sense.v,
        Channel::Current => &sense.i,
    }
}

fn lane_mut(sense: &mut SenseBlock, channel: Channel) -> &mut Codes {
    match channel {
        Channel::Voltage => &mut sense.v,
        Channel::Current => &mut sense.i,
    }
}

fn with_bit(code: u16, bit: u8, high: bool) -> u16 {
    if high { code | 1 << bit } else { code & !(1 << bit) }
}

/// Changes the codes of all lanes.
fn change_lanes(drive: &mut DriveBlock, change: impl Fn(u16) -> u16) {
    drive.lanes.iter_mut().flatten().for_each(|code| *code = change(*code));
}

/// Returns the largest deviation of a block from mid-code, codes.
fn swing(drive: &DriveBlock, middle: u16) -> u16 {
    drive.lanes.iter().flatten().map(|code| code.abs_diff(middle)).max().unwrap_or(0)
}

impl Processor for Injected {
    fn silence(&self) -> DriveBlock {
        self.controller.silence()
    }

    fn process(&mut self, orders: &Orders, sense: &SenseBlock, drive: &mut DriveBlock) -> Result<Telemetry, Lost> {
        let fails = self.block >= self.at_block;
        let mut orders = *orders;
        if fails {
            orders.host_lost |= self.failure == Failure::HostLost;
            orders.emergency_stop |= self.failure == Failure::EmergencyStop;
            if let Failure::Ordered(part) = self.failure {
                orders.amplitude = Some(Amplitude::Volts(part as f32 * self.scan_v));
            }
            if let Failure::Quadrature(turns) = self.failure {
                orders.quadrature = Some(Turns(turns));
            }
        }
        let given = if fails { self.corrupt_sense(sense) } else { sense.clone() };
        let telemetry = self.controller.process(&orders, &given, drive)?;
        let answered = drive.clone();
        if fails {
            self.corrupt_drive(drive);
        }
        self.last_sense.clone_from(sense);
        self.last_drive = answered;
        self.block += 1;
        Ok(telemetry)
    }
}
