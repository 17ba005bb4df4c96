//! The tests of the image.

#[cfg(feature = "hil")]
mod board;
mod count;

use core::panic::PanicInfo;

// Linked for the start of the image and the critical section.
use cortex_m as _;
use cortex_m_rt as _;
use semihosting::{eprintln, process};

/// Prints the panic, and ends the test as the runner expects.
#[panic_handler]
fn panic(info: &PanicInfo) -> ! {
    eprintln!("{info}");
    process::abort()
}

#[embedded_test::tests(default_timeout = 20)]
mod tests {
    use core::mem::MaybeUninit;

    use cortex_m::singleton;
    use firmware::board::command::{Command, Reply};
    use firmware::board::link::{self, Frame, FrameError, Receiver};
    use firmware::board::settings::{Record, Settings};
    use firmware::board::stored_state::StoredState;
    use firmware::controller::Controller;
    use firmware::seam::block::{Codes, Orders, Request, SenseBlock};
    use firmware::seam::config::{TrackingMode, Trim, TrimPoint};
    use firmware::seam::fault::Fault;
    use firmware::seam::mode::Mode;
    use on_target::of_the_host::OF_THE_HOST;
    use on_target::stream::{self, BLOCKS};
    use qemu_m4::bench::{SAMPLES, Transducer, config};
    use qemu_m4::pages::Pages;
    use qemu_m4::stack;
    use semihosting::println;

    use super::count::{Meter, UNIT};

    /// Length of a block on the reference board, cycles.
    const BLOCK_CYCLES: u32 = 5440;
    /// Stack that the controller may use, bytes: the limit of the board's whole image.
    const STACK_BYTES: u32 = 4096;
    /// Stack that building the controller may use, bytes; released before the first block.
    const BUILD_STACK_BYTES: u32 = 27 << 10;

    fn controller() -> Controller {
        // The transducer is at one lane; the others have no load.
        let mut config = config(TrackingMode::Observer, 4, SAMPLES);
        config.phasing.watch = false;
        Controller::build(&config).expect("a valid configuration")
    }

    #[test]
    fn the_controller_builds_and_plays_silence() {
        let mut controller = controller();
        let silence = controller.silence();
        assert_eq!((silence.lanes.len(), silence.lanes[0].len()), (4, SAMPLES));
        let (mut drive, mut sense) = (silence.clone(), SenseBlock::default());
        let mut transducer = Transducer::new();
        for _ in 0..50 {
            transducer.exchange(&drive, &mut sense);
            let report = controller.process(&Orders::default(), &sense, &mut drive);
            assert_eq!((report.mode, &drive), (Mode::Idle, &silence));
        }
    }

    #[test]
    fn a_power_up_is_played_as_the_host_has_played_it() {
        let played = stream::play(|_, process| process()).expect("a valid configuration");
        assert!(played.driven > BLOCKS / 4, "{} blocks under drive", played.driven);
        assert_eq!(played, OF_THE_HOST);
    }

    #[test]
    fn no_block_takes_longer_than_it_lasts() {
        let meter = Meter::start();
        let (mut worst, mut total) = (0, 0);
        let played = stream::play(|_, process| {
            let taken = meter.measure(process);
            worst = worst.max(taken);
            total += taken;
        });
        assert_eq!(played, Ok(OF_THE_HOST));
        println!("{} {UNIT} in the mean, {worst} in the worst block of {BLOCK_CYCLES} cycles", total / BLOCKS);
        assert!(worst < BLOCK_CYCLES, "{worst} {UNIT}");
        // A counter that does not count would pass.
        assert!(total / BLOCKS > 1000, "{total} {UNIT} in total");
    }

    #[test]
    fn the_controller_keeps_within_its_stack() {
        let mut above = 0;
        let mut deepest = 0;
        let played = stream::play(|block, process| {
            if block == 0 {
                stack::paint();
                above = stack::deepest_bytes();
            }
            process();
            if block == BLOCKS - 1 {
                deepest = stack::deepest_bytes();
            }
        });
        assert_eq!(played, Ok(OF_THE_HOST));
        println!("{} bytes of stack in the blocks, on top of {above} outside them", deepest - above);
        assert!((500..STACK_BYTES).contains(&(deepest - above)), "{deepest} less {above} bytes");
    }

