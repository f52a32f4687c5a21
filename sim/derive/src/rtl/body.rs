//! Function bodies: each statement and expression as one that builds hardware.
//!
//! What is made of configuration, constants, literals and loop counters alone is *native*: it stays the
//! Rust that it is, and is known while the netlist is built. All else becomes a hardware value. A
//! native `if`, `match` or `for` chooses and repeats hardware; any other condition becomes a choice
//! between the values that its branches give, and between those of every variable that they assign.

use super::assigned::{Assigned, CHANGING, is_compound, names};
use super::pattern::member;
use super::twin;
use proc_macro2::{Span, TokenStream};
use quote::{ToTokens, format_ident, quote, quote_spanned};
use std::collections::HashMap;
use syn::spanned::Spanned;
use syn::visit::Visit;
use syn::{Arm, BinOp, Block, Error, Expr, ExprCall, Ident, Lit, Member, Pat, Result, Stmt, UnOp};

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

/// A function body on its way.
#[derive(Default)]
pub struct Body {
    /// By scope, which names are native.
    scopes: Vec<HashMap<String, bool>>,
    /// Makes names of its own different.
    made: usize,
    error: Option<Error>,
}

/// The last two names of a called path: `Store` and `next` of `store::Store::next`.
fn callee(c: &ExprCall) -> Option<(Option<&Ident>, &Ident)> {
    let Expr::Path(p) = &*c.func else { return None };
    let mut segments = p.path.segments.iter().rev();
    let last = &segments.next()?.ident;
    Some((segments.next().map(|s| &s.ident), last))
}

/// Whether a call is `Type::name(...)` with so many arguments.
pub fn is_block_call(c: &ExprCall, name: &str, arguments: usize) -> bool {
    c.args.len() == arguments
        && matches!(callee(c), Some((Some(ty), last)) if last == name && is_type(ty))
}

fn is_type(id: &Ident) -> bool {
    id.to_string().starts_with(char::is_uppercase)
}

/// The bits of an integer type.
fn integer(name: &Ident) -> Option<u32> {
    match name.to_string().as_str() {
        "u8" => Some(8),
        "u16" => Some(16),
        "u32" => Some(32),
        "u64" | "usize" => Some(64),
        _ => None,
    }
}

fn rt() -> TokenStream {
    quote!(::pellucid_sim::netlist::twin)
}

