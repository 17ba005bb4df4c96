//! The image: receives a configuration, then one block per record, until the host closes its pipe.
//! Its exit codes are those of [the other image](../image.rs).

// Provides the critical section.
use cortex_m::{Peripherals, singleton};
use cortex_m_rt::entry;
use firmware::board::app::{self, App};
use firmware::board::block_task::BlockTask;
use firmware::board::lockstep::{Beat, Closing, Opening, Played};
use firmware::board::power_up::PowerUp;
use firmware::board::queues::{Loans, Queues};
use firmware::board::settings::Settings;
use qemu_m4::pages::Pages;
use qemu_m4::pipes::{Pipes, configuration, read, reason};
use qemu_m4::stack;
use semihosting::{eprintln, process};

use crate::pins::{self, Enable, Stop, VirtualWatchdog};
use crate::retained;
use crate::usart::{self, Usart};

/// Length of the queue of orders; one place stays empty.
const ORDERS: usize = 9;
/// Length of the queue of reports; one place stays empty.
const REPORTS: usize = 9;

const STARTED_TWICE: &str = "started twice";

#[entry]
fn main() -> ! {
    match serve() {
        Ok(()) => process::exit(0),
        Err(trouble) => {
            eprintln!("{trouble}");
            process::exit(1)
        }
    }
}

/// Runs the board, one block per record.
fn serve() -> Result<(), &'static str> {
    stack::paint();
    let mut core = Peripherals::take().ok_or(STARTED_TWICE)?;
    let link = Usart::start(&mut core);
    let pipes = Pipes::open()?;
    let Some((task, app)) = open(pipes, link)? else { return Ok(()) };
    let (beat, played) = records().ok_or(STARTED_TWICE)?;
    let stack_power_up_bytes = stack::deepest_bytes();
    stack::paint();
    while let Some(body) = pipes.receive()? {
        if body.is_empty() {
            pipes.send(&Closing { stack_power_up_bytes, stack_blocks_bytes: stack::deepest_bytes() })?;
            continue;
        }
        read(body, beat)?;
        pins::press(beat.pins.stop);
        usart::receive(beat.pins.sent);
        task.run(&beat.sense, &mut played.drive);
        let failed = app.poll().is_err();
        played.board = pins::seen(failed);
        pipes.send(&*played)?;
        if played.board.resets {
            retained::reset()
        }
    }
    Ok(())
}

/// Returns the static memory for the records. Not inlined, so that the stack used by their
/// construction is released.
#[inline(never)]
fn records() -> Option<&'static mut (Beat, Played)> {
    singleton!(: (Beat, Played) = Default::default())
}

/// Background task of this board.
type Slow = App<'static, Usart, Enable, Stop, VirtualWatchdog, &'static mut Pages>;

/// Builds both tasks from the configuration of the host and the stored settings, and answers.
/// Returns `None` if the host has closed its pipe or if the configuration was refused.
///
/// Not inlined, so that the stack used by the construction is released.
#[inline(never)]
fn open(pipes: &mut Pipes, link: Usart) -> Result<Option<&'static mut (BlockTask<'static>, Slow)>, &'static str> {
    let Some(body) = pipes.receive()? else { return Ok(None) };
    let built_in = configuration(body)?;
    let queues = singleton!(: Queues<ORDERS, REPORTS> = Queues::new()).ok_or(STARTED_TWICE)?;
    let loans = singleton!(: Loans<REPORTS> = Loans::new()).ok_or(STARTED_TWICE)?;
    let (hot, slow) = queues.split(loans);
    let (pages, start) = retained::take().ok_or(STARTED_TWICE)?;
    let mut settings = Settings::new(pages).map_err(|_| "the settings do not fit into their pages")?;
    let mut power_up = PowerUp::read(&built_in, &mut settings);
    match power_up.build(&built_in, hot) {
        Ok(task) => {
            pipes.send(&Opening { built: Ok(()), silence: task.silence() })?;
            let peripherals = app::Peripherals { link, enable: Enable, stop: Stop, watchdog: VirtualWatchdog, settings, start };
            singleton!(: (BlockTask<'static>, Slow) = (task, App::new(peripherals, slow, &power_up)))
                .ok_or(STARTED_TWICE)
                .map(Some)
        }
        Err(error) => {
            pipes.send(&Opening { built: Err(reason(&error)), ..Opening::default() })?;
            Ok(None)
        }
    }
}
