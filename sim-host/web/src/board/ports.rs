//! Ports of a page: a serial port of the browser, and a simulated board in real time.
//!
//! A wait suspends the stack of the module, so that the browser delivers bytes and requests.

use std::cell::RefCell;
use std::io::{self, ErrorKind};
use std::rc::Rc;
use std::sync::atomic::Ordering;
use std::time::Duration;

use link::as_on_board::adapted;
use link::link_error::LinkError;
use link::port::{Port, Simulated};
use link::simulated_board::SimulatedBoard;
use wasm_bindgen::prelude::*;

use super::STOP;
use crate::Request;
use crate::request::message;

/// Longest simulated time between two looks at the clock of the page.
const SLICE: Duration = Duration::from_millis(4);
/// Longest time without a suspension, ms: an order to stop waits no longer.
const MAX_BUSY_MS: f64 = 20.0;
/// Delay of a simulated board relative to real time after which it no longer catches up, ms.
const MAX_DELAY_MS: f64 = 50.0;

/// Result of a wait: the port is closed.
const CLOSED: f64 = -1.0;
/// Result of a wait: the page has requested the present command to end.
const INTERRUPTED: f64 = -2.0;

#[wasm_bindgen]
extern "C" {
    /// Returns the time, ms; it stops while the page is hidden.
    #[wasm_bindgen(js_name = sonoglideNow)]
    fn now_ms() -> f64;

    /// Sends bytes to the port.
    #[wasm_bindgen(js_name = sonoglideSend)]
    fn send(bytes: &[u8]);

    /// Waits up to this time, ms, for bytes or a request. Returns the number of received bytes, or
    /// one of the results above.
    #[wasm_bindgen(js_name = sonoglideWait)]
    fn wait(time_ms: f64) -> f64;

    /// Takes up to this number of received bytes.
    #[wasm_bindgen(js_name = sonoglideReceived)]
    fn received(count: u32) -> Vec<u8>;

    /// Returns a random number.
    #[wasm_bindgen(js_name = sonoglideRandom)]
    fn random() -> u32;
}

/// Suspends this module, and notices a request to end the present command.
fn suspend(time_ms: f64) -> f64 {
    let result = wait(time_ms);
    if result == INTERRUPTED {
        STOP.store(true, Ordering::Relaxed);
    }
    result
}

/// Serial port of the browser, which the page has opened.
pub struct PagePort(String);

impl PagePort {
    /// Creates the port with its name in messages.
    pub fn new(name: &str) -> Self {
        PagePort(name.to_owned())
    }
}

impl Port for PagePort {
    fn name(&self) -> &str {
        &self.0
    }

    fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        send(bytes);
        Ok(())
    }

    fn receive(&mut self, into: &mut [u8], wait: Duration) -> io::Result<usize> {
        match suspend(1e3 * wait.as_secs_f64()) {
            CLOSED => Err(io::Error::new(ErrorKind::UnexpectedEof, "the port was closed: is the cable still connected?")),
            count if count > 0.0 => {
                let bytes = received(into.len() as u32);
                into[..bytes.len()].copy_from_slice(&bytes);
                Ok(bytes.len())
            }
            _ => Ok(0),
        }
    }

    fn now(&self) -> Duration {
        Duration::from_secs_f64(1e-3 * now_ms())
    }

    fn reopen(&mut self) -> Result<(), LinkError> {
        Err(LinkError::Lost { port: self.0.clone(), why: "connect again".into() })
    }

    fn nonce(&mut self) -> u32 {
        random()
    }

    // Another connection begins disarmed.
    fn can_reopen(&self) -> bool {
        false
    }
}

/// Simulated board that is not faster than real time, and does not block the page.
struct Paced {
    board: Simulated<SimulatedBoard>,
    /// Time of the page at which the board was powered on.
    began_ms: f64,
    suspended_ms: f64,
}

/// Powers on the simulated board of a scene.
///
/// # Errors
/// All errors in the scene, or the reason for which the firmware refuses it.
pub fn simulated(request: &Request) -> Result<Box<dyn Port>, String> {
    let (loaded, _) = adapted(request.load()?).map_err(|error| message(&error))?;
    let scene = loaded.scene.driven().ok_or("error: this scene has no [controller], which a board needs")?;
    let mut board = SimulatedBoard::new(&scene, 0).map_err(|why| format!("error: the firmware refuses this scene: {why}"))?;
    if request.jumper {
        board.wire_jumper();
    }
    let board = Simulated::new(&format!("sim:{}", loaded.name), Rc::new(RefCell::new(board)), false);
    Ok(Box::new(Paced { board, began_ms: now_ms(), suspended_ms: now_ms() }))
}

impl Paced {
    /// Suspends the board if it is ahead of the page's time, and from time to time.
    fn keep_pace(&mut self) {
        let now = now_ms();
        let ahead_ms = 1e3 * self.board.now().as_secs_f64() - (now - self.began_ms);
        if ahead_ms < -MAX_DELAY_MS {
            self.began_ms -= ahead_ms + MAX_DELAY_MS;
        }
        if ahead_ms >= 1.0 || now - self.suspended_ms > MAX_BUSY_MS {
            suspend(ahead_ms.max(0.0));
            self.suspended_ms = now_ms();
        }
    }
}

impl Port for Paced {
    fn name(&self) -> &str {
        self.board.name()
    }

    fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.board.send(bytes)
    }

    fn receive(&mut self, into: &mut [u8], wait: Duration) -> io::Result<usize> {
        let until = self.board.now() + wait;
        loop {
            let left = until.saturating_sub(self.board.now());
            let count = self.board.receive(into, left.min(SLICE))?;
            self.keep_pace();
            if count > 0 || self.board.now() >= until || STOP.load(Ordering::Relaxed) {
                return Ok(count);
            }
        }
    }

    fn now(&self) -> Duration {
        self.board.now()
    }

    fn reopen(&mut self) -> Result<(), LinkError> {
        self.board.reopen()
    }

    fn nonce(&mut self) -> u32 {
        self.board.nonce()
    }

    fn stands_still(&self) -> bool {
        true
    }
}
