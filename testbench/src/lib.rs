//! Scenes, traces, golden model, scoreboard and reports: everything around the hardware.
//!
//! A [`source::Source`] plays a frame's fragments; [`golden::Golden`] says what image they must
//! give; a [`bench::Bench`] clocks a machine and catches what it gives; the [`scoreboard`] compares,
//! and the [`report`] tells. A [`trial`] is all of that at once; a [`compare`] has several side by side.

pub mod area;
pub mod bench;
pub mod compare;
pub mod costs;
pub mod export;
pub mod golden;
pub mod html;
pub mod image;
pub mod output;
pub mod outside;
pub mod plots;
mod ports;
pub mod progress;
pub mod recorder;
pub mod report;
pub mod room;
pub mod run;
pub mod scene;
pub mod scoreboard;
pub mod settings;
pub mod source;
pub mod stimulus;
pub mod trace;
pub mod trial;
pub mod view;
mod watch;
pub mod window;
