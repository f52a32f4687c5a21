//! Calls: of other twins, of children, of methods, of macros.

use super::assigned::CHANGING;
use super::body::{Body, rt, value};
use super::syntax::{callee, integer, is_block_call, is_type};
use super::twin;
use proc_macro2::TokenStream;
use quote::{quote, quote_spanned};
use syn::spanned::Spanned;
use syn::{Expr, ExprCall, Pat, Result};

/// Methods of hardware values; arguments are hardware values too.
const METHODS: [&str; 9] = [
    "q",
    "with",
    "fires",
    "min",
    "max",
    "wrapping_add",
    "wrapping_sub",
    "saturating_sub",
    "trailing_zeros",
];

impl Body {
    pub(super) fn call(&mut self, c: &ExprCall) -> TokenStream {
        let Some((ty, name)) = callee(c).map(|(ty, name)| (ty.cloned(), name.clone())) else {
            return self.refuse(&c.func, "a function is called by its path");
        };
        let Expr::Path(path) = &*c.func else {
            return self.refuse(&c.func, "a function is called by its path");
        };
        let ty = ty.filter(|ty| is_type(ty) || integer(ty).is_some());
        let Some(ty) = ty else {
            if is_type(&name) {
                return self.refuse(&c.func, "a tuple constructor has no netlist form");
            }
            let arguments = self.arguments(c.args.iter());
            return quote_spanned!(c.span()=> #path::netlist(#(#arguments),*));
        };
        if let (Some(bits), "from", Some(from)) = (integer(&ty), &*name.to_string(), c.args.first())
        {
            let (from, rt) = (self.hardware(from), rt());
            return quote_spanned!(c.span()=> #rt::cast(#from, #bits));
        }
        if name == "default" && c.args.is_empty() {
            let value = value();
            return quote!(#value::Zero);
        }
        // The type of the path, without the function.
        let mut block = path.clone();
        block.path.segments.pop();
        block.path.segments.pop_punct();
        if is_block_call(c, "moore", 3) {
            let cfg = &c.args[0];
            let (q, m) = (self.hardware(&c.args[1]), self.hardware(&c.args[2]));
            return if ty == "Self" {
                quote!(<Self as ::pellucid_sim::Netlist>::moore_netlist(#cfg, #q, #m))
            } else {
                quote_spanned!(c.span()=> ::pellucid_sim::netlist::elaborate::moore::<#block>(#cfg, #q, #m))
            };
        }
        if is_block_call(c, "next", 5) {
            return self.clocked(c, &block);
        }
        let mut path = path.clone();
        if let Some(last) = path.path.segments.last_mut() {
            last.ident = twin(&last.ident);
        }
        let arguments = self.arguments(c.args.iter());
        quote_spanned!(c.span()=> #path(#(#arguments),*))
    }

    /// A call of a child's `next`.
    pub(super) fn clocked(&mut self, c: &ExprCall, block: &syn::ExprPath) -> TokenStream {
        let cfg = &c.args[0];
        let (q, m, i) =
            (self.hardware(&c.args[1]), self.part(&c.args[3]), self.hardware(&c.args[4]));
        let (out, d_after, m_after) = (self.fresh("out"), self.fresh("d"), self.fresh("m"));
        let mut after = vec![];
        for (place, new) in [(&c.args[2], &d_after), (&c.args[3], &m_after)] {
            let place = match place {
                Expr::Reference(r) => &r.expr,
                other => other,
            };
            // `&mut ()`: there is nothing that could change.
            if !matches!(place, Expr::Tuple(_)) {
                after.push(self.store(place, quote!(#new)));
            }
        }
        quote_spanned! { c.span() => {
            let [#out, #d_after, #m_after] =
                ::pellucid_sim::netlist::elaborate::next::<#block>(#cfg, #q, #m, #i);
            #(#after;)*
            #out
        } }
    }

    /// The value of `&mut place`.
    pub(super) fn part(&mut self, e: &Expr) -> TokenStream {
        match e {
            Expr::Reference(r) => self.hardware(&r.expr),
            other => self.hardware(other),
        }
    }

    /// Arguments of a twin: what is native goes as what the parameter is, configuration or hardware.
    pub(super) fn arguments<'a>(
        &mut self,
        arguments: impl Iterator<Item = &'a Expr>,
    ) -> Vec<TokenStream> {
        let pass = |e: TokenStream| quote!(::pellucid_sim::netlist::value::Pass::pass(#e));
        arguments
            .map(|e| match e {
                Expr::Lit(_) => self.hardware(e),
                _ if self.is_native(e) => pass(quote!(#e)),
                _ => self.hardware(e),
            })
            .collect()
    }

    pub(super) fn method(&mut self, m: &syn::ExprMethodCall) -> TokenStream {
        let (name, text) = (&m.method, m.method.to_string());
        if text == "clone" {
            return self.hardware(&m.receiver);
        }
        if METHODS.contains(&text.as_str()) {
            let receiver = self.hardware(&m.receiver);
            let arguments: Vec<_> = m.args.iter().map(|a| self.hardware(a)).collect();
            return quote_spanned!(m.span()=> (#receiver).#name(#(#arguments),*));
        }
        if CHANGING.contains(&text.as_str()) {
            let receiver = self.hardware(&m.receiver);
            let arguments: Vec<_> = m.args.iter().map(|a| self.hardware(a)).collect();
            let port = self.fresh("port");
            let after = self.store(&m.receiver, quote!(#port));
            return quote_spanned!(m.span()=> {
                let mut #port = #receiver;
                #port.#name(#(#arguments),*);
                #after
            });
        }
        if self.is_native(&m.receiver) {
            let (receiver, name) = (&m.receiver, twin(name));
            let arguments = self.arguments(m.args.iter());
            return quote_spanned!(m.span()=> #receiver.#name(#(#arguments),*));
        }
        self.refuse(
            &m.method,
            "hardware values do not have this method: use a function that is #[rtl] itself",
        )
    }

    pub(super) fn macro_call(&mut self, mac: &syn::Macro) -> TokenStream {
        let value = value();
        if mac.path.is_ident("matches") {
            struct Matches(Expr, Pat, Option<Expr>);
            impl syn::parse::Parse for Matches {
                fn parse(input: syn::parse::ParseStream) -> Result<Matches> {
                    let e = input.parse()?;
                    input.parse::<syn::Token![,]>()?;
                    let pat = Pat::parse_multi_with_leading_vert(input)?;
                    let guard = match input.parse::<Option<syn::Token![if]>>()? {
                        Some(_) => Some(input.parse()?),
                        None => None,
                    };
                    input.parse::<Option<syn::Token![,]>>()?;
                    Ok(Matches(e, pat, guard))
                }
            }
            let Matches(e, pat, guard) = match mac.parse_body() {
                Ok(parsed) => parsed,
                Err(error) => return self.refuse(mac, &error.to_string()),
            };
            let (of, held, rt) = (self.hardware(&e), self.fresh("matched"), rt());
            return self.scope(|body| {
                let mut names = vec![];
                let cond = body.matches(&pat, &quote!(#held), &mut names);
                let guard = guard.as_ref().map(|g| {
                    let guard = body.hardware(g);
                    quote!({ #(#names)* #guard })
                });
                let cond = cond.into_iter().chain(guard).reduce(|a, b| quote!(#rt::and(#a, #b)));
                let cond =
                    cond.unwrap_or_else(|| quote!(::pellucid_sim::netlist::Lift::lift(true)));
                quote!({ let #held = #of; #cond })
            });
        }
        let assertion = ["assert", "assert_eq", "assert_ne", "debug_assert", "debug_assert_eq"];
        if assertion.iter().any(|name| mac.path.is_ident(name)) {
            return quote!(#value::Zero);
        }
        self.refuse(mac, "this macro has no netlist form")
    }
}
