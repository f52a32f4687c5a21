//! `#[derive(Memory)]`.

use proc_macro2::TokenStream;
use quote::{format_ident, quote};
use syn::{Data, DeriveInput, Error, Fields, Result};

pub fn derive(input: &DeriveInput) -> Result<TokenStream> {
    let Data::Struct(syn::DataStruct { fields: Fields::Named(fields), .. }) = &input.data else {
        return Err(Error::new_spanned(
            &input.ident,
            "#[derive(Memory)] is for a struct with named fields, each a memory",
        ));
    };
    let (name, vis) = (&input.ident, &input.vis);
    let (q, d) = (format_ident!("{name}Q"), format_ident!("{name}D"));
    let ids: Vec<_> = fields.named.iter().flat_map(|f| &f.ident).collect();
    let types: Vec<_> = fields.named.iter().map(|f| &f.ty).collect();
    let names: Vec<String> = ids.iter().map(ToString::to_string).collect();
    let (impl_generics, ty_generics, where_clause) = input.generics.split_for_impl();
    let (q_doc, d_doc) = (
        format!("What each memory of [`{name}`] shows: registers."),
        format!("What is asked of each memory of [`{name}`] on the coming edge."),
    );
    let field_docs: Vec<String> = names.iter().map(|n| format!("`{n}`")).collect();
    // Clone and Copy by hand: a derive would ask them of the type parameters, not of the fields.
    Ok(quote! {
        #[doc = #q_doc]
        #vis struct #q #impl_generics #where_clause {
            #(#[doc = #field_docs] pub #ids: <#types as ::pellucid_sim::Memory>::Q,)*
        }
        #[doc = #d_doc]
        #vis struct #d #impl_generics #where_clause {
            #(#[doc = #field_docs] pub #ids: <#types as ::pellucid_sim::Memory>::D,)*
        }
        impl #impl_generics Clone for #q #ty_generics #where_clause {
            fn clone(&self) -> Self { *self }
        }
        impl #impl_generics Copy for #q #ty_generics #where_clause {}
        impl #impl_generics Clone for #d #ty_generics #where_clause {
            fn clone(&self) -> Self { *self }
        }
        impl #impl_generics Copy for #d #ty_generics #where_clause {}
        impl #impl_generics ::pellucid_sim::Memory for #name #ty_generics #where_clause {
            type Q = #q #ty_generics;
            type D = #d #ty_generics;
            #[inline(always)]
            fn q(&self) -> Self::Q { #q { #(#ids: ::pellucid_sim::Memory::q(&self.#ids),)* } }
            #[inline(always)]
            fn clock(&mut self, d: Self::D) -> bool {
                let mut fault = false;
                #(fault |= ::pellucid_sim::Memory::clock(&mut self.#ids, d.#ids);)*
                fault
            }
            fn visit(&mut self, path: &str, to: &mut dyn FnMut(&str, &mut dyn ::pellucid_sim::Storage)) {
                #(::pellucid_sim::Memory::visit(&mut self.#ids, &::pellucid_sim::join(path, #names), to);)*
            }
        }
    })
}
