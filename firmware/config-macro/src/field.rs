//! Field of a table of settings, with its options.

use proc_macro2::{Literal, Span, TokenStream};
use quote::{format_ident, quote};
use syn::meta::ParseNestedMeta;
use syn::parse::{Parse, ParseStream};
use syn::spanned::Spanned;
use syn::{Attribute, Error, Expr, GenericArgument, Ident, Lit, PathArguments, Result, Token, Type};

/// Field of a table.
pub(crate) struct Field {
    pub(crate) name: Ident,
    pub(crate) ty: Type,
    pub(crate) value: Value,
    /// All attributes except `setting`.
    pub(crate) attributes: Vec<Attribute>,
    pub(crate) default: Option<DefaultValue>,
    pub(crate) range: Option<(Number, Number)>,
    pub(crate) key: Option<Expr>,
    pub(crate) hold: Hold,
    pub(crate) access: Option<(Expr, Expr)>,
    pub(crate) quiet: bool,
    pub(crate) place: Place,
}

/// Default of a field.
pub(crate) enum DefaultValue {
    /// Default of its type.
    OfType,
    /// Value of this expression.
    Is(Expr),
}

/// Location of a field: the controller's struct, the scene's, or both.
#[derive(Clone, Copy, PartialEq)]
pub(crate) enum Place {
    Both,
    Scene,
    Controller,
}

/// Limit of a parameter that is set over the link.
#[derive(Clone, Copy, PartialEq)]
pub(crate) enum Hold {
    Range,
    Ceiling,
    Scale,
}

/// Number as written, which may be negative.
pub(crate) struct Number {
    minus: Option<Token![-]>,
    number: Lit,
}

/// Kind of the value of a field.
pub(crate) enum Value {
    One(Type),
    Optional(Type),
    /// List, with its largest length if there is one.
    Several(Type, TokenStream),
}

impl Field {
    pub(crate) fn parse(field: syn::Field) -> Result<Self> {
        let span = field.span();
        let name = field.ident.ok_or_else(|| Error::new(span, "a setting must have a name"))?;
        let (said, attributes) = field.attrs.into_iter().partition::<Vec<_>, _>(|attribute| attribute.path().is_ident("setting"));
        let value = Value::from_type(&field.ty);
        let mut made = Field {
            default: matches!(value, Value::Optional(_) | Value::Several(..)).then_some(DefaultValue::OfType),
            name,
            ty: field.ty,
            value,
            attributes,
            range: None,
            key: None,
            hold: Hold::Range,
            access: None,
            quiet: false,
            place: Place::Both,
        };
        let (mut least, mut most, mut read, mut write) = (None, None, None, None);
        for said in said {
            said.parse_nested_meta(|option| {
                let name = option.path.get_ident().map(Ident::to_string).unwrap_or_default();
                match name.as_str() {
                    "default" if option.input.peek(Token![=]) => made.default = Some(DefaultValue::Is(option.value()?.parse()?)),
                    "default" => made.default = Some(DefaultValue::OfType),
                    "min" => least = Some(number(&option)?),
                    "max" => most = Some(number(&option)?),
                    "key" => made.key = Some(option.value()?.parse()?),
                    "ceiling" => made.hold = Hold::Ceiling,
                    "scale" => made.hold = Hold::Scale,
                    "read" => read = Some(option.value()?.parse()?),
                    "write" => write = Some(option.value()?.parse()?),
                    "quiet" => made.quiet = true,
                    "scene" => made.place = Place::Scene,
                    "controller" => made.place = Place::Controller,
                    _ => return Err(option.error("unknown option of a setting")),
                }
                Ok(())
            })?;
        }
        made.range = both(least, most, span, "`min` and `max` must be given together")?;
        made.access = both(read, write, span, "`read` and `write` must be given together")?;
        if made.quiet && !matches!(made.default, Some(DefaultValue::OfType)) {
            return Err(Error::new(span, "`quiet` requires the option `default` without a value"));
        }
        if made.hold != Hold::Range && made.range.is_none() {
            return Err(Error::new(span, "`ceiling` and `scale` require a range"));
        }
        Ok(made)
    }

    /// Returns `true` if the type or the default names an item that must be in scope.
    pub(crate) fn names_something(&self) -> bool {
        const PRIMITIVES: [&str; 6] = ["f32", "f64", "bool", "u8", "u16", "u32"];
        let (Value::One(ty) | Value::Optional(ty) | Value::Several(ty, _)) = &self.value;
        let listed = matches!(&self.value, Value::Several(_, most) if !most.is_empty());
        let default = matches!(&self.default, Some(DefaultValue::Is(value)) if !matches!(value, Expr::Lit(_) | Expr::Unary(_)));
        listed || default || !PRIMITIVES.iter().any(|name| is(ty, name))
    }

    /// Returns the name of the constant of this field.
    pub(crate) fn constant(&self) -> Ident {
        format_ident!("{}", self.name.to_string().to_uppercase(), span = self.name.span())
    }

    pub(crate) fn is_in_scene(&self) -> bool {
        self.place != Place::Controller
    }

    pub(crate) fn is_in_controller(&self) -> bool {
        self.place != Place::Scene
    }

    /// Returns the default as an expression.
    pub(crate) fn default(&self) -> Option<TokenStream> {
        Some(match self.default.as_ref()? {
            DefaultValue::OfType => quote!(::core::default::Default::default()),
            DefaultValue::Is(value) => quote!(#value),
        })
    }
}

fn number(option: &ParseNestedMeta<'_>) -> Result<Number> {
    option.value()?.parse()
}

fn both<T>(one: Option<T>, other: Option<T>, span: Span, otherwise: &str) -> Result<Option<(T, T)>> {
    match (one, other) {
        (Some(one), Some(other)) => Ok(Some((one, other))),
        (None, None) => Ok(None),
        _ => Err(Error::new(span, otherwise)),
    }
}

impl Parse for Number {
    fn parse(input: ParseStream<'_>) -> Result<Self> {
        Ok(Number { minus: input.parse()?, number: input.parse()? })
    }
}

impl Number {
    /// Returns the number as written: whole numbers stay whole.
    pub(crate) fn as_written(&self) -> TokenStream {
        let Number { minus, number } = self;
        quote!(#minus #number)
    }

    /// Returns the number in double precision.
    pub(crate) fn double(&self) -> TokenStream {
        let Number { minus, number } = self;
        match number {
            Lit::Int(whole) => {
                let number = Lit::new(Literal::f64_suffixed(whole.base10_parse().unwrap_or(f64::NAN)));
                quote!(#minus #number)
            }
            number => quote!(#minus #number),
        }
    }
}

impl Value {
    fn from_type(ty: &Type) -> Self {
        let one = || Value::One(ty.clone());
        let Type::Path(path) = ty else { return one() };
        let Some(last) = path.path.segments.last() else { return one() };
        let PathArguments::AngleBracketed(arguments) = &last.arguments else { return one() };
        match (last.ident.to_string().as_str(), arguments.args.first(), arguments.args.get(1)) {
            ("Option", Some(GenericArgument::Type(inner)), None) => Value::Optional(inner.clone()),
            ("Vec", Some(GenericArgument::Type(inner)), Some(most)) => Value::Several(inner.clone(), quote!(#most)),
            ("Vec", Some(GenericArgument::Type(inner)), None) => Value::Several(inner.clone(), TokenStream::new()),
            _ => one(),
        }
    }
}

/// Returns `true` if a type is the primitive of this name.
pub(crate) fn is(ty: &Type, name: &str) -> bool {
    matches!(ty, Type::Path(path) if path.path.is_ident(name))
}
