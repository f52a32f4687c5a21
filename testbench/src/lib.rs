//! Scenes, traces, golden model, scoreboard and reports.
pub mod scene;
