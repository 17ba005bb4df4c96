//! A board, real or simulated, and what is asked of it.
//!
//! The session with the board lives on a thread of its own: it waits while the board works, and keeps the board's host timeout from running out while
//! Python does something else.

use std::cell::RefCell;
use std::rc::Rc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::sync::{Mutex, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use ::link::answer::Answer;
use ::link::client::Client;
use ::link::link_error::LinkError as Error;
use ::link::port::{Port, Serial, Simulated, Tcp};
use ::link::script::Script;
use ::link::session::{Session, SessionOptions};
use ::link::simulated_board::SimulatedBoard;
use pyo3::prelude::*;
use scene::load::{Loaded, load};

use crate::errors::{LinkError, of_scene};
use crate::interruptible;

/// What a simulated board is called: `sim:SCENE`.
const SIMULATED: &str = "sim:";
/// How often a board is looked after while nothing is asked of it.
const LOOK_AFTER: Duration = Duration::from_millis(100);

/// What the thread of a session answers: text for a reader and fields as JSON, or what is wrong.
type Reply = Result<(String, String), String>;

/// A session with a board.
#[pyclass(frozen, module = "sonoglide._native")]
pub struct Link {
    port: String,
    stop: &'static AtomicBool,
    orders: Mutex<Option<Sender<String>>>,
    replies: Mutex<Receiver<Reply>>,
    thread: Mutex<Option<JoinHandle<()>>>,
}

#[pymethods]
impl Link {
    /// Connects: `sim:SCENE`, a serial device, or `tcp:HOST:PORT`. `changes` are of a simulated board's scene.
    #[new]
    fn connect(py: Python<'_>, port: &str, changes: Vec<String>, host_timeout_s: Option<f32>, stay: bool) -> PyResult<Self> {
        let options = SessionOptions { host_timeout_s, stay };
        let scene =
            port.strip_prefix(SIMULATED).map(|scene| load(scene, &changes).map_err(|error| of_scene(&error))).transpose()?;
        if scene.is_none() && !changes.is_empty() {
            return Err(LinkError::new_err("changes are of a simulated board's scene, `sim:SCENE`"));
        }
        // A client reads its flag for as long as it lives, which only the thread knows: a byte for each connection.
        let stop: &'static AtomicBool = Box::leak(Box::new(AtomicBool::new(false)));
        let (orders, received) = channel();
        let (sender, replies) = channel();
        let name = port.to_owned();
        let inputs = scene.as_ref().map(Loaded::files).unwrap_or_default();
        let thread = thread::spawn(move || {
            let open = || -> Result<Session, Error> {
                let port: Box<dyn Port> = match (scene, name.strip_prefix("tcp:")) {
                    (Some(loaded), _) => {
                        let none = || Error::Usage(format!("`{}` has no [controller]: there is nothing to talk to", loaded.name));
                        let driven = loaded.scene.driven().ok_or_else(none)?;
                        let refused = |why| Error::Usage(format!("the firmware refuses this scene: {why}"));
                        let board = SimulatedBoard::new(&driven, 0).map_err(refused)?;
                        Box::new(Simulated::new(&name, Rc::new(RefCell::new(board)), false))
                    }
                    (None, Some(address)) => Box::new(Tcp::connect(address)?),
                    (None, None) => Box::new(Serial::open(&name)?),
                };
                let mut session = Session::begin(Client::new(port, stop, |_| ()), options)?;
                session.inputs = inputs;
                Ok(session)
            };
            serve(open(), &received, &sender);
        });
        let link = Link {
            port: port.to_owned(),
            stop,
            orders: Mutex::new(Some(orders)),
            replies: Mutex::new(replies),
            thread: Mutex::new(Some(thread)),
        };
        link.reply(py)?;
        Ok(link)
    }

    /// The port as it was named.
    #[getter]
    fn port(&self) -> &str {
        &self.port
    }

    /// Runs a line of a script, such as `scan` or `drive --volts 3`: text for a reader, and fields as JSON.
    fn run(&self, py: Python<'_>, line: &str) -> PyResult<(String, String)> {
        let closed = || LinkError::new_err(format!("the link to {} is closed", self.port));
        self.stop.store(false, Ordering::Relaxed);
        {
            let orders = self.orders.lock().unwrap_or_else(PoisonError::into_inner);
            orders.as_ref().ok_or_else(closed)?.send(line.to_owned()).map_err(|_| closed())?;
        }
        self.reply(py)
    }

    /// Ends the session; the drive falls silent unless it is to stay.
    fn close(&self, py: Python<'_>) {
        self.orders.lock().unwrap_or_else(PoisonError::into_inner).take();
        let thread = self.thread.lock().unwrap_or_else(PoisonError::into_inner).take();
        // The session silences its drive as it ends; a thread that panicked has none any more.
        py.detach(|| thread.map(JoinHandle::join));
    }
}

impl Link {
    fn reply(&self, py: Python<'_>) -> PyResult<(String, String)> {
        interruptible::wait(py, self.stop, &self.replies)?.map_err(LinkError::new_err)
    }
}

/// Answers orders until nobody can give any, and looks after the board meanwhile.
fn serve(session: Result<Session, Error>, orders: &Receiver<String>, replies: &Sender<Reply>) {
    let mut session = match session {
        Ok(session) => session,
        Err(error) => {
            let _ = replies.send(Err(said(&error)));
            return;
        }
    };
    let mut heard = replies.send(Ok((String::new(), "{}".to_owned()))).is_ok();
    while heard {
        match orders.recv_timeout(LOOK_AFTER) {
            Ok(line) => heard = replies.send(run(&mut session, &line)).is_ok(),
            Err(RecvTimeoutError::Timeout) => {
                // A board that is lost meanwhile is found to be so by the next order.
                if !session.client.stands_still() {
                    let _ = session.client.status();
                }
            }
            Err(RecvTimeoutError::Disconnected) => break,
        }
    }
    // Whatever happens here, the session's own end silences the drive again.
    let _ = session.leave();
}

fn run(session: &mut Session, line: &str) -> Reply {
    let script = Script::parse("order", line).map_err(|error| said(&error))?;
    let mut answer = Answer::default();
    let ran = script.run(session, |_, done| {
        if let Ok(done) = done {
            answer = done.clone();
        }
        Ok(())
    });
    match ran {
        Ok(()) => Ok((answer.text, serde_json::Value::Object(answer.fields).to_string())),
        Err(error) => Err(said(error.cause())),
    }
}

/// An error as the command line shows it.
fn said(error: &Error) -> String {
    match error {
        Error::Script(report) => report.render(false),
        error => error.to_string(),
    }
}
