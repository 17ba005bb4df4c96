//! Pages and files that are generated from the schema of a scene.

pub mod all_keys;
pub mod keys_page;
pub mod resolved;
pub mod settings_page;
