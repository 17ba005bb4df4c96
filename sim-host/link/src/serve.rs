//! `serve`: a board in this process at a TCP port, in real time, for successive clients.
//!
//! One client holds the board at a time. Other clients wait for a moment, in case the holder
//! leaves, and are then sent the address of the holder. The board runs with or without a client, as
//! a real one does. Bytes that no client takes are lost, so that nothing grows, and the next client
//! does not wait for those of the last one.
//!
//! A holder that has sent nothing for the idle limit loses the board. A client that announces an
//! order to stop ([`Client::announce_stop`](crate::client::Client::announce_stop)) takes the board
//! from its holder, so that every client can stop the drive.

use std::io::{self, Read, Write};
use std::net::{Shutdown, TcpListener, TcpStream};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use firmware::board::command::Command;
use firmware::board::link::{Frame, MAX_FRAME, Receiver};

use crate::port::{HELD_MESSAGE, InProcess};

/// Pause between two turns.
const TURN_PAUSE: Duration = Duration::from_micros(500);
/// Maximum time for the blocks of a turn.
const MAX_TURN: Duration = Duration::from_millis(10);
/// Maximum number of reads per turn.
const MAX_READS: usize = 16;
/// Maximum number of bytes on the wire to the board, which the next client waits for: 11 ms at the
/// speed of the line. Further bytes are lost. A client sends one frame at a time.
const MAX_WIRE_BYTES: usize = 4 * MAX_FRAME;
/// Time that a client waits for the holder to leave. In this time the last bytes of a program that
/// has ended are read.
const HOLDER_WAIT: Duration = Duration::from_millis(500);
/// Time for which a refused connection stays open, so that the client can read the address of the
/// holder.
const REFUSED_WAIT: Duration = Duration::from_millis(1500);
/// Maximum number of waiting clients; more remain in the backlog of the operating system.
const MAX_WAITING: usize = 16;
/// Delay of the board relative to real time after which it no longer catches up.
const MAX_DELAY: Duration = Duration::from_millis(200);

/// Serves the board until `stop` is set. A client that has sent nothing for `idle_limit` loses the
/// board; zero means no limit.
///
/// `note` is called when a client connects or leaves, when no client can be accepted, and when the
/// machine is too slow.
pub fn serve(
    board: &mut impl InProcess,
    listener: &TcpListener,
    stop: &AtomicBool,
    idle_limit: Duration,
    note: fn(&str),
) -> io::Result<()> {
    listener.set_nonblocking(true)?;
    let mut client: Option<Client> = None;
    let mut queue = ClientQueue::default();
    let (mut began, mut slow) = (Instant::now(), false);
    while !stop.load(Ordering::Relaxed) {
        queue.accept(listener, note);
        if let Some(holder) = &mut client {
            if !exchange(board, holder) {
                note("the client has disconnected");
                client = None;
            } else if !idle_limit.is_zero() && holder.last_activity.elapsed() > idle_limit {
                note(&format!("the client has sent nothing for {} s and loses the board", idle_limit.as_secs_f64()));
                client = None;
            } else if let Some(next) = queue.take(announces_stop) {
                note(&format!("a client at {} orders the drive to stop and takes the board", address(&next.stream)));
                client = Some(next);
            }
        }
        match &client {
            Some(holder) => queue.refuse(&holder.stream),
            None => {
                while board.receive(&mut [0; 1024]) > 0 {}
                client = queue.take(|_| true);
                client.iter().for_each(|client| note(&format!("a client has connected from {}", address(&client.stream))));
            }
        }
        if board.is_held()? {
            // A debugger has stopped the board's time, which is not caught up afterwards.
            began = Instant::now().checked_sub(board.now()).unwrap_or(began);
            std::thread::sleep(TURN_PAUSE);
            continue;
        }
        let due = began.elapsed();
        if due > board.now() + MAX_DELAY {
            began += due - board.now();
            if !std::mem::replace(&mut slow, true) {
                note("this machine is slower than the board: simulated time lags behind real time");
            }
        }
        // The length of a turn is limited, so that a late board still answers its client.
        let turn = Instant::now();
        while board.now() < due.min(began.elapsed()) && turn.elapsed() < MAX_TURN && !board.is_held()? {
            board.block()?;
        }
        std::thread::sleep(TURN_PAUSE);
    }
    Ok(())
}

