//! Boards in this process: the firmware on mocks, or the flashed image on the model of its chip.
//! Simulated time advances block by block, and only while the client waits.

use std::cell::RefCell;
use std::io;
use std::rc::Rc;
use std::time::{Duration, Instant};

use super::Port;
use crate::link_error::LinkError;

/// Polling interval while a debugger holds the board.
const HOLD_POLL_INTERVAL: Duration = Duration::from_millis(1);

/// Board in this process.
pub trait InProcess {
    /// Puts bytes on the wire to the board.
    fn send(&mut self, bytes: &[u8]);

    /// Returns the number of bytes on the wire to the board.
    fn waiting(&self) -> usize;

    /// Takes bytes from the board; returns 0 if there are none.
    fn receive(&mut self, into: &mut [u8]) -> usize;

    /// Returns the time since power-on.
    fn now(&self) -> Duration;

    /// Plays one block. Fails if the board cannot continue.
    fn block(&mut self) -> io::Result<()>;

    /// Serves a debugger, if the board has one. Returns `true` while the debugger holds the board,
    /// whose time stops until it is released.
    fn is_held(&mut self) -> io::Result<bool> {
        Ok(false)
    }
}

/// Port of a board in this process. The owner of the other [`Rc`] has access to the plant.
pub struct Simulated<B> {
    name: String,
    board: Rc<RefCell<B>>,
    /// Time of opening, if the board must not be faster than real time.
    paced: Option<Instant>,
}

impl<B: InProcess> Simulated<B> {
    /// Creates a port with this name. If `paced`, the board is not faster than real time.
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
                std::thread::sleep(HOLD_POLL_INTERVAL);
                // The time that the debugger takes is not caught up.
                self.paced = self.paced.map(|opened| opened + HOLD_POLL_INTERVAL);
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
