//! `#[derive(Signals)]`.

use proc_macro2::{Span, TokenStream};
use quote::{quote, quote_spanned};
use syn::{
    Data, DataEnum, DeriveInput, Error, Expr, Field, Fields, Result, Type, spanned::Spanned,
};

pub fn derive(input: &DeriveInput) -> Result<TokenStream> {
    match &input.data {
        Data::Struct(s) => bundle(input, &s.fields),
        Data::Enum(e) => enumeration(input, e),
        Data::Union(u) => Err(Error::new_spanned(
            u.union_token,
            "a union has no signals: use a struct with a tag",
        )),
    }
}

fn enumeration(input: &DeriveInput, e: &DataEnum) -> Result<TokenStream> {
    for v in &e.variants {
        if !matches!(v.fields, Fields::Unit) {
            return Err(Error::new_spanned(
                v,
                "a variant with fields has no signals: use a struct with a tag",
            ));
        }
        if let Some((_, value)) = &v.discriminant {
            return Err(Error::new_spanned(
                value,
                "states are numbered from 0 in order: leave the number out",
            ));
        }
    }
    let name = &input.ident;
    let text = name.to_string();
    let variants: Vec<String> = e.variants.iter().map(|v| v.ident.to_string()).collect();
    let last = e.variants.len().max(2) - 1;
    let width = usize::BITS - last.leading_zeros();
    Ok(quote! {
        impl ::pellucid_sim::Signals for #name {
            type Config = ();
            fn declare(_: &(), name: &str, to: &mut dyn ::pellucid_sim::Declare) {
                const STATES: &::pellucid_sim::States =
                    &::pellucid_sim::States { name: #text, variants: &[#(#variants),*] };
                to.signal(name, #width, ::pellucid_sim::Kind::State(STATES));
            }
            fn sample(&self, _: &(), to: &mut Vec<u64>) { to.push(*self as u64); }
            fn check(&self, _: &()) -> Result<(), ::pellucid_sim::Overflow> { Ok(()) }
        }
    })
}

/// One field, with the expression of its configuration and, for an array, of its length.
struct Part<'a> {
    field: &'a Field,
    cfg: TokenStream,
    len: Option<TokenStream>,
}

fn bundle(input: &DeriveInput, fields: &Fields) -> Result<TokenStream> {
    let Fields::Named(named) = fields else {
        return Err(Error::new_spanned(&input.ident, "signals need names: use named fields"));
    };
    let parts: Vec<Part> = named.named.iter().map(part).collect::<Result<_>>()?;
    let needs_cfg = named.named.iter().any(|f| !f.attrs.iter().all(|a| a.path().is_ident("doc")));
    let mut config: Type =
        if needs_cfg { syn::parse_quote!(Config) } else { syn::parse_quote!(()) };
    if let Some(a) = input.attrs.iter().find(|a| a.path().is_ident("signals")) {
        config = a.parse_args()?;
    }
    let declare = parts.iter().map(|p| {
        let (ty, cfg, name) = (element(&p.field.ty), &p.cfg, field_name(p.field));
        match &p.len {
            Some(len) => quote! {
                for k in 0..(#len) as usize {
                    <#ty as ::pellucid_sim::Signals>::declare(#cfg, &format!("{}[{k}]", #name), to);
                }
            },
            None => quote! { <#ty as ::pellucid_sim::Signals>::declare(#cfg, #name, to); },
        }
    });
    let sample = parts.iter().map(|p| {
        let (id, cfg) = (&p.field.ident, &p.cfg);
        match &p.len {
            Some(len) => quote! {
                for x in &self.#id[..(#len) as usize] { ::pellucid_sim::Signals::sample(x, #cfg, to); }
            },
            None => quote! { ::pellucid_sim::Signals::sample(&self.#id, #cfg, to); },
        }
    });
    let check = parts.iter().map(|p| {
        let (id, cfg, name) = (&p.field.ident, &p.cfg, field_name(p.field));
        match &p.len {
            Some(len) => quote! {
                for (k, x) in self.#id[..(#len) as usize].iter().enumerate() {
                    if let Err(e) = ::pellucid_sim::Signals::check(x, #cfg) {
                        return Err(e.within(&format!("{}[{k}]", #name)));
                    }
                }
            },
            None => quote! {
                if let Err(e) = ::pellucid_sim::Signals::check(&self.#id, #cfg) {
                    return Err(e.within(#name));
                }
            },
        }
    });
    let name = &input.ident;
    let (impl_generics, ty_generics, where_clause) = input.generics.split_for_impl();
    Ok(quote! {
        #[allow(unused_variables)]
        impl #impl_generics ::pellucid_sim::Signals for #name #ty_generics #where_clause {
            type Config = #config;
            fn declare(cfg: &#config, name: &str, to: &mut dyn ::pellucid_sim::Declare) {
                to.open(name);
                #(#declare)*
                to.close();
            }
            fn sample(&self, cfg: &#config, to: &mut Vec<u64>) { #(#sample)* }
            fn check(&self, cfg: &#config) -> Result<(), ::pellucid_sim::Overflow> { #(#check)* Ok(()) }
        }
    })
}

fn field_name(field: &Field) -> String {
    field.ident.as_ref().map(ToString::to_string).unwrap_or_default()
}

/// The type of an array's elements, or the type itself.
fn element(ty: &Type) -> &Type {
    match ty {
        Type::Array(a) => &a.elem,
        _ => ty,
    }
}

fn part(field: &Field) -> Result<Part<'_>> {
    let attribute = |name: &str| -> Result<Option<Expr>> {
        field.attrs.iter().find(|a| a.path().is_ident(name)).map(|a| a.parse_args()).transpose()
    };
    let (width, with, len) = (attribute("width")?, attribute("with")?, attribute("len")?);
    let integer = matches!(element(&field.ty), Type::Path(p)
        if ["u8", "u16", "u32", "u64"].iter().any(|t| p.path.is_ident(t)));
    let cfg = match (width, with) {
        (Some(_), Some(_)) => {
            return Err(Error::new(field.span(), "a field has either a width or a configuration"));
        }
        (Some(w), None) => quote_spanned!(w.span()=> &(#w)),
        (None, Some(c)) => quote_spanned!(c.span()=> &(#c)),
        (None, None) if integer => {
            return Err(Error::new(field.span(), "an integer register needs #[width(bits)]"));
        }
        (None, None) => quote!(&()),
    };
    let len = match (&field.ty, len) {
        (Type::Array(_), Some(l)) => Some(quote!(#l)),
        (Type::Array(a), None) => {
            let n = &a.len;
            Some(quote!(#n))
        }
        (_, Some(_)) => return Err(Error::new(Span::call_site(), "#[len] is for arrays")),
        (_, None) => None,
    };
    Ok(Part { field, cfg, len })
}