    #[test]
    fn the_controller_is_built_within_its_stack() {
        let place = singleton!(: MaybeUninit<Controller> = MaybeUninit::uninit()).expect("taken once");
        let config = config(TrackingMode::Observer, 4, SAMPLES);
        stack::paint();
        let above = stack::deepest_bytes();
        Controller::build_in(place, &config).expect("a valid configuration");
        let taken = stack::deepest_bytes() - above;
        println!("{taken} bytes of stack to build it");
        assert!((2000..BUILD_STACK_BYTES).contains(&taken), "{taken} bytes");
    }

    #[test]
    fn settings_are_kept_in_a_flash() {
        let point = TrimPoint { hz: 40e3, lanes: [Trim { phase_turns: 0.01, gain: 0.9 }; 4] };
        let mut settings = Settings::new(Pages::new()).expect("room");
        assert_eq!(settings.record(), (Record::default(), StoredState::Nothing));
        for number in 0..60 {
            let trims = [TrimPoint { hz: 40e3 + number as f32, ..point }].into_iter().collect();
            let record = Record { trims, ..Record::default() };
            assert_eq!(settings.store(&record), Ok(()));
            // As after a reset.
            settings = Settings::new(settings.release()).expect("room");
            assert_eq!(settings.record(), (record, StoredState::Stored), "write {number}");
        }
        assert_eq!(settings.clear(), Ok(()));
        assert_eq!(settings.record(), (Record::default(), StoredState::Nothing));
    }

    #[test]
    fn the_link_returns_intact_frames_and_refuses_damaged_ones() {
        let mut receiver = Receiver::default();
        let mut sent = link::encode(300, 7, Command::TelemetryEvery(7)).expect("it fits");
        let mut take = |bytes: &[u8]| bytes.iter().filter_map(|&byte| receiver.take::<Command>(byte)).last();
        let frame = Frame { version: link::VERSION, sequence: 300, session: 7, body: Command::TelemetryEvery(7) };
        assert_eq!(take(&sent), Some(Ok(frame)));
        sent[2] ^= 0x10;
        assert_eq!(take(&sent), Some(Err(FrameError::Damaged)));
        let mut receiver = Receiver::default();
        let sent = link::encode(9, 7, Reply::Ack).expect("it fits");
        let reply = sent.iter().filter_map(|&byte| receiver.take::<Reply>(byte)).last();
        assert!(matches!(reply, Some(Ok(Frame { body: Reply::Ack, .. }))));
    }

    #[test]
    fn a_fault_mutes() {
        let mut controller = controller();
        let silence = controller.silence();
        let (mut playing, mut sense) = ([silence.clone(), silence.clone()], SenseBlock::default());
        let mut transducer = Transducer::new();
        let run = Orders { sequence: 1, attempt: 1, request: Request::Run, ..Orders::default() };
        let stop = Orders { sequence: 2, emergency_stop: true, ..run };
        let mut sounded = false;
        for block in 0..BLOCKS {
            let drive = &mut playing[block as usize % 2];
            transducer.exchange(drive, &mut sense);
            let report = controller.process(if block < BLOCKS - 100 { &run } else { &stop }, &sense, drive);
            sounded |= report.mode == Mode::Run && *drive != silence;
            if block >= BLOCKS - 100 {
                assert_eq!((report.fault, &drive.lanes), (Some(Fault::EmergencyStop), &silence.lanes), "block {block}");
                assert_eq!(drive.drops_queue, block == BLOCKS - 100, "block {block}");
            }
        }
        assert!(sounded);
    }

    #[test]
    #[should_panic]
    fn a_panic_is_seen() {
        let codes = Codes::new();
        // Past the end.
        assert_eq!(codes[core::hint::black_box(1)], 0);
    }

    #[test]
    #[cfg(feature = "hil")]
    fn the_amplifier_is_off_after_a_reset() {
        super::board::the_amplifier_is_off();
    }

    #[test]
    #[cfg(feature = "hil")]
    fn the_emergency_stop_is_wired_and_released() {
        super::board::the_emergency_stop_is_released();
    }

    #[test]
    #[cfg(feature = "hil")]
    fn the_flash_has_two_banks() {
        super::board::the_flash_has_two_banks();
    }

    #[test]
    #[cfg(feature = "hil")]
    fn the_core_coupled_ram_keeps_what_is_written() {
        super::board::the_core_coupled_ram_keeps_what_is_written();
    }
}