/// Connection to a client.
struct Client {
    stream: TcpStream,
    /// Time of the connection, or of the last byte sent to the board.
    last_activity: Instant,
    /// `true` once the client was sent the address of the holder.
    refused: bool,
}

/// Queue of waiting clients.
#[derive(Default)]
struct ClientQueue {
    /// Waiting clients in the order of their arrival.
    waiting: Vec<Client>,
    /// `true` while `accept` fails and this was reported.
    failing: bool,
}

impl ClientQueue {
    /// Accepts clients, and closes the connections of those that were refused.
    ///
    /// A failure, such as too few file descriptors, is reported once, and the next turn tries
    /// again.
    fn accept(&mut self, listener: &TcpListener, note: fn(&str)) {
        self.waiting.retain(|client| !client.refused || client.last_activity.elapsed() < REFUSED_WAIT);
        // Refused clients do not count, so that a `stop` can still enter.
        while self.waiting.iter().filter(|client| !client.refused).count() < MAX_WAITING {
            match accepted(listener) {
                Ok(Some(stream)) => self.waiting.push(Client { stream, last_activity: Instant::now(), refused: false }),
                Ok(None) => return self.failing = false,
                Err(_) if self.failing => return,
                Err(error) => {
                    self.failing = true;
                    return note(&format!("cannot accept a client: {error}"));
                }
            }
        }
    }

    /// Takes the client that has waited longest, of those that fit.
    fn take(&mut self, fits: impl Fn(&TcpStream) -> bool) -> Option<Client> {
        let place = self.waiting.iter().position(|client| !client.refused && fits(&client.stream))?;
        Some(self.waiting.remove(place))
    }

    /// Sends the address of the holder to the clients that have waited long enough.
    fn refuse(&mut self, holder: &TcpStream) {
        for client in self.waiting.iter_mut().filter(|client| !client.refused && client.last_activity.elapsed() > HOLDER_WAIT) {
            // Sent in one piece; an error means that the client has left.
            let said = format!("{HELD_MESSAGE}{}\n", address(holder));
            let _ = client.stream.write_all(said.as_bytes()).and_then(|()| client.stream.shutdown(Shutdown::Write));
            client.refused = true;
        }
    }
}

fn accepted(listener: &TcpListener) -> io::Result<Option<TcpStream>> {
    match listener.accept() {
        Ok((stream, _)) => {
            stream.set_nonblocking(true)?;
            stream.set_nodelay(true)?;
            Ok(Some(stream))
        }
        Err(error) if error.kind() == io::ErrorKind::WouldBlock => Ok(None),
        Err(error) => Err(error),
    }
}

/// Returns `true` if the first bytes of a client contain an order to stop. The bytes remain for the
/// board.
fn announces_stop(stream: &TcpStream) -> bool {
    let (mut bytes, mut receiver) = ([0; MAX_FRAME], Receiver::default());
    let count = stream.peek(&mut bytes).unwrap_or(0);
    bytes[..count].iter().any(|&byte| matches!(receiver.take(byte), Some(Ok(Frame { body: Command::Idle, .. }))))
}

/// Returns the address of a client.
fn address(stream: &TcpStream) -> String {
    stream.peer_addr().map_or_else(|_| "an unknown address".into(), |address| address.to_string())
}

/// Transfers bytes in both directions. Returns `false` if the client has disconnected.
fn exchange(board: &mut impl InProcess, client: &mut Client) -> bool {
    let (mut bytes, mut sent) = ([0; 1024], true);
    while let count @ 1.. = board.receive(&mut bytes) {
        // Bytes that do not fit into a full socket are lost, as on a wire without a receiver.
        sent &= waits(client.stream.write_all(&bytes[..count])).is_some();
    }
    // The number of reads is limited, so that the next block is not late. Bytes that exceed the
    // capacity of the wire are lost; a large read finds the end of a client behind them sooner.
    let mut bytes = [0; 1 << 16];
    for _ in 0..MAX_READS {
        match waits(client.stream.read(&mut bytes)) {
            Some(Some(0)) | None => return false,
            Some(Some(count)) => {
                client.last_activity = Instant::now();
                let room = MAX_WIRE_BYTES.saturating_sub(board.waiting());
                board.send(&bytes[..count.min(room)]);
            }
            Some(None) => break,
        }
    }
    sent
}

