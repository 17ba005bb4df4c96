//! `serve`: a board in this process at a TCP port, in real time, for clients that come and go.
//!
//! One client at a time. The next waits for a moment, in which the first may go, and is then told who holds the board. The board goes on with or without
//! a client, as a real one does.

use std::io::{self, Read, Write};
use std::net::{Shutdown, TcpListener, TcpStream};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use crate::port::{HELD, InProcess};

/// Pause between two turns.
const TURN: Duration = Duration::from_micros(500);
/// How long a turn may take.
const LONGEST: Duration = Duration::from_millis(10);
/// Reads of a turn at most.
const READS: usize = 16;
/// Bytes that may be on the wire to the board before more are lost: many times the longest frame.
const ROOM: usize = 4096;
/// How long the next client waits for the first to go: what a program has sent as it ended is read first.
const HELD_AFTER: Duration = Duration::from_millis(500);
/// How far the board may fall behind before it gives up catching up.
const BEHIND: Duration = Duration::from_millis(200);

/// Plays until `stop` is set. `note` is called when a client comes or goes, and where the machine is too slow.
pub fn serve(board: &mut impl InProcess, listener: &TcpListener, stop: &AtomicBool, note: fn(&str)) -> io::Result<()> {
    listener.set_nonblocking(true)?;
    let mut client: Option<TcpStream> = None;
    let mut door = Door::default();
    let (mut began, mut slow) = (Instant::now(), false);
    while !stop.load(Ordering::Relaxed) {
        if client.is_none() {
            client = door.opens(listener)?.inspect(|stream| note(&format!("a client from {}", address(stream))));
        }
        if let Some(stream) = &mut client
            && !exchange(board, stream)
        {
            note("the client has gone");
            client = None;
        }
        if let Some(holder) = &client {
            door.knock(listener, holder)?;
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

/// Where clients come in.
#[derive(Default)]
struct Door {
    /// The next client, and since when it waits.
    next: Option<(TcpStream, Instant)>,
    /// The one that was sent away last: its connection stays until it has read why.
    away: Option<TcpStream>,
}

impl Door {
    /// The next client, if there is one.
    fn opens(&mut self, listener: &TcpListener) -> io::Result<Option<TcpStream>> {
        match self.next.take() {
            Some((next, _)) => Ok(Some(next)),
            None => accepted(listener),
        }
    }

    /// Looks whether another client waits, and sends it away where the first does not go.
    fn knock(&mut self, listener: &TcpListener, holder: &TcpStream) -> io::Result<()> {
        match self.next.take_if(|(_, since)| since.elapsed() > HELD_AFTER) {
            Some((mut next, _)) => {
                // In one piece; whoever does not read it has gone.
                let said = format!("{HELD}{}\n", address(holder));
                let _ = next.write_all(said.as_bytes()).and_then(|()| next.shutdown(Shutdown::Write));
                self.away = Some(next);
            }
            None if self.next.is_none() => self.next = accepted(listener)?.map(|next| (next, Instant::now())),
            None => {}
        }
        Ok(())
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

/// Where a client is.
fn address(stream: &TcpStream) -> String {
    stream.peer_addr().map_or_else(|_| "an address that is gone".into(), |address| address.to_string())
}

/// Carries what there is, both ways. False: the client has gone.
fn exchange(board: &mut impl InProcess, stream: &mut TcpStream) -> bool {
    let mut bytes = [0; 1024];
    let count = board.receive(&mut bytes);
    // What a full socket does not take is lost, as on a wire without a receiver.
    let sent = count == 0 || waits(stream.write_all(&bytes[..count])).is_some();
    // However much a client sends, it does not keep the board from its next block; what is beyond the wire's room is lost.
    for _ in 0..READS {
        match waits(stream.read(&mut bytes)) {
            Some(Some(0)) | None => return false,
            Some(Some(count)) if board.waiting() < ROOM => board.send(&bytes[..count]),
            Some(Some(_)) => {}
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
            scope.spawn(|| serve(&mut Slow::default(), &listener, &stop, |_| ()).unwrap());
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
