//! The host's end of the link to a driver board, real or simulated.
//!
//! ```text
//! command line, script --> commands --> session --> client --> port --> serial device | TCP | simulated board
//!                             |                        |
//!                          answer               frames of firmware::board::link: sequence numbers, checks, asking again
//! ```
//!
//! [`port`] carries bytes and has the clock; the time of a [simulated board](simulated_board) is the one it plays in, and passes only
//! while a caller waits for it, so that a dialogue is the same every time and as fast as the machine. [`client`] asks and is answered.
//! [`session`] waits, keeps the board's host timeout from running out, and leaves the drive in the state that the user has asked for. Each
//! [command](commands) is one file, and gives an [`answer`](answer::Answer), for a reader or as a line of JSON.
//!
//! # Example
//!
//! ```
//! use std::cell::RefCell;
//! use std::rc::Rc;
//! use std::sync::atomic::AtomicBool;
//!
//! use scene::load::load;
//! use sonoglide_link::client::Client;
//! use sonoglide_link::port::Simulated;
//! use sonoglide_link::simulated_board::SimulatedBoard;
//!
//! static STOP: AtomicBool = AtomicBool::new(false); // set by Ctrl-C, say
//! let loaded = load("lock", &[])?;
//! let board = SimulatedBoard::new(&loaded.scene.driven().expect("the firmware drives it"), 0)?;
//! let port = Simulated::new("sim:lock", Rc::new(RefCell::new(board)), false);
//! let mut client = Client::new(Box::new(port), &STOP, |note| eprintln!("{note}"));
//! assert_eq!(client.connect()?.converters.sample_hz, 1_000_000);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
#![forbid(unsafe_code)]

pub mod admittance;
pub mod answer;
pub mod client;
pub mod commands;
#[cfg(target_os = "linux")]
pub mod emulated_board;
pub mod expect;
pub mod link_error;
pub mod parameter;
pub mod port;
pub mod prompt;
pub mod raw_frame;
pub mod refusal;
pub mod scale;
pub mod script;
pub mod serve;
pub mod session;
pub mod simulated_board;
pub mod terminal_plot;
pub mod update_file;
pub mod words;
