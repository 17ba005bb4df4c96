//! One description of a setting, from which everything else that is known of it follows.
//!
//! A table of settings is a struct; each field says what the setting means, which values are permitted, and which is the default:
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
//! | what follows | for |
//! |---|---|
//! | the struct itself, in single precision | the controller |
//! | `Limits::default()`; with the option `new` and required fields, `Limits::new(...)` | boards and tests |
//! | with the option `optional`, parameters of a table that a configuration may be without (`seam::config::Optional`) | the link |
//! | `Limits::VOLTAGE_V`, a `Setting`: name and range | relations that a stage checks itself |
//! | `Limits::check()`: every value is within its range | the build |
//! | `Limits::PARAMETERS`: the fields that have a key | the link and the stored settings |
//! | `scene::Limits`, in double precision, with the keys, the defaults and the JSON Schema of a scene, and its conversion | the host, by the feature `scene` |
//!
//! | option of a field | says |
//! |---|---|
//! | `default`, `default = X` | the value of a key that is not given; an `Option` and a `Vec` have a default by themselves |
//! | `min = X, max = Y` | the range, of each entry where there are several: both or neither |
//! | `key = N` | it can be set over the link and stored, under this number; without a range its type is a `Choice` |
//! | `ceiling` | a limit: over the link it can be lowered, never raised beyond what is built in |
//! | `scale` | a scale factor: the ceilings of limits that are judged by it follow it |
//! | `read = F, write = F` | how the link reads and writes it, where that is not the field itself |
//! | `quiet` | a scene that is written out leaves it out where it is the default |
//! | `scene` | a key of the scene only: what the controller has instead is derived from it |
//! | `controller` | a field of the controller only |

mod field;
mod parameter;
mod scene;
mod table;

use proc_macro::TokenStream;
use syn::{DeriveInput, parse_macro_input};

/// Makes a table of settings of a struct; see the crate's page.
#[proc_macro_attribute]
pub fn settings(options: TokenStream, item: TokenStream) -> TokenStream {
    let item = parse_macro_input!(item as DeriveInput);
    table::Options::parse(options.into())
        .and_then(|options| table::Table::parse(options, item))
        .map_or_else(syn::Error::into_compile_error, |table| table.expand())
        .into()
}
