//! Fields of a table that a host may set over the link.

use proc_macro2::TokenStream;
use quote::{format_ident, quote};

use crate::field::{Field, Hold, Value};
use crate::table::Table;

impl Table {
    /// Returns the constant `PARAMETERS`, if the table has any.
    pub(crate) fn parameters(&self) -> Option<TokenStream> {
        let entries: Vec<_> = self.fields.iter().filter_map(|field| self.parameter(field)).collect();
        let (name, documentation) = (&self.name, "Settings of this table that a host may set.");
        (!entries.is_empty()).then(|| {
            quote! {
                impl #name {
                    #[doc = #documentation]
                    pub(crate) const PARAMETERS: &'static [crate::seam::config::Parameter] = &[#(#entries),*];
                }
            }
        })
    }

    fn parameter(&self, field: &Field) -> Option<TokenStream> {
        let (key, constant) = (field.key.as_ref()?, field.constant());
        let is_choice = field.range.is_none();
        let (ty, path) = (&field.ty, self.path(field));
        let range = match field.hold {
            _ if is_choice => quote!(crate::seam::config::Range::Choice(<#ty as crate::seam::config::Choice>::NAMES)),
            Hold::Range => quote!(Self::#constant.range()),
            Hold::Ceiling => quote!(Self::#constant.up_to_ceiling()),
            Hold::Scale => quote!(Self::#constant.scale()),
        };
        let tables = self.options.path().map(|table| format_ident!("{table}"));
        let name = &field.name;
        let place = quote!(config #(.#tables)* .#name);
        let optional = quote!(<Self as crate::seam::config::Optional>);
        let (read, write) = match (&field.access, &field.value) {
            (Some((read, write)), _) => (quote!(#read), quote!(#write)),
            // If the configuration omits the table, its defaults are read, and nothing is written.
            (None, _) if self.options.optional => {
                let table = quote!(#optional::of(config).unwrap_or(&#optional::DEFAULT).#name);
                let (value, from) = match is_choice {
                    true => (quote!(crate::seam::config::Choice::place(#table)), quote!(crate::seam::config::Choice::at(value))),
                    false => (table, quote!(value)),
                };
                (
                    quote!(|config| #value),
                    quote!(|config, value| if let Some(table) = #optional::of_mut(config) { table.#name = #from }),
                )
            }
            (None, Value::Optional(_)) => (
                quote!(|config| #place.unwrap_or(f32::INFINITY)),
                quote!(|config, value| #place = value.is_finite().then_some(value)),
            ),
            (None, _) if is_choice => (
                quote!(|config| crate::seam::config::Choice::place(#place)),
                quote!(|config, value| #place = crate::seam::config::Choice::at(value)),
            ),
            (None, _) => (quote!(|config| #place), quote!(|config, value| #place = value)),
        };
        Some(quote! {
            crate::seam::config::Parameter {
                key: #key,
                name: #path,
                range: #range,
                read: #read,
                write: #write,
            }
        })
    }
}
