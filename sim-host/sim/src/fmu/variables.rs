//! Variables of a unit.

use firmware::seam::block::{SenseBlock, SlowSense};
use hal_mock::analog::Analog;
use scene::{DisturbedKey, Driven};

use super::Kind;
use crate::stepping::{Playing, Stepping};

/// Value of a variable.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// 64-bit floating-point number.
    Float(f64),
    /// 32-bit integer.
    Integer(i32),
    /// Truth value.
    Boolean(bool),
    /// 64-bit unsigned integer.
    Unsigned(u64),
    /// Unsigned 16-bit codes, one for each sample.
    Codes(Vec<u16>),
}

/// Role of a variable.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Causality {
    /// Set by the caller.
    Input,
    /// Computed by the unit.
    Output,
}

/// Variable of a unit.
#[derive(Clone, Debug, PartialEq)]
pub struct Variable {
    /// Name with its unit.
    pub name: &'static str,
    /// Reference; zero is the time.
    pub reference: u32,
    /// Role of the variable.
    pub causality: Causality,
    /// Unit symbol, or nothing.
    pub unit: &'static str,
    /// Value at the start.
    pub start: Value,
    /// Meaning of the variable.
    pub meaning: &'static str,
}

/// Value of an input that leaves a quantity to the scene.
pub(super) const AS_IN_THE_SCENE: f64 = -1.0;
/// Meaning of the load.
const LOAD: &str =
    "load on the slider or the belt, without its own weight; it acts when it changes, and so do changes of the scene";
/// Meaning of the speed.
const SPEED: &str = "sliding speed; it acts when it changes, and so do changes of the scene";

/// References of the variables.
pub(super) mod reference {
    pub(in super::super) const GATE: u32 = 1;
    pub(in super::super) const AMPLITUDE: u32 = 2;
    pub(in super::super) const FRICTION_TARGET: u32 = 3;
    pub(in super::super) const LOAD: u32 = 4;
    pub(in super::super) const SPEED: u32 = 5;
    pub(in super::super) const V: u32 = 6;
    pub(in super::super) const I: u32 = 7;
    pub(in super::super) const COUNTS: u32 = 8;
    pub(in super::super) const FORCE: u32 = 9;
    pub(in super::super) const TEMPERATURE: u32 = 10;
    pub(in super::super) const BROKEN: u32 = 11;
    pub(in super::super) const FRICTION: u32 = 20;
    pub(in super::super) const TIP_VELOCITY: u32 = 21;
    pub(in super::super) const POWER: u32 = 22;
    pub(in super::super) const FAULT: u32 = 23;
    pub(in super::super) const LOCKED: u32 = 24;
    pub(in super::super) const FREQUENCY: u32 = 25;
    pub(in super::super) const FRICTION_RATIO: u32 = 26;
    pub(in super::super) const HASH: u32 = 27;
    pub(in super::super) const CODES: u32 = 28;
    pub(in super::super) const DROPS_QUEUE: u32 = 29;
    pub(in super::super) const LISTEN: u32 = 30;
}

/// Keys by which load and speed of a scene change, with their present values: of a slider or of a
/// belt.
pub(super) fn moved(scene: &Driven) -> Option<[(DisturbedKey, f64); 2]> {
    if let Some((_, slider)) = scene.sliding() {
        return Some([(DisturbedKey::Load, slider.load_n), (DisturbedKey::Speed, slider.speed_m_per_s)]);
    }
    let (_, belt) = scene.belt()?;
    Some([(DisturbedKey::BeltLoad, belt.load_n), (DisturbedKey::BeltSpeed, belt.speed_m_per_s)])
}

/// Returns the readings of the slow sensors that a scene has, at its start.
fn slow(scene: &Driven) -> SlowSense {
    let mut sense = SenseBlock::default();
    let silence = Stepping::new(scene).map(|controller| controller.silence()).unwrap_or_default();
    Playing::new(scene).exchange(&silence, &mut sense);
    sense.slow
}

