//! The image: power-up in a fixed order, then the background task in a loop and the block interrupt
//! above it.
//!
//! From reset the amplifier's enable is low (pull-down) until the background task raises it. Every
//! hardware error ends in [`panic::end`]: the enable drops, the cause is stored, and the processor
//! resets.

#[path = "first_access.rs"]
mod first_access;

mod adc;
mod alarm;
mod amplifier_supply;
mod block;
#[cfg(feature = "slot")]
mod button;
mod ccmram;
mod clocks;
mod count;
mod dac;
mod dma;
mod encoder;
#[cfg(feature = "slot")]
mod field;
#[cfg_attr(not(feature = "slot"), expect(dead_code, reason = "needed for updates only"))]
mod flash;
mod force;
mod guard;
mod led;
mod options;
mod panic;
mod pins;
mod protection;
mod silicon;
mod supply;
mod temperature;
mod timers;
mod uart;
mod watchdog;

use boards_common::note::{Cause, Note};
use boards_common::supply_window::SupplyWindow;
use boards_common::thermistor::Thermistor;
use cortex_m::peripheral::NVIC;
use cortex_m::{Peripherals, singleton};
use cortex_m_rt::entry;
// Transport of the log.
use defmt_rtt as _;
use firmware::board::app::{self, App};
use firmware::board::hardware::{Clock, HardwareReport};
use firmware::board::power_up::PowerUp;
use firmware::board::queues::{BackgroundEnds, BlockEnds, Loans, Queues};
use firmware::board::settings::Settings;
use firmware::board::start::Start;
use firmware::seam::fault::Fault;
use firmware::seam::mode::Mode;
use firmware::seam::telemetry::Telemetry;
use nucleo_g474re::blocks::CYCLES_PER_BLOCK;
use nucleo_g474re::config::{CODES, REFERENCE_V, config};
use nucleo_g474re::errata;
use nucleo_g474re::trips::thresholds;
use stm32_metapac::{Interrupt, RCC};

use self::amplifier_supply::AmplifierSupply;
use self::block::BlockInterrupt;
use self::dac::Lanes;
use self::encoder::Encoder;
use self::flash::Pages;
use self::force::ForceChannel;
use self::protection::{Enable, Stop};
use self::temperature::Thermometer;
use self::uart::Link;
use self::watchdog::IndependentWatchdog;

/// Length of the queue of orders; one place stays empty.
const ORDERS: usize = 9;
/// Length of the queue of reports; one place stays empty. The background task empties it many times
/// per block.
const REPORTS: usize = 5;

defmt::timestamp!("{=u32} blocks", count::blocks());

#[entry]
fn main() -> ! {
    static mut QUEUES: Queues<ORDERS, REPORTS> = Queues::new();
    static mut LOANS: Loans<REPORTS> = Loans::new();

    ccmram::load();
    let Some(mut core) = Peripherals::take() else { panic!("started twice") };
    guard::start(&core.MPU);
    let note = panic::last();
    let last = note.as_ref().and_then(Note::read);
    let clock = clocks::start(!matches!(last, Some((Cause::ClockFailed, ..))));
    let start = cause_of_start(note.as_ref());
    defmt::info!("clock: {}", clock);
    core.DCB.enable_trace();
    core.DWT.enable_cycle_counter();

    supply::watch();
    led::start();
    let (app, mut thermometer, mut amplifier_supply) = build(QUEUES.split(LOANS), start, clock.into());
    start_blocks(&mut core.NVIC);
    let mut log = Log::default();
    loop {
        // The pins and the link of this board cannot fail.
        let _ = app.poll();
        thermometer.poll();
        amplifier_supply.poll();
        log.update(app.latest());
        app.set_worst_cycles(block::worst_cycles());
        led::show(app.latest());
    }
}

/// Background task of this board.
type Background = App<'static, Link, Enable, Stop, IndependentWatchdog, Pages>;

