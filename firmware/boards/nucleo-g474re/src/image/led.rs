//! The status LED at PA9. The board's own, LD2, hangs on PA5, which is a drive lane.

use boards_common::led::is_lit;
use firmware::seam::mode::Mode;
use firmware::seam::telemetry::Telemetry;
use nucleo_g474re::blocks::BLOCK;
use stm32_metapac::GPIOA;

use super::count;
use super::pins::Pin;

const LED: Pin = Pin::new(GPIOA, 9);

/// Makes the pin an output: off.
pub fn start() {
    LED.output();
}

/// Shows what the latest report says; before the first one the board is idle. The time is that of the blocks.
pub fn show(latest: Option<&Telemetry>) {
    let (mode, fault) = latest.map_or((Mode::Idle, None), |report| (report.mode, report.fault));
    LED.set(is_lit(mode, fault, count::blocks() / (1000 / BLOCK as u32)));
}
