//! Table of settings in the controller.

use proc_macro2::TokenStream;
use quote::quote;
use syn::parse::Parser;
use syn::{Attribute, Data, DeriveInput, Error, Ident, LitStr, Result, Visibility};

use crate::field::{DefaultValue, Field, Value, is};

/// Options of a table.
#[derive(Default)]
pub(crate) struct Options {
    /// Path of the table in the configuration.
    path: String,
    /// Name of the table in a scene, if scenes have it.
    scene: Option<Ident>,
    /// `true` if the table has a constructor that takes its required values.
    new: bool,
    /// `true` if a configuration may omit the table.
    pub(crate) optional: bool,
}

/// Table of settings.
pub(crate) struct Table {
    pub(crate) options: Options,
    pub(crate) name: Ident,
    pub(crate) documentation: Vec<Attribute>,
    pub(crate) fields: Vec<Field>,
    visibility: Visibility,
    attributes: Vec<Attribute>,
}

impl Options {
    pub(crate) fn parse(tokens: TokenStream) -> Result<Self> {
        let mut options = Options::default();
        let parser = syn::meta::parser(|option| {
            match option.path.get_ident().map(Ident::to_string).as_deref() {
                Some("table") => options.path = option.value()?.parse::<LitStr>()?.value(),
                Some("scene") => options.scene = Some(option.value()?.parse()?),
                Some("new") => options.new = true,
                Some("optional") => options.optional = true,
                _ => return Err(option.error("unknown option of a table of settings")),
            }
            Ok(())
        });
        parser.parse2(tokens)?;
        Ok(options)
    }

    /// Returns the name of the table in a scene, if scenes have it.
    pub(crate) fn scene(&self) -> Option<&Ident> {
        self.scene.as_ref()
    }

    /// Returns the names of the tables along the path.
    pub(crate) fn path(&self) -> impl Iterator<Item = &str> {
        self.path.split('.').filter(|name| !name.is_empty())
    }
}

impl Table {
    pub(crate) fn parse(options: Options, item: DeriveInput) -> Result<Self> {
        let Data::Struct(data) = item.data else {
            return Err(Error::new(item.ident.span(), "a table of settings must be a struct"));
        };
        let fields = data.fields.into_iter().map(Field::parse).collect::<Result<_>>()?;
        let documentation = item.attrs.iter().filter(|attribute| attribute.path().is_ident("doc")).cloned().collect();
        Ok(Table { options, name: item.ident, documentation, fields, visibility: item.vis, attributes: item.attrs })
    }

    /// Returns the path of a field in the configuration.
    pub(crate) fn path(&self, field: &Field) -> String {
        let name = field.name.to_string();
        self.options.path().chain([name.as_str()]).collect::<Vec<_>>().join(".")
    }

    pub(crate) fn expand(&self) -> TokenStream {
        let Table { name, visibility, attributes, .. } = self;
        // A table outside of scenes has its own schema.
        let alone = self.options.scene().is_none();
        let in_controller = || self.fields.iter().filter(|field| field.is_in_controller());
        let members = in_controller().map(|field| {
            let Field { name, ty, attributes, .. } = field;
            let range = field.range.as_ref().filter(|_| alone).map(|(least, most)| {
                let (least, most) = (least.as_written(), most.as_written());
                quote!(#[cfg_attr(feature = "scene", schemars(range(min = #least, max = #most)))])
            });
            let default = match (&field.default, &field.value) {
                (Some(DefaultValue::Is(value)), Value::One(_)) if alone => {
                    Some(quote!(#[cfg_attr(feature = "scene", schemars(extend("default" = #value)))]))
                }
                _ => None,
            };
            quote!(#(#attributes)* #range #default pub #name: #ty,)
        });
        let schema = alone.then(|| quote!(#[cfg_attr(feature = "scene", derive(::schemars::JsonSchema))]));
        let constants = self.fields.iter().filter_map(|field| {
            let (least, most) = field.range.as_ref()?;
            let (constant, path, least, most) = (field.constant(), self.path(field), least.double(), most.double());
            let documentation = format!("Name and range of `{path}`.");
            Some(quote! {
                #[doc = #documentation]
                pub const #constant: crate::seam::config::Setting =
                    crate::seam::config::Setting { name: #path, min: #least, max: #most };
            })
        });
        let checks = in_controller().filter(|field| field.range.is_some()).map(check);
        let default = self.default();
        let new = self.options.new.then(|| self.constructor());
        let parameters = self.parameters();
        let scene = self.scene();
        quote! {
            #(#attributes)*
            #schema
            #visibility struct #name { #(#members)* }

            impl #name {
                #(#constants)*

                #new

                /// Checks that every value is within its range. The error names the first that is
                /// not.
                pub(crate) fn check(&self) -> ::core::result::Result<(), crate::seam::error::Error> {
                    #(#checks)*
                    ::core::result::Result::Ok(())
                }
            }

            #default
            #parameters
            #scene
        }
    }

    /// Returns the implementation of `Default`, if no value is required.
    fn default(&self) -> Option<TokenStream> {
        let members = self.fields.iter().filter(|field| field.is_in_controller()).map(|field| {
            let (name, default) = (&field.name, field.default()?);
            Some(quote!(#name: #default,))
        });
        let (name, members) = (&self.name, members.collect::<Option<Vec<_>>>()?);
        Some(quote! {
            impl ::core::default::Default for #name {
                fn default() -> Self {
                    Self { #(#members)* }
                }
            }
        })
    }

    /// Returns a constructor that takes the required values, in the order of the fields.
    fn constructor(&self) -> TokenStream {
        let fields = || self.fields.iter().filter(|field| field.is_in_controller());
        let given = fields().filter(|field| field.default.is_none()).map(|Field { name, ty, .. }| quote!(#name: #ty));
        let members = fields().map(|field| {
            let name = &field.name;
            field.default().map_or_else(|| quote!(#name,), |default| quote!(#name: #default,))
        });
        quote! {
            /// Creates the table from its required values, with the defaults of all others.
            pub fn new(#(#given),*) -> Self {
                Self { #(#members)* }
            }
        }
    }
}

/// Returns the check of a field that has a range.
fn check(field: &Field) -> TokenStream {
    let (name, constant) = (&field.name, field.constant());
    let checked = |ty: &syn::Type, value: TokenStream| match ty {
        ty if is(ty, "f64") => quote!(Self::#constant.check_double(#value)?;),
        ty if is(ty, "f32") => quote!(Self::#constant.check(#value)?;),
        _ => quote!(Self::#constant.check(f32::from(#value))?;),
    };
    match &field.value {
        Value::One(ty) => checked(ty, quote!(self.#name)),
        Value::Optional(ty) => {
            let check = checked(ty, quote!(value));
            quote!(if let ::core::option::Option::Some(value) = self.#name { #check })
        }
        Value::Several(ty, _) => {
            let check = checked(ty, quote!(value));
            quote!(for &value in &self.#name { #check })
        }
    }
}
