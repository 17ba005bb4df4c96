//! Requests of a debugger, and their answers.

use std::time::{Duration, Instant};

use board::debugger::Debugged;

use super::gdb::{Gdb, PC, XPSR, board, bytes, debugged, elf, framed, hex};

/// Exception number of the block interrupt: DMA1 channel 1.
const BLOCK_INTERRUPT: u32 = 16 + 11;
const INTERRUPT: &str = "DMA1_CHANNEL1";
/// Free address in RAM, for instructions.
const FREE_ADDRESS: u32 = 0x2001_0000;
/// Number of SIGTRAP, as in `T05` or `S05`.
const SIGTRAP: &str = "05";
/// Number of SIGINT.
const SIGINT: &str = "02";
/// Number of SIGABRT.
const SIGABRT: &str = "06";

/// Returns a board that has run for 25 ms, so that it serves blocks, and a debugger that has halted
/// it.
fn halted_board() -> Option<(Debugged, Gdb)> {
    let mut board = debugged(board(&elf()?, false));
    run(&mut board, Duration::from_millis(25));
    let gdb = Gdb::connect(&mut board);
    Some((board, gdb))
}

fn address(board: &Debugged, name: &str) -> u32 {
    board.board().machine().symbols().address(name).unwrap_or_else(|| panic!("the image has {name}"))
}

/// Returns the signal of a stop reply.
fn signal(reply: &str) -> &str {
    assert!(reply.starts_with(['T', 'S']), "{reply}");
    &reply[1..3]
}

/// Runs for a time of the board, after the debugger lets it run.
fn run(board: &mut Debugged, time: Duration) {
    let (until, deadline) = (board.board().now() + time, Instant::now() + Duration::from_secs(20));
    while board.board().now() < until {
        board.attend().expect("no error");
        board.run_block().expect("no finding");
        assert!(Instant::now() < deadline, "the board does not run");
    }
}

/// Checks that the board runs without a debugger.
fn runs_on(board: &mut Debugged) {
    run(board, Duration::from_millis(3));
    assert!(!board.is_held());
    assert_eq!(board.board().was_reset(), None);
}

#[test]
fn registers_and_memories_are_read_and_peripherals_are_not() {
    let Some((mut board, mut gdb)) = halted_board() else { return };
    let held_at = board.board().now();
    let supported = gdb.ask(&mut board, "qSupported:multiprocess+;swbreak+;hwbreak+;vContSupported+");
    assert!(supported.contains("PacketSize=") && supported.contains("qXfer:features:read+"), "{supported}");
    let description = gdb.ask(&mut board, "qXfer:features:read:target.xml:0,ff0");
    assert!(description.contains("org.gnu.gdb.arm.m-profile") && description.contains("org.gnu.gdb.arm.vfp"));
    assert_eq!(signal(&gdb.ask(&mut board, "?")), SIGTRAP);

    let registers = gdb.registers(&mut board);
    assert_eq!(registers.len(), 17 + 32 + 1);
    let machine = board.board().machine();
    let own: Vec<u32> = (0..16).map(|number| machine.register(number)).collect();
    assert_eq!(registers[..16], own);
    assert_eq!((registers[XPSR], registers[49]), (machine.xpsr(), machine.fpscr()));
    assert_eq!(registers[17 + 5], machine.float_register(5));

    let log = address(&board, "_SEGGER_RTT");
    assert_eq!(bytes(&gdb.ask(&mut board, &format!("m{log:x},a"))), b"SEGGER RTT");
    let stack = address(&board, "_stack_start");
    assert_eq!(bytes(&gdb.ask(&mut board, "m8000000,4")), stack.to_le_bytes());
    // FPCCR, which GDB reads to unwind an exception frame: lazy stacking is on.
    assert_eq!(bytes(&gdb.ask(&mut board, "me000ef34,4"))[3], 0xC0);
    // DMA1, the factory's words, SysTick's control register, and an address without memory.
    for refused in ["m40020000,4", "m1fff75a8,4", "me000e010,4", "m60000000,4"] {
        assert!(gdb.ask(&mut board, refused).starts_with('E'), "{refused}");
    }
    assert_eq!(gdb.ask(&mut board, &format!("M{FREE_ADDRESS:x},4:01020304")), "OK");
    assert_eq!(gdb.ask(&mut board, &format!("m{FREE_ADDRESS:x},4")), "01020304");
    for refused in ["M8000000,4:01020304", "M40020000,4:01020304", "M20017fff,4:01020304"] {
        assert!(gdb.ask(&mut board, refused).starts_with('E'), "{refused}");
    }
    assert_eq!(bytes(&gdb.ask(&mut board, "m8000000,4")), stack.to_le_bytes());
    assert_eq!(gdb.ask(&mut board, "vNoSuchPacket"), "");
    assert_eq!(board.board().now(), held_at, "the time of the board must not advance");
}

