//! Device and silicon revision of the microcontroller. RM0440 47.6.1.

use stm32_metapac::DBGMCU;

/// Returns device and revision, and logs them: DBGMCU_IDCODE.DEV_ID, REV_ID.
pub fn identity() -> (u16, u16) {
    let code = DBGMCU.idcode().read();
    let (device, revision) = (code.dev_id(), code.rev_id());
    defmt::info!("silicon {=u16:#x}, revision {=u16:#x} (docs/errata.md)", device, revision);
    (device, revision)
}
