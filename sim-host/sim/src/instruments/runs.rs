//! A scene that is run many times: statistics of its metrics, which runs are counted, and how the error falls.

pub mod figures;
pub mod statistics;
pub mod table;
