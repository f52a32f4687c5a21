//! Which variables a branch assigns that it did not declare: those that must be chosen from where it
//! meets the other branch.

use super::syntax::{is_block_call, is_compound, names};
use std::collections::BTreeMap;
use syn::visit::{self, Visit};
use syn::{Expr, Ident};

/// Methods that change what they are called on.
pub const CHANGING: [&str; 6] = ["read", "write", "pass_read", "pass_write", "pass", "holds"];

/// `d` of `d.stage.entries[k].z`.
pub fn root(e: &Expr) -> Option<&Ident> {
    match e {
        Expr::Path(p) => p.path.get_ident(),
        Expr::Field(f) => root(&f.base),
        Expr::Index(x) => root(&x.expr),
        Expr::Paren(p) => root(&p.expr),
        Expr::Unary(u) => root(&u.expr),
        Expr::Reference(r) => root(&r.expr),
        _ => None,
    }
}

/// See the module's description.
#[derive(Default)]
pub struct Assigned {
    declared: Vec<Vec<String>>,
    found: BTreeMap<String, Ident>,
}

impl Assigned {
    /// What is assigned in all that `visit` visits.
    pub fn of(visit: impl FnOnce(&mut Assigned)) -> Vec<Ident> {
        let mut assigned = Assigned { declared: vec![vec![]], ..Assigned::default() };
        visit(&mut assigned);
        assigned.found.into_values().collect()
    }

    fn hit(&mut self, e: &Expr) {
        if let Expr::Tuple(t) = e {
            t.elems.iter().for_each(|e| self.hit(e));
        } else if let Some(id) = root(e) {
            let name = id.to_string();
            if !self.declared.iter().flatten().any(|d| *d == name) {
                self.found.entry(name).or_insert_with(|| id.clone());
            }
        }
    }
}

impl<'a> Visit<'a> for Assigned {
    fn visit_block(&mut self, b: &'a syn::Block) {
        self.declared.push(vec![]);
        visit::visit_block(self, b);
        self.declared.pop();
    }
    fn visit_local(&mut self, l: &'a syn::Local) {
        visit::visit_local(self, l);
        if let Some(scope) = self.declared.last_mut() {
            scope.extend(names(&l.pat).iter().map(ToString::to_string));
        }
    }
    fn visit_expr_assign(&mut self, a: &'a syn::ExprAssign) {
        self.hit(&a.left);
        visit::visit_expr_assign(self, a);
    }
    fn visit_expr_binary(&mut self, b: &'a syn::ExprBinary) {
        if is_compound(&b.op) {
            self.hit(&b.left);
        }
        visit::visit_expr_binary(self, b);
    }
    fn visit_expr_reference(&mut self, r: &'a syn::ExprReference) {
        if r.mutability.is_some() {
            self.hit(&r.expr);
        }
        visit::visit_expr_reference(self, r);
    }
    fn visit_expr_method_call(&mut self, m: &'a syn::ExprMethodCall) {
        if CHANGING.iter().any(|name| m.method == name) {
            self.hit(&m.receiver);
        }
        visit::visit_expr_method_call(self, m);
    }
    fn visit_expr_call(&mut self, c: &'a syn::ExprCall) {
        // A block's `next` changes registers and memories; they may be passed on by name.
        if is_block_call(c, "next", 5) {
            self.hit(&c.args[2]);
            self.hit(&c.args[3]);
        }
        visit::visit_expr_call(self, c);
    }
}
