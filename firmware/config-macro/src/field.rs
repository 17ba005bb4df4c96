//! A field, and what is said of it.

use proc_macro2::{Literal, Span, TokenStream};
use quote::{format_ident, quote};
use syn::meta::ParseNestedMeta;
use syn::parse::{Parse, ParseStream};
use syn::spanned::Spanned;
use syn::{Attribute, Error, Expr, GenericArgument, Ident, Lit, PathArguments, Result, Token, Type};

/// One field of a table.
pub(crate) struct Field {
    pub(crate) name: Ident,
    pub(crate) ty: Type,
    pub(crate) value: Value,
    /// All attributes but `setting`.
    pub(crate) attributes: Vec<Attribute>,
    pub(crate) default: Option<Otherwise>,
    pub(crate) range: Option<(Number, Number)>,
    pub(crate) key: Option<Expr>,
    pub(crate) hold: Hold,
    pub(crate) access: Option<(Expr, Expr)>,
    pub(crate) quiet: bool,
    pub(crate) place: Place,
}

/// The default of a field.
pub(crate) enum Otherwise {
    /// That of its type.
    OfType,
    Is(Expr),
}

/// Where a field is: in the controller's struct, in the scene's, or in both.
#[derive(Clone, Copy, PartialEq)]
pub(crate) enum Place {
    Both,
    Scene,
    Controller,
}

/// What holds a parameter back over the link.
#[derive(Clone, Copy, PartialEq)]
pub(crate) enum Hold {
    Range,
    Ceiling,
    Scale,
}

/// A number as it is written, which may be negative.
pub(crate) struct Number {
    minus: Option<Token![-]>,
    number: Lit,
}

/// How a field holds its value.
pub(crate) enum Value {
    One(Type),
    Optional(Type),
    /// At most so many.
    Several(Type, TokenStream),
}

impl Field {
    pub(crate) fn parse(field: syn::Field) -> Result<Self> {
        let span = field.span();
        let name = field.ident.ok_or_else(|| Error::new(span, "a setting has a name"))?;
        let (said, attributes) = field.attrs.into_iter().partition::<Vec<_>, _>(|attribute| attribute.path().is_ident("setting"));
        let value = Value::of(&field.ty);
        let mut made = Field {
            default: matches!(value, Value::Optional(_) | Value::Several(..)).then_some(Otherwise::OfType),
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
                    "default" if option.input.peek(Token![=]) => made.default = Some(Otherwise::Is(option.value()?.parse()?)),
                    "default" => made.default = Some(Otherwise::OfType),
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
                    _ => return Err(option.error("no option of a setting")),
                }
                Ok(())
            })?;
        }
        made.range = both(least, most, span, "a range has both ends")?;
        made.access = both(read, write, span, "what is read is written, too")?;
        if made.quiet && !matches!(made.default, Some(Otherwise::OfType)) {
            return Err(Error::new(span, "what is quiet has the default of its type"));
        }
        if made.hold != Hold::Range && made.range.is_none() {
            return Err(Error::new(span, "a limit and a scale factor have a range"));
        }
        Ok(made)
    }

    /// Whether its type or its default names something that must be in scope.
    pub(crate) fn names_something(&self) -> bool {
        const PRIMITIVES: [&str; 6] = ["f32", "f64", "bool", "u8", "u16", "u32"];
        let (Value::One(ty) | Value::Optional(ty) | Value::Several(ty, _)) = &self.value;
        let listed = matches!(&self.value, Value::Several(_, most) if !most.is_empty());
        let default = matches!(&self.default, Some(Otherwise::Is(value)) if !matches!(value, Expr::Lit(_) | Expr::Unary(_)));
        listed || default || !PRIMITIVES.iter().any(|name| is(ty, name))
    }

    /// The name of its constant.
    pub(crate) fn constant(&self) -> Ident {
        format_ident!("{}", self.name.to_string().to_uppercase(), span = self.name.span())
    }

    pub(crate) fn is_in_scene(&self) -> bool {
        self.place != Place::Controller
    }

    pub(crate) fn is_in_controller(&self) -> bool {
        self.place != Place::Scene
    }

    /// Its default, as an expression.
    pub(crate) fn default(&self) -> Option<TokenStream> {
        Some(match self.default.as_ref()? {
            Otherwise::OfType => quote!(::core::default::Default::default()),
            Otherwise::Is(value) => quote!(#value),
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
    /// As it is written: whole numbers stay whole.
    pub(crate) fn as_written(&self) -> TokenStream {
        let Number { minus, number } = self;
        quote!(#minus #number)
    }

    /// As a number of double precision.
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
    fn of(ty: &Type) -> Self {
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

/// Whether a type is the primitive of this name.
pub(crate) fn is(ty: &Type, name: &str) -> bool {
    matches!(ty, Type::Path(path) if path.path.is_ident(name))
}
