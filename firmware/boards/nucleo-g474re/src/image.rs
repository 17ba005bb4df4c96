//! The image: power-up in order, then the slow side in a loop and the block interrupt above it.
//!
//! The amplifier's enable is low from reset (its pull-down) until the slow side raises it. Whatever goes wrong ends in [`panic::end`]: enable low,
//! reason kept, reset.

mod adc;
mod block;
mod ccmram;
mod clocks;
mod dac;
mod dma;
mod encoder;
mod flash;
mod panic;
mod pins;
mod protection;
mod temperature;
mod timers;
mod uart;
mod watchdog;

use cortex_m::peripheral::NVIC;
use cortex_m::{Peripherals, singleton};
use cortex_m_rt::entry;
// For the log.
use defmt_rtt as _;
use firmware::board::app::{self, App};
use firmware::board::capture::memory::Memory;
use firmware::board::power_up::PowerUp;
use firmware::board::queues::{HotEnds, Queues, SlowEnds};
use firmware::board::settings::Settings;
use firmware::board::start::Start;
use firmware::seam::fault::Fault;
use firmware::seam::telemetry::Telemetry;
use nucleo_g474re::config::{LANES, config};
use nucleo_g474re::note::Note;
use stm32_metapac::{Interrupt, RCC};

use self::block::Hot;
use self::dac::Lanes;
use self::encoder::Encoder;
use self::flash::Pages;
use self::protection::{Enable, Stop};
use self::temperature::Thermometer;
use self::uart::Link;
use self::watchdog::IndependentWatchdog;

/// Room of the queues; one place of each stays empty. The slow side empties that of the telemetry many times a block.
const ORDERS: usize = 9;
const REPORTS: usize = 5;

defmt::timestamp!("{=u32} blocks", block::count());

#[entry]
fn main() -> ! {
    static mut QUEUES: Queues<ORDERS, REPORTS> = Queues::new();
    static mut MEMORY: Memory = Memory::new();

    ccmram::load();
    clocks::start();
    let start = what_started();
    let Some(mut core) = Peripherals::take() else { panic!("started twice") };
    core.DCB.enable_trace();
    core.DWT.enable_cycle_counter();

    let (enable, stop) = protection::start(LANES);
    let mut thermometer = Thermometer::start();
    let app = build(QUEUES.split(MEMORY), enable, stop, start);
    start_blocks(&mut core.NVIC);
    let mut log = Log::default();
    loop {
        // Pins and link of this board cannot fail.
        let _ = app.poll();
        thermometer.poll();
        log.look(app.latest());
    }
}

/// The slow side of this board.
type Slow = App<'static, Link, Enable, Stop, IndependentWatchdog, Pages>;

/// Builds both sides: hands the hot one over to the block interrupt, and returns the slow one. Not inlined: what that takes of the stack is given
/// back here.
#[inline(never)]
fn build(
    (hot_ends, slow_ends): (HotEnds<'static>, SlowEnds<'static>),
    enable: Enable,
    stop: Stop,
    start: Start,
) -> &'static mut Slow {
    let link = Link::start();
    let Ok(mut settings) = Settings::new(Pages) else { panic!("the settings do not fit") };
    let built_in = config();
    let mut power_up = PowerUp::read(&built_in, &mut settings);
    // What is built in is tested on the host.
    let Ok(task) = power_up.build(&built_in, hot_ends) else { panic!("the configuration is not valid") };
    let hot = singleton!(: Hot = Hot::new(task, Lanes::start(LANES), Encoder::start()));
    let Some(hot) = hot else { panic!("started twice") };
    block::hand_over(hot);
    adc::start();
    timers::prepare();
    let peripherals = app::Peripherals { link, enable, stop, watchdog: IndependentWatchdog::start(), settings, start };
    let slow = singleton!(: Slow = App::new(peripherals, slow_ends, &power_up));
    let Some(slow) = slow else { panic!("started twice") };
    slow
}

#[expect(unsafe_code, reason = "enabling an interrupt is")]
fn start_blocks(nvic: &mut NVIC) {
    // SAFETY: the priority is set before the interrupt is enabled, and no critical section here relies on priorities.
    unsafe { nvic.set_priority(Interrupt::DMA1_CHANNEL1, 0) };
    // SAFETY: what the interrupt needs was handed over.
    unsafe { NVIC::unmask(Interrupt::DMA1_CHANNEL1) };
    timers::start();
}

/// What started the part: the note of the last run, or the flags of RCC_CSR (RM0440 7.4.28).
fn what_started() -> Start {
    let flags = RCC.csr().read();
    RCC.csr().modify(|w| w.set_rmvf(true));
    let note = panic::last();
    if let Some((cause, file, line)) = note.as_ref().and_then(Note::read) {
        defmt::error!("the last run ended by {=str}, {=str}:{=u32}", cause.name(), file, line);
    }
    let start = match note.as_ref().and_then(Note::start) {
        Some(start) => start,
        None if flags.iwdgrstf() => Start::Watchdog,
        // A power-on pulls the pin low too.
        None if flags.borrstf() => Start::PowerOn,
        None => Start::Pin,
    };
    match start {
        Start::Watchdog => defmt::error!("reset by the watchdog: the block stream had died"),
        Start::PowerOn => defmt::info!("power on"),
        _ => {}
    }
    start
}

/// Says what has changed.
#[derive(Default)]
struct Log {
    fault: Option<Fault>,
    worst: u32,
}

impl Log {
    fn look(&mut self, report: Option<&Telemetry>) {
        let fault = report.and_then(|report| report.fault);
        if fault != self.fault {
            defmt::warn!("fault {}", fault);
            self.fault = fault;
        }
        let worst = block::worst_cycles();
        if worst > self.worst {
            defmt::info!("worst block {=u32} cycles", worst);
            self.worst = worst;
        }
    }
}
