//! Blocks, branches and loops.

use super::assigned::Assigned;
use super::body::{Body, rt, value};
use super::syntax::names;
use proc_macro2::TokenStream;
use quote::quote;
use syn::visit::Visit;
use syn::{Arm, Block, Expr, Ident, Pat, Stmt};

impl Body {
    /// A choice by a hardware value: both branches are built, and their values chosen from.
    pub(super) fn fork(
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
            let #c = #rt::cond(#cond);
            #(let #before = #assigned;)*
            let #a = #then;
            #(let #after = ::core::mem::replace(&mut #assigned, #before);)*
            let #b = #other;
            #(#assigned = #value::choose(#c, #after, #assigned) #hint;)*
            #value::choose(#c, #a, #b)
        }}
    }

    pub(super) fn choice(&mut self, i: &syn::ExprIf) -> TokenStream {
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

    pub(super) fn selection(&mut self, m: &syn::ExprMatch) -> TokenStream {
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

    pub(super) fn repetition(&mut self, f: &syn::ExprForLoop) -> TokenStream {
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

    pub(super) fn local(&mut self, local: &syn::Local) -> TokenStream {
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
