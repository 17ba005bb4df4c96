//! Exchange with the page: requests, events and files, in the order in which they were sent.

use serde::Deserialize;

pub use channel::tell;
use channel::{next, peek};

/// Request of the page.
#[derive(Clone, Debug, Deserialize, PartialEq)]
#[serde(tag = "ask", rename_all = "snake_case")]
pub enum Request {
    /// Allow or refuse commands that act on the board.
    Arm {
        /// `true` to allow them.
        armed: bool,
    },
    /// Run lines of a script.
    Lines {
        /// Number of the request, which its last event repeats.
        id: u32,
        /// The lines.
        text: String,
    },
    /// List all settings.
    Parameters {
        /// Number of the request.
        id: u32,
    },
    /// Keep a file that a later command reads.
    File {
        /// Name of the file in that command.
        name: String,
        /// Content.
        bytes: Vec<u8>,
    },
    /// Stop the drive and end the session.
    Leave,
}

/// Returns `true` if a request waits.
pub fn is_waiting() -> bool {
    peek()
}

/// Takes the next request. A request of another form comes from another version of the page, and is
/// an error of this program.
pub fn take() -> Option<Request> {
    next()
        .map(|text| serde_json::from_str(&text).unwrap_or_else(|error| panic!("invalid request from the page: {error}: {text}")))
}

#[cfg(target_arch = "wasm32")]
mod channel {
    use serde_json::Value;
    use wasm_bindgen::prelude::*;

    #[wasm_bindgen]
    extern "C" {
        #[wasm_bindgen(js_name = sonoglideTell)]
        fn post(event: &str);

        #[wasm_bindgen(js_name = sonoglideNext)]
        pub(super) fn next() -> Option<String>;

        #[wasm_bindgen(js_name = sonoglideIsWaiting)]
        pub(super) fn peek() -> bool;
    }

    /// Tells the page an event.
    pub fn tell(event: &Value) {
        post(&event.to_string());
    }
}

#[cfg(not(target_arch = "wasm32"))]
pub mod channel {
    use std::cell::RefCell;
    use std::collections::VecDeque;

    use serde_json::Value;

    thread_local! {
        /// Requests of a test in the role of the page.
        pub static REQUESTS: RefCell<VecDeque<String>> = const { RefCell::new(VecDeque::new()) };
        /// Events for it.
        pub static EVENTS: RefCell<Vec<Value>> = const { RefCell::new(Vec::new()) };
    }

    /// Keeps an event.
    pub fn tell(event: &Value) {
        EVENTS.with_borrow_mut(|events| events.push(event.clone()));
    }

    pub(super) fn next() -> Option<String> {
        REQUESTS.with_borrow_mut(VecDeque::pop_front)
    }

    pub(super) fn peek() -> bool {
        REQUESTS.with_borrow(|requests| !requests.is_empty())
    }
}
