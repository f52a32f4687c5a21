//! `#[derive(Signals)]`.

use crate::children;
use proc_macro2::{Span, TokenStream};
use quote::{quote, quote_spanned};
use syn::punctuated::Punctuated;
use syn::{
    Data, DataEnum, DeriveInput, Error, Expr, Field, Fields, Result, Token, Type, spanned::Spanned,
};

pub fn derive(input: &DeriveInput) -> Result<TokenStream> {
    match &input.data {
        Data::Struct(s) => bundle(input, &s.fields, false),
        Data::Enum(e) => enumeration(input, e),
        Data::Union(u) => Err(Error::new_spanned(
            u.union_token,
            "a union has no signals: use a struct with a tag",
        )),
    }
}

pub fn registers(input: &DeriveInput) -> Result<TokenStream> {
    match &input.data {
        Data::Struct(s) => bundle(input, &s.fields, true),
        _ => Err(Error::new_spanned(&input.ident, "#[derive(Registers)] is for a struct")),
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
    let idents: Vec<_> = e.variants.iter().map(|v| &v.ident).collect();
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
            fn sample(&self, _: &(), to: &mut impl ::pellucid_sim::Sink) { to.push(*self as u64); }
            #[inline(always)]
            fn fits(&self, _: &()) -> bool { true }
            fn seek(&self, _: &(), _: &str, _: &mut ::pellucid_sim::signals::Misfit) {}
            fn restore(_: &(), from: &mut dyn Iterator<Item = u64>) -> Self {
                let all = [#(#name::#idents),*];
                all[from.next().unwrap_or_default() as usize % all.len()]
            }
        }
        impl ::pellucid_sim::netlist::Lift for #name {
            fn lift(self) -> ::pellucid_sim::netlist::Value {
                ::pellucid_sim::netlist::Value::state::<Self>(self as u64)
            }
        }
    })
}

/// One field, with the expression of its configuration (over `cfg` and, for an array, the element's number `k`) and,
/// for an array, of its length.
struct Part<'a> {
    field: &'a Field,
    cfg: TokenStream,
    len: Option<TokenStream>,
    /// Only some elements exist.
    partly: bool,
    /// Where it exists, if not everywhere.
    exists: Option<Expr>,
}

impl Part<'_> {
    fn is_line(&self) -> bool {
        line(&self.field.ty).is_some()
    }

    /// What is done with the field, where it exists.
    fn where_it_exists(&self, done: TokenStream) -> TokenStream {
        match &self.exists {
            Some(exists) => quote! { if #exists { #done } },
            None => done,
        }
    }
}

