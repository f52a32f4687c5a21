//! The twins of an `impl Block`: an `impl Netlist`.

use super::body::Body;
use super::lenient;
use proc_macro2::{Span, TokenStream};
use quote::{format_ident, quote};
use syn::parse::{Parse, ParseStream};
use syn::{Error, Expr, FnArg, Ident, ImplItem, ImplItemFn, ItemImpl, LitStr, Result, Token, Type};

/// What stands in the brackets of `#[rtl(...)]`.
#[derive(Default)]
pub struct Options {
    name: Option<LitStr>,
    configs: Vec<(Ident, Expr)>,
    checks: Vec<(Type, Expr)>,
}

impl Parse for Options {
    fn parse(input: ParseStream) -> Result<Options> {
        let mut options = Options::default();
        while !input.is_empty() {
            let key: Ident = input.parse()?;
            match key.to_string().as_str() {
                "name" => {
                    input.parse::<Token![=]>()?;
                    options.name = Some(input.parse()?);
                }
                "state" | "input" | "moore" | "output" => {
                    input.parse::<Token![=]>()?;
                    options.configs.push((key, input.parse()?));
                }
                "check" => {
                    let inner;
                    syn::parenthesized!(inner in input);
                    let ty = inner.parse()?;
                    inner.parse::<Token![,]>()?;
                    options.checks.push((ty, inner.parse()?));
                }
                _ => {
                    return Err(Error::new_spanned(
                        key,
                        "expected `name = \"...\"`, `check(TYPE, CONFIG)`, or one of `state`, \
                         `input`, `moore` and `output` with the configuration of that bundle",
                    ));
                }
            }
            if !input.is_empty() {
                input.parse::<Token![,]>()?;
            }
        }
        Ok(options)
    }
}

