//! The hardware.
pub mod pixel;
