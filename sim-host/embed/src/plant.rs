//! The plant of a scene in C.

use std::error::Error;
use std::ffi::{c_char, c_int};
use std::ptr;

use firmware::seam::block::{DriveBlock, SenseBlock};
use hal_mock::analog::Analog;
use sim::stepping::Playing;

use crate::controller::{SonoglideSlow, done, loaded, texts};
use crate::failure::kept;
use crate::pointers::{self, Misuse};

/// Simulated amplifier, transducer, contact and converters of a scene.
pub struct SonoglidePlant {
    playing: Playing,
    drive: DriveBlock,
    sense: SenseBlock,
    lanes: usize,
    samples: usize,
}

/// True state of a plant at the end of the last block, which a controller never receives.
#[repr(C)]
pub struct SonoglideTruth {
    /// Mean friction, N.
    pub friction_n: f64,
    /// Peak tip velocity, m/s.
    pub tip_velocity_m_per_s: f64,
    /// Series resonance, Hz.
    pub series_resonance_hz: f64,
    /// Mean power of the drive, W.
    pub power_w: f64,
    /// Hash of all codes played, as in the summary of a run.
    pub drive_hash: u64,
}

/// Creates the plant of a scene, with the arguments of `sonoglide_controller_new`. Returns null on
/// failure; `sonoglide_failure` tells why.
///
/// # Safety
/// `source` and the `count` texts `changes` end with a zero byte.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sonoglide_plant_new(
    source: *const c_char,
    changes: *const *const c_char,
    count: usize,
) -> *mut SonoglidePlant {
    let made = kept(|| -> Result<_, Box<dyn Error>> {
        // SAFETY: guaranteed by the caller.
        let (source, changes) = unsafe { (pointers::text(source), texts(changes, count)) };
        let said = |misuse: Misuse| misuse.to_string();
        let loaded = loaded(source.map_err(said)?, &changes.map_err(said)?)?;
        let scene = loaded.scene.driven().ok_or("the scene has no [controller]")?;
        Ok(Box::new(SonoglidePlant {
            playing: Playing::new(&scene),
            drive: DriveBlock::default(),
            sense: SenseBlock::default(),
            lanes: scene.controller.drive.lanes.into(),
            samples: scene.controller.block_samples.into(),
        }))
    });
    made.map_or(ptr::null_mut(), Box::into_raw)
}

/// Frees a plant.
///
/// # Safety
/// `plant` is null or comes from `sonoglide_plant_new`, and is not used any more.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sonoglide_plant_free(plant: *mut SonoglidePlant) {
    // SAFETY: guaranteed by the caller.
    unsafe { pointers::free(plant) };
}

/// Plays one block of codes, `lanes` times `samples`, with the sense channels at the lane `listen`.
/// Writes `samples` codes of voltage and of current, and the slow readings, if `slow` is not null.
/// Returns 0, or -1 on failure.
///
/// # Safety
/// `plant` comes from `sonoglide_plant_new`; the arrays have the sizes stated.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sonoglide_plant_step(
    plant: *mut SonoglidePlant,
    codes: *const u16,
    listen: u8,
    v: *mut u16,
    i: *mut u16,
    slow: *mut SonoglideSlow,
) -> c_int {
    done(kept(|| {
        // SAFETY: guaranteed by the caller.
        let SonoglidePlant { playing, drive, sense, lanes, samples } = unsafe { pointers::object(plant) }?;
        if usize::from(listen) >= *lanes {
            return Err(Misuse("there is no such lane"));
        }
        // SAFETY: guaranteed by the caller.
        let codes = unsafe { pointers::read(codes, *lanes * *samples) }?;
        // SAFETY: guaranteed by the caller.
        let (v, i) = unsafe { (pointers::write(v, *samples)?, pointers::write(i, *samples)?) };
        let capacity = drive.lanes.capacity();
        drive.lanes = codes.chunks(*samples).map(|lane| lane.iter().copied().collect()).take(capacity).collect();
        drive.listen = listen;
        playing.exchange(drive, sense);
        v.copy_from_slice(&sense.v);
        i.copy_from_slice(&sense.i);
        // SAFETY: guaranteed by the caller.
        if let Some(slow) = unsafe { slow.as_mut() } {
            *slow = SonoglideSlow {
                has_counts: sense.slow.belt.is_some(),
                counts: sense.slow.belt.map_or(0, |belt| belt.counts),
                broken: sense.slow.belt.is_some_and(|belt| belt.broken),
                force_n: sense.slow.force.unwrap_or(f32::NAN),
                temperature_c: sense.slow.temperature.unwrap_or(f32::NAN),
            };
        }
        Ok(())
    }))
}

/// Writes the true state of a plant. Returns 0, or -1 on failure.
///
/// # Safety
/// `plant` comes from `sonoglide_plant_new`, `truth` has room for one.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sonoglide_plant_truth(plant: *mut SonoglidePlant, truth: *mut SonoglideTruth) -> c_int {
    done(kept(|| {
        // SAFETY: guaranteed by the caller.
        let (plant, into) = unsafe { (pointers::object(plant)?, pointers::write(truth, 1)?) };
        let truth = plant.playing.plant().truth();
        into[0] = SonoglideTruth {
            friction_n: truth.friction_mean_n,
            tip_velocity_m_per_s: truth.tip_velocity_m_per_s,
            series_resonance_hz: truth.series_resonance_hz,
            power_w: truth.power_w,
            drive_hash: plant.playing.drive_hash(),
        };
        Ok::<(), Misuse>(())
    }))
}
