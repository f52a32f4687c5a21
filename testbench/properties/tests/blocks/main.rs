//! The library's blocks keep their contracts; faults of every kind are found out.

mod allocator;
mod blender;
mod buffer;
mod counters;
mod fifo;
mod found;
mod invalid;
mod lanes;
mod late;
mod lists;
mod panics;
mod prefix_sum;
mod ram;
mod sorter;
mod stream;

/// A page of the book.
fn page(name: &str) -> String {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/src/");
    std::fs::read_to_string(format!("{folder}{name}")).unwrap()
}

/// The `Cargo.toml` on the page is one of a crate outside of the repository: Cargo finds all that it names.
#[test]
fn the_manifest_in_the_book_is_complete() {
    let page = page("properties.md");
    let (_, manifest) = page.split_once("```toml\n").unwrap();
    let (manifest, _) = manifest.split_once("```").unwrap();
    let root = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");
    let folder = tempfile::tempdir().unwrap();
    let put = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    put("Cargo.toml", &manifest.replace("../pellucid", root));
    std::fs::create_dir(folder.path().join("src")).unwrap();
    put("src/lib.rs", "");
    // The same versions of all others as here, so that none is looked for.
    put("Cargo.lock", &std::fs::read_to_string(format!("{root}/Cargo.lock")).unwrap());
    // What other platforms need may never have been fetched.
    let compiler = std::process::Command::new("rustc").arg("-vV").output().unwrap();
    let compiler = String::from_utf8(compiler.stdout).unwrap();
    let host = compiler.lines().find_map(|line| line.strip_prefix("host: ")).unwrap();
    let cargo = std::process::Command::new(env!("CARGO"))
        .args(["metadata", "--offline", "--format-version", "1", "--filter-platform", host])
        .current_dir(folder.path())
        .output()
        .unwrap();
    assert!(cargo.status.success(), "{}", String::from_utf8_lossy(&cargo.stderr));
}

/// The sentences of the contracts as they stand in the book.
#[test]
fn the_book_has_the_properties() {
    use pellucid_properties::{allocator, blender, buffer, counters, fifo, lanes, lists};
    use pellucid_properties::{prefix_sum, ram, sorter, stream};
    let page = ["properties.md", "allocators.md"].map(page).concat();
    let has = |sentences: &[&dyn std::fmt::Display]| {
        for sentence in sentences {
            assert!(page.contains(&format!("\n| {sentence} | ")), "it has no line for: {sentence}");
        }
    };
    {
        use allocator::Property::{Exhausted, Fault, Flagged, Granted, Held, Lent, Range, Twice};
        has(&[&Range, &Twice, &Held, &Granted, &Exhausted, &Lent, &Flagged, &Fault]);
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
    {
        use counters::Property::{Counted, Counts, End, Fault, Limit, Meets, Ready, Valid};
        has(&[&Ready, &End, &Counted, &Valid, &Counts, &Limit, &Meets, &Fault]);
    }
    {
        use prefix_sum::Property::{Band, Cleared, Cycles, Fault, List, Range, Slots, Sum, Valid};
        has(&[&Cycles, &Band, &Slots, &Sum, &List, &Cleared, &Range, &Valid, &Fault]);
    }
    {
        use lists::Property::{
            Done, Dropped, Fault, Held, Marks, Once, Order, Pages, Stored, Stuck,
        };
        has(&[&Dropped, &Stored, &Pages, &Held, &Order, &Once, &Marks, &Done, &Stuck, &Fault]);
    }
    {
        use buffer::Property::{Early, Fault, Flush, Held, Range, Read, Stuck};
        has(&[&Read, &Early, &Held, &Range, &Flush, &Stuck, &Fault]);
    }
}