impl Options {
    /// The configuration of one of the block's bundles, as an expression over `cfg`.
    fn config(&self, bundle: &str, ty: &Type) -> TokenStream {
        match self.configs.iter().find(|(key, _)| key == bundle) {
            Some((_, expr)) => quote!(&(#expr)),
            None if matches!(ty, Type::Tuple(t) if t.elems.is_empty()) => quote!(&()),
            None => quote!(cfg),
        }
    }
}

/// `DepthTest` as `depth_test`.
fn snake(name: &str) -> String {
    let mut text = String::new();
    for c in name.chars() {
        if c.is_uppercase() && !text.is_empty() {
            text.push('_');
        }
        text.extend(c.to_lowercase());
    }
    text
}

/// Adds what an `impl Block` leaves to its fields, and has what it shows and its cycle compiled into what it is a part of: a machine is
/// slower without. With debug assertions a cycle stays a function, which is compiled once, not in every place that plays the block.
pub fn complete(i: &mut ItemImpl) {
    for item in &mut i.items {
        let ImplItem::Fn(f) = item else { continue };
        if f.attrs.iter().any(|a| a.path().is_ident("inline")) {
            continue;
        }
        match f.sig.ident.to_string().as_str() {
            "moore" => f.attrs.push(syn::parse_quote!(#[inline(always)])),
            "next" => {
                f.attrs.push(syn::parse_quote!(#[cfg_attr(not(debug_assertions), inline(always))]))
            }
            _ => {}
        }
    }
    let has = |i: &ItemImpl, name: &str| {
        i.items.iter().any(|item| matches!(item, ImplItem::Fn(f) if f.sig.ident == name))
    };
    if !has(i, "reset") {
        i.items.push(syn::parse_quote! {
            fn reset(cfg: &Self::Config) -> Self::State {
                <Self::State>::reset(cfg)
            }
        });
    }
    if !has(i, "memories") {
        i.items.push(syn::parse_quote! {
            fn memories(cfg: &Self::Config) -> Self::Mem {
                <Self::Mem>::new(cfg)
            }
        });
    }
}

pub fn twins(options: &Options, i: &ItemImpl) -> Result<TokenStream> {
    let ty_of = |name: &str| -> Result<&Type> {
        let found = i.items.iter().find_map(|item| match item {
            ImplItem::Type(t) if t.ident == name => Some(&t.ty),
            _ => None,
        });
        found.ok_or_else(|| Error::new_spanned(&i.self_ty, format!("`type {name}` is missing")))
    };
    let function = |name: &str| -> Result<&ImplItemFn> {
        let found = i.items.iter().find_map(|item| match item {
            ImplItem::Fn(f) if f.sig.ident == name => Some(f),
            _ => None,
        });
        found.ok_or_else(|| Error::new_spanned(&i.self_ty, format!("`fn {name}` is missing")))
    };
    let Type::Path(path) = &*i.self_ty else {
        return Err(Error::new_spanned(&i.self_ty, "#[rtl] is for a block that has a name"));
    };
    let Some(block) = path.path.segments.last().map(|s| s.ident.to_string()) else {
        return Err(Error::new(Span::call_site(), "#[rtl] is for a block that has a name"));
    };
    if options.checks.is_empty() {
        return Err(Error::new(
            Span::call_site(),
            "#[rtl]: say with which configurations a test compares the netlist with the source: \
             `check(TYPE, CONFIG)`",
        ));
    }
    let name = options.name.as_ref().map_or_else(|| snake(&block), LitStr::value);
    let tests = options.checks.iter().enumerate().map(|(k, (ty, config))| {
        let test = format_ident!("the_netlist_of_{}_agrees_{}", snake(&block), k);
        quote! {
            #[cfg(test)]
            #[test]
            fn #test() {
                if let Err(difference) = ::pellucid_sim::netlist::agrees::<#ty>(&#config) {
                    panic!("{difference}");
                }
            }
        }
    });

    let state = options.config("state", ty_of("State")?);
    let input = options.config("input", ty_of("In")?);
    let moore = options.config("moore", ty_of("Moore")?);
    let output = options.config("output", ty_of("Out")?);
    let moore_twin = moore_twin(function("moore")?)?;
    let next_twin = next_twin(function("next")?)?;
    let (impl_generics, _, where_clause) = i.generics.split_for_impl();
    let ty = &i.self_ty;
    let lenient = lenient();
    Ok(quote! {
        #lenient
        impl #impl_generics ::pellucid_sim::Netlist for #ty #where_clause {
            fn name(_: &Self::Config) -> &'static str {
                #name
            }
            fn source(_: &Self::Config) -> &'static str {
                module_path!()
            }
            fn declare_state(cfg: &Self::Config, to: &mut dyn ::pellucid_sim::Declare) {
                <Self::State as ::pellucid_sim::Registers>::declare(#state, "", to)
            }
            fn declare_in(cfg: &Self::Config, to: &mut dyn ::pellucid_sim::Declare) {
                <Self::In as ::pellucid_sim::Signals>::declare(#input, "", to)
            }
            fn declare_moore(cfg: &Self::Config, to: &mut dyn ::pellucid_sim::Declare) {
                <Self::Moore as ::pellucid_sim::Signals>::declare(#moore, "", to)
            }
            fn declare_out(cfg: &Self::Config, to: &mut dyn ::pellucid_sim::Declare) {
                <Self::Out as ::pellucid_sim::Signals>::declare(#output, "", to)
            }
            fn numbers() -> ::pellucid_sim::netlist::Numbers<Self> {
                ::pellucid_sim::netlist::Numbers {
                    state: |cfg, q, to| ::pellucid_sim::Registers::sample(q, #state, to),
                    input: |cfg, i, to| ::pellucid_sim::Signals::sample(i, #input, to),
                    moore: |cfg, o, to| ::pellucid_sim::Signals::sample(o, #moore, to),
                    out: |cfg, o, to| ::pellucid_sim::Signals::sample(o, #output, to),
                    to_state: |cfg, from| ::pellucid_sim::Registers::restore(#state, from),
                    to_in: |cfg, from| ::pellucid_sim::Signals::restore(#input, from),
                }
            }
            #moore_twin
            #next_twin
        }
        #(#tests)*
    })
}

/// Opens the parameters of a block's function: the first is configuration, the others are hardware, in
/// the order of `values`.
fn open(f: &ImplItemFn, body: &mut Body, values: &[&str]) -> Result<Vec<TokenStream>> {
    let mut opening = vec![];
    let mut arguments = f.sig.inputs.iter();
    if let Some(FnArg::Typed(p)) = arguments.next() {
        let pat = &p.pat;
        if let syn::Pat::Ident(id) = &**pat {
            body.bind(&id.ident.to_string(), true);
        }
        opening.push(quote!(let #pat = cfg;));
    }
    if arguments.len() != values.len() {
        return Err(Error::new_spanned(&f.sig, "these are not the parameters of `Block`"));
    }
    for (argument, value) in arguments.zip(values) {
        if let FnArg::Typed(p) = argument {
            let value = Ident::new(value, Span::call_site());
            opening.extend(body.open(&p.pat, &quote!(#value)));
        }
    }
    Ok(opening)
}

fn moore_twin(f: &ImplItemFn) -> Result<TokenStream> {
    let mut body = Body::default();
    let opening = open(f, &mut body, &["__q", "__m"])?;
    let inner = body.block(&f.block);
    body.finish()?;
    Ok(quote! {
        fn moore_netlist(
            cfg: &Self::Config,
            __q: ::pellucid_sim::netlist::Value,
            __m: ::pellucid_sim::netlist::Value,
        ) -> ::pellucid_sim::netlist::Value {
            #(#opening)*
            #inner
        }
    })
}

fn next_twin(f: &ImplItemFn) -> Result<TokenStream> {
    let mut body = Body::default();
    let opening = open(f, &mut body, &["__q", "__d", "__m", "__i"])?;
    // What the registers and memories are called in the source, if they are used at all.
    let result = |k: usize, unused: &str| match f.sig.inputs.iter().nth(k) {
        Some(FnArg::Typed(p)) => match &*p.pat {
            syn::Pat::Ident(id) => id.ident.clone(),
            _ => Ident::new(unused, Span::call_site()),
        },
        _ => Ident::new(unused, Span::call_site()),
    };
    let (d, m) = (result(2, "__d"), result(3, "__m"));
    let inner = body.block(&f.block);
    body.finish()?;
    Ok(quote! {
        fn next_netlist(
            cfg: &Self::Config,
            __q: ::pellucid_sim::netlist::Value,
            __d: ::pellucid_sim::netlist::Value,
            __m: ::pellucid_sim::netlist::Value,
            __i: ::pellucid_sim::netlist::Value,
        ) -> [::pellucid_sim::netlist::Value; 3] {
            #(#opening)*
            let __out = #inner;
            [__out, #d, #m]
        }
    })
}
