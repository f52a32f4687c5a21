//! What `#[block(...)]` says of a field: it is a child's, and is made as the child makes it.

use proc_macro2::TokenStream;
use quote::quote;
use syn::parse::{Parse, ParseStream};
use syn::spanned::Spanned;
use syn::{DeriveInput, Error, Expr, Field, Fields, Result, Token, Type};

/// `BLOCK`, or `BLOCK, CONFIG` with an expression over `cfg`.
struct Child {
    block: Type,
    cfg: Option<Expr>,
}

impl Parse for Child {
    fn parse(input: ParseStream) -> Result<Child> {
        let block = input.parse()?;
        let cfg = input.parse::<Option<Token![,]>>()?.map(|_| input.parse()).transpose()?;
        Ok(Child { block, cfg })
    }
}

fn child(field: &Field) -> Result<Option<Child>> {
    field.attrs.iter().find(|a| a.path().is_ident("block")).map(|a| a.parse_args()).transpose()
}

/// A function `name` that makes the struct: each child's field by `make` of its block, every other one by its `#[reset]`
/// or as its type's default. Nothing if no field is a child's. `shared` is a field's configuration where `#[block]`
/// names none.
pub fn maker(
    input: &DeriveInput,
    fields: &Fields,
    config: &Type,
    [name, make]: [&str; 2],
    shared: impl Fn(&Field) -> Option<TokenStream>,
) -> Result<TokenStream> {
    let mut values = vec![];
    let mut any = false;
    for field in fields {
        let id = &field.ident;
        let reset = field.attrs.iter().find(|a| a.path().is_ident("reset"));
        let value = match (child(field)?, reset) {
            (Some(_), Some(reset)) => {
                return Err(Error::new(reset.span(), "a child is reset as it says itself"));
            }
            (Some(Child { block, cfg }), None) => {
                any = true;
                let cfg = match cfg {
                    Some(cfg) => quote!(&(#cfg)),
                    None => shared(field).ok_or_else(|| {
                        Error::new(field.span(), "expected #[block(BLOCK, CONFIG)]")
                    })?,
                };
                let make_child = syn::Ident::new(make, field.span());
                let made = quote!(<#block as ::pellucid_sim::Block>::#make_child(#cfg));
                let exists = field.attrs.iter().find(|a| a.path().is_ident("exists"));
                match exists {
                    Some(exists) if make == "memories" => {
                        let exists: Expr = exists.parse_args()?;
                        quote!(::pellucid_sim::Optional::new(#made, #exists))
                    }
                    _ => made,
                }
            }
            (None, Some(reset)) => {
                let value: Expr = reset.parse_args()?;
                quote!(#value)
            }
            (None, None) => quote!(::core::default::Default::default()),
        };
        values.push(quote!(#id: #value));
    }
    if !any {
        return Ok(TokenStream::new());
    }
    let own = &input.ident;
    let (impl_generics, ty_generics, where_clause) = input.generics.split_for_impl();
    let name = syn::Ident::new(name, own.span());
    Ok(quote! {
        #[allow(unused_variables)]
        impl #impl_generics #own #ty_generics #where_clause {
            /// Made of what the children make.
            pub fn #name(cfg: &#config) -> Self {
                Self { #(#values,)* }
            }
        }
    })
}
