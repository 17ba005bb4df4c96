//! A table of settings, as the controller has it.

use proc_macro2::TokenStream;
use quote::quote;
use syn::parse::Parser;
use syn::{Attribute, Data, DeriveInput, Error, Ident, LitStr, Result, Visibility};

use crate::field::{Field, Otherwise, Value, is};

/// What is said of a table.
#[derive(Default)]
pub(crate) struct Options {
    /// Its place in the configuration.
    path: String,
    /// Its name in a scene, if it is there.
    scene: Option<Ident>,
    /// There is a constructor of what must be given.
    new: bool,
    /// A configuration may be without it.
    pub(crate) optional: bool,
}

/// A table of settings.
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
                _ => return Err(option.error("no option of a table of settings")),
            }
            Ok(())
        });
        parser.parse2(tokens)?;
        Ok(options)
    }

    /// Its name in a scene, if it is there.
    pub(crate) fn scene(&self) -> Option<&Ident> {
        self.scene.as_ref()
    }

    /// The tables on the way to it.
    pub(crate) fn path(&self) -> impl Iterator<Item = &str> {
        self.path.split('.').filter(|name| !name.is_empty())
    }
}

impl Table {
    pub(crate) fn parse(options: Options, item: DeriveInput) -> Result<Self> {
        let Data::Struct(data) = item.data else {
            return Err(Error::new(item.ident.span(), "a table of settings is a struct"));
        };
        let fields = data.fields.into_iter().map(Field::parse).collect::<Result<_>>()?;
        let documentation = item.attrs.iter().filter(|attribute| attribute.path().is_ident("doc")).cloned().collect();
        Ok(Table { options, name: item.ident, documentation, fields, visibility: item.vis, attributes: item.attrs })
    }

    /// The path of a field in the configuration.
    pub(crate) fn path(&self, field: &Field) -> String {
        let name = field.name.to_string();
        self.options.path().chain([name.as_str()]).collect::<Vec<_>>().join(".")
    }

    pub(crate) fn expand(&self) -> TokenStream {
        let Table { name, visibility, attributes, .. } = self;
        // A table that no scene has describes itself.
        let alone = self.options.scene().is_none();
        let in_controller = || self.fields.iter().filter(|field| field.is_in_controller());
        let members = in_controller().map(|field| {
            let Field { name, ty, attributes, .. } = field;
            let range = field.range.as_ref().filter(|_| alone).map(|(least, most)| {
                let (least, most) = (least.as_written(), most.as_written());
                quote!(#[cfg_attr(feature = "scene", schemars(range(min = #least, max = #most)))])
            });
            let default = match (&field.default, &field.value) {
                (Some(Otherwise::Is(value)), Value::One(_)) if alone => {
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
                pub const #constant: crate::seam::config::Setting = crate::seam::config::Setting { name: #path, min: #least, max: #most };
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

                /// Whether every value is within its range; names the first that is not.
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

    /// `Default`, if nothing must be given.
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

    /// A constructor of what must be given, in the order of the fields.
    fn constructor(&self) -> TokenStream {
        let fields = || self.fields.iter().filter(|field| field.is_in_controller());
        let given = fields().filter(|field| field.default.is_none()).map(|Field { name, ty, .. }| quote!(#name: #ty));
        let members = fields().map(|field| {
            let name = &field.name;
            field.default().map_or_else(|| quote!(#name,), |default| quote!(#name: #default,))
        });
        quote! {
            /// What must be given, and the defaults of everything else.
            pub fn new(#(#given),*) -> Self {
                Self { #(#members)* }
            }
        }
    }
}

/// The check of one field that has a range.
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
