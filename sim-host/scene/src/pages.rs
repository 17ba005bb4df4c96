//! Pages and files that the schema of a scene writes.

pub mod all_keys;
pub mod keys_page;
pub mod resolved;
pub mod settings_page;
