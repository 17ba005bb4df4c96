//! Sonoglide for a page: scenes, runs and their results as JSON.
//!
//! ```text
//! page (page/*.js) -- request --> worker (page/worker.js) --> here --> scene, sim: as the command line calls them
//!       ^                                                      |
//!       +------------- opened scene, result, file -------------+
//! ```
//!
//! [`Session`] is what a worker holds: it opens a scene, runs it, and gives the files of the last run. Everything but the module `worker`, which names the
//! functions that JavaScript calls, is the same on the host, where it is tested.
//!
//! # Example
//!
//! ```
//! use sonoglide_web::{Request, Session};
//!
//! let request = Request { name: "lock".into(), ..Request::default() };
//! let result = Session::default().run(&request, None).expect("a result");
//! assert_eq!(result["drive_hash"], "8e65e1fdb0fffc3d");
//! ```

mod catalogue;
mod controls;
mod figures;
mod motor;
mod opened;
mod outcome;
mod request;
mod scope;
mod session;
#[cfg(target_arch = "wasm32")]
mod worker;

pub use catalogue::{Entry, FIRST, scenes};
pub use request::Request;
pub use session::Session;