#[test]
fn the_block_interrupt_is_found_by_a_breakpoint_and_stepped() {
    let Some((mut board, mut gdb)) = halted_board() else { return };
    let handler = address(&board, INTERRUPT);
    assert_eq!(gdb.ask(&mut board, &format!("Z0,{handler:x},2")), "OK");
    // Twice: the second run must start from the breakpoint at which the board is halted.
    let mut halted_at = None;
    for _ in 0..2 {
        let reply = gdb.ask(&mut board, "c");
        assert_eq!(signal(&reply), SIGTRAP, "{reply}");
        let registers = gdb.registers(&mut board);
        assert_eq!((registers[PC], registers[XPSR] & 0x1FF), (handler, BLOCK_INTERRUPT));
        let executed = board.board().machine().instructions();
        assert_ne!(halted_at.replace(executed), Some(executed), "the board must have run");
    }
    assert_eq!(signal(&gdb.ask(&mut board, "s")), SIGTRAP);
    let pc = gdb.registers(&mut board)[PC];
    assert!(pc == handler + 2 || pc == handler + 4, "{pc:#x} after {handler:#x}");
    assert_eq!(gdb.ask(&mut board, &format!("z0,{handler:x},2")), "OK");
    // Without the breakpoint, only Ctrl-C ends the run.
    gdb.send("c");
    run(&mut board, Duration::from_millis(2));
    gdb.send_raw(&[3]);
    assert_eq!(signal(&gdb.receive(&mut board).expect("an answer")), SIGINT);
    assert!(board.is_held());
}

#[test]
fn a_reset_halts_at_the_first_instruction() {
    let Some((mut board, mut gdb)) = halted_board() else { return };
    assert!(gdb.monitor(&mut board, "help").contains("monitor reset"));
    assert!(gdb.monitor(&mut board, "halt").contains("halted"));
    assert!(gdb.monitor(&mut board, "reset halt").contains("reset"));
    let registers = gdb.registers(&mut board);
    assert_eq!((registers[PC], registers[13]), (address(&board, "Reset") & !1, address(&board, "_stack_start")));
    let main = address(&board, "main") & !1;
    assert_eq!(gdb.ask(&mut board, &format!("Z1,{main:x},2")), "OK");
    assert_eq!(signal(&gdb.ask(&mut board, "c")), SIGTRAP);
    assert_eq!(gdb.registers(&mut board)[PC], main);
    assert_eq!(gdb.ask(&mut board, "D"), "OK");
    let resets = board.board().bench().resets.len();
    run(&mut board, Duration::from_millis(30));
    assert!(!board.is_held());
    assert_eq!((resets, board.board().bench().resets.len()), (1, 1), "only the reset of the debugger");
}

#[test]
fn the_board_runs_after_a_failed_connection() {
    let Some((mut board, mut gdb)) = halted_board() else { return };
    let handler = address(&board, INTERRUPT);
    assert_eq!(gdb.ask(&mut board, &format!("Z0,{handler:x},2")), "OK");
    drop(gdb);
    // Its breakpoint is removed with the connection.
    runs_on(&mut board);

    let mut gdb = Gdb::connect(&mut board);
    gdb.send_raw(&framed("g", 1));
    assert_eq!(gdb.receive(&mut board), None, "a packet with a wrong checksum ends the session");
    runs_on(&mut board);

    let mut gdb = Gdb::connect(&mut board);
    gdb.send_raw(b"$m8000000");
    drop(gdb);
    runs_on(&mut board);

    let mut gdb = Gdb::connect(&mut board);
    assert_eq!(signal(&gdb.ask(&mut board, "?")), SIGTRAP);
    board.release().expect("no finding");
    runs_on(&mut board);
    assert_eq!(gdb.receive(&mut board), None);
}

#[test]
fn findings_and_breakpoint_instructions_halt_before_they_execute() {
    let Some((mut board, mut gdb)) = halted_board() else { return };
    // LDR R0, [R0]; BKPT #1; NOP; B to itself
    let code: Vec<u8> = [0x6800u16, 0xBE01, 0xBF00, 0xE7FE].iter().flat_map(|half| half.to_le_bytes()).collect();
    assert_eq!(gdb.ask(&mut board, &format!("M{FREE_ADDRESS:x},8:{}", hex(&code))), "OK");
    let mut registers = gdb.registers(&mut board);
    // The address of a trace unit, which the model lacks.
    (registers[0], registers[PC]) = (0xE000_0000, FREE_ADDRESS);
    gdb.set_registers(&mut board, &registers);
    for order in ["s", "c", "c"] {
        assert_eq!(signal(&gdb.ask(&mut board, order)), SIGABRT, "{order}");
        assert_eq!(gdb.registers(&mut board)[PC], FREE_ADDRESS);
    }
    // After it, the run reaches the breakpoint instruction. A step and a run both skip that one.
    registers[PC] = FREE_ADDRESS + 2;
    for order in ["s", "c"] {
        gdb.set_registers(&mut board, &registers);
        assert_eq!(signal(&gdb.ask(&mut board, "c")), SIGTRAP);
        assert_eq!(gdb.registers(&mut board)[PC], FREE_ADDRESS + 2);
        assert_eq!(gdb.ask(&mut board, &format!("Z0,{:x},2", FREE_ADDRESS + 6)), "OK");
        assert_eq!(signal(&gdb.ask(&mut board, order)), SIGTRAP);
        let expected = if order == "s" { FREE_ADDRESS + 4 } else { FREE_ADDRESS + 6 };
        assert_eq!(gdb.registers(&mut board)[PC], expected);
    }
}

#[test]
fn ctrl_c_at_a_halted_board_answers_the_next_order() {
    let Some((mut board, mut gdb)) = halted_board() else { return };
    let held_at = board.board().now();
    gdb.send_raw(&[3]);
    assert_eq!(signal(&gdb.ask(&mut board, "c")), SIGINT);
    assert!(board.is_held());
    assert_eq!(board.board().now(), held_at);
    assert_eq!(gdb.registers(&mut board).len(), 50);
}
