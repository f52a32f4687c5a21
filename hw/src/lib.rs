//! The hardware: clocked blocks, one per file, and the architectures that are composed of them.
//!
//! Shared blocks stand here, an architecture's own in its folder. `hw` knows neither files nor
//! formats.
//!
//! | block | what it does |
//! | --- | --- |
//! | [`course`] | the course of a frame |
//! | [`depth_test`] | draws opaque fragments, drops hidden ones, passes transparent ones on |
//! | [`display`] | the frame buffer, and the scanout that shows it |
//! | [`chains`] | fragments grouped by pixel in chains of sections |
//! | [`allocator`] | hands out free sections |
//! | [`sorter`] | sorts each pixel's fragments far to near, any number of them |
//! | [`blender`] | blends sorted fragments over the opaque colour |
//! | [`weights`] | weight factors in fixed point |
//! | [`primitive`] | triangles that are set up for an edge walk |
//! | [`tbuffer`], [`rbuffer`], [`mbuffer`] | the architectures of seed 000 |
//! | [`composer`] | the image composition machine of seed 001 |

pub mod allocator;
pub mod bits;
pub mod blender;
pub mod chains;
pub mod composer;
pub mod course;
pub mod depth_test;
pub mod display;
pub mod ends;
pub mod frame_buffer;
pub mod machine;
pub mod mbuffer;
pub mod params;
pub mod pixel;
pub mod primitive;
pub mod rbuffer;
pub mod scanout;
pub mod sorter;
pub mod tbuffer;
pub mod weights;

#[cfg(test)]
mod test_util;
