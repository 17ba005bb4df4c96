//! Debugger's end of GDB's remote serial protocol. It runs the board while it waits.

use std::io::{ErrorKind, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::time::{Duration, Instant};

use board::configure::load;
use board::debugger::Debugged;
use board::{Board, Options};

/// Longest time for an answer.
const ANSWERS_WITHIN: Duration = Duration::from_secs(20);
/// Number of the program counter.
pub const PC: usize = 15;
/// Number of xPSR.
pub const XPSR: usize = 16;

/// Returns the image, or `None` after a message if it cannot be built.
pub fn elf() -> Option<Vec<u8>> {
    if let Some(reason) = pil::missing_to_build() {
        // Directly to the stream: output of a passing test by a macro is not shown.
        let text = format!("\nSKIPPED, debugger at the flashed image on a model of its microcontroller: {reason}\n");
        std::io::stderr().write_all(text.as_bytes()).expect("standard error");
        return None;
    }
    Some(std::fs::read(pil::board_image().expect("the image builds")).expect("the image is readable"))
}

/// Returns a board with the dummy load, just after power-on.
pub fn board(elf: &[u8], record: bool) -> Board {
    let loaded = load("dummy-load", &[]).expect("a built-in scene");
    let scene = loaded.scene.driven().expect("a driven scene");
    Board::start(elf, &scene, Options { record, ..Options::default() }).expect("the board starts")
}

/// Gives the board a port for a debugger.
pub fn debugged(board: Board) -> Debugged {
    let listener = TcpListener::bind("127.0.0.1:0").expect("a free port");
    Debugged::new(board, listener, |_| ()).expect("a port")
}

/// Connected debugger. While it waits, it polls the board, which runs unless it is halted.
pub struct Gdb {
    stream: TcpStream,
    received: Vec<u8>,
}

impl Gdb {
    /// Connects and waits until the board is halted.
    pub fn connect(board: &mut Debugged) -> Gdb {
        let stream = TcpStream::connect(board.address().expect("an address")).expect("a listener");
        stream.set_nonblocking(true).expect("a socket");
        let gdb = Gdb { stream, received: Vec::new() };
        let until = Instant::now() + ANSWERS_WITHIN;
        while !board.is_held() {
            board.attend().expect("no error");
            assert!(Instant::now() < until, "the board does not accept the connection");
        }
        gdb
    }

    /// Sends raw bytes.
    pub fn send_raw(&mut self, bytes: &[u8]) {
        self.stream.write_all(bytes).expect("the other end is open");
    }

    /// Sends a packet.
    pub fn send(&mut self, packet: &str) {
        self.send_raw(&framed(packet, 0));
    }

    /// Receives the next packet from the board. Returns `None` after the board has closed the
    /// connection.
    pub fn receive(&mut self, board: &mut Debugged) -> Option<String> {
        let until = Instant::now() + ANSWERS_WITHIN;
        loop {
            if let Some(packet) = self.packet() {
                self.send_raw(b"+");
                return Some(packet);
            }
            assert!(Instant::now() < until, "no answer");
            board.attend().expect("no error");
            board.run_block().expect("no finding without a debugger");
            let mut bytes = [0; 4096];
            match self.stream.read(&mut bytes) {
                Ok(0) => return None,
                Ok(count) => self.received.extend(&bytes[..count]),
                Err(error) if error.kind() == ErrorKind::WouldBlock => {}
                Err(error) if error.kind() == ErrorKind::ConnectionReset => return None,
                Err(error) => panic!("{error}"),
            }
        }
    }

    /// Sends a packet and returns the answer.
    pub fn ask(&mut self, board: &mut Debugged, packet: &str) -> String {
        self.send(packet);
        self.receive(board).expect("an answer")
    }

    /// Sends a `monitor` command and returns its output.
    pub fn monitor(&mut self, board: &mut Debugged, command: &str) -> String {
        let mut text = self.ask(board, &format!("qRcmd,{}", hex(command.as_bytes())));
        let mut printed = String::new();
        while let Some(part) = text.strip_prefix('O').filter(|part| *part != "K") {
            printed += &String::from_utf8(bytes(part)).expect("text");
            text = self.receive(board).expect("an answer");
        }
        assert_eq!(text, "OK");
        printed
    }

    /// Returns all registers: R0 to R15, xPSR, two words for each of D0 to D15, FPSCR.
    pub fn registers(&mut self, board: &mut Debugged) -> Vec<u32> {
        let answer = bytes(&self.ask(board, "g"));
        answer.chunks_exact(4).map(|word| u32::from_le_bytes(word.try_into().expect("four bytes"))).collect()
    }

    /// Sets all registers.
    pub fn set_registers(&mut self, board: &mut Debugged, registers: &[u32]) {
        let all: Vec<u8> = registers.iter().flat_map(|word| word.to_le_bytes()).collect();
        assert_eq!(self.ask(board, &format!("G{}", hex(&all))), "OK");
    }

    /// Returns the next complete packet and checks its checksum.
    fn packet(&mut self) -> Option<String> {
        let start = self.received.iter().position(|byte| *byte == b'$')?;
        let end = start + self.received[start..].iter().position(|byte| *byte == b'#')?;
        if self.received.len() < end + 3 {
            return None;
        }
        let packet = String::from_utf8(self.received[start + 1..end].to_vec()).expect("text");
        assert_eq!(self.received[start..end + 3], framed(&packet, 0), "the checksum of the packet");
        self.received.drain(..end + 3);
        Some(unpacked(&packet))
    }
}

/// Encodes a packet for the wire. `damage` changes its checksum.
pub fn framed(packet: &str, damage: u8) -> Vec<u8> {
    let sum = packet.bytes().fold(damage, u8::wrapping_add);
    format!("${packet}#{sum:02x}").into_bytes()
}

/// Expands run lengths: `x*c` is `x`, followed by (code of `c` - 29) more `x`.
fn unpacked(packet: &str) -> String {
    let mut text = String::new();
    let mut characters = packet.chars();
    while let Some(character) = characters.next() {
        match (character, text.chars().last()) {
            ('*', Some(last)) => {
                let more = characters.next().expect("a length") as usize - 29;
                text.extend(std::iter::repeat_n(last, more));
            }
            _ => text.push(character),
        }
    }
    text
}

pub fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

pub fn bytes(hex: &str) -> Vec<u8> {
    let digits: Vec<char> = hex.chars().collect();
    digits.chunks(2).map(|pair| u8::from_str_radix(&pair.iter().collect::<String>(), 16).expect("hexadecimal")).collect()
}
