//! What must hold of a block, as properties that random sequences try to break.
//!
//! A sequence that breaks a property is shrunk to the shortest one that still does, is kept as a regression
//! beside the test's source, and leaves a waveform of exactly that sequence, with a marker where the property
//! is broken. Long sequences are played and every state of small blocks is looked at too.
//!
//! ```no_run
//! use pellucid_blocks::{allocator::FreeList, blender::Blender, sorter::Sorter};
//! use pellucid_properties::{allocator_properties, blender_properties, sorter_properties};
//! allocator_properties!(FreeList);
//! sorter_properties!(Sorter);
//! blender_properties!(Blender);
//! ```
//!
//! How many sequences are tried is proptest's to say: `PROPTEST_CASES=10000 cargo test` tries that many.
//!
//! | module | what it has |
//! | --- | --- |
//! | [`allocator`], [`lanes`], [`fifo`], [`ram`], [`stream`], [`sorter`], [`blender`], [`buffer`] | the contracts |
//! | [`counters`], [`mod@prefix_sum`], [`lists`] | those of what stores fragments |
//! | [`mod@reference`] | what a contract is |
//! | [`harness`] | what runs a block beside one |
//! | [`trials`] | the tests that are made of it |

pub mod allocator;
pub mod blender;
pub mod buffer;
pub mod counters;
pub mod fifo;
pub mod harness;
pub mod lanes;
pub mod lists;
mod panics;
pub mod prefix_sum;
pub mod ram;
pub mod reference;
mod report;
pub mod sorter;
pub mod stream;
pub mod trials;

pub use reference::{Judged, Long, Reference};
pub use report::report;