fn value() -> TokenStream {
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

    fn fresh(&mut self, name: &str) -> Ident {
        self.made += 1;
        format_ident!("__{name}_{}", self.made, span = Span::mixed_site())
    }

    fn scope<R>(&mut self, inside: impl FnOnce(&mut Body) -> R) -> R {
        self.scopes.push(HashMap::new());
        let result = inside(self);
        self.scopes.pop();
        result
    }

    fn lookup(&self, name: &str) -> Option<bool> {
        self.scopes.iter().rev().find_map(|scope| scope.get(name).copied())
    }

    /// Whether an expression is known while the netlist is built.
    fn is_native(&self, e: &Expr) -> bool {
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
            Expr::Path(p) => quote!(#p.clone()),
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
                let (one, len, value) = (self.hardware(&r.expr), &r.len, value());
                quote!(#value::list(vec![#one; (#len) as usize]))
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
        quote!(#value::list([#(#elements),*]))
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
            Some(base) => quote!((#base).updated([#(#fields),*])),
            None => quote!(#value::record([#(#fields),*])),
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
    fn store(&mut self, place: &Expr, new: TokenStream) -> TokenStream {
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
    fn assign(&mut self, left: &Expr, right: TokenStream) -> TokenStream {
        let Expr::Tuple(t) = left else { return self.store(left, right) };
        let (held, value) = (self.fresh("tuple"), value());
        let mut parts = vec![];
        for (k, place) in (0u64..).zip(&t.elems) {
            parts.push(self.store(place, quote!(#held.at(#value::literal(#k)))));
        }
        quote!({ let #held = #right; #(#parts;)* #value::Zero })
    }

    fn call(&mut self, c: &ExprCall) -> TokenStream {
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
    fn clocked(&mut self, c: &ExprCall, block: &syn::ExprPath) -> TokenStream {
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
    fn part(&mut self, e: &Expr) -> TokenStream {
        match e {
            Expr::Reference(r) => self.hardware(&r.expr),
            other => self.hardware(other),
        }
    }

    /// Arguments of a twin: what is native goes as what the parameter is, configuration or hardware.
    fn arguments<'a>(&mut self, arguments: impl Iterator<Item = &'a Expr>) -> Vec<TokenStream> {
        let pass = |e: TokenStream| quote!(::pellucid_sim::netlist::value::Pass::pass(#e));
        arguments
            .map(|e| match e {
                Expr::Lit(_) => self.hardware(e),
                _ if self.is_native(e) => pass(quote!(#e)),
                _ => self.hardware(e),
            })
            .collect()
    }

    fn method(&mut self, m: &syn::ExprMethodCall) -> TokenStream {
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

    fn macro_call(&mut self, mac: &syn::Macro) -> TokenStream {
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

    /// A choice by a hardware value: both branches are built, and their values chosen from.
    fn fork(
        &mut self,
        cond: TokenStream,
        assigned: &[Ident],
        then: TokenStream,
        other: TokenStream,
    ) -> TokenStream {
        let assigned: Vec<&Ident> =
            assigned.iter().filter(|id| self.lookup(&id.to_string()) == Some(false)).collect();
        let (c, a, b) = (self.fresh("cond"), self.fresh("then"), self.fresh("else"));
        let before: Vec<Ident> = assigned.iter().map(|_| self.fresh("before")).collect();
        let after: Vec<Ident> = assigned.iter().map(|_| self.fresh("after")).collect();
        let (rt, value) = (rt(), value());
        // Registers and memories have names of their own.
        let hint = assigned.iter().map(|id| match id.to_string().as_str() {
            "d" | "m" => quote!(),
            name => quote!(.hinted(#name)),
        });
        quote! {{
            let #c = #rt::cond(&#cond);
            #(let #before = #assigned.clone();)*
            let #a = #then;
            #(let #after = ::core::mem::replace(&mut #assigned, #before);)*
            let #b = #other;
            #(#assigned = #value::choose(#c, #after, #assigned) #hint;)*
            #value::choose(#c, #a, #b)
        }}
    }

    fn choice(&mut self, i: &syn::ExprIf) -> TokenStream {
        let value = value();
        let then = self.block(&i.then_branch);
        let other = match &i.else_branch {
            Some((_, e)) => self.hardware(e),
            None => quote!(#value::Zero),
        };
        if self.is_native(&i.cond) {
            let cond = &i.cond;
            return quote!(if #cond { #then } else { #other });
        }
        let assigned = Assigned::of(|a| {
            a.visit_block(&i.then_branch);
            if let Some((_, e)) = &i.else_branch {
                a.visit_expr(e);
            }
        });
        let cond = self.hardware(&i.cond);
        self.fork(cond, &assigned, then, other)
    }

    fn selection(&mut self, m: &syn::ExprMatch) -> TokenStream {
        if self.is_native(&m.expr) {
            let of = &m.expr;
            let mut arms = vec![];
            for arm in &m.arms {
                arms.push(self.scope(|body| {
                    for id in names(&arm.pat) {
                        body.bind(&id.to_string(), true);
                    }
                    let (pat, guard) = (&arm.pat, arm.guard.as_ref().map(|(i, g)| quote!(#i #g)));
                    let inner = body.hardware(&arm.body);
                    quote!(#pat #guard => #inner,)
                }));
            }
            return quote!(match #of { #(#arms)* });
        }
        let (of, held) = (self.hardware(&m.expr), self.fresh("matched"));
        let arms = self.arms(&quote!(#held), &m.arms);
        quote!({ let #held = #of; #arms })
    }

    /// The arms in order: each against those behind it. The native `match` covers everything, so the
    /// last arm needs no test.
    fn arms(&mut self, of: &TokenStream, arms: &[Arm]) -> TokenStream {
        let Some((arm, rest)) = arms.split_first() else { return quote!(::core::unreachable!()) };
        let (cond, then) = self.scope(|body| {
            let mut names = vec![];
            let cond = body.matches(&arm.pat, of, &mut names);
            let guard = arm.guard.as_ref().map(|(_, g)| {
                let guard = body.hardware(g);
                quote!({ #(#names)* #guard })
            });
            let rt = rt();
            let cond = cond.into_iter().chain(guard).reduce(|a, b| quote!(#rt::and(#a, #b)));
            let inner = body.hardware(&arm.body);
            (cond, quote!({ #(#names)* #inner }))
        });
        let Some(cond) = cond.filter(|_| !rest.is_empty()) else { return then };
        let assigned = Assigned::of(|a| {
            a.visit_expr(&arm.body);
            rest.iter().for_each(|arm| a.visit_expr(&arm.body));
        });
        let other = self.arms(of, rest);
        self.fork(cond, &assigned, then, other)
    }

    fn repetition(&mut self, f: &syn::ExprForLoop) -> TokenStream {
        let (native, value) = (self.is_native(&f.expr), value());
        if let (false, Expr::Range(range)) = (native, &*f.expr) {
            return self.refuse(
                range,
                "a loop is unrolled: its bounds are configuration, constants and literals",
            );
        }
        self.scope(|body| {
            if native {
                for id in names(&f.pat) {
                    body.bind(&id.to_string(), true);
                }
                let (pat, over) = (&f.pat, &f.expr);
                let inner = body.block(&f.body);
                return quote!({ for #pat in #over { #inner; } #value::Zero });
            }
            let over = body.hardware(&f.expr);
            let element = body.fresh("element");
            let opening = body.open(&f.pat, &quote!(#element));
            let inner = body.block(&f.body);
            quote!({ for #element in (#over).elements() { #(#opening)* #inner; } #value::Zero })
        })
    }

    /// A block as a hardware value.
    pub fn block(&mut self, block: &Block) -> TokenStream {
        let value = value();
        self.scope(|body| {
            let mut statements = vec![];
            for (k, statement) in block.stmts.iter().enumerate() {
                let last = k + 1 == block.stmts.len();
                statements.push(match statement {
                    Stmt::Local(local) => body.local(local),
                    Stmt::Expr(e, None) if last => body.hardware(e),
                    Stmt::Expr(e, _) => {
                        let e = body.hardware(e);
                        quote!(let _ = #e;)
                    }
                    Stmt::Macro(m) => {
                        let called = body.macro_call(&m.mac);
                        if last && m.semi_token.is_none() {
                            called
                        } else {
                            quote!(let _ = #called;)
                        }
                    }
                    Stmt::Item(item) => quote!(#item),
                });
            }
            if !matches!(block.stmts.last(), Some(Stmt::Expr(_, None))) {
                statements.push(quote!(#value::Zero));
            }
            quote!({ #(#statements)* })
        })
    }

    fn local(&mut self, local: &syn::Local) -> TokenStream {
        let Some(init) = &local.init else {
            return self.refuse(local, "a variable needs a value from the start");
        };
        if let Some((_, diverge)) = &init.diverge {
            return self.refuse(diverge, "`let else` has no netlist form");
        }
        let mut pat = &local.pat;
        while let Pat::Type(p) = pat {
            pat = &p.pat;
        }
        let simple = matches!(pat, Pat::Ident(id) if id.mutability.is_none());
        if simple && !matches!(*init.expr, Expr::Lit(_)) && self.is_native(&init.expr) {
            for id in names(pat) {
                self.bind(&id.to_string(), true);
            }
            return quote!(#local);
        }
        let of = self.hardware(&init.expr);
        if let Pat::Ident(_) = pat {
            let opening = self.open(pat, &quote!(#of));
            return quote!(#(#opening)*);
        }
        let held = self.fresh("opened");
        let opening = self.open(pat, &quote!(#held));
        quote!(let #held = #of; #(#opening)*)
    }
}
