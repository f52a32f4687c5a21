//! Scenes, traces, golden model, scoreboard and reports.

pub mod frame;
pub mod golden;
pub mod image;
pub mod output;
pub mod trace;
