//! `#[derive(Memory)]`.

use crate::children;
use proc_macro2::TokenStream;
use quote::quote;
use syn::{Data, DeriveInput, Error, Fields, Result, Type};

pub fn derive(input: &DeriveInput) -> Result<TokenStream> {
    let Data::Struct(syn::DataStruct { fields: all @ Fields::Named(fields), .. }) = &input.data
    else {
        return Err(Error::new_spanned(
            &input.ident,
            "#[derive(Memory)] is for a struct with named fields, each a memory",
        ));
    };
    let name = &input.ident;
    let ids: Vec<_> = fields.named.iter().flat_map(|f| &f.ident).collect();
    let names: Vec<String> = ids.iter().map(ToString::to_string).collect();
    let mut config: Type = syn::parse_quote!(Config);
    if let Some(a) = input.attrs.iter().find(|a| a.path().is_ident("memory")) {
        config = a.parse_args()?;
    }
    let new = children::maker(input, all, &config, ["new", "memories"], |_| None)?;
    let (impl_generics, ty_generics, where_clause) = input.generics.split_for_impl();
    Ok(quote! {
        #new
        impl #impl_generics ::pellucid_sim::Memory for #name #ty_generics #where_clause {
            #[inline(always)]
            fn clock(&mut self) -> bool {
                let mut fault = false;
                #(fault |= ::pellucid_sim::Memory::clock(&mut self.#ids);)*
                fault
            }
            fn reset(&mut self) {
                #(::pellucid_sim::Memory::reset(&mut self.#ids);)*
            }
            fn visit(&mut self, path: &str, to: &mut dyn FnMut(&str, &mut dyn ::pellucid_sim::Storage)) {
                #(::pellucid_sim::Memory::visit(&mut self.#ids, &::pellucid_sim::join(path, #names), to);)*
            }
            fn each(&mut self, to: &mut dyn FnMut(&mut dyn ::pellucid_sim::Storage)) {
                #(::pellucid_sim::Memory::each(&mut self.#ids, to);)*
            }
        }
    })
}
