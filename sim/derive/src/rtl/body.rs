//! Function bodies: each statement and expression as one that builds hardware.
//!
//! What is made of configuration, constants, literals and loop counters alone is *native*: it stays the
//! Rust that it is, and is known while the netlist is built. All else becomes a hardware value. A
//! native `if`, `match` or `for` chooses and repeats hardware; any other condition becomes a choice
//! between the values that its branches give, and between those of every variable that they assign.

use super::syntax::{callee, integer, is_compound, is_type, member};
use proc_macro2::{Span, TokenStream};
use quote::{ToTokens, format_ident, quote, quote_spanned};
use std::collections::HashMap;
use syn::spanned::Spanned;
use syn::{BinOp, Error, Expr, Ident, Lit, Member, Result, UnOp};

/// A function body on its way.
#[derive(Default)]
pub struct Body {
    /// By scope, which names are native.
    scopes: Vec<HashMap<String, bool>>,
    /// Makes names of its own different.
    made: usize,
    error: Option<Error>,
}

pub(super) fn rt() -> TokenStream {
    quote!(::pellucid_sim::netlist::twin)
}

pub(super) fn value() -> TokenStream {
    quote!(::pellucid_sim::netlist::Value)
}

impl Body {
    /// Remembers the first thing that has no netlist form.
    pub fn refuse(&mut self, at: impl ToTokens, message: &str) -> TokenStream {
        let error = Error::new_spanned(at, format!("#[rtl]: {message}"));
        match &mut self.error {
            Some(first) => first.combine(error),
            None => self.error = Some(error),
        }
        quote!(::core::unreachable!())
    }

    /// Ends the body.
    pub fn finish(self) -> Result<()> {
        self.error.map_or(Ok(()), Err)
    }

    /// A name comes into being.
    pub fn bind(&mut self, name: &str, native: bool) {
        if self.scopes.is_empty() {
            self.scopes.push(HashMap::new());
        }
        if let Some(scope) = self.scopes.last_mut() {
            scope.insert(name.to_string(), native);
        }
    }

    pub(super) fn fresh(&mut self, name: &str) -> Ident {
        self.made += 1;
        format_ident!("__{name}_{}", self.made, span = Span::mixed_site())
    }

    pub(super) fn scope<R>(&mut self, inside: impl FnOnce(&mut Body) -> R) -> R {
        self.scopes.push(HashMap::new());
        let result = inside(self);
        self.scopes.pop();
        result
    }

    pub(super) fn lookup(&self, name: &str) -> Option<bool> {
        self.scopes.iter().rev().find_map(|scope| scope.get(name).copied())
    }

    /// Whether an expression is known while the netlist is built.
    pub(super) fn is_native(&self, e: &Expr) -> bool {
        match e {
            Expr::Lit(_) => true,
            Expr::Path(p) => match p.path.get_ident() {
                Some(id) => self.lookup(&id.to_string()).unwrap_or_else(|| is_type(id)),
                None => true,
            },
            Expr::Field(f) => self.is_native(&f.base),
            Expr::Paren(p) => self.is_native(&p.expr),
            Expr::Group(g) => self.is_native(&g.expr),
            Expr::Cast(c) => self.is_native(&c.expr),
            Expr::Reference(r) => r.mutability.is_none() && self.is_native(&r.expr),
            Expr::Index(x) => self.is_native(&x.expr) && self.is_native(&x.index),
            Expr::Unary(u) => self.is_native(&u.expr),
            Expr::Binary(b) => {
                !is_compound(&b.op) && self.is_native(&b.left) && self.is_native(&b.right)
            }
            Expr::Range(r) => [&r.start, &r.end].into_iter().flatten().all(|e| self.is_native(e)),
            Expr::MethodCall(m) => {
                self.is_native(&m.receiver) && m.args.iter().all(|a| self.is_native(a))
            }
            Expr::Call(c) => match callee(c) {
                // Without arguments, only the type knows what comes: hardware, unless it is a helper.
                Some((Some(ty), _)) if is_type(ty) && c.args.is_empty() => false,
                _ => c.args.iter().all(|a| self.is_native(a)),
            },
            Expr::Macro(m) => m.mac.path.is_ident("concat"),
            _ => false,
        }
    }

