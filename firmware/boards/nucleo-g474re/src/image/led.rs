//! Status LED at PA9. The board's own LED, LD2, is at PA5, which is a drive lane.

use boards_common::led::is_lit;
use firmware::seam::mode::Mode;
use firmware::seam::telemetry::Telemetry;
use nucleo_g474re::blocks::BLOCK;
use stm32_metapac::GPIOA;

use super::count;
use super::pins::Pin;

const LED: Pin = Pin::new(GPIOA, 9);

/// Makes the pin an output with the LED off.
pub fn start() {
    LED.output();
}

/// Shows the state of the latest report; before the first one, the board is idle. The count of
/// blocks gives the time.
pub fn show(latest: Option<&Telemetry>) {
    let (mode, fault) = latest.map_or((Mode::Idle, None), |report| (report.mode, report.fault));
    LED.set(is_lit(mode, fault, count::blocks() / (1000 / BLOCK as u32)));
}
