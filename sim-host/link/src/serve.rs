//! `serve`: a board in this process at a TCP port, in real time, for clients that come and go.
//!
//! One client holds the board at a time. The others wait for a moment, in which the holder may go, and are then told who holds the board. The board runs on
//! with or without a client, as a real one does.
//!
//! A holder that has sent nothing for the idle limit loses the board. A client that announces an order to stop
//! ([`Client::announce_stop`](crate::client::Client::announce_stop)) takes the board from its holder: silence can always be ordered.

use std::io::{self, Read, Write};
use std::net::{Shutdown, TcpListener, TcpStream};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use firmware::board::command::Command;
use firmware::board::link::{Frame, MAX_FRAME, Receiver};

use crate::port::{HELD, InProcess};

/// Pause between two turns.
const TURN: Duration = Duration::from_micros(500);
/// How long a turn may take.
const LONGEST: Duration = Duration::from_millis(10);
/// Reads of a turn at most.
const READS: usize = 16;
/// Bytes that may be on the wire to the board before more are lost: many times the longest frame.
const ROOM: usize = 4096;
/// Time that a client waits for the holder to go: bytes that a program has sent as it ended are read first.
const HELD_AFTER: Duration = Duration::from_millis(500);
/// Time that the connection of such a client stays open, so that it can read who holds the board.
const AWAY_AFTER: Duration = Duration::from_millis(1500);
/// Most clients that wait at a time; more remain in the backlog of the operating system.
const MOST_WAITING: usize = 16;
/// How far the board may fall behind before it gives up catching up.
const BEHIND: Duration = Duration::from_millis(200);

/// Plays until `stop` is set. A client that has sent nothing for `idle_limit` loses the board; zero is never.
///
/// `note` is called when a client comes or goes, when none can be accepted, and when the machine is too slow.
pub fn serve(
    board: &mut impl InProcess,
    listener: &TcpListener,
    stop: &AtomicBool,
    idle_limit: Duration,
    note: fn(&str),
) -> io::Result<()> {
    listener.set_nonblocking(true)?;
    let mut client: Option<Client> = None;
    let mut door = Door::default();
    let (mut began, mut slow) = (Instant::now(), false);
    while !stop.load(Ordering::Relaxed) {
        door.accept(listener, note);
        if let Some(holder) = &mut client {
            if !exchange(board, holder) {
                note("the client has gone");
                client = None;
            } else if !idle_limit.is_zero() && holder.heard.elapsed() > idle_limit {
                note(&format!("the client has sent nothing for {} s and loses the board", idle_limit.as_secs_f64()));
                client = None;
            } else if let Some(next) = door.take(announces_stop) {
                note(&format!("a client from {} orders the drive to stop and takes the board", address(&next.stream)));
                client = Some(next);
            }
        }
        match &client {
            Some(holder) => door.refuse(&holder.stream),
            None => {
                client = door.take(|_| true);
                client.iter().for_each(|client| note(&format!("a client from {}", address(&client.stream))));
            }
        }
        if board.is_held()? {
            // Its time stands, and what a debugger took is not to be caught up with.
            began = Instant::now().checked_sub(board.now()).unwrap_or(began);
            std::thread::sleep(TURN);
            continue;
        }
        let due = began.elapsed();
        if due > board.now() + BEHIND {
            began += due - board.now();
            if !std::mem::replace(&mut slow, true) {
                note("this machine is slower than the board: the board's time passes more slowly");
            }
        }
        // However far the board is behind, its client is not kept waiting.
        let turn = Instant::now();
        while board.now() < due.min(began.elapsed()) && turn.elapsed() < LONGEST && !board.is_held()? {
            board.block()?;
        }
        std::thread::sleep(TURN);
    }
    Ok(())
}

/// A connection to a client.
struct Client {
    stream: TcpStream,
    /// When it came, or when its last byte went to the board.
    heard: Instant,
    /// It was told that another client holds the board.
    told: bool,
}

/// Clients that come in.
#[derive(Default)]
struct Door {
    /// The clients that wait, the first first.
    waiting: Vec<Client>,
    /// `accept` fails, and this was noted.
    failing: bool,
}

impl Door {
    /// Lets clients in, and closes the connections of those that were told who holds the board.
    ///
    /// A failure, such as too few file descriptors, is noted once, and the next turn tries again.
    fn accept(&mut self, listener: &TcpListener, note: fn(&str)) {
        self.waiting.retain(|client| !client.told || client.heard.elapsed() < AWAY_AFTER);
        // Those that were refused do not keep a `stop` out.
        while self.waiting.iter().filter(|client| !client.told).count() < MOST_WAITING {
            match accepted(listener) {
                Ok(Some(stream)) => self.waiting.push(Client { stream, heard: Instant::now(), told: false }),
                Ok(None) => return self.failing = false,
                Err(_) if self.failing => return,
                Err(error) => {
                    self.failing = true;
                    return note(&format!("cannot accept a client: {error}"));
                }
            }
        }
    }

