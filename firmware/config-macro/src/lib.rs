//! Attribute that derives all uses of a setting from one description.
//!
//! A table of settings is a struct. Each field states the meaning of the setting, its permitted
//! values, and its default:
//!
//! ```ignore
//! #[settings(table = "limits", scene = Limits)]
//! #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
//! pub struct Limits {
//!     /// Peak drive voltage, V.
//!     #[setting(default = 15.466, min = 1e-3, max = 1e4, key = 8, ceiling)]
//!     pub voltage_v: f32,
//! }
//! ```
//!
//! | generated item | user |
//! |---|---|
//! | the struct itself, in single precision | the controller |
//! | `Limits::default()`; with the option `new` and required fields, `Limits::new(...)` | boards and tests |
//! | with the option `optional`, parameters of a table that a configuration may omit (`seam::config::Optional`) | the link |
//! | `Limits::VOLTAGE_V`, a `Setting`: name and range | relations that a stage checks itself |
//! | `Limits::check()`: checks that every value is within its range | the build |
//! | `Limits::PARAMETERS`: the fields that have a key | the link and the stored settings |
//! | `scene::Limits`, in double precision, with the keys, the defaults and the JSON Schema of a scene, and its conversion | the host, by the feature `scene` |
//!
//! | option of a field | meaning |
//! |---|---|
//! | `default`, `default = X` | the value of a missing key; an `Option` and a `Vec` always have the default of their type |
//! | `min = X, max = Y` | the range, for a list that of each entry; both or neither must be given |
//! | `key = N` | the setting can be set over the link and stored, under this number; without a range its type must be a `Choice` |
//! | `ceiling` | a limit: over the link it can be lowered, but never raised above the built-in value |
//! | `scale` | a scale factor: the ceilings of the limits that depend on it are scaled by it |
//! | `read = F, write = F` | access of the link, if it is not to the field itself |
//! | `quiet` | a written scene omits the key if it has its default |
//! | `scene` | a key of the scene only: the controller has a derived value instead |
//! | `controller` | a field of the controller only |

mod field;
mod parameter;
mod scene;
mod table;

use proc_macro::TokenStream;
use syn::{DeriveInput, parse_macro_input};

/// Turns a struct into a table of settings; see the documentation of the crate.
#[proc_macro_attribute]
pub fn settings(options: TokenStream, item: TokenStream) -> TokenStream {
    let item = parse_macro_input!(item as DeriveInput);
    table::Options::parse(options.into())
        .and_then(|options| table::Table::parse(options, item))
        .map_or_else(syn::Error::into_compile_error, |table| table.expand())
        .into()
}
