//! The library's blocks keep their contracts; faults of every kind are found out.

mod allocator;
mod blender;
mod fifo;
mod found;
mod lanes;
mod ram;
mod sorter;
mod stream;

/// The sentences of the contracts as they stand in the book.
#[test]
fn the_book_has_the_properties() {
    use pellucid_properties::{allocator, blender, fifo, lanes, ram, sorter, stream};
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/src/");
    let pages = ["properties.md", "allocators.md"];
    let page =
        pages.map(|page| std::fs::read_to_string(format!("{folder}{page}")).unwrap()).concat();
    let has = |sentences: &[&dyn std::fmt::Display]| {
        for sentence in sentences {
            assert!(page.contains(&format!("\n| {sentence} | ")), "it has no line for: {sentence}");
        }
    };
    {
        use allocator::Property::{Exhausted, Fault, Granted, Held, Lent, Range, Twice};
        has(&[&Range, &Twice, &Held, &Granted, &Exhausted, &Lent, &Fault]);
    }
    {
        use lanes::Property::{Exhausted, Fault, Granted, Held, Range, Ready, Twice};
        has(&[&Range, &Twice, &Held, &Granted, &Exhausted, &Ready, &Fault]);
    }
    {
        use fifo::Property::{Count, Fault, Front, Held, Order, Ready, Reset};
        has(&[&Reset, &Held, &Order, &Front, &Ready, &Count, &Fault]);
    }
    {
        use ram::Property::{Data, Fault, Held, Meets, Misuse, Valid};
        has(&[&Valid, &Data, &Meets, &Held, &Misuse, &Fault]);
    }
    {
        use stream::Property::{Early, Fault, Held, Order, Stuck};
        has(&[&Held, &Order, &Early, &Stuck, &Fault]);
    }
    {
        use sorter::Property::{Early, End, Fault, Held, Last, Once, Order, Stuck, Ties};
        has(&[&Held, &Order, &Ties, &Once, &Early, &Last, &End, &Stuck, &Fault]);
    }
    {
        use blender::Property::{Blended, Colour, Done, Fault, Read, Write};
        has(&[&Read, &Write, &Colour, &Blended, &Done, &Fault]);
    }
}
