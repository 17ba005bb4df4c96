//! The verdicts.
