//! Host side of the link to a driver board, real or simulated.
//!
//! ```text
//! command line, script, page --> commands --> session --> client --> port --> serial device | TCP | simulated board
//!                                   |                        |
//!                                answer               frames of firmware::board::link: sequence numbers, checksums, repeats
//! ```
//!
//! A [`port`] carries bytes and provides the clock. The clock of a [simulated
//! board](simulated_board) is its simulated time. It advances only while a caller waits for it, so
//! that a dialogue is reproducible and as fast as the machine. A [`client`] sends commands and
//! receives answers. A [`session`] waits, prevents the host timeout of the board from expiring, and
//! leaves the drive in the state that the user has chosen. Each [command](commands) is one file. It
//! returns an [`answer`](answer::Answer), as text or as a line of JSON.
//!
//! Without the feature `host` (serial devices, TCP, folders of results) the same client compiles
//! for a browser, whose port is elsewhere.
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
//! static STOP: AtomicBool = AtomicBool::new(false); // set by Ctrl-C, for example
//! let loaded = load("lock", &[])?;
//! let board = SimulatedBoard::new(&loaded.scene.driven().expect("a driven scene"), 0)?;
//! let port = Simulated::new("sim:lock", Rc::new(RefCell::new(board)), false);
//! let mut client = Client::new(Box::new(port), &STOP, |note| eprintln!("{note}"));
//! assert_eq!(client.connect()?.converters.sample_hz, 1_000_000);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
#![forbid(unsafe_code)]

pub mod admittance;
pub mod answer;
pub mod as_on_board;
pub mod client;
pub mod commands;
#[cfg(all(target_os = "linux", feature = "host"))]
pub mod emulated_board;
pub mod expect;
pub mod files;
#[cfg(feature = "host")]
pub mod flash_file;
pub mod link_error;
pub mod number_with_unit;
pub mod parameter;
pub mod port;
pub mod prompt;
pub mod raw_frame;
pub mod refusal;
pub mod scale;
pub mod script;
#[cfg(feature = "host")]
pub mod serve;
pub mod session;
pub mod simulated_board;
pub mod terminal_plot;
#[cfg(feature = "host")]
pub mod update_file;
pub mod words;
