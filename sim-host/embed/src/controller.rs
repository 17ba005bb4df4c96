//! The controller of a scene in C.

use std::error::Error;
use std::ffi::{c_char, c_int};
use std::ptr;

use firmware::seam::block::{
    Amplitude, BeltSense, DriveBlock, Gate, LATENCY_BLOCKS, SenseBlock, SlowSense, Target, dropped_from,
};
use scene::load::{Loaded, load};
use sim::stepping::{OrderError, Stepping};

use crate::failure::kept;
use crate::pointers::{self, Misuse};

/// Controller of a scene: the code of the firmware, bit for bit.
pub struct SonoglideController {
    stepping: Stepping,
    sense: SenseBlock,
    drive: DriveBlock,
}

/// Sizes of a block, and the conversion between codes and physical units.
#[repr(C)]
pub struct SonoglideShape {
    /// Number of lanes of the drive.
    pub lanes: usize,
    /// Samples in a block.
    pub samples: usize,
    /// Samples per second.
    pub sample_hz: f64,
    /// Number of blocks after which the answer to a block plays.
    pub latency_blocks: usize,
    /// Sample of the playing block from which it must be silent if an answer drops the queue.
    pub dropped_from: usize,
    /// Code of zero volts and amperes.
    pub sense_mid_code: u16,
    /// Largest code of the sense channels.
    pub sense_max_code: u16,
    /// Volts per code of the voltage channel.
    pub volt_per_code: f32,
    /// Amperes per code of the current channel.
    pub ampere_per_code: f32,
    /// Code of zero drive.
    pub drive_mid_code: u16,
    /// Volts of the drive per code.
    pub drive_volt_per_code: f32,
}

/// Slow readings of a board. NaN without such a sensor.
#[repr(C)]
pub struct SonoglideSlow {
    /// `true` if there is a belt encoder.
    pub has_counts: bool,
    /// Counts of the belt encoder.
    pub counts: i32,
    /// `true` if a line to the belt encoder is broken.
    pub broken: bool,
    /// Friction force, N.
    pub force_n: f32,
    /// Temperature at the driver, degrees Celsius.
    pub temperature_c: f32,
}

/// Report of one block.
#[repr(C)]
#[derive(Default)]
pub struct SonoglideReport {
    /// Number of the block, from zero.
    pub block: u32,
    /// Number of the fault for which the drive is muted, or zero.
    pub fault: u8,
    /// Number of the limit that acts, or zero.
    pub limit: u8,
    /// `true` if the tracker is locked.
    pub locked: bool,
    /// `true` if codes that were returned before must not play any longer.
    pub drops_queue: bool,
    /// Lane that the sense channels are connected to while the returned codes play.
    pub listen: u8,
    /// Frequency of the returned codes, Hz.
    pub frequency_hz: f32,
    /// Smoothed estimate of the resonance, Hz.
    pub resonance_hz: f32,
    /// Peak voltage of the returned codes before the envelope, V.
    pub drive_v: f32,
    /// Peak motional current of the measured block, A, in phase with the voltage and at 90 degrees.
    pub motional_current_a: [f32; 2],
    /// Estimate of the friction ratio; NaN if friction is not switched.
    pub friction_ratio: f32,
}

/// Loads a scene that the firmware drives: a built-in name or a file, with changes `key=value`.
pub(crate) fn loaded(source: &str, changes: &[String]) -> Result<Loaded, Box<dyn Error>> {
    if source == "-" {
        return Err("a scene is a built-in name or a file".into());
    }
    let loaded = load(source, changes).map_err(|error| match &error {
        scene::load::LoadError::Invalid(report) => report.render(false).into(),
        _ => Box::<dyn Error>::from(error),
    })?;
    if loaded.scene.driven().is_none() {
        return Err(format!("the scene {source} has no [controller]").into());
    }
    Ok(loaded)
}

/// Returns changes as texts.
///
/// # Safety
/// As of [`pointers::read`] and [`pointers::text`].
pub(crate) unsafe fn texts(changes: *const *const c_char, count: usize) -> Result<Vec<String>, Misuse> {
    // SAFETY: guaranteed by the caller.
    let changes = unsafe { pointers::read(changes, count) }?;
    // SAFETY: guaranteed by the caller.
    changes.iter().map(|change| unsafe { pointers::text(*change) }.map(str::to_owned)).collect()
}

