//! Patterns: what they ask of a value, and what they name.

use super::body::Body;
use super::syntax::{is_type, member};
use proc_macro2::TokenStream;
use quote::{quote, quote_spanned};
use syn::spanned::Spanned;
use syn::{Pat, RangeLimits};

impl Body {
    /// Statements that name the parts of `value` as an irrefutable pattern does.
    pub fn open(&mut self, pat: &Pat, value: &TokenStream) -> Vec<TokenStream> {
        match pat {
            Pat::Wild(_) => vec![],
            Pat::Ident(id) if id.subpat.is_none() => {
                let (name, text) = (&id.ident, id.ident.to_string());
                self.bind(&text, false);
                vec![quote_spanned!(pat.span()=> let mut #name = (#value).named(#text);)]
            }
            Pat::Paren(p) => self.open(&p.pat, value),
            Pat::Type(p) => self.open(&p.pat, value),
            Pat::Reference(p) => self.open(&p.pat, value),
            Pat::Tuple(syn::PatTuple { elems, .. }) | Pat::Slice(syn::PatSlice { elems, .. }) => {
                let mut all = vec![];
                for (k, inner) in (0u64..).zip(elems) {
                    let part = quote!((#value).at(::pellucid_sim::netlist::Value::literal(#k)));
                    all.extend(self.open(inner, &part));
                }
                all
            }
            Pat::Struct(s) => {
                let mut all = vec![];
                for field in &s.fields {
                    let member = member(&field.member);
                    all.extend(self.open(&field.pat, &quote!((#value) #member)));
                }
                all
            }
            other => {
                self.refuse(other, "this pattern has no netlist form");
                vec![]
            }
        }
    }

    /// Whether `value` matches, as a hardware value; nothing if it always does. The names that the
    /// pattern gives to parts of it are added to `names`.
    pub fn matches(
        &mut self,
        pat: &Pat,
        value: &TokenStream,
        names: &mut Vec<TokenStream>,
    ) -> Option<TokenStream> {
        let rt = quote!(::pellucid_sim::netlist::twin);
        let span = pat.span();
        let both = |a: TokenStream, b: TokenStream| quote!(#rt::and(#a, #b));
        match pat {
            Pat::Wild(_) => None,
            Pat::Ident(id) if !is_type(&id.ident) => {
                names.extend(self.open(pat, value));
                None
            }
            Pat::Ident(id) => {
                let id = &id.ident;
                let lifted = quote!(::pellucid_sim::netlist::Lift::lift(#id));
                Some(quote_spanned!(span=> #rt::eq(#value, #lifted)))
            }
            Pat::Path(p) => {
                let lifted = quote!(::pellucid_sim::netlist::Lift::lift(#p));
                Some(quote_spanned!(span=> #rt::eq(#value, #lifted)))
            }
            Pat::Lit(l) => {
                let literal = self.literal(&l.lit);
                Some(quote_spanned!(span=> #rt::eq(#value, #literal)))
            }
            Pat::Range(r) => {
                let low = r.start.as_ref().map(|low| {
                    let low = self.hardware(low);
                    quote!(#rt::ge(#value, #low))
                });
                let high = r.end.as_ref().map(|high| {
                    let high = self.hardware(high);
                    match r.limits {
                        RangeLimits::Closed(_) => quote!(#rt::le(#value, #high)),
                        RangeLimits::HalfOpen(_) => quote!(#rt::lt(#value, #high)),
                    }
                });
                low.into_iter().chain(high).reduce(both)
            }
            Pat::Or(o) => {
                let mut any = vec![];
                for case in &o.cases {
                    any.push(self.matches(case, value, names)?);
                }
                any.into_iter().reduce(|a, b| quote!(#rt::or(#a, #b)))
            }
            Pat::Tuple(t) => {
                let mut all = vec![];
                for (k, inner) in (0u64..).zip(&t.elems) {
                    let part = quote!((#value).at(::pellucid_sim::netlist::Value::literal(#k)));
                    all.extend(self.matches(inner, &part, names));
                }
                all.into_iter().reduce(both)
            }
            Pat::Struct(s) => {
                let mut all = vec![];
                for field in &s.fields {
                    let member = member(&field.member);
                    all.extend(self.matches(&field.pat, &quote!((#value) #member), names));
                }
                all.into_iter().reduce(both)
            }
            Pat::Paren(p) => self.matches(&p.pat, value, names),
            other => {
                self.refuse(other, "this pattern has no netlist form");
                None
            }
        }
    }
}
