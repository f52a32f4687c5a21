//! The hardware: clocked blocks, one per file, and the architectures that are composed of them.
//!
//! Shared blocks stand here, an architecture's own in its folder. `hw` knows neither files nor
//! formats.
//!
//! | block | what it does |
//! | --- | --- |
//! | [`depth_test`] | draws opaque fragments, drops hidden ones, passes transparent ones on |
//! | [`frame_buffer`] | depth and colour of every pixel, two banks |
//! | [`sorter`] | sorts each pixel's fragments far to near, any number of them |
//! | [`blender`] | blends sorted fragments over the opaque colour |
//! | [`scanout`] | shows a finished frame and wipes its bank |
//! | [`allocator`] | hands out free sections |
//! | [`tbuffer`] | the T-buffer architecture of seed 000 |

pub mod allocator;
pub mod blender;
pub mod course;
pub mod depth_test;
pub mod frame_buffer;
pub mod machine;
pub mod params;
pub mod pixel;
pub mod rbuffer;
pub mod scanout;
pub mod sorter;
pub mod tbuffer;

#[cfg(test)]
mod test_util;
