//! `serve`: a board in this process at a TCP port, in real time, for clients that come and go.
//!
//! One client at a time; the next waits until the first has gone. The board goes on with or without a client, as a real one does.

use std::io::{self, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use crate::port::InProcess;

/// Pause between two turns.
const TURN: Duration = Duration::from_micros(500);
/// Reads of a turn at most.
const READS: usize = 16;
/// Bytes that may be on the wire to the board before more are lost: many times the longest frame.
const ROOM: usize = 4096;
/// How far the board may fall behind before it gives up catching up.
const BEHIND: Duration = Duration::from_millis(200);

/// Plays until `stop` is set. `note` is called when a client comes or goes, and where the machine is too slow.
pub fn serve(board: &mut impl InProcess, listener: &TcpListener, stop: &AtomicBool, note: fn(&str)) -> io::Result<()> {
    listener.set_nonblocking(true)?;
    let mut client: Option<TcpStream> = None;
    let (mut began, mut slow) = (Instant::now(), false);
    while !stop.load(Ordering::Relaxed) {
        if client.is_none() {
            client = accepted(listener, note)?;
        }
        if let Some(stream) = &mut client
            && !exchange(board, stream)
        {
            note("the client has gone");
            client = None;
        }
        let due = began.elapsed();
        if due > board.now() + BEHIND {
            began += due - board.now();
            if !std::mem::replace(&mut slow, true) {
                note("this machine is slower than the board: the board's time passes more slowly");
            }
        }
        while board.now() < due.min(began.elapsed()) {
            board.block()?;
        }
        std::thread::sleep(TURN);
    }
    Ok(())
}

fn accepted(listener: &TcpListener, note: fn(&str)) -> io::Result<Option<TcpStream>> {
    match listener.accept() {
        Ok((stream, from)) => {
            note(&format!("a client from {from}"));
            stream.set_nonblocking(true)?;
            stream.set_nodelay(true)?;
            Ok(Some(stream))
        }
        Err(error) if error.kind() == io::ErrorKind::WouldBlock => Ok(None),
        Err(error) => Err(error),
    }
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
