//! `#[rtl]`: beside each function its twin, which builds a netlist from the same tokens.

mod assigned;
mod block;
mod body;
mod calls;
mod control;
mod pattern;
mod syntax;

use proc_macro2::TokenStream;
use quote::{format_ident, quote, quote_spanned};
use syn::spanned::Spanned;
use syn::{Error, FnArg, Ident, ImplItem, Item, ItemFn, ItemImpl, Pat, Result, Signature, Type};

pub use block::Options;
use body::Body;

/// The item as it is, and its twins.
pub fn expand(options: Options, mut item: Item) -> Result<TokenStream> {
    if let Item::Impl(i) = &mut item
        && i.trait_.is_some()
    {
        block::complete(i);
    }
    let twins = match &item {
        Item::Fn(f) => free(f)?,
        Item::Impl(i) if i.trait_.is_some() => block::twins(&options, i)?,
        Item::Impl(i) => associated(i)?,
        other => {
            return Err(Error::new_spanned(
                other,
                "#[rtl] is for a function, an `impl Block` or an `impl` of functions",
            ));
        }
    };
    Ok(quote!(#item #twins))
}

/// What the twins do not need to care for: they are written by a machine.
fn lenient() -> TokenStream {
    quote! {
        #[allow(
            unused_mut, unused_variables, unused_assignments, unused_parens, unused_braces,
            unused_imports, unreachable_code, missing_docs, clippy::all
        )]
    }
}

/// The name of an associated function's twin.
fn twin(name: &Ident) -> Ident {
    format_ident!("{name}_netlist", span = name.span())
}

/// A free function's twin stands in a module of the function's name: whoever imports the one imports
/// the other.
fn free(f: &ItemFn) -> Result<TokenStream> {
    let (vis, name) = (&f.vis, &f.sig.ident);
    // Seen from inside the module, what is private is `super`'s.
    let inner = match vis {
        syn::Visibility::Inherited => quote!(pub(super)),
        other => quote!(#other),
    };
    let twin = function(&f.sig, &Ident::new("netlist", name.span()), &f.block)?;
    let lenient = lenient();
    Ok(quote! {
        #[doc(hidden)]
        #lenient
        #vis mod #name {
            use super::*;
            #inner #twin
        }
    })
}

/// The twins of the functions of an `impl`. Type parameters stand for hardware values in them.
fn associated(i: &ItemImpl) -> Result<TokenStream> {
    let mut twins = vec![];
    for item in &i.items {
        let ImplItem::Fn(f) = item else {
            return Err(Error::new_spanned(item, "#[rtl]: only functions have twins"));
        };
        let (vis, name) = (&f.vis, twin(&f.sig.ident));
        let body = function(&f.sig, &name, &f.block)?;
        twins.push(quote!(#[doc(hidden)] #vis #body));
    }
    let ty = concrete(i);
    let lenient = lenient();
    Ok(quote!(#lenient impl #ty { #(#twins)* }))
}

/// The type of an `impl` with hardware values for its parameters.
fn concrete(i: &ItemImpl) -> Type {
    struct Substitute(Vec<Ident>);
    impl syn::visit_mut::VisitMut for Substitute {
        fn visit_type_mut(&mut self, ty: &mut Type) {
            let parameter =
                matches!(ty, Type::Path(p) if self.0.iter().any(|id| p.path.is_ident(id)));
            if parameter {
                *ty = syn::parse_quote!(::pellucid_sim::netlist::Value);
            } else {
                syn::visit_mut::visit_type_mut(self, ty);
            }
        }
    }
    let mut ty = (*i.self_ty).clone();
    let parameters = i.generics.type_params().map(|p| p.ident.clone()).collect();
    syn::visit_mut::VisitMut::visit_type_mut(&mut Substitute(parameters), &mut ty);
    ty
}

/// The twin of a function: shared references are configuration, everything else is hardware.
fn function(sig: &Signature, name: &Ident, block: &syn::Block) -> Result<TokenStream> {
    let mut body = Body::default();
    let mut parameters = vec![];
    let mut opening = vec![];
    for (k, argument) in sig.inputs.iter().enumerate() {
        match argument {
            FnArg::Receiver(r) if r.reference.is_some() && r.mutability.is_none() => {
                body.bind("self", true);
                parameters.push(quote!(#r));
            }
            FnArg::Receiver(r) => {
                return Err(Error::new_spanned(
                    r,
                    "#[rtl]: `self` is configuration and stands as `&self`",
                ));
            }
            FnArg::Typed(p) => match &*p.ty {
                Type::Reference(r) if r.mutability.is_some() => {
                    return Err(Error::new_spanned(
                        r,
                        "#[rtl]: a function gives its results back; it changes nothing of its caller",
                    ));
                }
                Type::Reference(_) => {
                    if let Pat::Ident(id) = &*p.pat {
                        body.bind(&id.ident.to_string(), true);
                    }
                    parameters.push(quote!(#p));
                }
                _ => {
                    let value = format_ident!("__argument_{k}");
                    parameters.push(quote!(#value: ::pellucid_sim::netlist::Value));
                    opening.extend(body.open(&p.pat, &quote!(#value)));
                }
            },
        }
    }
    let inner = body.block(block);
    body.finish()?;
    Ok(quote_spanned! { sig.span() =>
        fn #name(#(#parameters),*) -> ::pellucid_sim::netlist::Value {
            #(#opening)*
            #inner
        }
    })
}

#[cfg(test)]
mod tests;
