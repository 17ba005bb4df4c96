//! A session with a board, real or simulated.
//!
//! The session runs on a separate thread. It waits while the board works, and prevents the board's
//! host timeout while Python does something else.

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

use crate::errors::{LinkError, scene_error};
use crate::interruptible;

/// Prefix of a simulated board: `sim:SCENE`.
const SIMULATED_PREFIX: &str = "sim:";
/// Interval of the status requests to an idle board.
const STATUS_INTERVAL: Duration = Duration::from_millis(100);

/// Reply of a session's thread: text for a reader and fields as JSON, or an error message.
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
    /// Connects to `sim:SCENE`, a serial device, or `tcp:HOST:PORT`. `changes` apply to the scene
    /// of a simulated board.
    #[new]
    fn connect(py: Python<'_>, port: &str, changes: Vec<String>, host_timeout_s: Option<f32>, stay: bool) -> PyResult<Self> {
        let options = SessionOptions { host_timeout_s, stay };
        let scene = port
            .strip_prefix(SIMULATED_PREFIX)
            .map(|scene| load(scene, &changes).map_err(|error| scene_error(&error)))
            .transpose()?;
        if scene.is_none() && !changes.is_empty() {
            return Err(LinkError::new_err("changes need a simulated board, `sim:SCENE`"));
        }
        // A client reads its flag during its whole life, which only the thread knows: one leaked
        // byte per connection.
        let stop: &'static AtomicBool = Box::leak(Box::new(AtomicBool::new(false)));
        let (orders, received) = channel();
        let (sender, replies) = channel();
        let name = port.to_owned();
        let inputs = scene.as_ref().map(Loaded::files).unwrap_or_default();
        let thread = thread::spawn(move || {
            let open = || -> Result<Session, Error> {
                let port: Box<dyn Port> = match (scene, name.strip_prefix("tcp:")) {
                    (Some(loaded), _) => {
                        let none =
                            || Error::Usage(format!("`{}` has no [controller], so there is no board to talk to", loaded.name));
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

    /// Returns the port, as given by the caller.
    #[getter]
    fn port(&self) -> &str {
        &self.port
    }

    /// Runs a line of a script, such as `scan` or `drive --volts 3`. Returns text for a reader, and
    /// fields as JSON.
    fn run(&self, py: Python<'_>, line: &str) -> PyResult<(String, String)> {
        let closed = || LinkError::new_err(format!("the link to {} is closed", self.port));
        self.stop.store(false, Ordering::Relaxed);
        {
            let orders = self.orders.lock().unwrap_or_else(PoisonError::into_inner);
            orders.as_ref().ok_or_else(closed)?.send(line.to_owned()).map_err(|_| closed())?;
        }
        self.reply(py)
    }

    /// Ends the session; the drive stops unless `stay` is set.
    fn close(&self, py: Python<'_>) {
        self.orders.lock().unwrap_or_else(PoisonError::into_inner).take();
        let thread = self.thread.lock().unwrap_or_else(PoisonError::into_inner).take();
        // The session stops its drive as it ends; a thread that panicked has already lost its
        // session.
        py.detach(|| thread.map(JoinHandle::join));
    }
}

impl Link {
    fn reply(&self, py: Python<'_>) -> PyResult<(String, String)> {
        interruptible::wait(py, Some(self.stop), &self.replies)?.map_err(LinkError::new_err)
    }
}

/// Answers commands until the channel closes, and keeps the link alive meanwhile.
fn serve(session: Result<Session, Error>, orders: &Receiver<String>, replies: &Sender<Reply>) {
    let mut session = match session {
        Ok(session) => session,
        Err(error) => {
            let _ = replies.send(Err(message(&error)));
            return;
        }
    };
    let mut connected = replies.send(Ok((String::new(), "{}".to_owned()))).is_ok();
    while connected {
        match orders.recv_timeout(STATUS_INTERVAL) {
            Ok(line) => connected = replies.send(run(&mut session, &line)).is_ok(),
            Err(RecvTimeoutError::Timeout) => {
                // The next command detects a board that is lost meanwhile.
                if !session.client.stands_still() {
                    let _ = session.client.status();
                }
            }
            Err(RecvTimeoutError::Disconnected) => break,
        }
    }
    // In any case the end of the session stops the drive again.
    let _ = session.leave();
}

fn run(session: &mut Session, line: &str) -> Reply {
    let script = Script::parse("order", line).map_err(|error| message(&error))?;
    let mut answer = Answer::default();
    let ran = script.run(session, |_, done| {
        if let Ok(done) = done {
            answer = done.clone();
        }
        Ok(())
    });
    match ran {
        Ok(()) => Ok((answer.text, serde_json::Value::Object(answer.fields).to_string())),
        Err(error) => Err(message(error.cause())),
    }
}

/// Formats an error as on the command line.
fn message(error: &Error) -> String {
    match error {
        Error::Script(report) => report.render(false),
        error => error.to_string(),
    }
}
