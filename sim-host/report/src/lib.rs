//! Reports: figures as SVG, PNG and CSV, and one page with all of them.
//!
//! A [`Report`] is plain data. [`write()`] turns it into a directory that can be archived or sent.
//! For each figure it has three files with the same stem: a vector picture for papers, a bitmap for
//! everything else, and the numbers for other tools ([`write_drawn()`] has other sizes and
//! formats). `report.html` contains the whole report in one file. The page loads nothing, so it
//! opens from a disk, from a mail, or ten years from now.
//!
//! # Example
//!
//! ```
//! use sonoglide_report::spectrum::Spectrum;
//! use sonoglide_report::{Report, TableBlock};
//!
//! let sine: Vec<f64> = (0..65536).map(|n| (std::f64::consts::TAU * 0.04 * f64::from(n)).sin()).collect();
//! let sndr = format!("{:.0}", Spectrum::new(&sine, 0.04).sndr_db());
//! let table = TableBlock::new("purity", "Purity", "Of a sine in double precision.", &["what", "dB"], vec![vec!["SNDR".into(), sndr]]);
//! let report = Report { title: "A sine".into(), tables: vec![table], ..Report::default() };
//! # #[cfg(feature = "pictures")]
//! # {
//! let folder = std::env::temp_dir().join(format!("a-sine-{}", std::process::id()));
//! sonoglide_report::write(&report, &folder)?;
//! assert!(folder.join("report.html").exists());
//! # std::fs::remove_dir_all(&folder).unwrap();
//! # }
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
#![forbid(unsafe_code)]

#[cfg(feature = "data")]
mod data;
pub mod decimate;
#[cfg(feature = "docs")]
pub mod docs;
pub mod spectrum;
pub mod statistics;
pub mod time_frequency;

mod crash_view;
mod digits;
mod drawing;
mod figure;
#[cfg(feature = "pictures")]
mod pictures;
mod table;

pub use crash_view::{CrashView, Instant};
#[cfg(feature = "data")]
pub use data::{ReportError, csv, data_file::text_cell};
pub use digits::{MIN_STATED_REL, rounded, rounded_to, significant, stated};
pub use drawing::{Drawing, PictureFormat, PrintSize, ToPdf};
pub use figure::{Along, Axis, Figure, HeatMap, Marker, Panel, Report, Series, Span, Style};
#[cfg(feature = "pdf")]
pub use pictures::pdf;
#[cfg(feature = "pictures")]
pub use pictures::{svg, write, write_drawn};
pub use table::{TableBlock, markdown, verdict};
