//! Derives for `pellucid-sim`, so that a register is described once: in the `struct` that holds it.
//!
//! - [`macro@Signals`] gives a bundle of registers or wires its names, widths and kinds.
//! - [`macro@Registers`] does so for the registers of a block that holds lines of children.
//! - [`macro@Memory`] makes a set of memories one.

mod children;
mod memory;
mod rtl;
mod signals;

use proc_macro::TokenStream;
use syn::{DeriveInput, parse_macro_input};

/// Names, widths and kinds of a bundle of registers or wires.
///
/// On a struct with named fields:
/// - `#[signals(Type)]` names the configuration that the width expressions read as `cfg`
///   (default: `Config` where a field needs one, else `()`).
/// - An integer field needs `#[width(bits)]`, an expression over `cfg`. Width 0 means that the
///   field does not exist in this configuration: it must hold 0 and is not shown.
/// - A field whose type takes a configuration of its own is given it by `#[with(cfg.part)]`; several
///   parts make a tuple.
/// - An array field may name how many of its elements exist: `#[len(count)]`. What its elements are given may depend on
///   the element's number `k`.
/// - A field that exists in some configurations alone says in which: `#[exists(condition)]`. In the others it is not
///   shown.
/// - A field that only the simulator keeps is `#[unseen]`: it is no signal.
/// - A field that holds a child's registers is `#[block(CHILD)]`, or `#[block(CHILD, cfg.part)]` where the child's
///   configuration is not what `#[with]` names. Then there is a function `reset`: children are reset as they say, other
///   fields are as `#[reset(value)]` says, or their types' defaults. `#[rtl]` makes it the block's.
///
/// On an enum without fields: the variants, numbered from 0 in order, with the fewest bits that
/// hold the last of them.
#[proc_macro_derive(Signals, attributes(signals, width, with, len, exists, unseen, block, reset))]
pub fn signals(input: TokenStream) -> TokenStream {
    let input = parse_macro_input!(input as DeriveInput);
    signals::derive(&input).unwrap_or_else(|e| e.to_compile_error()).into()
}

/// Names, widths and kinds of the registers of a block that holds lines of children.
///
/// On a struct with named fields, as for [`macro@Signals`]; besides, a field may be a `Vec` with `#[len(count)]`. The
/// configuration is named by `#[signals(Type)]` here too.
#[proc_macro_derive(Registers, attributes(signals, width, with, len, exists, unseen, block, reset))]
pub fn registers(input: TokenStream) -> TokenStream {
    let input = parse_macro_input!(input as DeriveInput);
    signals::registers(&input).unwrap_or_else(|e| e.to_compile_error()).into()
}

/// A struct whose fields are all memories is one too: clocked together, each visited by its name.
///
/// Where fields are children's, each is `#[block(CHILD, cfg.part)]`, then there is a function `new`, which `#[rtl]` makes
/// the block's `memories`; `#[memory(Type)]` names the configuration (default: `Config`). Memories of a child with
/// `#[exists(condition)]`, which are `Optional`, have no words where that does not hold, and are not clocked.
#[proc_macro_derive(Memory, attributes(memory, block, exists))]
pub fn memory(input: TokenStream) -> TokenStream {
    let input = parse_macro_input!(input as DeriveInput);
    memory::derive(&input).unwrap_or_else(|e| e.to_compile_error()).into()
}

/// Gives functions a second meaning: beside each, a twin that builds a netlist from the same tokens.
///
/// - On an `impl Block`: what it says of neither `reset` nor `memories` is made of its fields' `#[block]`; `moore` and `next` are
///   compiled into what the block is a part of, `next` where there are no debug assertions, unless they have an `#[inline]` of
///   their own; and the block can be elaborated (`pellucid_sim::Netlist`). `name = "..."` names its module (default: the block's
///   name in snake case); `state`, `input`, `moore` and `output = EXPR` give a bundle's configuration where it is not the block's
///   own; each `check(TYPE, CONFIG)` makes a test that compares the source with the netlist on random registers and inputs.
/// - On a function or an `impl` of functions: other twins can call them. Parameters by shared
///   reference are configuration, all others hardware.
///
/// What is made of configuration, constants, literals and loop counters alone stays native Rust. What
/// has no netlist form is refused at its token.
#[proc_macro_attribute]
pub fn rtl(options: TokenStream, item: TokenStream) -> TokenStream {
    let options = parse_macro_input!(options as rtl::Options);
    let item = parse_macro_input!(item as syn::Item);
    rtl::expand(options, item).unwrap_or_else(|e| e.to_compile_error()).into()
}
