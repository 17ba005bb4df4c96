//! Sonoglide for a web page: scenes, runs and their results as JSON.
//!
//! ```text
//! page (page/*.js) -- request --> worker (page/worker.js) --> here --> scene, sim: as the command line calls them
//!       ^                                                      |
//!       +------------- opened scene, result, file -------------+
//! ```
//!
//! [`Session`] is the state of a worker: it opens a scene, runs it, and returns the files of the
//! last run. Everything except the module `worker`, which defines the functions that JavaScript
//! calls, is the same on the host, where it is tested.
//!
//! [`board`] talks to a real board over a serial port of the browser, or to a simulated one.
//!
//! # Example
//!
//! ```
//! use sonoglide_web::{Request, Session};
//!
//! let request = Request { name: "lock".into(), ..Request::default() };
//! let result = Session::default().run(&request, None).expect("a result");
//! assert_eq!(result["drive_hash"], "82f8af0840dc6188");
//! ```

pub mod board;
mod catalogue;
mod controls;
mod curve;
mod figures;
mod measurement;
mod motor;
mod opened;
mod outcome;
mod request;
mod scope;
mod series;
mod session;
#[cfg(target_arch = "wasm32")]
mod worker;

pub use catalogue::{Entry, FIRST_SCENE, scenes};
pub use curve::Target;
pub use measurement::OpenedFile;
pub use request::Request;
pub use session::Session;
