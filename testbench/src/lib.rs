//! Scenes, traces, golden model, scoreboard and reports.
