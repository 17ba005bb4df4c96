//! A board in this process: the firmware on mocks, or the flashed image on the model of its part. Its time passes only while the client waits, a block at
//! a time.

use std::cell::RefCell;
use std::io;
use std::rc::Rc;
use std::time::{Duration, Instant};

use super::Port;
use crate::link_error::LinkError;

/// Pause between two looks at a board that a debugger holds.
const HELD: Duration = Duration::from_millis(1);

/// A board in this process.
pub trait InProcess {
    /// Puts bytes on the wire to the board.
    fn send(&mut self, bytes: &[u8]);

    /// How many bytes are on the wire to the board.
    fn waiting(&self) -> usize;

    /// Takes bytes that have come from the board; 0 where none have.
    fn receive(&mut self, into: &mut [u8]) -> usize;

    /// Time since the power came.
    fn now(&self) -> Duration;

    /// Plays one block. Fails where the board cannot go on.
    fn block(&mut self) -> io::Result<()>;

    /// Looks after a debugger, where there can be one. True: it holds the board, whose time stands until it lets go.
    fn is_held(&mut self) -> io::Result<bool> {
        Ok(false)
    }
}

/// A board in this process as a port. The holder of the other end of the [`Rc`] sees the plant.
pub struct Simulated<B> {
    name: String,
    board: Rc<RefCell<B>>,
    /// Where it is not to be faster than real: when it was opened.
    paced: Option<Instant>,
}

impl<B: InProcess> Simulated<B> {
    /// A board of this name; `paced`: not faster than real.
    pub fn new(name: &str, board: Rc<RefCell<B>>, paced: bool) -> Self {
        Simulated { name: name.to_owned(), board, paced: paced.then(Instant::now) }
    }
}

impl<B: InProcess> Port for Simulated<B> {
    fn name(&self) -> &str {
        &self.name
    }

    fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.board.borrow_mut().send(bytes);
        Ok(())
    }

    fn receive(&mut self, into: &mut [u8], wait: Duration) -> io::Result<usize> {
        let mut board = self.board.borrow_mut();
        let until = board.now() + wait;
        loop {
            let count = board.receive(into);
            if count > 0 || board.now() >= until {
                return Ok(count);
            }
            if board.is_held()? {
                std::thread::sleep(HELD);
                // What a debugger took is not to be caught up with.
                self.paced = self.paced.map(|opened| opened + HELD);
                continue;
            }
            board.block()?;
            if let Some(ahead) = self.paced.and_then(|opened| board.now().checked_sub(opened.elapsed())) {
                std::thread::sleep(ahead);
            }
        }
    }

    fn now(&self) -> Duration {
        self.board.borrow().now()
    }

    fn reopen(&mut self) -> Result<(), LinkError> {
        Ok(())
    }

    fn nonce(&mut self) -> u32 {
        self.now().as_nanos() as u32
    }

    fn stands_still(&self) -> bool {
        true
    }
}
