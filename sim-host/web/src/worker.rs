//! Interface for JavaScript: strings in, strings out. The glue is generated and contains the only
//! `unsafe` code.

use std::cell::RefCell;
use std::time::Duration;

use serde::de::DeserializeOwned;
use serde_json::{Value, json};
use wasm_bindgen::prelude::*;

use crate::board::{PagePort, simulated, talk, tell};
use crate::{FIRST_SCENE, OpenedFile, Request, Session, Target, scenes};

#[wasm_bindgen]
extern "C" {
    /// Returns the milliseconds since the worker began.
    #[wasm_bindgen(js_namespace = performance)]
    fn now() -> f64;

    /// Reports the progress of a run from time to time.
    #[wasm_bindgen(js_name = sonoglideProgress)]
    fn progress(reached: f64);

    /// Returns the port to connect to: a scene, or nothing for the serial port that the page has
    /// opened.
    #[wasm_bindgen(js_name = sonoglidePort)]
    fn port() -> Option<String>;

    /// Reports the message of a panic, after which the worker is lost.
    #[wasm_bindgen(js_name = sonoglidePanic)]
    fn panicked(said: &str);
}

fn clock() -> Duration {
    Duration::from_secs_f64(now() / 1e3)
}

thread_local! {
    static SESSION: RefCell<Session> = RefCell::new(Session::timed(clock));
}

/// Initialises the worker; called once, before anything else.
#[wasm_bindgen(start)]
pub fn begin() {
    std::panic::set_hook(Box::new(|info| panicked(&info.to_string())));
}

/// Returns the version, the scenes, and the first scene.
#[wasm_bindgen]
pub fn catalogue() -> String {
    wrapped(Ok(json!({ "version": sim::VERSION, "first": FIRST_SCENE, "scenes": scenes() })))
}

/// Returns the data of a scene before it is run.
#[wasm_bindgen]
pub fn open(request: &str) -> String {
    answer(request, |session, request| session.open(request))
}

/// Runs a scene. Returns its result.
#[wasm_bindgen]
pub fn run(request: &str) -> String {
    answer(request, |session, request| session.run(request, Some(&mut |reached| progress(reached))))
}

/// Returns a file of the last run.
#[wasm_bindgen]
pub fn file(name: &str) -> String {
    SESSION.with_borrow_mut(|session| wrapped(session.file(name).map(Value::from)))
}

/// Runs a scene for one of its metrics.
#[wasm_bindgen]
pub fn point(request: &str) -> String {
    wrapped(parsed(request).and_then(|request: Request| request.point()).map(Value::from))
}

/// Returns the next step of a search for a target.
#[wasm_bindgen]
pub fn target(request: &str) -> String {
    wrapped(parsed(request).map(|target: Target| target.next()))
}

/// Reads a file as a scene; a measurement is fitted, or drawn over the last run.
#[wasm_bindgen]
pub fn read(request: &str, content: Vec<u8>) -> String {
    SESSION.with_borrow_mut(|session| wrapped(parsed(request).and_then(|file: OpenedFile| session.read(&file, content))))
}

/// Talks to a board until the page leaves or the board is lost. It has no argument and no result,
/// so that a browser can suspend it.
#[wasm_bindgen]
pub fn connect() {
    let port = match port() {
        Some(request) => {
            serde_json::from_str(&request).map_err(|error| error.to_string()).and_then(|request| simulated(&request))
        }
        None => Ok(Box::new(PagePort::new("the serial port")) as _),
    };
    match port {
        Ok(port) => talk(port),
        Err(error) => tell(&json!({ "event": "ended", "error": error })),
    }
}

fn answer(request: &str, ask: impl FnOnce(&mut Session, &Request) -> Result<Value, String>) -> String {
    wrapped(parsed(request).and_then(|request| SESSION.with_borrow_mut(|session| ask(session, &request))))
}

fn parsed<T: DeserializeOwned>(request: &str) -> Result<T, String> {
    serde_json::from_str(request).map_err(|error| format!("error: invalid request from the page: {error}"))
}

/// Serialises a result, or an error message.
fn wrapped(result: Result<Value, String>) -> String {
    match result {
        Ok(value) => json!({ "value": value }),
        Err(error) => json!({ "error": error }),
    }
    .to_string()
}
