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

use core::mem::MaybeUninit;

use cortex_m::peripheral::NVIC;
use cortex_m::{Peripherals, singleton};
use cortex_m_rt::entry;
// For the log.
use defmt_rtt as _;
use firmware::app::{self, App};
use firmware::block::Orders;
use firmware::block_task::{BlockTask, Exchange};
use firmware::config::LaneTrims;
use firmware::controller::Controller;
use firmware::keeper::Keeper;
use firmware::settings::{Kept, Settings};
use firmware::supervisor::Fault;
use firmware::telemetry::Telemetry;
use heapless::spsc::{Consumer, Producer, Queue};
use nucleo_g474re::config::{LANES, config};
use stm32_metapac::{Interrupt, RCC};

use self::block::Hot;
use self::dac::Lanes;
use self::encoder::Encoder;
use self::flash::Pages;
use self::temperature::Thermometer;
use self::uart::Link;
use self::watchdog::Dog;

/// Room of the queues; one place of each stays empty. The slow side empties that of the telemetry many times a block.
const ORDERS: usize = 9;
const REPORTS: usize = 9;
const TRIMS: usize = 2;

defmt::timestamp!("{=u32} blocks", block::count());

#[entry]
fn main() -> ! {
    ccmram::load();
    clocks::start();
    report_last_run();
    let Some(mut core) = Peripherals::take() else { panic!("started twice") };
    core.DCB.enable_trace();
    core.DWT.enable_cycle_counter();

    let (enable, stop) = protection::start(LANES);
    let mut thermometer = Thermometer::start();
    let link = Link::start();
    let Ok(mut settings) = Settings::new(Pages) else { panic!("the settings do not fit") };
    let (trims, kept) = settings.lane_trims();
    let Slow { orders, reports, keeper } = build(trims, kept);
    adc::start();
    timers::prepare();

    let watchdog = Dog::start();
    start_blocks(&mut core.NVIC);
    let mut app = App::new(app::Peripherals { link, enable, stop, watchdog, settings }, orders, reports, keeper);
    let mut log = Log::default();
    loop {
        // Pins and link of this board cannot fail.
        let _ = app.poll();
        thermometer.poll();
        log.look(app.latest());
    }
}

/// What the slow side has of the queues.
struct Slow {
    orders: Producer<'static, Orders>,
    reports: Consumer<'static, Telemetry>,
    keeper: Keeper<'static>,
}

/// Builds the controller with its queues, and hands it over to the block interrupt. Not inlined: what that takes of the stack is given back here.
#[inline(never)]
fn build(trims: LaneTrims, kept: Kept) -> Slow {
    let queues = (
        singleton!(: Queue<Orders, ORDERS> = Queue::new()),
        singleton!(: Queue<Telemetry, REPORTS> = Queue::new()),
        singleton!(: Queue<LaneTrims, TRIMS> = Queue::new()),
        singleton!(: Queue<LaneTrims, TRIMS> = Queue::new()),
    );
    let (Some(orders), Some(reports), Some(found), Some(taken)) = queues else { panic!("started twice") };
    let ((orders_in, orders_out), (reports_in, reports_out)) = (orders.split(), reports.split());
    let ((found_in, found_out), (taken_in, taken_out)) = (found.split(), taken.split());
    let mut config = config();
    if kept == Kept::Stored {
        config.phasing.calibration = trims;
    }
    // Tested on the host; what is kept was checked as it was read.
    let Some(place) = singleton!(: MaybeUninit<Controller> = MaybeUninit::uninit()) else { panic!("started twice") };
    let Ok(controller) = Controller::build_in(place, &config) else { panic!("the configuration is not valid") };
    let task = BlockTask::new(controller, orders_out, reports_in, Exchange { found: found_in, taken: taken_out });
    let hot = singleton!(: Hot = Hot::new(task, Lanes::start(LANES), Encoder::start()));
    let Some(hot) = hot else { panic!("started twice") };
    block::hand_over(hot);
    Slow { orders: orders_in, reports: reports_out, keeper: Keeper::new(found_out, taken_in, config.phasing.calibration, kept) }
}

#[expect(unsafe_code, reason = "enabling an interrupt is")]
fn start_blocks(nvic: &mut NVIC) {
    // SAFETY: the priority is set before the interrupt is enabled, and no critical section here relies on priorities.
    unsafe { nvic.set_priority(Interrupt::DMA1_CHANNEL1, 0) };
    // SAFETY: what the interrupt needs was handed over.
    unsafe { NVIC::unmask(Interrupt::DMA1_CHANNEL1) };
    timers::start();
}

/// What ended the last run, and what the part was reset by: RCC_CSR (RM0440 7.4.28).
fn report_last_run() {
    let flags = RCC.csr().read();
    RCC.csr().modify(|w| w.set_rmvf(true));
    if flags.iwdgrstf() {
        defmt::error!("reset by the watchdog: the block stream had died");
    } else if flags.borrstf() {
        defmt::info!("power on");
    }
    if let Some(note) = panic::last()
        && let Some((cause, file, line)) = note.read()
    {
        defmt::error!("the last run ended by {=str}, {=str}:{=u32}", cause.name(), file, line);
    }
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