/// Returns the variables of a unit. Those that a scene does not have are left out.
pub fn variables(scene: &Driven, kind: Kind) -> Vec<Variable> {
    use Causality::{Input, Output};
    use Value::{Boolean, Codes, Float, Integer, Unsigned};
    let samples = usize::from(scene.controller.block_samples);
    let lanes = usize::from(scene.controller.drive.lanes);
    let silent = vec![scene::settings::config(scene).front_end.sense_mid_code; samples];
    let quiet = vec![scene::settings::config(scene).front_end.drive_mid_code; samples * lanes];
    let variable =
        |name, reference, causality, unit, start, meaning| Variable { name, reference, causality, unit, start, meaning };
    let mut all = Vec::new();
    if kind == Kind::Controller {
        all.push(variable(
            "v_code",
            reference::V,
            Input,
            "",
            Codes(silent.clone()),
            "codes of the voltage channel in the last block",
        ));
        all.push(variable("i_code", reference::I, Input, "", Codes(silent), "codes of the current channel in the last block"));
        let slow = slow(scene);
        if let Some(belt) = slow.belt {
            all.push(variable("belt_counts", reference::COUNTS, Input, "", Integer(belt.counts), "counts of the belt encoder"));
            let broken = "a line to the belt encoder is broken";
            all.push(variable("belt_broken", reference::BROKEN, Input, "", Boolean(false), broken));
        }
        if let Some(force) = slow.force {
            all.push(variable("force_n", reference::FORCE, Input, "N", Float(force.into()), "reading of the force sensor"));
        }
        if let Some(temperature) = slow.temperature {
            let meaning = "reading of the temperature sensor, degrees Celsius";
            all.push(variable("temperature_c", reference::TEMPERATURE, Input, "", Float(temperature.into()), meaning));
        }
    }
    all.push(variable("gate", reference::GATE, Input, "", Integer(0), "0: the bursts of the scene; 1: drive ON; 2: drive OFF"));
    all.push(variable(
        "amplitude_v",
        reference::AMPLITUDE,
        Input,
        "V",
        Float(AS_IN_THE_SCENE),
        "peak voltage of the drive; negative: as in the scene",
    ));
    if scene.controller.friction.is_some() {
        let meaning = "ordered friction ratio, 0 to 1, unless `amplitude_v` is given; negative: as in the scene";
        all.push(variable("friction_target_ratio", reference::FRICTION_TARGET, Input, "", Float(AS_IN_THE_SCENE), meaning));
    }
    if kind == Kind::Board {
        if let Some([(_, load_n), (_, speed_m_per_s)]) = moved(scene) {
            all.push(variable("load_n", reference::LOAD, Input, "N", Float(load_n), LOAD));
            all.push(variable("speed_m_per_s", reference::SPEED, Input, "m/s", Float(speed_m_per_s), SPEED));
        }
        if scene.contact.is_some() || scene.rig.is_some() {
            all.push(variable("friction_n", reference::FRICTION, Output, "N", Float(0.0), "mean friction over the step"));
        }
        let tip = "mean over the step of the peak tip velocity in each block";
        all.push(variable("tip_velocity_m_per_s", reference::TIP_VELOCITY, Output, "m/s", Float(0.0), tip));
        all.push(variable("power_w", reference::POWER, Output, "W", Float(0.0), "mean power of the drive over the step"));
        let hash = "hash of all codes played, as in the summary of a run";
        all.push(variable("drive_hash", reference::HASH, Output, "", Unsigned(0), hash));
    } else {
        all.push(variable(
            "codes",
            reference::CODES,
            Output,
            "",
            Codes(quiet),
            "codes to play two blocks later, lane after lane",
        ));
        let drops = "codes that were returned before must not play any longer";
        all.push(variable("drops_queue", reference::DROPS_QUEUE, Output, "", Boolean(false), drops));
        all.push(variable("listen", reference::LISTEN, Output, "", Integer(0), "lane that the sense channels are connected to"));
    }
    all.push(variable(
        "fault",
        reference::FAULT,
        Output,
        "",
        Integer(0),
        "number of the fault for which the drive is muted, or 0",
    ));
    all.push(variable("locked", reference::LOCKED, Output, "", Boolean(false), "the tracker is locked"));
    all.push(variable("frequency_hz", reference::FREQUENCY, Output, "Hz", Float(0.0), "frequency of the drive"));
    if scene.controller.friction.is_some() {
        let meaning = "estimate of the controller, or 0 without one";
        all.push(variable("friction_ratio", reference::FRICTION_RATIO, Output, "", Float(0.0), meaning));
    }
    all
}