/// The implementation of `Signals`, or of `Registers` for a struct that may hold lines.
fn bundle(input: &DeriveInput, fields: &Fields, lines: bool) -> Result<TokenStream> {
    let bundle =
        if lines { quote!(::pellucid_sim::Registers) } else { quote!(::pellucid_sim::Signals) };
    let Fields::Named(named) = fields else {
        return Err(Error::new_spanned(&input.ident, "signals need names: use named fields"));
    };
    let unseen = |f: &Field| f.attrs.iter().any(|a| a.path().is_ident("unseen"));
    let parts: Vec<Part> =
        named.named.iter().filter(|f| !unseen(f)).map(part).collect::<Result<_>>()?;
    let hidden: Vec<_> = named.named.iter().filter(|f| unseen(f)).map(|f| &f.ident).collect();
    let plain = |a: &syn::Attribute| ["doc", "reset"].iter().any(|name| a.path().is_ident(name));
    let needs_cfg = parts.iter().any(|p| !p.field.attrs.iter().all(plain));
    let mut config: Type =
        if needs_cfg { syn::parse_quote!(Config) } else { syn::parse_quote!(()) };
    if let Some(a) = input.attrs.iter().find(|a| a.path().is_ident("signals")) {
        config = a.parse_args()?;
    }
    let declare = parts.iter().map(|p| {
        let (ty, cfg, name) = (element(&p.field.ty), &p.cfg, field_name(p.field));
        p.where_it_exists(match &p.len {
            Some(len) => quote! {
                for k in 0..(#len) as usize {
                    <#ty as #bundle>::declare(#cfg, &format!("{}[{k}]", #name), to);
                }
            },
            None => quote! { <#ty as #bundle>::declare(#cfg, #name, to); },
        })
    });
    let sample = parts.iter().map(|p| {
        let (id, cfg) = (&p.field.ident, &p.cfg);
        p.where_it_exists(match &p.len {
            Some(len) => quote! {
                for (k, x) in self.#id[..(#len) as usize].iter().enumerate() {
                    #bundle::sample(x, #cfg, to);
                }
            },
            None => quote! { #bundle::sample(&self.#id, #cfg, to); },
        })
    });
    let fits = parts.iter().map(|p| {
        let (id, cfg) = (&p.field.ident, &p.cfg);
        p.where_it_exists(match &p.len {
            Some(len) => quote! {
                let len = (#len) as usize;
                for (k, x) in self.#id[..len].iter().enumerate() {
                    fits &= #bundle::fits(x, #cfg);
                }
            },
            None => quote! { fits &= #bundle::fits(&self.#id, #cfg); },
        })
    });
    let seek = parts.iter().map(|p| {
        let (id, cfg, name) = (&p.field.ident, &p.cfg, field_name(p.field));
        p.where_it_exists(match &p.len {
            Some(len) => quote! {
                for (k, x) in self.#id[..(#len) as usize].iter().enumerate() {
                    #bundle::seek(x, #cfg, &format!("{}[{k}]", #name), to);
                }
            },
            None => quote! { #bundle::seek(&self.#id, #cfg, #name, to); },
        })
    });
    let restore = parts.iter().map(|p| {
        let (id, ty, cfg) = (&p.field.ident, element(&p.field.ty), &p.cfg);
        let one = quote! { <#ty as #bundle>::restore(#cfg, from) };
        let absent = quote! {
            <#ty as #bundle>::restore(#cfg, &mut ::core::iter::empty())
        };
        match &p.len {
            Some(len) if p.is_line() => {
                quote! { #id: (0..(#len) as usize).map(|k| #one).collect() }
            }
            Some(len) if p.partly => quote! {
                #id: ::core::array::from_fn(|k| if k < (#len) as usize { #one } else { #absent })
            },
            Some(_) => quote! { #id: ::core::array::from_fn(|k| #one) },
            None => match &p.exists {
                Some(exists) => quote! { #id: if #exists { #one } else { #absent } },
                None => quote! { #id: #one },
            },
        }
    });
    let lift = parts.iter().map(|p| {
        let (id, name) = (&p.field.ident, field_name(p.field));
        quote! { (#name, ::pellucid_sim::netlist::Lift::lift(self.#id)) }
    });
    let name = &input.ident;
    // A field of a type that is a parameter must have signals itself.
    let mut generics = input.generics.clone();
    let parameters: Vec<_> = input.generics.type_params().map(|p| p.ident.clone()).collect();
    for part in &parts {
        let ty = element(&part.field.ty);
        if matches!(ty, Type::Path(p) if parameters.iter().any(|id| p.path.is_ident(id))) {
            generics.make_where_clause().predicates.push(syn::parse_quote!(#ty: #bundle));
        }
    }
    let (impl_generics, ty_generics, where_clause) = generics.split_for_impl();
    let shown = quote! {
        type Config = #config;
        fn declare(cfg: &#config, name: &str, to: &mut dyn ::pellucid_sim::Declare) {
            to.open(name);
            #(#declare)*
            to.close();
        }
        fn sample(&self, cfg: &#config, to: &mut impl ::pellucid_sim::Sink) { #(#sample)* }
        fn fits(&self, cfg: &#config) -> bool {
            let mut fits = true;
            #(#fits)*
            fits
        }
        fn seek(&self, cfg: &#config, name: &str, to: &mut ::pellucid_sim::signals::Misfit) {
            to.group(name, &mut |to| { #(#seek)* });
        }
        fn restore(cfg: &#config, from: &mut dyn Iterator<Item = u64>) -> Self {
            #name { #(#restore,)* #(#hidden: Default::default(),)* }
        }
    };
    let config_of =
        |field: &Field| parts.iter().find(|p| p.field.ident == field.ident).map(|p| p.cfg.clone());
    let reset = children::maker(input, fields, &config, ["reset", "reset"], config_of)?;
    // What is small is taken as a whole: that costs less than to ask what of it exists.
    let is_child = |p: &Part| p.field.attrs.iter().any(|a| a.path().is_ident("block"));
    let apart = lines || parts.iter().any(|p| p.partly || p.exists.is_some() || is_child(p));
    let follow = apart.then(|| {
        let follow = parts.iter().map(|p| {
            let (id, cfg) = (&p.field.ident, &p.cfg);
            p.where_it_exists(match &p.len {
                Some(len) => quote! {
                    let len = (#len) as usize;
                    for (k, (own, from)) in self.#id[..len].iter_mut().zip(&from.#id[..len]).enumerate() {
                        #bundle::follow(own, #cfg, from);
                    }
                },
                None => quote! { #bundle::follow(&mut self.#id, #cfg, &from.#id); },
            })
        });
        let whole = (!lines).then(|| quote! {
            if size_of::<Self>() <= ::pellucid_sim::signals::TAKEN_WHOLE {
                *self = *from;
                return;
            }
        });
        quote! {
            #[inline(always)]
            fn follow(&mut self, cfg: &#config, from: &Self) {
                #whole
                #(#follow)*
                #(self.#hidden = from.#hidden.clone();)*
            }
        }
    });
    if lines {
        return Ok(quote! {
            #[allow(unused_variables)]
            impl #impl_generics #bundle for #name #ty_generics #where_clause {
                #shown
                #follow
            }
            #reset
        });
    }
    Ok(quote! {
        impl #impl_generics ::pellucid_sim::netlist::Lift for #name #ty_generics #where_clause {
            fn lift(self) -> ::pellucid_sim::netlist::Value {
                ::pellucid_sim::netlist::Value::record(&[#(#lift),*])
            }
        }
        #[allow(unused_variables)]
        impl #impl_generics #bundle for #name #ty_generics #where_clause {
            #shown
            #follow
        }
        #reset
    })
}

fn field_name(field: &Field) -> String {
    field.ident.as_ref().map(ToString::to_string).unwrap_or_default()
}

/// The type of the elements of an array or of a line, or the type itself.
fn element(ty: &Type) -> &Type {
    match ty {
        Type::Array(a) => &a.elem,
        _ => line(ty).unwrap_or(ty),
    }
}

/// The type of the elements of a line, `Vec<T>`.
fn line(ty: &Type) -> Option<&Type> {
    let Type::Path(path) = ty else { return None };
    let last = path.path.segments.last().filter(|segment| segment.ident == "Vec")?;
    let syn::PathArguments::AngleBracketed(arguments) = &last.arguments else { return None };
    match arguments.args.first() {
        Some(syn::GenericArgument::Type(ty)) => Some(ty),
        _ => None,
    }
}

fn part(field: &Field) -> Result<Part<'_>> {
    let attribute = |name: &str| -> Result<Option<Expr>> {
        field.attrs.iter().find(|a| a.path().is_ident(name)).map(|a| a.parse_args()).transpose()
    };
    let (width, len, exists) = (attribute("width")?, attribute("len")?, attribute("exists")?);
    let with: Option<Punctuated<Expr, Token![,]>> = field
        .attrs
        .iter()
        .find(|a| a.path().is_ident("with"))
        .map(|a| a.parse_args_with(Punctuated::parse_terminated))
        .transpose()?;
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
    let partly = len.is_some();
    let len = match (&field.ty, len) {
        (Type::Array(_), Some(l)) => Some(quote!(#l)),
        (ty, Some(l)) if line(ty).is_some() => Some(quote!(#l)),
        (ty, None) if line(ty).is_some() => {
            return Err(Error::new(field.span(), "a line of registers needs #[len(count)]"));
        }
        (Type::Array(a), None) => {
            let n = &a.len;
            Some(quote!(#n))
        }
        (_, Some(_)) => return Err(Error::new(Span::call_site(), "#[len] is for arrays")),
        (_, None) => None,
    };
    if len.is_some() && exists.is_some() {
        return Err(Error::new(field.span(), "an array exists as far as its #[len] says"));
    }
    Ok(Part { field, cfg, len, partly, exists })
}
