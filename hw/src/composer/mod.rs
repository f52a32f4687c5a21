//! The image composition machine (seed 001).

pub mod buckets;
pub mod config;
pub mod distributor;
pub mod merger;
pub mod merging_unit;
pub mod object_engine;
pub mod raster;
pub mod scan_line;
pub mod scan_lines;
pub mod sweep;
pub mod walker;
