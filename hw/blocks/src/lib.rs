//! The shared hardware: clocked blocks that architectures are composed of, one per file.
//!
//! | block | what it does |
//! | --- | --- |
//! | [`front`] | what machines of fragments have in common: sequencer, depth test, display |
//! | [`sequencer`] | from frame to frame |
//! | [`depth_test`] | draws opaque fragments, drops hidden ones, passes transparent ones on |
//! | [`display`] | the frame buffer, and the scanout that shows it |
//! | [`pixels`] | the same with the frame buffer in outside memory |
//! | [`chains`] | fragments grouped by pixel in chains of sections |
//! | [`mod@array`] | fragments grouped by pixel in arrays that a count has made room for, or that are all of one length |
//! | [`allocator`] | hands out free sections |
//! | [`sorter`] | sorts each pixel's fragments far to near, any number of them |
//! | [`bitonic`] | sorts all that is loaded into its memory |
//! | [`blender`] | blends sorted fragments over the opaque colour |
//! | [`buffer`] | the contract of what stands between a client and outside memory |
//! | [`cache`] | stands before outside memory and keeps some of its words |
//! | [`table_cache`] | stands before a table in outside memory and fetches ahead what will be used of it |
//! | [`cached_table`] | the same with entries as their users know them |
//! | [`combiner`] | stands before outside memory and gathers what is written to one burst |
//! | [`arbiter`] | lets several clients share one outside memory |
//! | [`shared_port`] | one port for fragments and frame buffer, where both may lie outside |
//! | [`rebuild`] | lets what a frame may use grow until the frame fits |
//! | [`walker`] | set-up and edge walk of primitives |
//! | [`weights`] | weight factors in fixed point |

pub mod allocator;
pub mod arbiter;
pub mod array;
pub mod bitonic;
pub mod bits;
pub mod blender;
pub mod buffer;
pub mod cache;
pub mod cached_table;
pub mod chains;
pub mod combiner;
pub mod depth_test;
pub mod display;
pub mod frame_buffer;
pub mod front;
pub mod pixels;
pub mod rebuild;
pub mod round_robin;
pub mod scanout;
pub mod sequencer;
pub mod shared_port;
pub mod skid;
pub mod sorter;
pub mod table_cache;
pub mod walker;
pub mod weights;

#[cfg(test)]
mod test_util;