    /// Takes the client that has waited longest of those that fit.
    fn take(&mut self, fits: impl Fn(&TcpStream) -> bool) -> Option<Client> {
        let place = self.waiting.iter().position(|client| !client.told && fits(&client.stream))?;
        Some(self.waiting.remove(place))
    }

    /// Tells the clients that have waited long enough who holds the board.
    fn refuse(&mut self, holder: &TcpStream) {
        for client in self.waiting.iter_mut().filter(|client| !client.told && client.heard.elapsed() > HELD_AFTER) {
            // In one piece; a client that does not read it has gone.
            let said = format!("{HELD}{}\n", address(holder));
            let _ = client.stream.write_all(said.as_bytes()).and_then(|()| client.stream.shutdown(Shutdown::Write));
            client.told = true;
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

/// Returns whether an order to stop is among the first bytes of a client. The bytes are left for the board.
fn announces_stop(stream: &TcpStream) -> bool {
    let (mut bytes, mut receiver) = ([0; MAX_FRAME], Receiver::default());
    let count = stream.peek(&mut bytes).unwrap_or(0);
    bytes[..count].iter().any(|&byte| matches!(receiver.take(byte), Some(Ok(Frame { body: Command::Idle, .. }))))
}

/// Where a client is.
fn address(stream: &TcpStream) -> String {
    stream.peer_addr().map_or_else(|_| "an address that is gone".into(), |address| address.to_string())
}

/// Carries bytes both ways. False: the client has gone.
fn exchange(board: &mut impl InProcess, client: &mut Client) -> bool {
    let mut bytes = [0; 1024];
    let count = board.receive(&mut bytes);
    // What a full socket does not take is lost, as on a wire without a receiver.
    let sent = count == 0 || waits(client.stream.write_all(&bytes[..count])).is_some();
    // However much a client sends, it does not keep the board from its next block; what is beyond the wire's room is lost.
    for _ in 0..READS {
        match waits(client.stream.read(&mut bytes)) {
            Some(Some(0)) | None => return false,
            Some(Some(count)) => {
                client.heard = Instant::now();
                if board.waiting() < ROOM {
                    board.send(&bytes[..count]);
                }
            }
            Some(None) => break,
        }
    }
    sent
}

/// The result of a read or write; `Some(None)` if nothing can be moved now, `None` if the connection is over.
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

    use super::*;

    /// A board that sends back what it is sent, and takes five times its own time.
    #[derive(Default)]
    struct Slow {
        wire: VecDeque<u8>,
        now: Duration,
    }

    impl InProcess for Slow {
        fn send(&mut self, bytes: &[u8]) {
            self.wire.extend(bytes);
        }

        fn waiting(&self) -> usize {
            0
        }

        fn receive(&mut self, into: &mut [u8]) -> usize {
            let count = into.len().min(self.wire.len());
            into.iter_mut().zip(self.wire.drain(..count)).for_each(|(into, byte)| *into = byte);
            count
        }

        fn now(&self) -> Duration {
            self.now
        }

        fn block(&mut self) -> io::Result<()> {
            std::thread::sleep(Duration::from_millis(5));
            self.now += Duration::from_millis(1);
            Ok(())
        }
    }

    #[test]
    fn a_board_that_is_slower_than_real_answers_all_the_same() {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let address = listener.local_addr().unwrap();
        let stop = AtomicBool::new(false);
        let waits = std::thread::scope(|scope| {
            scope.spawn(|| serve(&mut Slow::default(), &listener, &stop, Duration::ZERO, |_| ()).unwrap());
            let mut client = TcpStream::connect(address).unwrap();
            // Until the board is further behind than it may be.
            std::thread::sleep(2 * BEHIND);
            let waits: Vec<Duration> = (0..5)
                .map(|_| {
                    let began = Instant::now();
                    client.write_all(b"x").unwrap();
                    client.read_exact(&mut [0]).unwrap();
                    began.elapsed()
                })
                .collect();
            stop.store(true, Ordering::Relaxed);
            waits
        });
        // Turns that catch up become longer and longer.
        assert!(waits.iter().all(|wait| *wait < Duration::from_millis(500)), "{waits:?}");
    }
}