/// Returns the result of a read or write: `Some(None)` if no byte can be transferred now, `None` if
/// the connection has ended.
fn waits<T>(done: io::Result<T>) -> Option<Option<T>> {
    match done {
        Ok(value) => Some(Some(value)),
        Err(error) if matches!(error.kind(), io::ErrorKind::WouldBlock | io::ErrorKind::Interrupted) => Some(None),
        Err(_) => None,
    }
}

#[cfg(test)]
mod tests {
    use std::collections::VecDeque;
    use std::io::BufReader;
    use std::net::SocketAddr;

    use super::*;

    /// Number of bytes that the wire of the board transfers per block of 1 ms.
    const WIRE_BYTES: usize = 92;

    /// Board that echoes its input after the byte 0 of each block.
    #[derive(Default)]
    struct EchoBoard {
        wire: VecDeque<u8>,
        echo: VecDeque<u8>,
        now: Duration,
        /// Time that a block takes.
        block_time: Duration,
    }

    impl InProcess for EchoBoard {
        fn send(&mut self, bytes: &[u8]) {
            self.wire.extend(bytes);
        }

        fn waiting(&self) -> usize {
            self.wire.len()
        }

        fn receive(&mut self, into: &mut [u8]) -> usize {
            let count = into.len().min(self.echo.len());
            into.iter_mut().zip(self.echo.drain(..count)).for_each(|(into, byte)| *into = byte);
            count
        }

        fn now(&self) -> Duration {
            self.now
        }

        fn block(&mut self) -> io::Result<()> {
            std::thread::sleep(self.block_time);
            self.now += Duration::from_millis(1);
            self.echo.push_back(0);
            self.echo.extend(self.wire.drain(..WIRE_BYTES.min(self.wire.len())));
            Ok(())
        }
    }

    /// Serves a board while `act` runs with its address.
    fn served<T>(block_time: Duration, act: impl FnOnce(SocketAddr) -> T) -> T {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let stop = AtomicBool::new(false);
        let mut board = EchoBoard { block_time, ..Default::default() };
        std::thread::scope(|scope| {
            let serving = scope.spawn(|| serve(&mut board, &listener, &stop, Duration::ZERO, |_| ()).unwrap());
            let done = act(listener.local_addr().unwrap());
            stop.store(true, Ordering::Relaxed);
            serving.join().unwrap();
            done
        })
    }

    /// Sends a byte and waits for its echo. Returns the duration, and the number of other bytes.
    fn echoed(client: &mut TcpStream) -> (Duration, usize) {
        let began = Instant::now();
        client.write_all(b"x").unwrap();
        let others = BufReader::new(client).bytes().take_while(|byte| *byte.as_ref().unwrap() != b'x').count();
        (began.elapsed(), others)
    }

    #[test]
    fn a_board_slower_than_real_time_still_answers() {
        let waits = served(Duration::from_millis(5), |address| {
            let mut client = TcpStream::connect(address).unwrap();
            // Until the board is late by more than the limit.
            std::thread::sleep(2 * MAX_DELAY);
            (0..5).map(|_| echoed(&mut client).0).collect::<Vec<_>>()
        });
        // If turns were not limited, they would become longer and longer.
        assert!(waits.iter().all(|wait| *wait < Duration::from_millis(500)), "{waits:?}");
    }

    #[test]
    fn a_flood_of_one_client_does_not_delay_the_next() {
        let (wait, others) = served(Duration::ZERO, |address| {
            let mut flood = TcpStream::connect(address).unwrap();
            // The echoes are not read.
            (0..100).for_each(|_| flood.write_all(&[1; 20_000]).unwrap());
            drop(flood);
            // The board sends bytes that no client takes.
            std::thread::sleep(Duration::from_secs(1));
            echoed(&mut TcpStream::connect(address).unwrap())
        });
        assert!(wait < Duration::from_millis(500) && others < 500, "{wait:?} {others}");
    }
}
