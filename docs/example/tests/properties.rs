//! What the library's allocators are held to, for an allocator that is not part of it.

use my_allocator::{Hasty, LowestFirst};
use pellucid_properties::allocator::test;
use pellucid_properties::allocator_properties;
use std::panic::catch_unwind;

allocator_properties!(LowestFirst);

/// How a failure looks. A section that comes back replaces the offer of a higher one, which nobody has taken
/// yet; whoever has begun to use that number is betrayed.
#[test]
fn the_fault_of_the_hasty_one_is_found() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().to_owned();
    let panic = catch_unwind(|| test::<Hasty>("", &path)).unwrap_err();
    let expected = format!(
        "broken in cycle 2: what is offered is held until it is taken: 1 was offered, then 0\n\
         its waveform: gtkwave {}\n\
         2 sections, cycle by cycle:\n     0  take\n     1  release 0\n     2  nothing",
        folder.path().join("wave.gtkw").display()
    );
    assert_eq!(panic.downcast_ref::<String>(), Some(&expected));
}