/// Creates the controller of a scene: a built-in name or a TOML file, with `count` changes such as
/// "controller.drive.amplitude_v=5". Returns null on failure; `sonoglide_failure` tells why. The
/// scene gives the orders until the first order of the caller.
///
/// # Safety
/// `source` and the `count` texts `changes` end with a zero byte.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sonoglide_controller_new(
    source: *const c_char,
    changes: *const *const c_char,
    count: usize,
) -> *mut SonoglideController {
    let made = kept(|| -> Result<_, Box<dyn Error>> {
        // SAFETY: guaranteed by the caller.
        let (source, changes) = unsafe { (pointers::text(source), texts(changes, count)) };
        let said = |misuse: Misuse| misuse.to_string();
        let loaded = loaded(source.map_err(said)?, &changes.map_err(said)?)?;
        let stepping = Stepping::new(&loaded.scene.driven().ok_or("the scene has no [controller]")?)?;
        let drive = stepping.silence();
        Ok(Box::new(SonoglideController { stepping, sense: SenseBlock::default(), drive }))
    });
    made.map_or(ptr::null_mut(), Box::into_raw)
}

/// Frees a controller.
///
/// # Safety
/// `controller` is null or comes from `sonoglide_controller_new`, and is not used any more.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sonoglide_controller_free(controller: *mut SonoglideController) {
    // SAFETY: guaranteed by the caller.
    unsafe { pointers::free(controller) };
}

/// Writes the sizes of a block. Returns 0, or -1 on failure.
///
/// # Safety
/// `controller` comes from `sonoglide_controller_new`, `shape` has room for one.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sonoglide_controller_shape(controller: *mut SonoglideController, shape: *mut SonoglideShape) -> c_int {
    done(kept(|| {
        // SAFETY: guaranteed by the caller.
        let (controller, shape) = unsafe { (pointers::object(controller)?, pointers::write(shape, 1)?) };
        let (stepping, front) = (&controller.stepping, &controller.stepping.front_end);
        shape[0] = SonoglideShape {
            lanes: controller.drive.lanes.len(),
            samples: stepping.samples,
            sample_hz: stepping.sample_hz,
            latency_blocks: LATENCY_BLOCKS,
            dropped_from: dropped_from(stepping.samples),
            sense_mid_code: front.sense_mid_code,
            sense_max_code: front.sense_max_code,
            volt_per_code: front.volt_per_lsb,
            ampere_per_code: front.ampere_per_lsb,
            drive_mid_code: front.drive_mid_code,
            drive_volt_per_code: front.drive_volt_per_lsb,
        };
        Ok::<(), Misuse>(())
    }))
}

/// Processes one block: `samples` codes of voltage and current, and slow readings, or null if the
/// scene has no such sensor. Writes the codes to play `latency_blocks` later, `lanes` times
/// `samples`, lane after lane, and the report, if it is not null. Returns 0, or -1 on failure.
///
/// # Safety
/// `controller` comes from `sonoglide_controller_new`; the arrays have the sizes stated.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sonoglide_controller_process(
    controller: *mut SonoglideController,
    v: *const u16,
    i: *const u16,
    slow: *const SonoglideSlow,
    codes: *mut u16,
    report: *mut SonoglideReport,
) -> c_int {
    done(kept(|| -> Result<(), Box<dyn Error>> {
        let said = |misuse: Misuse| misuse.to_string();
        // SAFETY: guaranteed by the caller.
        let controller = unsafe { pointers::object(controller) }.map_err(said)?;
        let SonoglideController { stepping, sense, drive } = controller;
        let samples = stepping.samples;
        // SAFETY: guaranteed by the caller.
        let (v, i) = unsafe { (pointers::read(v, samples), pointers::read(i, samples)) };
        // SAFETY: guaranteed by the caller.
        let codes = unsafe { pointers::write(codes, drive.lanes.len() * samples) };
        // Before anything changes.
        let (v, i, codes) = (v.map_err(said)?, i.map_err(said)?, codes.map_err(said)?);
        sense.v = v.iter().copied().collect();
        sense.i = i.iter().copied().collect();
        // SAFETY: guaranteed by the caller.
        sense.slow = unsafe { slow.as_ref() }.map_or_else(SlowSense::default, |slow| SlowSense {
            belt: slow.has_counts.then_some(BeltSense { counts: slow.counts, broken: slow.broken }),
            force: Some(slow.force_n).filter(|force| !force.is_nan()),
            temperature: Some(slow.temperature_c).filter(|temperature| !temperature.is_nan()),
            ..SlowSense::default()
        });
        stepping.process(sense, drive)?;
        codes.iter_mut().zip(drive.lanes.iter().flatten()).for_each(|(into, code)| *into = *code);
        // SAFETY: guaranteed by the caller.
        if let Some(report) = unsafe { report.as_mut() } {
            *report = reported(stepping, drive);
        }
        Ok(())
    }))
}

