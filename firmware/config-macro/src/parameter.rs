//! The fields of a table that a host may set over the link.

use proc_macro2::TokenStream;
use quote::{format_ident, quote};

use crate::field::{Field, Hold, Value};
use crate::table::Table;

impl Table {
    /// `PARAMETERS`, if the table has any.
    pub(crate) fn parameters(&self) -> Option<TokenStream> {
        let entries: Vec<_> = self.fields.iter().filter_map(|field| self.parameter(field)).collect();
        let (name, documentation) = (&self.name, "The settings of this table that a host may set.");
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
        let range = match field.hold {
            Hold::Range => quote!(Self::#constant.range()),
            Hold::Ceiling => quote!(Self::#constant.up_to_built_in()),
            Hold::Near => quote!(crate::seam::config::Range::NearBuiltIn),
        };
        let tables = self.options.path().map(|table| format_ident!("{table}"));
        let name = &field.name;
        let place = quote!(config #(.#tables)* .#name);
        let (read, write) = match (&field.access, &field.value) {
            (Some((read, write)), _) => (quote!(#read), quote!(#write)),
            (None, Value::Optional(_)) => (
                quote!(|config| #place.unwrap_or(f32::INFINITY)),
                quote!(|config, value| #place = value.is_finite().then_some(value)),
            ),
            (None, _) => (quote!(|config| #place), quote!(|config, value| #place = value)),
        };
        Some(quote! {
            crate::seam::config::Parameter {
                key: #key,
                name: Self::#constant.name,
                range: #range,
                read: #read,
                write: #write,
            }
        })
    }
}
