//! Scenes, traces, golden model, scoreboard and reports.

pub mod golden;
pub mod image;
pub mod output;
pub mod scene;
pub mod trace;