fn reported(stepping: &Stepping, drive: &DriveBlock) -> SonoglideReport {
    let report = &stepping.report;
    SonoglideReport {
        block: report.block,
        fault: report.fault.map_or(0, |fault| fault.code()),
        limit: report.limit.map_or(0, |limit| limit.code()),
        locked: report.locked,
        drops_queue: drive.drops_queue,
        listen: drive.listen,
        frequency_hz: report.frequency.0,
        resonance_hz: report.resonance.0,
        drive_v: report.drive.0,
        motional_current_a: [report.motional_current.re, report.motional_current.im],
        friction_ratio: report.friction.map_or(f32::NAN, |friction| friction.ratio),
    }
}

/// Orders a run with the drive always ON at a peak voltage, V. Like every order, it ends the
/// friction steps of the scene. Returns 0, or -1 on failure.
///
/// # Safety
/// `controller` comes from `sonoglide_controller_new`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sonoglide_controller_drive(controller: *mut SonoglideController, volts: f32) -> c_int {
    // SAFETY: guaranteed by the caller.
    unsafe { order(controller, |stepping| stepping.drive(Some(Amplitude::Volts(volts)), None)) }
}

/// Orders the drive ON or OFF in a run, instead of the bursts and the friction switch of the scene;
/// OFF holds the frequency. Returns 0, or -1 on failure.
///
/// # Safety
/// `controller` comes from `sonoglide_controller_new`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sonoglide_controller_gate(controller: *mut SonoglideController, on: bool) -> c_int {
    let gate = if on { Gate::On } else { Gate::Off };
    // SAFETY: guaranteed by the caller.
    unsafe {
        order(controller, |stepping| {
            stepping.gate(gate);
            Ok(())
        })
    }
}

/// Orders a friction ratio, 0 to 1, for scenes with [controller.friction]. Returns 0, or -1 on
/// failure.
///
/// # Safety
/// `controller` comes from `sonoglide_controller_new`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sonoglide_controller_friction(controller: *mut SonoglideController, ratio: f32) -> c_int {
    // SAFETY: guaranteed by the caller.
    unsafe { order(controller, |stepping| stepping.friction(Target::Ratio(ratio))) }
}

/// Orders silence, and clears a fault if wanted; then `sonoglide_controller_drive` begins a new
/// attempt. Returns 0, or -1 on failure.
///
/// # Safety
/// `controller` comes from `sonoglide_controller_new`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sonoglide_controller_stop(controller: *mut SonoglideController, clear_fault: bool) -> c_int {
    // SAFETY: guaranteed by the caller.
    unsafe {
        order(controller, |stepping| {
            stepping.stop(clear_fault);
            Ok(())
        })
    }
}

/// Gives an order.
///
/// # Safety
/// As of [`pointers::object`].
unsafe fn order(controller: *mut SonoglideController, order: impl FnOnce(&mut Stepping) -> Result<(), OrderError>) -> c_int {
    done(kept(|| -> Result<(), Box<dyn Error>> {
        // SAFETY: guaranteed by the caller.
        let controller = unsafe { pointers::object(controller) }.map_err(|misuse| misuse.to_string())?;
        Ok(order(&mut controller.stepping)?)
    }))
}

/// Returns 0 for success, -1 for failure.
pub(crate) fn done(result: Option<()>) -> c_int {
    if result.is_some() { 0 } else { -1 }
}
