//! What JavaScript calls: texts in, texts out. The glue is generated, with the only `unsafe` there is.

use std::cell::RefCell;
use std::time::Duration;

use serde_json::{Value, json};
use wasm_bindgen::prelude::*;

use crate::{FIRST, Request, Session, scenes};

#[wasm_bindgen]
extern "C" {
    /// Milliseconds since the worker began.
    #[wasm_bindgen(js_namespace = performance)]
    fn now() -> f64;

    /// Called by a run every now and then.
    #[wasm_bindgen(js_name = sonoglideProgress)]
    fn progress(reached: f64);

    /// Called with the words of a panic, after which the worker is lost.
    #[wasm_bindgen(js_name = sonoglidePanic)]
    fn panicked(said: &str);
}

fn clock() -> Duration {
    Duration::from_secs_f64(now() / 1e3)
}

thread_local! {
    static SESSION: RefCell<Session> = RefCell::new(Session::timed(clock));
}

/// Called once, before anything else.
#[wasm_bindgen(start)]
pub fn begin() {
    std::panic::set_hook(Box::new(|info| panicked(&info.to_string())));
}

/// Version, scenes, and the scene to begin with.
#[wasm_bindgen]
pub fn catalogue() -> String {
    wrapped(Ok(json!({ "version": sim::VERSION, "first": FIRST, "scenes": scenes() })))
}

/// A scene before it is run.
#[wasm_bindgen]
pub fn open(request: &str) -> String {
    answer(request, |session, request| session.open(request))
}

/// The result of a scene.
#[wasm_bindgen]
pub fn run(request: &str) -> String {
    answer(request, |session, request| session.run(request, Some(&mut |reached| progress(reached))))
}

/// A file of the last run.
#[wasm_bindgen]
pub fn file(name: &str) -> String {
    SESSION.with_borrow_mut(|session| wrapped(session.file(name).map(Value::from)))
}

fn answer(request: &str, ask: impl FnOnce(&mut Session, &Request) -> Result<Value, String>) -> String {
    match serde_json::from_str(request) {
        Ok(request) => SESSION.with_borrow_mut(|session| wrapped(ask(session, &request))),
        Err(error) => wrapped(Err(format!("error: the page has asked wrongly: {error}"))),
    }
}

/// A result, or an error in words.
fn wrapped(result: Result<Value, String>) -> String {
    match result {
        Ok(value) => json!({ "value": value }),
        Err(error) => json!({ "error": error }),
    }
    .to_string()
}
