//! Table of settings in a scene: in double precision, with its keys.

use proc_macro2::TokenStream;
use quote::{format_ident, quote};
use syn::Type;

use crate::field::{DefaultValue, Field, Place, Value, is};
use crate::table::Table;

impl Table {
    /// Returns the module `scene`, if scenes have this table.
    pub(crate) fn scene(&self) -> Option<TokenStream> {
        let (controller, scene, documentation) = (&self.name, self.options.scene()?, &self.documentation);
        let fields = || self.fields.iter().filter(|field| field.is_in_scene());
        let members = fields().map(member);
        let defaults = fields().filter_map(default);
        let default_of_table = self.default_of_scene();
        let shared = fields().filter(|field| field.place == Place::Both).map(converted);
        let of_controller = || self.fields.iter().filter(|field| field.place == Place::Controller);
        let others = of_controller().map(|Field { name, ty, .. }| quote!(#name: #ty));
        let given = of_controller().map(|field| &field.name);
        let (method, about_method) = match of_controller().count() {
            0 => (quote!(settings), "Returns the settings of the controller."),
            _ => (
                quote!(with),
                "Returns the settings of the controller: those of the scene, and those that only the controller has.",
            ),
        };
        let names = fields().any(Field::names_something).then(|| {
            quote!(
                use super::*;
            )
        });
        let about = format!("Table `{}` of a scene.", self.options.path().collect::<Vec<_>>().join("."));
        Some(quote! {
            #[cfg(feature = "scene")]
            #[doc = #about]
            pub mod scene {
                #names

                #(#documentation)*
                #[derive(Clone, Debug, PartialEq, ::serde::Serialize, ::serde::Deserialize, ::schemars::JsonSchema)]
                #[serde(deny_unknown_fields)]
                pub struct #scene { #(#members)* }

                impl #scene {
                    #[doc = #about_method]
                    pub fn #method(&self #(, #others)*) -> super::#controller {
                        super::#controller { #(#shared)* #(#given,)* }
                    }
                }

                #(#defaults)*
                #default_of_table
            }
        })
    }

    fn default_of_scene(&self) -> Option<TokenStream> {
        let members = self.fields.iter().filter(|field| field.is_in_scene()).map(|field| {
            let (name, default) = (&field.name, field.default()?);
            Some(quote!(#name: #default,))
        });
        let (scene, members) = (self.options.scene(), members.collect::<Option<Vec<_>>>()?);
        Some(quote! {
            impl ::core::default::Default for #scene {
                fn default() -> Self {
                    Self { #(#members)* }
                }
            }
        })
    }
}

/// Returns the type in double precision.
fn double(ty: &Type) -> TokenStream {
    if is(ty, "f32") { quote!(f64) } else { quote!(#ty) }
}

fn is_omitted(field: &Field) -> Option<&'static str> {
    Some(match &field.value {
        Value::Optional(_) => "::core::option::Option::is_none",
        Value::Several(..) => "::std::vec::Vec::is_empty",
        Value::One(_) if field.quiet => "crate::seam::config::is_default",
        Value::One(_) => return None,
    })
}

/// Returns a field with the attributes by which a scene reads, writes and describes it.
fn member(field: &Field) -> TokenStream {
    let Field { name, attributes, .. } = field;
    let documentation = attributes.iter().filter(|attribute| attribute.path().is_ident("doc"));
    let range = field.range.as_ref().map(|(least, most)| {
        let (least, most) = (least.as_written(), most.as_written());
        quote!(range(min = #least, max = #most))
    });
    let (ty, schema) = match &field.value {
        Value::One(ty) => (double(ty), range.map(|range| quote!(#[schemars(#range)]))),
        Value::Optional(ty) => {
            let ty = double(ty);
            (quote!(::core::option::Option<#ty>), range.map(|range| quote!(#[schemars(#range)])))
        }
        Value::Several(ty, most) => {
            let ty = double(ty);
            let length = (!most.is_empty()).then(|| quote!(length(max = #most),));
            let schema = range.map(|range| quote!(#[schemars(#length inner(#range))]));
            (quote!(::std::vec::Vec<#ty>), schema)
        }
    };
    let default = match (&field.value, &field.default) {
        // Serde accepts a missing option without an attribute.
        (Value::Optional(_), _) | (_, None) => None,
        (_, Some(DefaultValue::OfType)) => Some(quote!(#[serde(default)])),
        (_, Some(DefaultValue::Is(_))) => {
            let function = function(field).to_string();
            Some(quote!(#[serde(default = #function)]))
        }
    };
    let quiet = is_omitted(field).map(|function| quote!(#[serde(skip_serializing_if = #function)]));
    quote!(#(#documentation)* #default #quiet #schema pub #name: #ty,)
}

/// Returns the name of the function that returns a default to serde.
fn function(field: &Field) -> syn::Ident {
    format_ident!("default_of_{}", field.name)
}

/// Returns the function that returns a default to serde.
fn default(field: &Field) -> Option<TokenStream> {
    let (Some(DefaultValue::Is(value)), Value::One(ty)) = (&field.default, &field.value) else { return None };
    let (function, ty) = (function(field), double(ty));
    Some(quote!(fn #function() -> #ty { #value }))
}

/// Returns the initializer of the controller's field from that of the scene.
fn converted(field: &Field) -> TokenStream {
    let name = &field.name;
    match &field.value {
        Value::One(ty) if is(ty, "f32") => quote!(#name: self.#name as f32,),
        Value::Optional(ty) if is(ty, "f32") => quote!(#name: self.#name.map(|value| value as f32),),
        Value::Several(ty, _) if is(ty, "f32") => quote!(#name: self.#name.iter().map(|&value| value as f32).collect(),),
        Value::Several(..) => quote!(#name: ::core::iter::Iterator::collect(::core::iter::Iterator::cloned(self.#name.iter())),),
        _ => quote!(#name: ::core::clone::Clone::clone(&self.#name),),
    }
}