    /// A literal as a hardware value.
    pub fn literal(&mut self, literal: &Lit) -> TokenStream {
        match literal {
            Lit::Int(n) if n.suffix().is_empty() => match n.base10_parse::<u64>() {
                Ok(number) => {
                    let value = value();
                    quote!(#value::literal(#number))
                }
                Err(_) => self.refuse(n, "a hardware integer has 64 bits at most"),
            },
            Lit::Int(_) | Lit::Bool(_) => quote!(::pellucid_sim::netlist::Lift::lift(#literal)),
            other => self.refuse(other, "this literal has no netlist form"),
        }
    }

    /// An expression as a hardware value.
    pub fn hardware(&mut self, e: &Expr) -> TokenStream {
        match e {
            Expr::Lit(l) => self.literal(&l.lit),
            Expr::Paren(p) => self.hardware(&p.expr),
            Expr::Group(g) => self.hardware(&g.expr),
            Expr::Tuple(t) if t.elems.is_empty() => {
                let value = value();
                quote!(#value::Zero)
            }
            _ if self.is_native(e) => {
                quote_spanned!(e.span()=> ::pellucid_sim::netlist::Lift::lift(#e))
            }
            Expr::Path(p) => quote!(#p),
            Expr::Reference(r) if r.mutability.is_none() => self.hardware(&r.expr),
            Expr::Field(f) => {
                let (base, member) = (self.hardware(&f.base), member(&f.member));
                quote_spanned!(f.span()=> #base #member)
            }
            Expr::Index(x) => {
                let (base, index) = (self.hardware(&x.expr), self.hardware(&x.index));
                quote_spanned!(x.span()=> #base.at(#index))
            }
            Expr::Tuple(t) => self.list(t.elems.iter()),
            Expr::Array(a) => self.list(a.elems.iter()),
            Expr::Repeat(r) => {
                let (one, len) = (self.hardware(&r.expr), &r.len);
                quote!((#one).repeated((#len) as usize))
            }
            Expr::Struct(s) => self.structure(s),
            Expr::Block(b) => self.block(&b.block),
            Expr::Unary(u) => {
                let (inner, rt) = (self.hardware(&u.expr), rt());
                match u.op {
                    UnOp::Not(_) => quote_spanned!(u.span()=> #rt::not(#inner)),
                    UnOp::Deref(_) => inner,
                    _ => self.refuse(u, "hardware integers are unsigned"),
                }
            }
            Expr::Cast(c) => {
                let inner = self.hardware(&c.expr);
                let bits = match &*c.ty {
                    syn::Type::Path(p) => p.path.get_ident().and_then(integer),
                    _ => None,
                };
                match bits {
                    Some(bits) => {
                        let rt = rt();
                        quote_spanned!(c.span()=> #rt::cast(#inner, #bits))
                    }
                    None => {
                        self.refuse(&c.ty, "a hardware value is cast to u8, u16, u32, u64 or usize")
                    }
                }
            }
            Expr::Binary(b) => {
                let (left, right) = (self.hardware(&b.left), self.hardware(&b.right));
                let result = self.binary(&b.op, left, right);
                if is_compound(&b.op) { self.store(&b.left, result) } else { result }
            }
            Expr::Assign(a) => {
                let right = self.hardware(&a.right);
                self.assign(&a.left, right)
            }
            Expr::Call(c) => self.call(c),
            Expr::MethodCall(m) => self.method(m),
            Expr::If(i) => self.choice(i),
            Expr::Match(m) => self.selection(m),
            Expr::ForLoop(f) => self.repetition(f),
            Expr::Macro(m) => self.macro_call(&m.mac),
            Expr::Return(r) => self.refuse(
                r,
                "a function ends at its end: write the rest as the other branch of an `if`",
            ),
            Expr::While(w) => self.refuse(
                w.while_token,
                "hardware has no loop of unknown length: use `for` over a range of configuration",
            ),
            Expr::Loop(l) => self.refuse(l.loop_token, "hardware has no loop of unknown length"),
            Expr::Closure(c) => self.refuse(c, "a closure has no netlist form: use a function"),
            Expr::Let(l) => {
                self.refuse(l.let_token, "`if let` has no netlist form: use `match` or a flag")
            }
            other => self.refuse(other, "this has no netlist form"),
        }
    }

    fn list<'a>(&mut self, elements: impl Iterator<Item = &'a Expr>) -> TokenStream {
        let elements: Vec<_> = elements.map(|e| self.hardware(e)).collect();
        let value = value();
        quote!(#value::list(&[#(#elements),*]))
    }

    fn structure(&mut self, s: &syn::ExprStruct) -> TokenStream {
        let base = s.rest.as_ref().map(|rest| self.hardware(rest));
        let mut fields = vec![];
        for field in &s.fields {
            let Member::Named(name) = &field.member else {
                return self.refuse(&field.member, "hardware bundles have named fields");
            };
            let (name, of) = (name.to_string(), self.hardware(&field.expr));
            fields.push(quote_spanned!(field.span()=> (#name, #of)));
        }
        let value = value();
        match base {
            Some(base) => quote!((#base).updated(&[#(#fields),*])),
            None => quote!(#value::record(&[#(#fields),*])),
        }
    }

    fn binary(&mut self, op: &BinOp, left: TokenStream, right: TokenStream) -> TokenStream {
        use BinOp::*;
        let name = match op {
            Add(_) | AddAssign(_) => "add",
            Sub(_) | SubAssign(_) => "sub",
            Mul(_) | MulAssign(_) => "mul",
            BitAnd(_) | BitAndAssign(_) | And(_) => "and",
            BitOr(_) | BitOrAssign(_) | Or(_) => "or",
            BitXor(_) | BitXorAssign(_) => "xor",
            Shl(_) | ShlAssign(_) => "shl",
            Shr(_) | ShrAssign(_) => "shr",
            Eq(_) => "eq",
            Ne(_) => "ne",
            Lt(_) => "lt",
            Le(_) => "le",
            Gt(_) => "gt",
            Ge(_) => "ge",
            Div(_) | DivAssign(_) | Rem(_) | RemAssign(_) => {
                return self.refuse(
                    op,
                    "a divider is a block of its own: shift and mask for a power of two",
                );
            }
            _ => return self.refuse(op, "this operator has no netlist form"),
        };
        let (name, rt) = (Ident::new(name, op.span()), rt());
        quote_spanned!(op.span()=> #rt::#name(#left, #right))
    }

    /// The variable of a place, and the steps from it.
    fn place(&mut self, e: &Expr) -> Option<(Ident, Vec<TokenStream>)> {
        let step = quote!(::pellucid_sim::netlist::Step);
        match e {
            Expr::Path(p) => p.path.get_ident().map(|id| (id.clone(), vec![])),
            Expr::Paren(p) => self.place(&p.expr),
            Expr::Unary(u) if matches!(u.op, UnOp::Deref(_)) => self.place(&u.expr),
            Expr::Field(f) => {
                let (root, mut steps) = self.place(&f.base)?;
                steps.push(match &f.member {
                    Member::Named(id) => {
                        let name = id.to_string();
                        quote!(#step::Field(#name))
                    }
                    Member::Unnamed(k) => {
                        let (k, value) = (u64::from(k.index), value());
                        quote!(#step::Element(#value::literal(#k)))
                    }
                });
                Some((root, steps))
            }
            Expr::Index(x) => {
                let (root, mut steps) = self.place(&x.expr)?;
                let index = self.hardware(&x.index);
                steps.push(quote!(#step::Element(#index)));
                Some((root, steps))
            }
            _ => None,
        }
    }

    /// `place = new`, where `new` is a hardware value.
    pub(super) fn store(&mut self, place: &Expr, new: TokenStream) -> TokenStream {
        let Some((root, steps)) = self.place(place) else {
            return self.refuse(place, "a variable, a field or an element is assigned");
        };
        let (held, value) = (self.fresh("new"), value());
        quote_spanned! { place.span() => {
            let #held = #new;
            let __steps: &[::pellucid_sim::netlist::Step] = &[#(#steps),*];
            #root.set(__steps, #held);
            #value::Zero
        } }
    }

    /// `left = right`; a tuple on the left takes apart what comes.
    pub(super) fn assign(&mut self, left: &Expr, right: TokenStream) -> TokenStream {
        let Expr::Tuple(t) = left else { return self.store(left, right) };
        let (held, value) = (self.fresh("tuple"), value());
        let mut parts = vec![];
        for (k, place) in (0u64..).zip(&t.elems) {
            parts.push(self.store(place, quote!(#held.at(#value::literal(#k)))));
        }
        quote!({ let #held = #right; #(#parts;)* #value::Zero })
    }
}
