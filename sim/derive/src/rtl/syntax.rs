//! What can be said of a piece of source by its form alone.

use proc_macro2::TokenStream;
use quote::quote;
use syn::visit::{self, Visit};
use syn::{BinOp, Expr, ExprCall, Ident, Member, Pat};

/// The last two names of a called path: `Store` and `next` of `store::Store::next`.
pub fn callee(c: &ExprCall) -> Option<(Option<&Ident>, &Ident)> {
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

pub fn is_type(id: &Ident) -> bool {
    id.to_string().starts_with(char::is_uppercase)
}

/// The bits of an integer type.
pub fn integer(name: &Ident) -> Option<u32> {
    match name.to_string().as_str() {
        "u8" => Some(8),
        "u16" => Some(16),
        "u32" => Some(32),
        "u64" | "usize" => Some(64),
        _ => None,
    }
}

/// The names in a pattern.
pub fn names(pat: &Pat) -> Vec<Ident> {
    struct Names(Vec<Ident>);
    impl Visit<'_> for Names {
        fn visit_pat_ident(&mut self, p: &syn::PatIdent) {
            self.0.push(p.ident.clone());
            visit::visit_pat_ident(self, p);
        }
    }
    let mut names = Names(vec![]);
    names.visit_pat(pat);
    names.0
}

/// Whether `op` assigns, as `+=` does.
pub fn is_compound(op: &BinOp) -> bool {
    use BinOp::*;
    matches!(
        op,
        AddAssign(_)
            | SubAssign(_)
            | MulAssign(_)
            | DivAssign(_)
            | RemAssign(_)
            | BitAndAssign(_)
            | BitOrAssign(_)
            | BitXorAssign(_)
            | ShlAssign(_)
            | ShrAssign(_)
    )
}

/// How to reach a member.
pub fn member(m: &Member) -> TokenStream {
    match m {
        Member::Named(id) => {
            let name = id.to_string();
            quote!(.field(#name))
        }
        Member::Unnamed(index) => {
            let k = u64::from(index.index);
            quote!(.at(::pellucid_sim::netlist::Value::literal(#k)))
        }
    }
}