/// Builds both tasks from the settings: passes one to the block interrupt and returns the
/// background task.
///
/// Not inlined, so that the stack memory it needs is free afterwards.
#[inline(never)]
fn build(
    (hot_ends, slow_ends): (BlockEnds<'static>, BackgroundEnds<'static>),
    start: Start,
    clock: Clock,
) -> (&'static mut Background, Thermometer, AmplifierSupply) {
    let link = Link::start();
    let Ok(mut settings) = Settings::new(Pages::SETTINGS) else { panic!("the settings do not fit into their pages") };
    let built_in = config();
    let mut power_up = PowerUp::read(&built_in, &mut settings);
    // Cannot fail: the built-in configuration is tested on the host.
    let Ok(task) = power_up.build(&built_in, hot_ends) else { panic!("the configuration is not valid") };
    let config = &power_up.config;
    // Silence first: on a bench without a front end, the lane itself holds the current inputs at
    // mid-scale while the trips are tested.
    let lanes = Lanes::start(config.lanes);
    // The thresholds come from the DAC that does not play.
    let (device, revision) = silicon::identity();
    let is_supported = !errata::is_refused(revision);
    let thresholds = thresholds(config.limits.current_a, config.front_end.ampere_per_lsb);
    let (enable, stop, failure) = protection::start(config.lanes, thresholds, adc::levels(), is_supported);
    let start = if is_supported { start } else { Start::UnsupportedSilicon(revision) };
    let start = failure.map_or(start, |failure| {
        defmt::error!("the over-current trips failed their test, the amplifier stays off: {=u8}", failure as u8);
        Start::TripFailed(failure)
    });
    let thermometer = Thermometer::start(Thermistor::from_settings(&config.heat_sink, CODES));
    let amplifier_supply = AmplifierSupply::start(SupplyWindow::from_settings(&config.supply, REFERENCE_V, CODES));
    let force = config.front_end.newton_per_lsb.map(ForceChannel::start);
    let encoder = config.front_end.metre_per_count.map(|_| Encoder::start());
    let interrupt = singleton!(: BlockInterrupt = BlockInterrupt::new(task, lanes, encoder, force));
    let Some(interrupt) = interrupt else { panic!("started twice") };
    block::hand_over(interrupt);
    adc::start();
    timers::prepare();
    let peripherals = app::Peripherals { link, enable, stop, watchdog: IndependentWatchdog::start(), settings, start };
    let background = singleton!(: Background = App::new(peripherals, slow_ends, &power_up));
    let Some(background) = background else { panic!("started twice") };
    background.set_built_in(&nucleo_g474re::config::config);
    background.set_hardware(HardwareReport {
        device,
        revision,
        option_bytes: options::check(),
        clock,
        core_hz: clocks::SYSTEM_HZ,
        block_cycles: CYCLES_PER_BLOCK,
        worst_cycles: 0,
        muted: false,
    });
    #[cfg(feature = "slot")]
    background.set_updates(field::start());
    (background, thermometer, amplifier_supply)
}

#[expect(unsafe_code, reason = "enabling an interrupt is unsafe")]
fn start_blocks(nvic: &mut NVIC) {
    // SAFETY: the priority is set before the interrupt is enabled, and no critical section here
    // relies on priorities.
    unsafe { nvic.set_priority(Interrupt::DMA1_CHANNEL1, 0) };
    // SAFETY: the state that the interrupt needs was handed over before.
    unsafe { NVIC::unmask(Interrupt::DMA1_CHANNEL1) };
    timers::start();
}

/// Returns the cause of this start: the note of the last run, or the flags of RCC_CSR (RM0440
/// 7.4.28).
fn cause_of_start(note: Option<&Note>) -> Start {
    let flags = RCC.csr().read();
    RCC.csr().modify(|w| w.set_rmvf(true));
    if let Some((cause, file, line)) = note.and_then(Note::read) {
        defmt::error!("the last run ended with {=str}, {=str}:{=u32}", cause.name(), file, line);
    }
    let start = match note.and_then(Note::start) {
        Some(start) => start,
        None if flags.iwdgrstf() => Start::Watchdog,
        // A power-on pulls the reset pin low too.
        None if flags.borrstf() => Start::PowerOn,
        None => Start::Pin,
    };
    match start {
        Start::Watchdog => defmt::error!("reset by the watchdog: no blocks, or the background task had stopped"),
        Start::PowerOn => defmt::info!("power on"),
        _ => {}
    }
    start
}

/// Log of changes: the fault, and the longest block.
///
/// A log line masks interrupts for up to 6 us. The long blocks during a start leave no time for
/// that, so the log waits until the start is over.
#[derive(Default)]
struct Log {
    fault: Option<Fault>,
    worst: u32,
}

impl Log {
    fn update(&mut self, report: Option<&Telemetry>) {
        let fault = report.and_then(|report| report.fault);
        if fault != self.fault {
            defmt::warn!("fault {}", fault);
            self.fault = fault;
        }
        let worst = block::worst_cycles();
        let starts = report.is_some_and(|report| !matches!(report.mode, Mode::Idle | Mode::Fault | Mode::Run));
        if worst > self.worst && !starts {
            defmt::info!("worst block {=u32} cycles", worst);
            self.worst = worst;
        }
    }
}
