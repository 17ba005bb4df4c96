//! The debugger's end of GDB's remote serial protocol, and the board that it is pumped with.

use std::io::{ErrorKind, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::time::{Duration, Instant};

use board::configure::load;
use board::debugger::Debugged;
use board::{Board, Options};

/// How long an answer may take.
const ANSWER: Duration = Duration::from_secs(20);
/// Registers by number: program counter, xPSR.
pub const PC: usize = 15;
pub const XPSR: usize = 16;

/// The image; none where it cannot be built, which has then been said.
pub fn elf() -> Option<Vec<u8>> {
    if let Some(reason) = pil::missing_to_build() {
        // Straight to the stream: what a passing test prints by macro is never shown.
        let text = format!("\nSKIPPED, a debugger at the flashed image on a model of its part: {reason}\n");
        std::io::stderr().write_all(text.as_bytes()).expect("standard error");
        return None;
    }
    Some(std::fs::read(pil::board_image().expect("the image builds")).expect("it can be read"))
}

/// A board with the dummy load that was just powered.
pub fn board(elf: &[u8], record: bool) -> Board {
    let loaded = load("dummy-load", &[]).expect("a built-in scene");
    let scene = loaded.scene.driven().expect("a driven scene");
    Board::start(elf, &scene, Options { record, ..Options::default() }).expect("it starts")
}

/// The board with a port for a debugger.
pub fn debugged(board: Board) -> Debugged {
    let listener = TcpListener::bind("127.0.0.1:0").expect("a free port");
    Debugged::new(board, listener, |_| ()).expect("a port")
}

/// A debugger that is connected. Between its bytes the board looks after it, and runs unless it is held.
pub struct Gdb {
    stream: TcpStream,
    received: Vec<u8>,
}

impl Gdb {
    /// Connects, and waits until the board is held.
    pub fn connect(board: &mut Debugged) -> Gdb {
        let stream = TcpStream::connect(board.address().expect("an address")).expect("a listener");
        stream.set_nonblocking(true).expect("a socket");
        let gdb = Gdb { stream, received: Vec::new() };
        let until = Instant::now() + ANSWER;
        while !board.is_held() {
            board.attend().expect("no error");
            assert!(Instant::now() < until, "nobody accepts");
        }
        gdb
    }

    /// Sends these bytes as they are.
    pub fn send_raw(&mut self, bytes: &[u8]) {
        self.stream.write_all(bytes).expect("the other end is there");
    }

    /// Sends a packet.
    pub fn send(&mut self, packet: &str) {
        self.send_raw(&framed(packet, 0));
    }

    /// The next packet from the board; none once it has closed the connection.
    pub fn receive(&mut self, board: &mut Debugged) -> Option<String> {
        let until = Instant::now() + ANSWER;
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

    /// A `monitor` command: what it prints.
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

    /// All registers: R0 to R15, xPSR, two words for each of D0 to D15, FPSCR.
    pub fn registers(&mut self, board: &mut Debugged) -> Vec<u32> {
        let answer = bytes(&self.ask(board, "g"));
        answer.chunks_exact(4).map(|word| u32::from_le_bytes(word.try_into().expect("four bytes"))).collect()
    }

    /// Sets all registers.
    pub fn set_registers(&mut self, board: &mut Debugged, registers: &[u32]) {
        let all: Vec<u8> = registers.iter().flat_map(|word| word.to_le_bytes()).collect();
        assert_eq!(self.ask(board, &format!("G{}", hex(&all))), "OK");
    }

    /// A packet that has come as a whole, with its sum checked.
    fn packet(&mut self) -> Option<String> {
        let start = self.received.iter().position(|byte| *byte == b'$')?;
        let end = start + self.received[start..].iter().position(|byte| *byte == b'#')?;
        if self.received.len() < end + 3 {
            return None;
        }
        let packet = String::from_utf8(self.received[start + 1..end].to_vec()).expect("text");
        assert_eq!(self.received[start..end + 3], framed(&packet, 0), "its sum");
        self.received.drain(..end + 3);
        Some(unpacked(&packet))
    }
}

/// A packet on the wire. `damage` changes its sum.
pub fn framed(packet: &str, damage: u8) -> Vec<u8> {
    let sum = packet.bytes().fold(damage, u8::wrapping_add);
    format!("${packet}#{sum:02x}").into_bytes()
}

/// Without run lengths: `x*c` is x and then as many more as c is beyond 29.
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
